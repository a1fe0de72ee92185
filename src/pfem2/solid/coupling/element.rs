//! Rows and columns of an element that the surface of a solid cuts, in the unknowns of its nodes and of the nodes of
//! the solid that its cut points move with (theory J.3).

use super::trace::TracePoint;
use super::walls::WallArea;
use crate::math::{Tensor, Vector};
use crate::pfem2::element::{Block, Content};
use crate::pfem2::solid::cut::{CutPoint, VelocityWeights};

/// Equations of the fluid part of a cut element, in the unknowns of its nodes and of the nodes of solids.
#[derive(Debug, Clone)]
pub struct CoupledElement<const D: usize, const N: usize> {
    /// The element.
    pub element: u32,
    /// Content of its fluid part.
    pub content: Content<N>,
    /// Lumped mass of its fluid part at its nodes and then its cut points [kg].
    pub vertex_mass: Vec<f64>,
    /// True for nodes whose pressure acts on their own side of an interface somewhere in the fluid part.
    pub tied: [bool; N],
    /// Energy of the interface in it [J].
    pub energy: f64,
    /// Areas of walls beside its cut points.
    pub on_walls: Vec<WallArea<D, N>>,
    /// Facets of its fluid part at openings.
    pub openings: Vec<Opening<D>>,
    /// Pressures of nodes inside that follow those of the nodes outside.
    pub(super) one_sided: Vec<OneSidedPressure>,
    /// Local nodes outside, where there are such pressures.
    pub(super) outside: Vec<usize>,
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
#[derive(Debug, Clone, Copy)]
pub(in crate::pfem2::solid) enum Unknown {
    /// Velocity of a local node.
    Node(usize),
    /// Velocity of a node of a solid: its place in [`CoupledElement::solid`].
    Solid(usize),
}

/// Velocity of a vertex by the unknowns that it depends on: v = Σ P v_k.
pub(in crate::pfem2::solid) type VelocityMap<const D: usize> = Vec<(Unknown, Tensor<D>)>;

/// A facet of the fluid part of a cut element at an opening.
#[derive(Debug, Clone)]
pub struct Opening<const D: usize> {
    /// The facet of the mesh, by the local node opposite to it.
    pub(super) facet: u32,
    /// Its area vector [m²], out of the mesh.
    pub(super) area: Vector<D>,
    /// Positions of its corners [m].
    pub(super) positions: [Vector<D>; D],
    /// Velocities of its corners, by the unknowns of the element.
    pub(super) velocities: [VelocityMap<D>; D],
    /// Load at each corner [N].
    pub(super) loads: [Vector<D>; D],
    /// Blocks of an outlet in the rows of its corners.
    pub(super) outflow: Vec<OutflowBlock<D>>,
}

/// The pressure of a node inside on the side of an element.
#[derive(Debug, Clone, Copy)]
pub(super) struct OneSidedPressure {
    /// The local node.
    pub node: usize,
    /// Its pressure over the mean of those of the nodes outside, at rest [Pa].
    pub above: f64,
}

/// A block of an outlet, in the rows of a corner of its facet (theory (J.9e)).
#[derive(Debug, Clone)]
pub(super) struct OutflowBlock<const D: usize> {
    /// Velocity of the corner, by the unknowns of the element.
    pub row: VelocityMap<D>,
    /// The velocity that it acts on.
    pub column: VelocityMap<D>,
    /// The block [kg/s].
    pub block: Tensor<D>,
}

/// The velocities of the vertices of an element.
pub(in crate::pfem2::solid) struct VertexVelocities<const D: usize> {
    /// Velocity of each vertex by the unknowns that it follows.
    pub maps: Vec<VelocityMap<D>>,
    /// v̂ [m/s].
    pub hats: Vec<Vector<D>>,
    /// Positions of the cut points [m].
    pub positions: Vec<Vector<D>>,
}

impl<const D: usize, const N: usize> CoupledElement<D, N> {
    /// No equations, with the unknowns of cut points and points of the surface.
    pub(super) fn empty(element: u32, points: &[&CutPoint<D>], trace: &[TracePoint<D, N>]) -> Self {
        let weights = points.iter().map(|point| &point.weights).chain(trace.iter().map(|point| &point.weights));
        let mut solid: Vec<u32> = weights.flatten().map(|(a, _)| *a).collect();
        solid.sort_unstable();
        solid.dedup();
        let count = solid.len();
        Self {
            element,
            content: Content { mass: [0.0; N], viscosity: 0.0, tau: 0.0, volume_over_density: 0.0 },
            vertex_mass: vec![0.0; N + points.len()],
            tied: [false; N],
            energy: 0.0,
            on_walls: Vec::new(),
            openings: Vec::new(),
            one_sided: Vec::new(),
            outside: Vec::new(),
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
    pub(super) fn velocity_maps(&self, nodes: &[u32; N], points: &[&CutPoint<D>]) -> Vec<VelocityMap<D>> {
        let place = |a: u32| Unknown::Solid(self.solid.binary_search(&a).unwrap_or(0));
        let of = |point: &&CutPoint<D>| {
            let VelocityWeights { solid, node } = point.velocity_weights();
            let of_solid = point.weights.iter().map(|&(a, w)| (place(a), solid * w));
            let of_node = nodes.iter().position(|&i| point.gliding_node == Some(i)).zip(node);
            of_solid.chain(of_node.map(|(i, p)| (Unknown::Node(i), p))).collect()
        };
        let nodal = |i| vec![(Unknown::Node(i), Tensor::identity())];
        (0..N).map(nodal).chain(points.iter().map(of)).collect()
    }

    /// Adds a block of velocities.
    pub(super) fn add_velocities(&mut self, row: &VelocityMap<D>, column: &VelocityMap<D>, block: &Tensor<D>) {
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
    pub(super) fn add_pressure(
        &mut self,
        vertex: &VelocityMap<D>,
        k: usize,
        pressure: Vector<D>,
        divergence: Vector<D>,
    ) {
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

    /// Adds to the right-hand side of a velocity [N].
    pub(super) fn add_load(&mut self, vertex: &VelocityMap<D>, load: Vector<D>) {
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

    /// Force of the fluid on solid node `a` of the element [N]: load − matrix · x, for the unknowns of its nodes and
    /// of all solids.
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
