//! What a run is watched for: fluid that is lost, energy that errors take or give.

use super::available::{AvailablePotentialEnergy, EnergyCheck};
use crate::error::StepError;
use crate::pfem2::Pfem2;

/// Part of the largest other energy so far that errors may take, or give, without a word.
const TAKEN: f64 = 0.05;
const GIVEN: f64 = 0.02;

/// The same for a viscous dissipation below zero.
const NEGATIVE: f64 = 0.01;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Keeps what the start says about what may come.
    pub(in crate::pfem2) fn begin_watch(&mut self) {
        self.available = AvailablePotentialEnergy::new(&self.system, &self.totals);
        if self.is_closed() {
            self.closed = self.system.volumes.clone();
        }
    }

    /// What errors are measured by: the largest other energy so far, and no less than what counts in this run [J].
    pub(in crate::pfem2) fn largest_energy(&self) -> f64 {
        let least = self.available.as_ref().map_or(0.0, |available| available.least(&self.books));
        self.books.largest().max(least)
    }

    /// Looks at what errors have taken of the energy, or given.
    fn watch_energy(&mut self) {
        let largest = self.largest_energy();
        let gained = self.books.gained(&self.totals, self.system.surface_energy());
        let part = if largest > 0.0 { -gained / largest } else { 0.0 };
        self.notices.errors(part, !(-GIVEN..=TAKEN).contains(&part));
        if self.books.viscous() < -NEGATIVE * largest {
            self.notices.friction();
        }
    }

    /// Looks for what should not come: fluid that is lost, and energy from nothing.
    ///
    /// # Errors
    /// The flow has gained many times the energy that there was.
    pub(in crate::pfem2) fn watch(&mut self) -> Result<(), StepError> {
        let Self { system, notices, .. } = self;
        notices.losses(&system.physics.fluids, &self.closed, &system.volumes);
        if self.kept_volumes.is_some() {
            notices.weights(&system.physics.fluids, &self.closed, &system.volumes);
        }
        self.watch_energy();
        let Self { system, notices, .. } = self;
        let Some(available) = &self.available else { return Ok(()) };
        if available.judge(&self.books, &self.totals, system)? == EnergyCheck::TooMuch {
            notices.energy();
        }
        Ok(())
    }
}
