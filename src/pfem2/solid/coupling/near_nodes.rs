//! The nodes of the fluid that viscosity ties to the surface of solids (theory (J.10b)).
//!
//! ```text
//! [ S   F_t  ] [y]   [r_S]
//! [ E_t A_tt ] [δ] = [r_t]        t: velocities of the nodes i with Σ_a |E_ia| > ε A_ii
//! ```
//!
//! A cut point close to a node makes both move as one, whatever the fluid around them does: neither the preconditioner
//! of the fluid, for which solids stand still, nor S knows that. Here both are solved with one sparse factor.

use super::node_coupling::NodeCoupling;
use crate::linalg::{BlockMatrix, MatrixEntry, NearAndBorder, PreconditioningFactor, SparseMatrix};
use crate::pfem2::solid::equations::independent::IndependentVelocities;

/// ε: fraction of a node's diagonal that solids have, above which the node is solved with them.
const LEAST_SOLID_FRACTION: f64 = 0.01;

/// The border with its near nodes.
pub struct NearNodes {
    /// The nodes, ascending.
    pub nodes: Vec<u32>,
    factor: PreconditioningFactor,
}

impl NearNodes {
    /// The near nodes, from the matrix of a border, the blocks that couple it to the fluid, and the matrix
    /// of the fluid. `None` if it is singular.
    pub fn new<const D: usize, const N: usize>(
        border: &SparseMatrix,
        couplings: &[NodeCoupling<D, N>],
        velocities: &IndependentVelocities,
        fluid: &BlockMatrix<N>,
    ) -> Option<Self> {
        let nodes = near(couplings, fluid);
        let place = |node: u32| nodes.binary_search(&node).ok();
        let unknown = |place: usize, axis: usize| (border.rows() + place * D + axis) as u32;
        let mut entries: Vec<MatrixEntry> = border.triplets().collect();
        for (row, &node) in nodes.iter().enumerate() {
            for entry in fluid.pattern.row(node as usize) {
                let Some(column) = place(fluid.pattern.columns()[entry]) else { continue };
                let block = &fluid.values[entry];
                let entry = |r: usize, s: usize| MatrixEntry::new(unknown(row, r), unknown(column, s), block[r][s]);
                entries.extend((0..D * D).map(|k| entry(k / D, k % D)));
            }
        }
        for (coupling, own) in couplings.iter().filter_map(|coupling| Some((coupling, place(coupling.node)?))) {
            for (column, &a) in coupling.solid.iter().enumerate() {
                for (r, s) in (0..D * D).map(|k| (k / D, k % D)) {
                    let (e, f) = (coupling.to_fluid[column][r][s], coupling.to_solid[column][s][r]);
                    for (w, weight) in velocities.row(a as usize * D + s) {
                        let k = unknown(own, r);
                        entries.extend([MatrixEntry::new(k, w, e * weight), MatrixEntry::new(w, k, f * weight)]);
                    }
                }
            }
        }
        let unknowns = border.rows() + nodes.len() * D;
        let matrix = SparseMatrix::from_triplets(unknowns, entries);
        let factor = PreconditioningFactor::new(&matrix)?;
        Some(Self { nodes, factor })
    }

    /// Solves for the velocities of the near nodes and of the border, from the residuals of their rows, for several
    /// right-hand sides.
    pub fn solve<const N: usize>(&self, sides: &mut [NearAndBorder<N>]) {
        let together = |side: &NearAndBorder<N>| {
            let velocities = side.near.iter().flat_map(|near| &near[..N - 1]);
            side.border.iter().chain(velocities).copied().collect()
        };
        let mut vectors: Vec<Vec<f64>> = sides.iter().map(together).collect();
        self.factor.solve_all(&mut vectors);
        for (side, solution) in sides.iter_mut().zip(&vectors) {
            let (border, velocities) = solution.split_at(side.border.len());
            side.border.copy_from_slice(border);
            for (near, v) in side.near.iter_mut().zip(velocities.chunks_exact(N - 1)) {
                near[..N - 1].copy_from_slice(v);
                near[N - 1] = 0.0;
            }
        }
    }
}

/// The nodes near the border, ascending.
fn near<const D: usize, const N: usize>(couplings: &[NodeCoupling<D, N>], fluid: &BlockMatrix<N>) -> Vec<u32> {
    let is_near = |coupling: &&NodeCoupling<D, N>| {
        let diagonal = &fluid.values[fluid.pattern.diagonal(coupling.node as usize)];
        (0..D).any(|r| {
            let of_solids: f64 = coupling.to_fluid.iter().flat_map(|block| block[r]).map(f64::abs).sum();
            of_solids > LEAST_SOLID_FRACTION * diagonal[r][r]
        })
    };
    couplings.iter().filter(is_near).map(|coupling| coupling.node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Pattern;
    use std::sync::Arc;

    /// A node of the fluid with the diagonal a, tied by k to a node of a solid with the diagonal s, along each axis
    /// alone: s y − k δ = r, a δ − k y = q. Another node is hardly tied.
    #[test]
    fn a_node_at_the_surface_moves_with_the_solid_as_by_hand() {
        let [s, a, k] = [5.0, 8.0, 6.0];
        let pattern = Arc::new(Pattern::new(3, &[[0u32, 1, 2]]));
        let mut fluid = BlockMatrix::<3>::zeros(pattern.clone());
        (0..3).for_each(|node| (0..2).for_each(|axis| fluid.values[pattern.diagonal(node)][axis][axis] = a));
        let coupling = |node: u32, k: f64| NodeCoupling::<2, 3> {
            node,
            solid: vec![0],
            to_fluid: vec![[[-k, 0.0], [0.0, -k], [0.0; 2]]],
            to_solid: vec![[[-k, 0.0, 0.0], [0.0, -k, 0.0]]],
        };
        let couplings = [coupling(1, k), coupling(2, 0.01)];
        let border = SparseMatrix::from_triplets(2, vec![(0, 0, s), (1, 1, s)]);
        let mut velocities = IndependentVelocities::default();
        let first = velocities.add(&[0.0, 0.0]);
        (0..2).for_each(|axis| velocities.push(&[(first + axis, 1.0)], 0.0));
        let nodes = NearNodes::new(&border, &couplings, &velocities, &fluid).unwrap();
        assert_eq!(nodes.nodes, [1]);
        let mut sides = [1.0, -2.0]
            .map(|c| NearAndBorder { near: vec![[1.0, 2.0, 7.0].map(|r| c * r)], border: vec![3.0 * c, 4.0 * c] });
        nodes.solve(&mut sides);
        for axis in 0..2 {
            let (q, r) = ([1.0, 2.0][axis], [3.0, 4.0][axis]);
            let y = (r + k / a * q) / (s - k * k / a);
            for (side, c) in sides.iter().zip([1.0, -2.0]) {
                // To single numbers: y counts s + k²/a against s − k²/a.
                let near = |found: f64, exact: f64| (found / exact - 1.0).abs() < 20.0 * f64::from(f32::EPSILON);
                assert!(near(side.border[axis], c * y), "{side:?}");
                assert!(near(side.near[0][axis], c * (q + k * y) / a), "{side:?}");
            }
        }
        assert_eq!(sides.map(|side| side.near[0][2]), [0.0; 2]);
    }
}
