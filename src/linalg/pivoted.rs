//! The factorisation with row exchanges: S A S = Pᵀ L U, supernodal, by `faer` (theory F.15).
//!
//! The last resort for matrices whose unsymmetric part rules somewhere, as at an outlet that a very viscous fluid
//! reaches:
//! there the symmetric part may be indefinite, and its factor (`direct`) says nothing about the matrix. It takes about
//! four times the time and memory of the symmetric factor, and its structure depends on the numbers.

use super::matrix::BlockMatrix;
use super::sparse::solve_scaled;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

/// The factor of one matrix.
pub(super) struct PivotedFactor {
    factor: Lu<u32, f64>,
    scaling: Vec<f64>,
    work: Vec<f64>,
}

impl PivotedFactor {
    /// Factorises S A S; `None` where it is singular or too large.
    pub fn new<const B: usize>(a: &BlockMatrix<B>, scaling: &[[f64; B]]) -> Option<Self> {
        let (start, rows, values) = compressed_columns(a, scaling)?;
        let n = start.len() - 1;
        let places = SymbolicSparseColMatRef::new_checked(n, n, &start, None, &rows);
        let symbolic = SymbolicLu::try_new(places).ok()?;
        let factor = Lu::try_new_with_symbolic(symbolic, SparseColMatRef::new(places, &values[..])).ok()?;
        Some(Self { factor, scaling: scaling.as_flattened().to_vec(), work: vec![0.0; n] })
    }

    /// z = A⁻¹ r.
    pub fn solve<const B: usize>(&mut self, r: &[[f64; B]], z: &mut [[f64; B]]) {
        solve_scaled(&self.factor, &self.scaling, &mut self.work, r.as_flattened(), z.as_flattened_mut());
    }
}

/// S A S by columns: where each begins, the rows of its numbers, and the numbers. `None` if 31 bits can't count them.
fn compressed_columns<const B: usize>(a: &BlockMatrix<B>, s: &[[f64; B]]) -> Option<(Vec<u32>, Vec<u32>, Vec<f64>)> {
    let pattern = &a.pattern;
    let count = pattern.entries() * B * B;
    if count > i32::MAX as usize {
        return None;
    }
    let (mut start, mut rows, mut values) = (vec![0], Vec::with_capacity(count), Vec::with_capacity(count));
    for node in 0..pattern.rows() {
        for column in 0..B {
            for entry in pattern.row(node) {
                let other = pattern.columns()[entry] as usize;
                let block = &a.values[pattern.mirror(entry)];
                rows.extend((0..B).map(|row| (other * B + row) as u32));
                values.extend((0..B).map(|row| block[row][column] * s[other][row] * s[node][column]));
            }
            start.push(rows.len() as u32);
        }
    }
    Some((start, rows, values))
}
