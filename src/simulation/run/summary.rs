//! The summary of the steps so far.

use super::Simulation;
use crate::simulation::RunSummary;

impl Simulation {
    /// The summary of the steps so far.
    pub(super) fn summary(&self) -> RunSummary {
        let ledger = self.solver.snapshot().ledger;
        RunSummary {
            clock: self.clock,
            elapsed: self.throughput.elapsed(),
            steps: self.steps,
            particle_steps: self.particle_steps,
            substeps: self.substeps,
            element_steps: self.element_steps,
            stages: self.solver.stage_times().into_iter().chain(self.timer.seconds()).collect(),
            closure: ledger.closure(self.stored_at_start),
            energy_scale: ledger.scale(self.stored_at_start),
            energy_remainder: ledger.remainder(self.stored_at_start),
        }
    }
}
