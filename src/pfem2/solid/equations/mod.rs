//! The linear equations of a step of solids, in the velocities of all nodes and in those that are independent
//! (theory J.4, J.10).
//!
//! ```text
//! S v + L v = r + l + forces of the fluid,      v = T w + v̄,      M_r w = h       inertia of rigid solids
//! [Tᵀ (S + L) T + M_r] w = Tᵀ (r + l − (S + L) v̄) + h
//! ```
//!
//! S, r: inertia, internal forces, loads. L, l: contacts and springs, forces that are linear in the velocity.

pub mod independent;

use crate::linalg::{MatrixEntry, SparseMatrix};
use crate::math::{Tensor, Vector};
use independent::IndependentVelocities;

/// Equations of the velocity of all nodes; forces [N] in the rows.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidEquations {
    /// S.
    pub matrix: SparseMatrix,
    /// r [N].
    pub rhs: Vec<f64>,
    /// L and l.
    pub linear: LinearForces,
    /// Inertia of rigid solids.
    pub inertia: IndependentInertia,
    /// T and v̄.
    pub velocities: IndependentVelocities,
    /// ∂V/∂u of the volume of elastic solids, axis by axis [m²].
    pub volume_slopes: Vec<f64>,
}

/// Forces on nodes that are linear in their velocities, l − L v.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LinearForces {
    /// Entries of L [N s/m].
    pub entries: Vec<MatrixEntry>,
    /// l of unknowns [N].
    pub loads: Vec<(u32, f64)>,
}

/// Inertia along independent velocities.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct IndependentInertia {
    /// Entries of M_r.
    pub entries: Vec<MatrixEntry>,
    /// h.
    pub loads: Vec<(u32, f64)>,
}

impl SolidEquations {
    /// The equations of the independent velocities, where the fluid adds these entries and right-hand sides to those
    /// of all nodes.
    pub fn independent(&self, fluid: &[MatrixEntry], fluid_rhs: &[f64]) -> (SparseMatrix, Vec<f64>) {
        let mut rhs: Vec<f64> = self.rhs.iter().zip(fluid_rhs).map(|(own, fluid)| own + fluid).collect();
        self.linear.loads.iter().for_each(|&(k, load)| rhs[k as usize] += load);
        let (mut entries, mut rhs) =
            self.velocities.reduced(&self.matrix, &[&self.linear.entries[..], fluid].concat(), rhs);
        entries.extend(&self.inertia.entries);
        self.inertia.loads.iter().for_each(|&(k, load)| rhs[k as usize] += load);
        (self.velocities.matrix(entries), rhs)
    }

    /// Forces that nodes need beside those of S and r at velocities that solve the equations [N]: S v − r, which
    /// the fluid, contacts, springs and supports give, and what keeps rigid solids rigid.
    pub fn missing(&self, velocity: &[f64]) -> Vec<f64> {
        let mut rows = vec![0.0; self.rhs.len()];
        self.matrix.multiply(velocity, &mut rows);
        rows.iter_mut().zip(&self.rhs).for_each(|(row, rhs)| *row -= rhs);
        rows
    }
}

impl LinearForces {
    /// Numbers of entries and of loads.
    pub fn counts(&self) -> [usize; 2] {
        [self.entries.len(), self.loads.len()]
    }

    /// Takes back all but the first ones.
    pub fn truncate(&mut self, [entries, loads]: [usize; 2]) {
        self.entries.truncate(entries);
        self.loads.truncate(loads);
    }

    /// Adds the force l − L v on node `row` that the velocity of node `column` makes, by the block L [N s/m].
    pub fn add_block<const D: usize>(&mut self, (row, column): (u32, u32), block: &Tensor<D>) {
        let unknown = |node: u32, axis: usize| node * D as u32 + axis as u32;
        for i in 0..D {
            self.entries.extend((0..D).map(|j| MatrixEntry::new(unknown(row, i), unknown(column, j), block[i][j])));
        }
    }

    /// Adds the force l on a node [N].
    pub fn add_load<const D: usize>(&mut self, node: u32, load: Vector<D>) {
        self.loads.extend((0..D).map(|i| (node * D as u32 + i as u32, load[i])));
    }
}
