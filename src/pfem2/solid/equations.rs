//! The linear equations of a step of solids, and the elimination of prescribed velocities from them.
//!
//! ```text
//! A v = r,   v_k = v̄_k:      r_i ← r_i − A_ik v̄_k,  A_ik = A_ki = 0,  r_k = A_kk v̄_k,      reaction  R_k = Σ_j A_kj v_j − r_k
//! ```

use crate::linalg::SparseMatrix;

/// Equations of the velocity of all nodes; forces [N] in the rows.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidEquations {
    /// A; its entries have mirrors.
    pub matrix: SparseMatrix,
    /// r [N].
    pub rhs: Vec<f64>,
    /// Prescribed velocity of each unknown at the end of the step [m/s].
    pub held: Vec<Option<f64>>,
}

/// Rows of prescribed unknowns before their elimination.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportRows {
    rows: Vec<SupportRow>,
}

#[derive(Debug, Clone, PartialEq)]
struct SupportRow {
    unknown: u32,
    entries: Vec<(u32, f64)>,
    rhs: f64,
}

impl SolidEquations {
    /// Eliminates prescribed unknowns, symmetrically; the places of the entries stay. Returns their rows as they were.
    pub fn constrain(&mut self) -> SupportRows {
        let held: Vec<usize> = (0..self.held.len()).filter(|&k| self.held[k].is_some()).collect();
        let rows = held.iter().map(|&k| self.support_row(k)).collect();
        for row in 0..self.rhs.len() {
            let own = self.held[row];
            for entry in self.matrix.row(row) {
                let column = self.matrix.columns[entry] as usize;
                let Some(velocity) = self.held[column] else {
                    if own.is_some() {
                        self.matrix.values[entry] = 0.0;
                    }
                    continue;
                };
                if row == column {
                    continue;
                }
                self.rhs[row] -= self.matrix.values[entry] * velocity;
                self.matrix.values[entry] = 0.0;
            }
        }
        for k in held {
            let diagonal = self.matrix.entry(k, k).map_or(0.0, |entry| self.matrix.values[entry]);
            self.rhs[k] = diagonal * self.held[k].unwrap_or_default();
        }
        SupportRows { rows }
    }

    fn support_row(&self, k: usize) -> SupportRow {
        let entries = self.matrix.row(k).map(|n| (self.matrix.columns[n], self.matrix.values[n])).collect();
        SupportRow { unknown: k as u32, entries, rhs: self.rhs[k] }
    }
}

impl SupportRows {
    /// Forces of the supports on the solids [N] at the prescribed unknowns, where `velocity` [m/s] solves the equations.
    pub fn reactions(&self, velocity: &[f64]) -> Vec<(u32, f64)> {
        let product = |row: &SupportRow| row.entries.iter().map(|&(k, a)| a * velocity[k as usize]).sum::<f64>();
        self.rows.iter().map(|row| (row.unknown, product(row) - row.rhs)).collect()
    }
}
