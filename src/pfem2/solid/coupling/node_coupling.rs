//! The blocks that couple a node of the fluid to the nodes of solids, summed over the cut elements around it
//! (theory J.3, J.4).
//!
//! ```text
//! E_ia = Σ_e E^e_ia     rows (v, p) of node i, columns of solid node a;       F_ai = Σ_e F^e_ai: the transposed place
//! ```

use super::element::CoupledElement;
use crate::linalg::MatrixEntry;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::boundary::Constraints;
use crate::pfem2::solid::equations::independent::IndependentVelocities;
use std::collections::BTreeMap;

/// Nodes per piece of a parallel loop.
const PIECE: usize = 16;

/// Blocks that couple a node of the fluid to solids, without its prescribed unknowns.
pub(in crate::pfem2::solid) struct NodeCoupling<const D: usize, const N: usize> {
    /// The node.
    pub node: u32,
    /// Nodes of solids, ascending.
    pub solid: Vec<u32>,
    /// E_ia, in the order of `solid`.
    pub to_fluid: Vec<[[f64; D]; N]>,
    /// F_ai, in the order of `solid`.
    pub to_solid: Vec<[[f64; N]; D]>,
}

impl<const D: usize, const N: usize> NodeCoupling<D, N> {
    /// Couplings of all nodes of cut elements, ascending.
    pub fn all(mesh: &Mesh<D, N>, elements: &[CoupledElement<D, N>]) -> Vec<Self> {
        let mut around: BTreeMap<u32, Vec<(usize, usize)>> = BTreeMap::new();
        for (place, element) in elements.iter().enumerate() {
            let nodes = mesh.elements()[element.element as usize].iter().enumerate();
            nodes.for_each(|(i, &node)| around.entry(node).or_default().push((place, i)));
        }
        let around: Vec<(u32, Vec<(usize, usize)>)> = around.into_iter().collect();
        parallel::collect(around.len(), PIECE, |n| {
            let (node, places) = &around[n];
            Self::new(*node, places.iter().map(|&(place, i)| (&elements[place], i)))
        })
    }

    /// Coupling of a node, with the elements around it and its place in each.
    fn new<'a>(node: u32, elements: impl Iterator<Item = (&'a CoupledElement<D, N>, usize)> + Clone) -> Self {
        let mut solid: Vec<u32> = elements.clone().flat_map(|(element, _)| element.solid.iter().copied()).collect();
        solid.sort_unstable();
        solid.dedup();
        let (mut to_fluid, mut to_solid) = (vec![[[0.0; D]; N]; solid.len()], vec![[[0.0; N]; D]; solid.len()]);
        for (element, i) in elements {
            for (place, a) in element.solid.iter().enumerate() {
                let Ok(column) = solid.binary_search(a) else { continue };
                for (r, s) in (0..N * D).map(|k| (k / D, k % D)) {
                    to_fluid[column][r][s] += element.to_fluid[place][i][r][s];
                    to_solid[column][s][r] += element.to_solid[place][i][s][r];
                }
            }
        }
        Self { node, solid, to_fluid, to_solid }
    }

    /// Turns the velocity of the node into its frame.
    pub fn turn(&mut self, constraints: &Constraints<D, N>) {
        let Some(frame) = constraints.frame(self.node as usize) else { return };
        for (rows, columns) in self.to_fluid.iter_mut().zip(&mut self.to_solid) {
            for s in 0..D {
                let turned = frame.apply(Vector::<D>::from_fn(|r| rows[r][s]));
                (0..D).for_each(|r| rows[r][s] = turned[r]);
                let turned = frame.apply(Vector::<D>::from_fn(|r| columns[s][r]));
                columns[s][..D].copy_from_slice(&turned.0);
            }
        }
    }

    /// Takes out the prescribed unknowns of the node; `load`: the right-hand side of the nodes of solids.
    pub fn eliminate_fluid(&mut self, constraints: &Constraints<D, N>, load: &mut [f64]) {
        let (mask, value) = (constraints.mask[self.node as usize], &constraints.value[self.node as usize]);
        for k in (0..N).filter(|k| mask >> k & 1 == 1) {
            for (place, &a) in self.solid.iter().enumerate() {
                self.to_fluid[place][k] = [0.0; D];
                for s in 0..D {
                    load[a as usize * D + s] -= self.to_solid[place][s][k] * value[k];
                    self.to_solid[place][s][k] = 0.0;
                }
            }
        }
    }

    /// Moves what the prescribed parts of the velocities of solids bring to the right-hand side of the fluid.
    pub fn move_prescribed(&self, velocities: &IndependentVelocities, rhs: &mut [[f64; N]]) {
        let rhs = &mut rhs[self.node as usize];
        for (rows, &a) in self.to_fluid.iter().zip(&self.solid) {
            for s in 0..D {
                let value = velocities.prescribed(a as usize * D + s);
                rhs.iter_mut().zip(rows).for_each(|(rhs, row)| *rhs -= row[s] * value);
            }
        }
    }

    /// Adds E v to the rows of the node; `velocity` of all nodes of solids, axis by axis.
    pub fn add_flux(&self, velocity: &[f64], rows: &mut [[f64; N]]) {
        let mut sum = [0.0; N];
        for (block, &a) in self.to_fluid.iter().zip(&self.solid) {
            let v: [f64; D] = std::array::from_fn(|s| velocity[a as usize * D + s]);
            sum.iter_mut()
                .zip(block)
                .for_each(|(sum, row)| *sum += row.iter().zip(&v).map(|(e, v)| e * v).sum::<f64>());
        }
        rows[self.node as usize].iter_mut().zip(sum).for_each(|(row, sum)| *row += sum);
    }

    /// Adds the entries of E T and Tᵀ F, whose independent velocities come after `first` unknowns of the mesh.
    pub fn add_entries(&self, velocities: &IndependentVelocities, first: u32, entries: &mut Vec<MatrixEntry>) {
        let of_node = |r: usize| self.node * N as u32 + r as u32;
        for ((rows, columns), &a) in self.to_fluid.iter().zip(&self.to_solid).zip(&self.solid) {
            for (s, r) in (0..N * D).map(|k| (k / N, k % N)) {
                for (w, weight) in velocities.row(a as usize * D + s) {
                    entries.push(MatrixEntry::new(of_node(r), first + w, rows[r][s] * weight));
                    entries.push(MatrixEntry::new(first + w, of_node(r), columns[s][r] * weight));
                }
            }
        }
    }

    /// E_p y in the row of continuity of the node.
    pub fn volume_flux(&self, velocity: &[f64]) -> f64 {
        let of = |(block, &a): (&[[f64; D]; N], &u32)| -> f64 {
            block[N - 1].iter().zip(&velocity[a as usize * D..]).map(|(e, v)| e * v).sum()
        };
        self.to_fluid.iter().zip(&self.solid).map(of).sum()
    }

    /// Adds F x to the rows of the nodes of solids.
    pub fn add_forces(&self, x: &[[f64; N]], forces: &mut [f64]) {
        let x = x[self.node as usize];
        for (block, &a) in self.to_solid.iter().zip(&self.solid) {
            for (sum, row) in forces[a as usize * D..][..D].iter_mut().zip(block) {
                *sum += row.iter().zip(&x).map(|(f, x)| f * x).sum::<f64>();
            }
        }
    }
}
