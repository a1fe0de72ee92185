//! The independent velocities of solids, from which those of all nodes follow (theory J.10).
//!
//! ```text
//! v = T w + v̄,      (M/Δ + Δ K) v = r + forces of supports and ties      becomes      Tᵀ S T w = Tᵀ (r − S v̄)
//! ```
//!
//! A free node has D entries of w; a node that is held has none along that axis, a node of a rigid solid those
//! of the solid, a node that is tied those of the nodes that it follows. Forces of supports, and those that keep rigid
//! solids rigid and tied nodes together, are orthogonal to all columns of T, and drop out. Unknown D a + i of v is
//! the velocity of node a along axis i.

use crate::linalg::{MatrixEntry, SparseMatrix};
use crate::math::Vector;
use crate::parallel;
use std::ops::Range;

/// Rows per piece of a parallel loop.
const ROWS_PER_PIECE: usize = 128;

/// The map from independent velocities to those of all nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct IndependentVelocities {
    /// Entries of row k of T are `start[k]..start[k + 1]`.
    start: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
    /// v̄ [m/s].
    prescribed: Vec<f64>,
    /// The guess of w with which iterations begin.
    guess: Vec<f64>,
}

/// The velocities of a solution of the step.
#[derive(Debug, Clone, PartialEq)]
pub struct SolutionVelocities<const D: usize> {
    /// Velocities of all nodes, v [m/s].
    pub nodal: Vec<Vector<D>>,
    /// The independent velocities w that they follow from.
    pub independent: Vec<f64>,
}

impl Default for IndependentVelocities {
    fn default() -> Self {
        Self { start: vec![0], columns: Vec::new(), values: Vec::new(), prescribed: Vec::new(), guess: Vec::new() }
    }
}

impl IndependentVelocities {
    /// Adds independent velocities with this guess; returns the number of the first.
    pub fn add(&mut self, guess: &[f64]) -> u32 {
        self.guess.extend(guess);
        (self.guess.len() - guess.len()) as u32
    }

    /// Adds the row of the next nodal unknown: its entries of T, and its v̄ [m/s].
    pub fn push(&mut self, entries: &[(u32, f64)], prescribed: f64) {
        self.columns.extend(entries.iter().map(|(column, _)| column));
        self.values.extend(entries.iter().map(|(_, value)| value));
        self.start.push(self.columns.len() as u32);
        self.prescribed.push(prescribed);
    }

    /// Number of independent velocities.
    pub fn count(&self) -> usize {
        self.guess.len()
    }

    /// Number of nodal unknowns.
    pub fn unknowns(&self) -> usize {
        self.prescribed.len()
    }

    /// The guess of w.
    pub fn guess(&self) -> &[f64] {
        &self.guess
    }

    /// The entries of a nodal unknown's row.
    pub fn row(&self, unknown: usize) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        let range = self.start[unknown] as usize..self.start[unknown + 1] as usize;
        range.map(|n| (self.columns[n], self.values[n]))
    }

    /// v̄ of a nodal unknown [m/s].
    pub fn prescribed(&self, unknown: usize) -> f64 {
        self.prescribed[unknown]
    }

    /// True for a nodal unknown that is prescribed.
    pub fn is_prescribed(&self, unknown: usize) -> bool {
        self.start[unknown] == self.start[unknown + 1]
    }

    /// T w: what independent velocities add to those of the nodes.
    pub fn added(&self, w: &[f64]) -> Vec<f64> {
        let unknowns = 0..self.prescribed.len();
        unknowns.map(|k| self.row(k).map(|(column, value)| value * w[column as usize]).sum()).collect()
    }

    /// T w + v̄ [m/s].
    pub fn nodal(&self, w: &[f64]) -> Vec<f64> {
        self.added(w).iter().zip(&self.prescribed).map(|(added, prescribed)| added + prescribed).collect()
    }

    /// T w + v̄ by node [m/s].
    pub fn nodal_vectors<const D: usize>(&self, w: &[f64]) -> Vec<Vector<D>> {
        self.nodal(w).chunks(D).map(|v| Vector::from_fn(|axis| v[axis])).collect()
    }

    /// A solution by its independent velocities w.
    pub fn solution<const D: usize>(&self, w: &[f64]) -> SolutionVelocities<D> {
        SolutionVelocities { nodal: self.nodal_vectors(w), independent: w.to_vec() }
    }

    /// Tᵀ r: forces on the nodes as those along the independent velocities.
    pub fn gathered(&self, forces: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.count()];
        for (k, force) in forces.iter().enumerate() {
            self.row(k).for_each(|(column, value)| sum[column as usize] += value * force);
        }
        sum
    }

    /// Entries of Tᵀ S T and the right-hand side Tᵀ (r − S v̄), of S, as a matrix and more entries, and r [N].
    pub fn reduced(
        &self,
        matrix: &SparseMatrix,
        more: &[MatrixEntry],
        mut rhs: Vec<f64>,
    ) -> (Vec<MatrixEntry>, Vec<f64>) {
        let of_rows = |rows: Range<usize>| {
            let mut reduced = Vec::with_capacity(matrix.row(rows.end - 1).end - matrix.row(rows.start).start);
            let of_row = |row: usize| {
                let entries =
                    matrix.row(row).map(|n| MatrixEntry::new(row as u32, matrix.columns[n], matrix.values[n]));
                entries.fold(rhs[row], |rhs, entry| rhs - self.reduce(entry, &mut reduced))
            };
            let rhs: Vec<f64> = rows.map(of_row).collect();
            (reduced, rhs)
        };
        let (pieces, sums): (Vec<_>, Vec<_>) =
            parallel::map_ranges(matrix.rows(), ROWS_PER_PIECE, of_rows).into_iter().unzip();
        rhs = sums.concat();
        let mut of_more = Vec::new();
        for &entry in more {
            rhs[entry.row as usize] -= self.reduce(entry, &mut of_more);
        }
        let reduced = pieces.into_iter().chain([of_more]).collect::<Vec<_>>().concat();
        (reduced, self.gathered(&rhs))
    }

    /// Adds the entries of Tᵀ S T that an entry of S makes; returns its part of S v̄.
    fn reduce(&self, MatrixEntry { row, column, value }: MatrixEntry, reduced: &mut Vec<MatrixEntry>) -> f64 {
        if value != 0.0 {
            for (i, left) in self.row(row as usize) {
                reduced
                    .extend(self.row(column as usize).map(|(j, right)| MatrixEntry::new(i, j, left * value * right)));
            }
        }
        value * self.prescribed[column as usize]
    }

    /// The matrix with these entries; those that are missing on the diagonal are there, too.
    pub fn matrix(&self, mut entries: Vec<MatrixEntry>) -> SparseMatrix {
        entries.extend((0..self.count() as u32).map(|k| MatrixEntry::new(k, k, 0.0)));
        SparseMatrix::from_triplets(self.count(), entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring of stiffness 3 between two nodes of which one follows half of the other, and a third that is prescribed
    /// with 2 m/s and pulled along by a spring of stiffness 5: (3/4 + 5) w = 7 + 5 · 2, by hand.
    #[test]
    fn springs_between_nodes_that_follow_each_other_are_as_by_hand() {
        let mut velocities = IndependentVelocities::default();
        let first = velocities.add(&[0.0]);
        velocities.push(&[(first, 1.0)], 0.0);
        velocities.push(&[(first, 0.5)], 0.0);
        velocities.push(&[], 2.0);
        let spring = |i: u32, j: u32, k: f64| [(i, i, k), (j, j, k), (i, j, -k), (j, i, -k)].map(MatrixEntry::from);
        let matrix = SparseMatrix::from_triplets(3, spring(0, 1, 3.0));
        let (entries, rhs) = velocities.reduced(&matrix, &spring(0, 2, 5.0), vec![7.0, 0.0, 0.0]);
        let matrix = velocities.matrix(entries);
        assert!((matrix.values[0] - 5.75).abs() < 1e-14 && (rhs[0] - 17.0).abs() < 1e-14, "{matrix:?} {rhs:?}");
        assert_eq!(velocities.nodal(&[4.0]), [4.0, 2.0, 2.0]);
        assert_eq!(velocities.gathered(&[1.0, 1.0, 1.0]), [1.5]);
        assert!(velocities.is_prescribed(2) && !velocities.is_prescribed(1));
    }
}
