//! The equations of an element that holds solid (Becker (22)–(27), (29)–(33); theory (K.8)–(K.12)).
//!
//! ```text
//! r = 2/Δt in elements of solid alone, with r v̂ + â on the right; 1/Δt with v̂/Δt where there is fluid, too
//! ⎡ r M + K + Δt κ W* g_i ⊗ g_j   −w_j g_i   ⎤ ⎧v⎫   ⎧ M (b + r v̂ + â) − V_s σ̄' g_i + Σ_k w*_k p̂*_k g_i ⎫
//! ⎣ −w_i g_j                      −w_i δ_ij/κΔt − C ⎦ ⎩p⎭ = ⎩ −w_i p̂_i/κΔt − τ V_f g_i·s                ⎭
//! K_ij = μ_s Δt V_s (g_i·g_j 1 + g_j ⊗ g_i − ⅔ g_i ⊗ g_j) + μ_f V_f (g_i·g_j 1 + g_j ⊗ g_i)
//! ```
//!
//! In cut elements w_k = ∫N_k over the side of node k and w*_k over the other, W* = Σ w*_k: the shape function
//! of the pressure is split into two, of which the second belongs to the element alone and is condensed. Elsewhere w_k
//! = V/(d+1), and that of the solid is compressible.

use crate::math::{SymTensor, Vector};
use crate::mesh::Simplex;
use crate::pfem2::cut_element::CutGeometry;
use crate::pfem2::element::{Block, Drive};

/// An element that holds solid.
#[derive(Debug, Clone)]
pub struct SolidElement<const D: usize, const N: usize> {
    /// The element.
    pub element: u32,
    /// Number of the solid.
    pub solid: usize,
    /// Blocks of its matrix, condensed.
    pub blocks: [[Block<N>; N]; N],
    /// Right-hand sides of its nodes, condensed.
    pub loads: [[f64; N]; N],
    /// The solid in it.
    pub part: SolidPart<D, N>,
    /// Pressures of both sides, if the interface cuts it.
    pub split: Option<SplitPressure<N>>,
}

/// The solid in an element.
#[derive(Debug, Clone, Copy)]
pub struct SolidPart<const D: usize, const N: usize> {
    /// Volume V_s [m³].
    pub volume: f64,
    /// Mass at each node [kg].
    pub mass: [f64; N],
    /// ∫N_k dV over it [m³].
    pub weights: [f64; N],
    /// Mean stress σ̄' before the step [Pa].
    pub stress: SymTensor,
    /// Shear modulus μ_s [Pa].
    pub shear: f64,
    /// r, of the velocity in the acceleration [1/s].
    pub rate: f64,
    /// â at the nodes [m/s²], zero where it doesn't enter.
    pub acceleration: [Vector<D>; N],
}

/// Pressures on both sides of a cut element (theory K.5).
#[derive(Debug, Clone, Copy)]
pub struct SplitPressure<const N: usize> {
    /// True for nodes on the side of the solid.
    pub solid: [bool; N],
    /// w_k [m³].
    pub own: [f64; N],
    /// w*_k [m³].
    pub ghost: [f64; N],
    /// κ, of both sides [Pa].
    pub bulk: f64,
    /// p̂*_k [Pa].
    pub estimate: [f64; N],
    /// p*_k after the solution [Pa].
    pub recovered: [f64; N],
}

impl<const N: usize> SplitPressure<N> {
    /// The split of an element of this volume [m³] that is cut with the solid on the negative side, with these
    /// pressures p̂ at its nodes [Pa].
    ///
    /// p̂*_k is the mean p̂ of the nodes of the side where N*_k lives: without a gradient across the interface
    /// (theory (K.10)).
    pub fn new(cut: &CutGeometry<N>, volume: f64, bulk: f64, pressure: &[f64; N]) -> Self {
        let [solid, fluid] = cut.sides();
        let side = |negative: bool, k: usize| {
            let parts = cut.parts.iter().filter(|part| part.negative == negative);
            parts.map(|part| volume * part.volume_fraction * part.center[k]).sum::<f64>()
        };
        let mean = |nodes: [bool; N]| {
            let own = || (0..N).filter(|&k| nodes[k]);
            own().map(|k| pressure[k]).sum::<f64>() / own().count().max(1) as f64
        };
        let means = [mean(solid), mean(fluid)];
        let estimate = std::array::from_fn(|k| means[usize::from(solid[k])]);
        // Becker (29): D and D*, and the masses of the pressures, which follow from the same integrals.
        let [own, ghost] = [true, false].map(|same| std::array::from_fn(|k| side(solid[k] == same, k)));
        Self { solid, own, ghost, bulk, estimate, recovered: estimate }
    }

    /// ∫N_k over the solid [m³].
    pub fn in_solid(&self) -> [f64; N] {
        std::array::from_fn(|k| if self.solid[k] { self.own[k] } else { self.ghost[k] })
    }

    /// Pressures whose interpolation holds on the side of the solid, or of the fluid, from those of the nodes [Pa].
    pub fn on_side(&self, nodal: [f64; N], solid: bool) -> [f64; N] {
        std::array::from_fn(|k| if self.solid[k] == solid { nodal[k] } else { self.recovered[k] })
    }

    /// Finds p* after a step `dt` [s] from the divergence of its velocity [1/s].
    pub fn recover(&mut self, dt: f64, divergence: f64) {
        // The second row of Becker (30), theory (K.12).
        self.recovered = self.estimate.map(|estimate| estimate - dt * self.bulk * divergence);
    }
}

/// Integrals over an element that its matrix consists of.
#[derive(Debug, Clone, Copy)]
pub struct ElementIntegrals<const N: usize> {
    /// M_ij [kg].
    pub mass: [[f64; N]; N],
    /// r [1/s].
    pub rate: f64,
    /// Δt ∫μ_s dV [Pa s m³].
    pub elastic: f64,
    /// ∫μ_f dV [Pa s m³].
    pub viscous: f64,
    /// w_k [m³].
    pub own: [f64; N],
    /// w_k/κΔt [m³/(Pa s)], without what is incompressible.
    pub compression: [f64; N],
    /// Δt κ W* [Pa s m³].
    pub ghost: f64,
    /// τ V_f/ρ [m³ s m³/kg].
    pub diffusion: f64,
}

impl<const N: usize> ElementIntegrals<N> {
    /// The block of rows of node `i` and columns of node `j`; `g`: gradients of the shape functions [1/m].
    pub fn block<const D: usize>(&self, g: &[Vector<D>; N], (i, j): (usize, usize)) -> Block<N> {
        let mut a = [[0.0; N]; N];
        let (both, stiffness) = (g[i].dot(g[j]), self.elastic + self.viscous);
        // Becker (25), theory (K.8); with the ghost pressures K̂ of Becker (31), Becker (32), theory (K.11).
        for r in 0..D {
            for s in 0..D {
                let volumetric = self.ghost - 2.0 / 3.0 * self.elastic;
                // Becker (26), with the deviator of Becker (27).
                a[r][s] = stiffness * g[i][s] * g[j][r] + volumetric * g[i][r] * g[j][s];
            }
            a[r][r] += stiffness * both + self.mass[i][j] * self.rate;
            a[r][D] = -self.own[j] * g[i][r];
            a[D][r] = -self.own[i] * g[j][r];
        }
        a[D][D] = -self.diffusion * both - if i == j { self.compression[i] } else { 0.0 };
        a
    }

    /// The right-hand side of the rows of node `i`.
    pub fn load<const D: usize>(&self, g: &[Vector<D>; N], forces: &ElementLoads<'_, D, N>, i: usize) -> [f64; N] {
        let drive = forces.drive;
        let mass: f64 = self.mass[i].iter().sum();
        // Becker (25), f̂ of Becker (33); theory (K.8), (K.11).
        let mut momentum = drive.force[i] * mass + g[i] * forces.ghosts - traction(&forces.stress, g[i]);
        for j in 0..N {
            momentum += (drive.convected[j] * self.rate + forces.acceleration[j]) * self.mass[i][j];
        }
        let mut f = [0.0; N];
        f[..D].copy_from_slice(&momentum.0);
        f[D] = -self.compression[i] * forces.pressure[i] - g[i].dot(forces.source);
        f
    }
}

/// Forces and pressures in an element beside its matrix.
#[derive(Debug, Clone, Copy)]
pub struct ElementLoads<'a, const D: usize, const N: usize> {
    /// Body force and v̂ at the nodes.
    pub drive: &'a Drive<D, N>,
    /// â at the nodes [m/s²].
    pub acceleration: [Vector<D>; N],
    /// p̂ at the nodes [Pa].
    pub pressure: [f64; N],
    /// V_s σ̄' [Pa m³].
    pub stress: SymTensor,
    /// Σ w*_k p̂*_k [Pa m³].
    pub ghosts: f64,
    /// τ V_f s [m⁴/s].
    pub source: Vector<D>,
}

/// σ·g of a stress [Pa m³] and a gradient [1/m].
pub fn traction<const D: usize>(stress: &SymTensor, g: Vector<D>) -> Vector<D> {
    let full = stress.full();
    Vector::from_fn(|r| (0..D).map(|s| full[r][s] * g[s]).sum())
}

/// Values at the nodes of an element after a step.
#[derive(Debug, Clone, Copy)]
pub struct NodalSolution<'a, const D: usize, const N: usize> {
    /// Body force and v̂.
    pub drive: &'a Drive<D, N>,
    /// Velocity [m/s].
    pub velocity: [Vector<D>; N],
    /// Pressure [Pa].
    pub pressure: [f64; N],
    /// The step Δt [s].
    pub dt: f64,
}

impl<const D: usize, const N: usize> SolidElement<D, N> {
    /// Force that the solid in the element takes at its nodes [N]: what the equations of the solid lack
    /// (theory (K.13)).
    pub fn force_on_solid(&self, simplex: &Simplex<D, N>, solution: &NodalSolution<'_, D, N>) -> [Vector<D>; N] {
        let &NodalSolution { drive, velocity, pressure, dt } = solution;
        let (part, g) = (&self.part, &simplex.gradient);
        let gradient = (0..N).map(|k| crate::math::Tensor::outer(velocity[k], g[k]));
        let rate = super::strain_rate::deviatoric_rate(&gradient.fold(crate::math::Tensor::ZERO, |sum, own| sum + own));
        let own = self.split.map_or(pressure, |split| split.on_side(pressure, true));
        let p: f64 = own.iter().zip(&part.weights).map(|(p, w)| p * w).sum();
        let stress = (part.stress + rate * (2.0 * part.shear * dt)) * part.volume - SymTensor::isotropic(p);
        std::array::from_fn(|i| {
            let inertia = (velocity[i] - drive.convected[i]) * part.rate - part.acceleration[i] - drive.force[i];
            inertia * part.mass[i] + traction(&stress, g[i])
        })
    }
}
