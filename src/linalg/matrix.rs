//! Sparse matrices of small dense blocks on the pattern of a mesh.
//!
//! ```text
//! row i, column j: a block of B × B numbers; the unknowns of node i are (v_1 … v_D, p), B = D + 1
//! ```

use super::pattern::Pattern;
use rayon::prelude::*;
use std::sync::Arc;

/// Rows per task of a product. Fixed, and each row is summed in one task: the same bits for any number of threads.
const ROWS: usize = 512;

/// Largest factor of rows: where the stabilisation takes nearly all of the divergence out of a row of continuity,
/// 1 − τ/Δ ≪ 1, what is left of it is no multiple of what pressure does.
const MOST_BALANCE: f64 = 2.0;

/// A matrix with one block of B × B per entry of the pattern.
#[derive(Debug, Clone)]
pub struct BlockMatrix<const B: usize> {
    /// Positions of the blocks.
    pub pattern: Arc<Pattern>,
    /// One block per entry: `values[entry][row][column]`.
    pub values: Vec<[[f64; B]; B]>,
}

impl<const B: usize> BlockMatrix<B> {
    /// All zeros.
    pub fn zeros(pattern: Arc<Pattern>) -> Self {
        let values = vec![[[0.0; B]; B]; pattern.entries()];
        Self { pattern, values }
    }

    /// y = A x.
    pub fn multiply(&self, x: &[[f64; B]], y: &mut [[f64; B]]) {
        y.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, rows)| {
            for (offset, sum) in rows.iter_mut().enumerate() {
                *sum = self.row_product(chunk * ROWS + offset, x);
            }
        });
    }

    /// A row of A x.
    pub fn row_product(&self, row: usize, x: &[[f64; B]]) -> [f64; B] {
        let mut sum = [0.0; B];
        for entry in self.pattern.row(row) {
            add_product(&self.values[entry], &x[self.pattern.columns()[entry] as usize], &mut sum);
        }
        sum
    }

    /// s_i = |a_ii|^(−1/2), and one where the diagonal is zero: symmetric scaling makes the diagonal ±1.
    pub fn scaling(&self) -> Vec<[f64; B]> {
        let diagonal = |row: usize| &self.values[self.pattern.diagonal(row)];
        (0..self.pattern.rows()).map(|row| std::array::from_fn(|k| scale_of(diagonal(row)[k][k]))).collect()
    }

    /// Factors r_i of the rows of continuity that make the matrix as symmetric as they can: with the entries q of row i
    /// on velocities and g of velocities on pressure i, Σ (r_i q − g)² → min, r_i = Σ q·g / Σ q·q (theory (F.42a)).
    /// Between ½ and 2, and one where q = g or all q are zero.
    pub fn row_balance(&self) -> Vec<f64> {
        let p = B - 1;
        let factor = |row: usize| {
            let (mut both, mut own) = (0.0, 0.0);
            for entry in self.pattern.row(row) {
                let (block, mirrored) = (&self.values[entry], &self.values[self.pattern.mirror(entry)]);
                for k in 0..p {
                    both += block[p][k] * mirrored[k][p];
                    own += block[p][k] * block[p][k];
                }
            }
            if own > 0.0 { (both / own).clamp(MOST_BALANCE.recip(), MOST_BALANCE) } else { 1.0 }
        };
        (0..self.pattern.rows()).map(factor).collect()
    }

    /// The symmetric part of R A at an entry, (R_i A_ij + (R_j A_ji)ᵀ)/2, with R = diag(1 … 1, r_i) in the block of
    /// node i.
    pub fn symmetric(&self, (row, entry): (usize, usize), balance: &[f64]) -> [[f64; B]; B] {
        let (block, mirrored) = (&self.values[entry], &self.values[self.pattern.mirror(entry)]);
        let factor = |node: usize, k: usize| if k + 1 == B { balance[node] } else { 1.0 };
        let column = self.pattern.columns()[entry] as usize;
        std::array::from_fn(|i| {
            std::array::from_fn(|j| 0.5 * (factor(row, i) * block[i][j] + factor(column, j) * mirrored[j][i]))
        })
    }
}

fn scale_of(diagonal: f64) -> f64 {
    if diagonal == 0.0 { 1.0 } else { diagonal.abs().sqrt().recip() }
}

#[inline(always)]
fn add_product<const B: usize>(block: &[[f64; B]; B], x: &[f64; B], sum: &mut [f64; B]) {
    for (sum, row) in sum.iter_mut().zip(block) {
        for (a, x) in row.iter().zip(x) {
            *sum += a * x;
        }
    }
}
