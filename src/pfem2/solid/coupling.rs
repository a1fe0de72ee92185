//! Equations of the fluid in elements that the surface of a solid cuts, coupled to the nodes of the solid (theory J.3).
//!
//! The fluid part of an element e is divided into simplices s between its nodes and its cut points c, whose velocity is that of
//! the solid's surface, v_c = Σ_a N_a v_a. The pressure keeps the functions of e, also those of nodes inside the solid:
//!
//! ```text
//! M, K       as of an element s
//! D_k,jβ   = V_s N^e_k(x_s) g^s_jβ                    x_s: centre of s;   rows p_k of e, columns v_j of s
//! C_kl     = τ/ρ V_s g^e_k·g^e_l
//! R_k,jβ   = τ V_s/(d + 1) g^e_kβ                     with the consistent stabilisation, theory (F.27)
//! ```
//!
//! Rows of cut points go to the nodes of the solid with the same weights N_a: the fluid does on the surface the work that the solid
//! takes.

use super::cut::{CutBySolid, CutPoint, SubSimplex, Vertex};
use crate::math::Vector;
use crate::mesh::{Mesh, Simplex};
use crate::pfem2::equations::element::{Block, Drive, Equations, Mass, Stabilisation};
use crate::pfem2::interface::Medium;

/// What fills the fluid part of a cut element.
#[derive(Debug, Clone, Copy)]
pub struct FluidPart<const D: usize, const N: usize> {
    /// Density and viscosity.
    pub medium: Medium,
    /// Stabilisation time τ [s].
    pub tau: f64,
    /// Nodal values of the right-hand side.
    pub drive: Drive<D, N>,
}

/// Equations of the fluid part of a cut element, in the unknowns of its nodes and of the nodes of solids.
#[derive(Debug, Clone)]
pub struct CoupledElement<const D: usize, const N: usize> {
    /// The element.
    pub element: u32,
    /// Volume of its fluid part over its own.
    pub share: f64,
    /// ∫ρ N_i over its fluid part [kg].
    pub mass: [f64; N],
    /// Rows and columns of its nodes.
    pub blocks: [[Block<N>; N]; N],
    /// Right-hand side of its nodes.
    pub loads: [[f64; N]; N],
    /// Nodes of solids that its cut points move with.
    pub solid: Vec<u32>,
    /// Rows (v, p) of node i, columns of solid node a: `[a][i]`.
    pub to_fluid: Vec<[[[f64; D]; N]; N]>,
    /// Rows of solid node a, columns (v, p) of node i: `[a][i]`.
    pub to_solid: Vec<[[[f64; N]; D]; N]>,
    /// Rows of solid node a, columns of solid node b: `[a * count + b]`.
    pub among_solid: Vec<[[f64; D]; D]>,
    /// Right-hand side of solid node a [N].
    pub solid_loads: Vec<Vector<D>>,
}

/// Velocity of a vertex by the unknowns that it depends on.
enum Follows {
    Node(usize),
    /// Places in [`CoupledElement::solid`] with their weights.
    Solid(Vec<(usize, f64)>),
}

/// A simplex of the fluid part.
struct Part<const D: usize, const N: usize> {
    simplex: Simplex<D, N>,
    /// Shape functions of the element at its centre.
    center: [f64; N],
    /// Its vertices, in the list of nodes and then cut points of the element.
    vertices: [usize; N],
}

impl<const D: usize, const N: usize> CoupledElement<D, N> {
    /// Equations of a cut element; `velocity_hat`: v̂ of all nodes of solids [m/s].
    pub fn new(
        mesh: &Mesh<D, N>,
        cut: &CutBySolid<N>,
        points: &[CutPoint<D>],
        fluid: &FluidPart<D, N>,
        equations: &Equations,
        velocity_hat: &[Vector<D>],
    ) -> Self {
        let own: Vec<&CutPoint<D>> = cut.points.iter().map(|&point| &points[point as usize]).collect();
        let mut element = Self::empty(cut.element, &own);
        let follows = element.follows(&own);
        let hat = |vertex: &Follows| match vertex {
            Follows::Node(i) => fluid.drive.convected[*i],
            Follows::Solid(all) => all.iter().map(|&(a, w)| velocity_hat[element.solid[a] as usize] * w).sum(),
        };
        let hats: Vec<Vector<D>> = follows.iter().map(hat).collect();
        let volume = mesh.simplex(cut.element as usize).volume;
        for part in parts(mesh, cut, &own) {
            element.share += part.simplex.volume / volume;
            let mass = fluid.medium.density * part.simplex.volume;
            (0..N).for_each(|k| element.mass[k] += mass * part.center[k]);
            element.add(mesh, &part, fluid, equations, &follows, &hats);
        }
        element
    }

    fn empty(element: u32, points: &[&CutPoint<D>]) -> Self {
        let mut solid: Vec<u32> = points.iter().flat_map(|point| point.weights.iter().map(|(a, _)| *a)).collect();
        solid.sort_unstable();
        solid.dedup();
        let count = solid.len();
        Self {
            element,
            share: 0.0,
            mass: [0.0; N],
            blocks: [[[[0.0; N]; N]; N]; N],
            loads: [[0.0; N]; N],
            to_fluid: vec![[[[0.0; D]; N]; N]; count],
            to_solid: vec![[[[0.0; N]; D]; N]; count],
            among_solid: vec![[[0.0; D]; D]; count * count],
            solid_loads: vec![Vector::ZERO; count],
            solid,
        }
    }

    /// The unknowns of its nodes and cut points.
    fn follows(&self, points: &[&CutPoint<D>]) -> Vec<Follows> {
        let place = |a: &u32| self.solid.binary_search(a).unwrap_or(0);
        let of = |point: &&CutPoint<D>| Follows::Solid(point.weights.iter().map(|(a, w)| (place(a), *w)).collect());
        (0..N).map(Follows::Node).chain(points.iter().map(of)).collect()
    }

    /// Adds the equations of a part.
    fn add(
        &mut self,
        mesh: &Mesh<D, N>,
        part: &Part<D, N>,
        fluid: &FluidPart<D, N>,
        equations: &Equations,
        follows: &[Follows],
        hats: &[Vector<D>],
    ) {
        let parent = &mesh.simplex(self.element as usize).gradient;
        let FluidPart { medium, tau, drive } = fluid;
        let (g, volume, delta) = (&part.simplex.gradient, part.simplex.volume, equations.delta);
        let force = drive.force.iter().copied().sum::<Vector<D>>() / N as f64;
        let stiffness = medium.viscosity * volume;
        let consistent = equations.stabilisation == Stabilisation::ConsistentPspg;
        let mut mean_hat = Vector::ZERO;
        for i in 0..N {
            let row = &follows[part.vertices[i]];
            mean_hat += hats[part.vertices[i]] / N as f64;
            let mut load = Vector::ZERO;
            for j in 0..N {
                let mass = medium.density * volume * mass_share::<N>(equations.mass, i == j);
                load += (hats[part.vertices[j]] / delta + force) * mass;
                let both = g[i].dot(g[j]);
                let block: [[f64; D]; D] = std::array::from_fn(|r| {
                    std::array::from_fn(|s| {
                        let inertia = if r == s { stiffness * both + mass / delta } else { 0.0 };
                        inertia + stiffness * g[i][s] * g[j][r]
                    })
                });
                self.add_velocities(row, &follows[part.vertices[j]], &block);
            }
            self.add_load(row, load);
            for k in 0..N {
                let share = volume * part.center[k];
                // −Dᵀ and −(D + R/Δ), theory (J.7), (J.9).
                let pressure = g[i] * -share;
                let residual = if consistent { tau / delta * volume / N as f64 } else { 0.0 };
                self.add_pressure(row, k, pressure, pressure - parent[k] * residual);
            }
        }
        let source = match equations.stabilisation {
            Stabilisation::Pspg => force,
            Stabilisation::ConsistentPspg => force + mean_hat / delta,
            Stabilisation::Oss => force + drive.projected.iter().copied().sum::<Vector<D>>() / N as f64,
        };
        for k in 0..N {
            self.loads[k][D] -= tau * volume * parent[k].dot(source);
            for l in 0..N {
                self.blocks[k][l][D][D] -= tau / medium.density * volume * parent[k].dot(parent[l]);
            }
        }
    }

    /// Adds a block of velocities.
    fn add_velocities(&mut self, row: &Follows, column: &Follows, block: &[[f64; D]; D]) {
        let count = self.solid.len();
        for r in 0..D {
            for s in 0..D {
                let value = block[r][s];
                match (row, column) {
                    (Follows::Node(i), Follows::Node(j)) => self.blocks[*i][*j][r][s] += value,
                    (Follows::Node(i), Follows::Solid(b)) => {
                        b.iter().for_each(|&(b, w)| self.to_fluid[b][*i][r][s] += w * value);
                    }
                    (Follows::Solid(a), Follows::Node(j)) => {
                        a.iter().for_each(|&(a, w)| self.to_solid[a][*j][r][s] += w * value);
                    }
                    (Follows::Solid(a), Follows::Solid(b)) => {
                        for &(a, w) in a {
                            b.iter().for_each(|&(b, x)| self.among_solid[a * count + b][r][s] += w * x * value);
                        }
                    }
                }
            }
        }
    }

    /// Adds the column of pressure k in a row of velocity, and the column of that velocity in the row of pressure k.
    fn add_pressure(&mut self, vertex: &Follows, k: usize, pressure: Vector<D>, divergence: Vector<D>) {
        for r in 0..D {
            match vertex {
                Follows::Node(i) => {
                    self.blocks[*i][k][r][D] += pressure[r];
                    self.blocks[k][*i][D][r] += divergence[r];
                }
                Follows::Solid(all) => {
                    for &(a, w) in all {
                        self.to_solid[a][k][r][D] += w * pressure[r];
                        self.to_fluid[a][k][D][r] += w * divergence[r];
                    }
                }
            }
        }
    }

    fn add_load(&mut self, vertex: &Follows, load: Vector<D>) {
        match vertex {
            Follows::Node(i) => (0..D).for_each(|r| self.loads[*i][r] += load[r]),
            Follows::Solid(all) => all.iter().for_each(|&(a, w)| self.solid_loads[a] += load * w),
        }
    }

    /// Rows of local node `i` against the velocities of solids [N, m³/s].
    pub fn from_solid(&self, i: usize, velocity: &[f64]) -> [f64; N] {
        let mut sum = [0.0; N];
        for (block, &node) in self.to_fluid.iter().zip(&self.solid) {
            for (sum, row) in sum.iter_mut().zip(&block[i]) {
                *sum += (0..D).map(|s| row[s] * velocity[node as usize * D + s]).sum::<f64>();
            }
        }
        sum
    }

    /// Force of the fluid on solid node `a` of the element [N]: load − matrix · x, for the unknowns of its nodes and of all solids.
    pub fn force(&self, a: usize, x: &[[f64; N]; N], velocity: &[f64]) -> Vector<D> {
        let count = self.solid.len();
        Vector::from_fn(|r| {
            let of_nodes: f64 = (0..N).map(|i| (0..N).map(|s| self.to_solid[a][i][r][s] * x[i][s]).sum::<f64>()).sum();
            let of_solids = (0..count).map(|b| {
                let node = self.solid[b] as usize;
                (0..D).map(|s| self.among_solid[a * count + b][r][s] * velocity[node * D + s]).sum::<f64>()
            });
            self.solid_loads[a][r] - of_nodes - of_solids.sum::<f64>()
        })
    }
}

/// M_ij over the mass of a simplex.
fn mass_share<const N: usize>(mass: Mass, diagonal: bool) -> f64 {
    match (mass, diagonal) {
        (Mass::Consistent, true) => 2.0 / (N * (N + 1)) as f64,
        (Mass::Consistent, false) => 1.0 / (N * (N + 1)) as f64,
        (Mass::Lumped, true) => 1.0 / N as f64,
        (Mass::Lumped, false) => 0.0,
    }
}

/// The simplices of the fluid part that have a volume.
fn parts<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    cut: &CutBySolid<N>,
    points: &[&CutPoint<D>],
) -> Vec<Part<D, N>> {
    let e = cut.element as usize;
    let corners = mesh.corners(e);
    let part = |part: &SubSimplex<N>| {
        let places = part.vertices.map(|vertex| match vertex {
            Vertex::Node(k) => (k as usize, corners[k as usize]),
            Vertex::Point(k) => (N + k as usize, points[k as usize].position),
        });
        let simplex = Simplex::new(places.map(|(_, x)| x)).filter(|simplex| simplex.volume > 0.0)?;
        let center = places.iter().map(|(_, x)| *x).sum::<Vector<D>>() / N as f64;
        Some(Part { simplex, center: mesh.shape_functions(e, center), vertices: places.map(|(vertex, _)| vertex) })
    };
    cut.parts.iter().filter_map(part).collect()
}
