//! Energy of solids on particles in the balance of a run (theory (K.14)).
//!
//! Their kinetic energy and the work of gravity on them are those of the mesh, as those of the fluid are: one velocity
//! serves both. What is left is the energy of their strain, as far as a rate law has one, and the work of supports that
//! move.

use crate::simulation::TermKind::{Gain, Stored};
use crate::simulation::{BalanceTerm, CompensatedSum, Record};
use bytemuck::{Pod, Zeroable};

/// Strain energy of solids on particles since the start, a column of checkpoints.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct StrainEnergy {
    supports: CompensatedSum,
    /// Strain energy at the end of the last step [J].
    pub last: f64,
    /// Strain energy at the start [J].
    pub start: f64,
}

impl Record for StrainEnergy {
    type Number = f64;
}

impl StrainEnergy {
    /// Opens the account with the energy at the start [J].
    pub fn open(start: f64) -> Self {
        Self { last: start, start, ..Self::default() }
    }

    /// Adds a step: the energy at its end and the work of supports in it [J].
    pub fn add(&mut self, now: f64, supports: f64) {
        self.last = now;
        self.supports.add(supports);
    }

    /// Energy that supports don't explain [J]: what the flow has given.
    pub fn gained(&self) -> f64 {
        self.last - self.start - self.supports.value()
    }

    /// The largest of its terms [J].
    pub fn largest(&self) -> f64 {
        self.last.max(self.supports.value().abs())
    }

    /// Terms of the ledger.
    pub fn terms(&self) -> [BalanceTerm; 2] {
        [
            BalanceTerm::energy(Stored, "strain energy", self.last),
            BalanceTerm::energy(Gain, "work of supports", self.supports.value()),
        ]
    }
}
