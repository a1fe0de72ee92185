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

use super::cut::{CutBySolid, CutPoint, FluidSimplex, Motion, Vertex};
use crate::math::{Tensor, Vector};
use crate::mesh::{Mesh, Simplex};
use crate::pfem2::equations::element::{Block, Drive, Equations, Mass, Stabilisation, viscous_forces};
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

/// An unknown of an element.
#[derive(Clone, Copy)]
enum Unknown {
    /// Velocity of a local node.
    Node(usize),
    /// Velocity of a node of a solid: its place in [`CoupledElement::solid`].
    Solid(usize),
}

/// Velocity of a vertex by the unknowns that it depends on: v = Σ P v_k.
type Follows<const D: usize> = Vec<(Unknown, Tensor<D>)>;

/// A simplex of the fluid part.
struct PartGeometry<const D: usize, const N: usize> {
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
        let follows = element.follows(&cut.nodes, &own);
        let of = |unknown: Unknown| match unknown {
            Unknown::Node(i) => fluid.drive.convected[i],
            Unknown::Solid(a) => velocity_hat[element.solid[a] as usize],
        };
        let hat = |vertex: &Follows<D>| vertex.iter().map(|&(unknown, p)| p.apply(of(unknown))).sum();
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
    fn follows(&self, nodes: &[u32; N], points: &[&CutPoint<D>]) -> Vec<Follows<D>> {
        let place = |a: u32| Unknown::Solid(self.solid.binary_search(&a).unwrap_or(0));
        let of = |point: &&CutPoint<D>| {
            let Motion { own, outside } = point.motion();
            let solid = point.weights.iter().map(|&(a, w)| (place(a), own * w));
            let node = nodes.iter().position(|&node| node == point.edge[0]).zip(outside);
            solid.chain(node.map(|(i, p)| (Unknown::Node(i), p))).collect()
        };
        let nodal = |i| vec![(Unknown::Node(i), Tensor::identity())];
        (0..N).map(nodal).chain(points.iter().map(of)).collect()
    }

    /// Adds the equations of a part.
    fn add(
        &mut self,
        mesh: &Mesh<D, N>,
        part: &PartGeometry<D, N>,
        fluid: &FluidPart<D, N>,
        equations: &Equations,
        follows: &[Follows<D>],
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
                let block = Tensor::from_fn(|r, s| {
                    let inertia = if r == s { stiffness * both + mass / delta } else { 0.0 };
                    inertia + stiffness * g[i][s] * g[j][r]
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
        let projected = drive.projected.iter().copied().sum::<Vector<D>>() / N as f64;
        let source = match equations.stabilisation {
            Stabilisation::Pspg => force,
            Stabilisation::ConsistentPspg => force + projected + mean_hat / delta,
            Stabilisation::Oss => force + projected,
        };
        for k in 0..N {
            self.loads[k][D] -= tau * volume * parent[k].dot(source);
            for l in 0..N {
                self.blocks[k][l][D][D] -= tau / medium.density * volume * parent[k].dot(parent[l]);
            }
        }
    }

    /// Adds a block of velocities.
    fn add_velocities(&mut self, row: &Follows<D>, column: &Follows<D>, block: &Tensor<D>) {
        let count = self.solid.len();
        for &(first, p) in row {
            let left = p.transpose().dot(block);
            for &(second, q) in column {
                let product = left.dot(&q);
                for r in 0..D {
                    for s in 0..D {
                        let value = product[r][s];
                        match (first, second) {
                            (Unknown::Node(i), Unknown::Node(j)) => self.blocks[i][j][r][s] += value,
                            (Unknown::Node(i), Unknown::Solid(b)) => self.to_fluid[b][i][r][s] += value,
                            (Unknown::Solid(a), Unknown::Node(j)) => self.to_solid[a][j][r][s] += value,
                            (Unknown::Solid(a), Unknown::Solid(b)) => self.among_solid[a * count + b][r][s] += value,
                        }
                    }
                }
            }
        }
    }

    /// Adds the column of pressure k in a row of velocity, and the column of that velocity in the row of pressure k.
    fn add_pressure(&mut self, vertex: &Follows<D>, k: usize, pressure: Vector<D>, divergence: Vector<D>) {
        for &(unknown, p) in vertex {
            let transposed = p.transpose();
            let (pressure, divergence) = (transposed.apply(pressure), transposed.apply(divergence));
            for r in 0..D {
                match unknown {
                    Unknown::Node(i) => {
                        self.blocks[i][k][r][D] += pressure[r];
                        self.blocks[k][i][D][r] += divergence[r];
                    }
                    Unknown::Solid(a) => {
                        self.to_solid[a][k][r][D] += pressure[r];
                        self.to_fluid[a][k][D][r] += divergence[r];
                    }
                }
            }
        }
    }

    fn add_load(&mut self, vertex: &Follows<D>, load: Vector<D>) {
        for &(unknown, p) in vertex {
            let load = p.transpose().apply(load);
            match unknown {
                Unknown::Node(i) => (0..D).for_each(|r| self.loads[i][r] += load[r]),
                Unknown::Solid(a) => self.solid_loads[a] += load,
            }
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

/// Viscous force on each node of an element [N], and its share of the mass of the fluid there [kg].
pub type CutForces<const D: usize, const N: usize> = [(Vector<D>, f64); N];

/// Viscous forces of the fluid part of a cut element on the nodes of the element; `velocity` [m/s] of these and of nodes of solids.
pub fn cut_forces<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    cut: &CutBySolid<N>,
    points: &[CutPoint<D>],
    medium: Medium,
    velocity: [&dyn Fn(usize) -> Vector<D>; 2],
) -> CutForces<D, N> {
    let own: Vec<&CutPoint<D>> = cut.points.iter().map(|&point| &points[point as usize]).collect();
    let [of_node, of_solid] = velocity;
    let nodes = &mesh.elements()[cut.element as usize];
    let mut sum = [(Vector::ZERO, 0.0); N];
    for PartGeometry { simplex, vertices, .. } in parts(mesh, cut, &own) {
        let at = |k: usize| match nodes.get(k) {
            Some(&node) => of_node(node as usize),
            None => own[k - N].velocity(of_node, of_solid),
        };
        let forces = viscous_forces(&simplex, medium.viscosity, &vertices.map(at));
        for (&k, force) in vertices.iter().zip(forces).filter(|(k, _)| **k < N) {
            sum[k].0 += force;
            sum[k].1 += medium.density * simplex.volume / N as f64;
        }
    }
    sum
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
) -> Vec<PartGeometry<D, N>> {
    let e = cut.element as usize;
    let corners = mesh.corners(e);
    let part = |part: &FluidSimplex<N>| {
        let places = part.vertices.map(|vertex| match vertex {
            Vertex::Node(k) => (k as usize, corners[k as usize]),
            Vertex::Point(k) => (N + k as usize, points[k as usize].position),
        });
        let simplex = Simplex::new(places.map(|(_, x)| x)).filter(|simplex| simplex.volume > 0.0)?;
        let center = places.iter().map(|(_, x)| *x).sum::<Vector<D>>() / N as f64;
        Some(PartGeometry {
            simplex,
            center: mesh.shape_functions(e, center),
            vertices: places.map(|(vertex, _)| vertex),
        })
    };
    cut.parts.iter().filter_map(part).collect()
}
