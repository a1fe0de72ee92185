//! Gauss–Seidel in blocks of rows: sequential inside a block, with the old values of the other blocks.
//!
//! The blocks depend on the size alone, so that the sweeps give the same bits for any number of threads.

use super::csr::Csr;
use rayon::prelude::*;

/// Number of blocks of rows, at most.
const BLOCKS: usize = 8;

/// Least size of a block.
const SMALLEST_BLOCK: usize = 4096;

/// Rows per block.
pub(in crate::linalg) fn block_rows(rows: usize) -> usize {
    rows.div_ceil(BLOCKS).max(SMALLEST_BLOCK)
}

/// x after one sweep through ascending rows from x = 0.
pub(super) fn forward_from_zero(a: &Csr, inverse_diagonal: &[f32], b: &[f32], x: &mut [f32]) {
    let size = block_rows(a.rows());
    x.par_chunks_mut(size).enumerate().for_each(|(block, x)| {
        let from = block * size;
        for local in 0..x.len() {
            let row = from + local;
            // Rows behind this one, and other blocks, are still zero.
            let known: f32 = a.row(row).filter(|&(j, _)| j >= from && j < row).map(|(j, v)| v * x[j - from]).sum();
            x[local] = (b[row] - known) * inverse_diagonal[row];
        }
    });
}

/// One sweep through descending rows; `old` is workspace for the values before it.
pub(super) fn backward(a: &Csr, inverse_diagonal: &[f32], b: &[f32], x: &mut [f32], old: &mut [f32]) {
    old.copy_from_slice(x);
    let size = block_rows(a.rows());
    let old = &*old;
    x.par_chunks_mut(size).enumerate().for_each(|(block, x)| {
        let from = block * size;
        for local in (0..x.len()).rev() {
            let row = from + local;
            let mut rest = b[row];
            for (j, v) in a.row(row) {
                // Other blocks wrap around to numbers beyond this one's length.
                rest -= v * x.get(j.wrapping_sub(from)).copied().unwrap_or(old[j]);
            }
            x[local] += rest * inverse_diagonal[row];
        }
    });
}
