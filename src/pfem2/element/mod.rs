//! The equations of one P1–P1 element, as pure functions (theory F.6, F.7).
//!
//! With Δ = θ Δt, the rows of the momentum and, with the sign changed, of the continuity equation:
//!
//! ```text
//! ⎡ M/Δ + K   −Dᵀ ⎤ ⎧v⎫   ⎧ M (b + v̂/Δ) ⎫        M_ij = δ_ij m_i                 (lumped)
//! ⎣   −D      −C  ⎦ ⎩p⎭ = ⎩ −τ V g_i·s   ⎭        K_ij = μ V (g_i·g_j I + g_j ⊗ g_i)
//!                                               D_ij = V/(d+1) g_j
//! τ = (1/Δ + 4 μ/(ρ h²) + 2 |v|/h)⁻¹            C_ij = τ ∫dV/ρ  g_i·g_j
//!
//! PSPG             s = b                        (the paper; inconsistent, theory F.7.1)
//! consistent PSPG  s = b + v̂/Δ + f, f the viscous force per unit mass of the last step, and −τ/Δ V/(d+1) g_i on the velocities in
//!                  the continuity row   (theory (F.27))
//! OSS              s = b + π̄, π the projection of ∇p/ρ − b of the last step (theory (F.28))
//! ```
//!
//! Becker (17) is the weak form, Becker (19) its matrices, Becker (20) the stabilised system (Becker, Idelsohn & Oñate
//! 2015). Pressure and gradient stand in divergence form: the natural condition is the traction, Becker (18), and
//! the pressure inside an element may jump.

pub mod shear;

use crate::math::Vector;
use crate::mesh::Simplex;

/// One block of the system: the rows (v_1 … v_d, p) of a node against the columns of another.
pub type Block<const N: usize> = [[f64; N]; N];

/// Stabilisation of the pressure (theory F.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stabilisation {
    /// The paper's: without inertia in the residual.
    Pspg,
    /// The whole residual, with the viscous force of the last step; the system is not symmetric.
    ConsistentPspg,
    /// The whole residual, of subscales that have an inertia (see `equations/dynamic_subscale.rs`).
    Dynamic,
    /// Orthogonal subscales: against the projected pressure gradient of the last step.
    #[default]
    Oss,
}

impl Stabilisation {
    /// True if the residual has its inertia: the system is not symmetric.
    pub fn has_inertia(self) -> bool {
        matches!(self, Self::ConsistentPspg | Self::Dynamic)
    }
}

/// The mass matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mass {
    /// A diagonal.
    Lumped,
    /// ∫ρ N_i N_j, in cut elements over each side: it doesn't slow down what is short, or moves along an interface.
    #[default]
    Consistent,
}

/// Constants of the equations during a step.
#[derive(Debug, Clone, Copy)]
pub struct Equations {
    /// Δ = θ Δt: implicit part of the step [s].
    pub delta: f64,
    /// Mass matrix.
    pub mass: Mass,
    /// Stabilisation.
    pub stabilisation: Stabilisation,
}

/// Mass, viscosity and stabilisation of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Content<const N: usize> {
    /// Mass at each node, ∫ρ N_i [kg].
    pub mass: [f64; N],
    /// Mean viscosity [Pa s].
    pub viscosity: f64,
    /// Stabilisation time τ [s].
    pub tau: f64,
    /// ∫dV/ρ [m³·m³/kg].
    pub volume_over_density: f64,
}

impl<const N: usize> Content<N> {
    /// The content of an element that is full of one fluid.
    pub fn uniform(volume: f64, density: f64, viscosity: f64, tau: f64) -> Self {
        let mass = [density * volume / N as f64; N];
        Self { mass, viscosity, tau, volume_over_density: volume / density }
    }
}

/// τ [s] (theory (F.24)): `delta` [s], viscosity [Pa s], density [kg/m³], shortest edge [m], speed [m/s].
pub fn tau(delta: f64, viscosity: f64, density: f64, h: f64, speed: f64) -> f64 {
    1.0 / (1.0 / delta + 4.0 * viscosity / (density * h * h) + 2.0 * speed / h)
}

/// M_ij [kg]; in cut elements that of their mean density.
#[inline]
pub fn mass<const N: usize>(content: &Content<N>, kind: Mass, (i, j): (usize, usize)) -> f64 {
    match kind {
        Mass::Lumped => {
            if i == j {
                content.mass[i]
            } else {
                0.0
            }
        }
        Mass::Consistent => {
            let weight = if i == j { 2.0 } else { 1.0 };
            content.mass.iter().sum::<f64>() * weight / (N * (N + 1)) as f64
        }
    }
}

/// The block of rows of node `i` and columns of node `j`.
#[inline]
pub fn block<const D: usize, const N: usize>(
    simplex: &Simplex<D, N>,
    content: &Content<N>,
    equations: &Equations,
    (i, j): (usize, usize),
) -> Block<N> {
    let (g, volume) = (&simplex.gradient, simplex.volume);
    let nodal_volume = volume / N as f64;
    let stiffness = content.viscosity * volume;
    let both = g[i].dot(g[j]);
    let inertia = mass(content, equations.mass, (i, j)) / equations.delta;
    let mut a = [[0.0; N]; N];
    // Becker (17), (19): M/Δ + K, −Dᵀ and −D; theory (F.21), (F.22). No terms between elements: Becker (18).
    for r in 0..D {
        for s in 0..D {
            a[r][s] = stiffness * g[i][s] * g[j][r];
        }
        a[r][r] += stiffness * both + inertia;
        a[r][D] = -nodal_volume * g[i][r];
        a[D][r] = -nodal_volume * g[j][r];
    }
    // Becker (20): −τ times the Laplacian of the pressure; theory (F.22), (F.23).
    a[D][D] = -content.tau * content.volume_over_density * both;
    if equations.stabilisation.has_inertia() {
        for s in 0..D {
            a[D][s] -= content.tau / equations.delta * nodal_volume * g[i][s];
        }
    }
    a
}

/// Nodal values on the right-hand side of an element: body force [m/s²], convected velocity v̂ [m/s], and the projected
/// pressure gradient π [m/s²].
#[derive(Debug, Clone, Copy)]
pub struct Drive<const D: usize, const N: usize> {
    /// Body force b per unit mass at the nodes [m/s²].
    pub force: [Vector<D>; N],
    /// Convected velocity v̂ at the nodes [m/s].
    pub convected: [Vector<D>; N],
    /// Part of the residual that is projected on the nodes [m/s²]: ∇p/ρ − b with orthogonal subscales, the viscous
    /// force per unit mass with the consistent form.
    pub projected: [Vector<D>; N],
    /// ũ̂/(c Δ) of the element's subscale [m/s²], zero where it has none.
    pub subscale: Vector<D>,
}

impl<const D: usize, const N: usize> Drive<D, N> {
    /// Source s, against which the pressure gradient is stabilised [m/s²].
    #[inline]
    pub fn source(&self, equations: &Equations) -> Vector<D> {
        let mean = |values: &[Vector<D>; N]| values.iter().copied().sum::<Vector<D>>() / N as f64;
        self.subscale + mean(&self.force) + mean(&self.projected) + self.inertia(equations)
    }

    /// v̂/Δ, as a mean over the nodes [m/s²]; zero where the residual has no inertia.
    pub fn inertia(&self, equations: &Equations) -> Vector<D> {
        if !equations.stabilisation.has_inertia() {
            return Vector::ZERO;
        }
        self.convected.iter().copied().sum::<Vector<D>>() / (N as f64 * equations.delta)
    }

    /// Source s without v̂/Δ on the side of a cut element to which the nodes with `own` belong [m/s²]: each fluid has
    /// its own ∇p/ρ.
    pub fn forces_of(&self, equations: &Equations, own: [bool; N]) -> Vector<D> {
        let count = own.iter().filter(|own| **own).count();
        let all = equations.stabilisation != Stabilisation::Oss || count == 0;
        let side = (0..N).filter(|&k| all || own[k]).map(|k| self.projected[k]).sum::<Vector<D>>();
        self.subscale
            + self.force.iter().copied().sum::<Vector<D>>() / N as f64
            + side / if all { N as f64 } else { count as f64 }
    }
}

/// The right-hand side of the rows of node `i`; `source` is s [m/s²].
#[inline]
pub fn load<const D: usize, const N: usize>(
    simplex: &Simplex<D, N>,
    content: &Content<N>,
    equations: &Equations,
    drive: &Drive<D, N>,
    source: Vector<D>,
    i: usize,
) -> [f64; N] {
    // Becker (19): M v̂/Δ + F.
    let mut momentum = drive.force[i] * content.mass[i];
    for j in 0..N {
        momentum += drive.convected[j] * (mass(content, equations.mass, (i, j)) / equations.delta);
    }
    let mut f = [0.0; N];
    f[..D].copy_from_slice(&momentum.0);
    // Becker (20), the stabilisation on the right-hand side; theory (F.23).
    f[D] = -content.tau * simplex.volume * simplex.gradient[i].dot(source);
    f
}

/// Forces of the viscous stress on the nodes of an element [N], −Σ_j K_ij v_j, at these nodal velocities [m/s].
pub fn viscous_forces<const D: usize, const N: usize>(
    simplex: &Simplex<D, N>,
    viscosity: f64,
    velocity: &[Vector<D>; N],
) -> [Vector<D>; N] {
    let g = &simplex.gradient;
    let stiffness = viscosity * simplex.volume;
    std::array::from_fn(|i| {
        let of = |j: usize| velocity[j] * g[i].dot(g[j]) + g[j] * g[i].dot(velocity[j]);
        (0..N).map(of).sum::<Vector<D>>() * -stiffness
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const EQUATIONS: Equations = Equations { delta: 0.1, mass: Mass::Lumped, stabilisation: Stabilisation::Oss };

    fn tetrahedron() -> (Simplex<3, 4>, [Vector<3>; 4]) {
        let x = [[0.0, 0.1, 0.0], [1.0, 0.0, 0.2], [0.1, 0.9, 0.0], [0.2, 0.3, 1.1]].map(Vector);
        (Simplex::new(x).unwrap(), x)
    }

    /// The rows of the element against nodal unknowns.
    fn product(equations: &Equations, content: &Content<4>, unknowns: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
        let (simplex, _) = tetrahedron();
        std::array::from_fn(|i| {
            let mut sum = [0.0; 4];
            for j in 0..4 {
                let block = block(&simplex, content, equations, (i, j));
                (0..4).for_each(|r| sum[r] += (0..4).map(|s| block[r][s] * unknowns[j][s]).sum::<f64>());
            }
            sum
        })
    }

    #[test]
    fn a_linear_velocity_has_its_stress_and_divergence() {
        let (simplex, x) = tetrahedron();
        let content = Content { mass: [0.0; 4], viscosity: 3.0, tau: 0.0, volume_over_density: 1.0 };
        // v = L x
        let l = [[1.0, 2.0, 0.5], [-0.3, 0.7, 1.1], [0.4, -0.2, 0.9]];
        let v = |x: Vector<3>, r: usize| (0..3).map(|s| l[r][s] * x[s]).sum::<f64>();
        let rows = product(&EQUATIONS, &content, &x.map(|x| [v(x, 0), v(x, 1), v(x, 2), 0.0]));
        for (i, row) in rows.iter().enumerate() {
            for r in 0..3 {
                // ∫2μ d·∇N_i
                let stress = |s: usize| 3.0 * (l[r][s] + l[s][r]);
                let force: f64 = (0..3).map(|s| simplex.volume * stress(s) * simplex.gradient[i][s]).sum();
                assert!((row[r] - force).abs() < 1e-14);
            }
            assert!((row[3] + simplex.volume / 4.0 * (1.0 + 0.7 + 0.9)).abs() < 1e-14);
        }
    }

    #[test]
    fn a_linear_pressure_is_in_balance_with_gravity_in_every_form() {
        let (simplex, x) = tetrahedron();
        let gravity = Vector([0.3, -9.81, 2.0]);
        let content = Content::uniform(simplex.volume, 1000.0, 1e-3, 0.03);
        let unknowns = x.map(|x| [0.0, 0.0, 0.0, 1000.0 * gravity.dot(x)]);
        for stabilisation in
            [Stabilisation::Pspg, Stabilisation::ConsistentPspg, Stabilisation::Dynamic, Stabilisation::Oss]
        {
            let equations = Equations { stabilisation, ..EQUATIONS };
            let drive = Drive {
                force: [gravity; 4],
                convected: [Vector::ZERO; 4],
                projected: [Vector::ZERO; 4],
                subscale: Vector::ZERO,
            };
            let source = drive.source(&equations);
            let rows = product(&equations, &content, &unknowns);
            // The momentum rows of one element lack the pressure of its neighbours; the continuity rows don't.
            for (i, row) in rows.iter().enumerate() {
                let load = load(&simplex, &content, &equations, &drive, source, i);
                assert!((row[3] - load[3]).abs() < 1e-10 * load[3].abs().max(1.0));
            }
            let net: f64 = (0..4).map(|i| load(&simplex, &content, &equations, &drive, source, i)[1]).sum();
            assert!((net - 1000.0 * simplex.volume * gravity[1]).abs() < 1e-9);
        }
    }

    #[test]
    fn the_system_is_symmetric_unless_inertia_enters_the_stabilisation() {
        let (simplex, _) = tetrahedron();
        let content = Content::uniform(simplex.volume, 2.0, 3.0, 0.03);
        for mass in [Mass::Lumped, Mass::Consistent] {
            let equations = Equations { mass, ..EQUATIONS };
            for (i, j) in [(0, 0), (0, 1), (3, 2)] {
                let (a, b) =
                    (block(&simplex, &content, &equations, (i, j)), block(&simplex, &content, &equations, (j, i)));
                (0..4).for_each(|r| (0..4).for_each(|s| assert!((a[r][s] - b[s][r]).abs() < 1e-16)));
            }
            let total: f64 = (0..16).map(|k| super::mass(&content, mass, (k / 4, k % 4))).sum();
            assert!((total - 2.0 * simplex.volume).abs() < 1e-15);
        }
    }

    #[test]
    fn the_stabilisation_time_has_the_limits_of_inertia_viscosity_and_convection() {
        assert!((tau(0.1, 0.0, 1.0, 1.0, 0.0) - 0.1).abs() < 1e-16);
        assert!((tau(1e12, 2.0, 1.0, 0.5, 0.0) - 1.0 / 32.0).abs() < 1e-12);
        assert!((tau(1e12, 0.0, 1.0, 0.5, 4.0) - 1.0 / 16.0).abs() < 1e-12);
    }
}
