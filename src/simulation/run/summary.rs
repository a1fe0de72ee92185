//! Summary of a run.

use super::Simulation;
use crate::simulation::Clock;
use std::time::Duration;

/// Summary of a run that has ended.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RunSummary {
    /// Time and steps at the end.
    pub clock: Clock,
    /// Wall time of this process.
    pub elapsed: Duration,
    /// Steps of this process.
    pub steps: u64,
    /// Particles moved, summed over the steps of this process.
    pub particle_steps: u64,
    /// Sub-steps of the membranes in the steps of this process; 0 without any.
    pub substeps: u64,
    /// Elements of membranes advanced, summed over these sub-steps.
    pub element_steps: u64,
    /// Seconds per stage: those of the solver, outputs and checkpoints.
    pub stages: Vec<(&'static str, f64)>,
    /// Energy that the ledger can't explain [J].
    pub closure: f64,
    /// The largest term of the ledger [J], to measure the closure by.
    pub energy_scale: f64,
    /// The part of it that errors have taken, where the ledger finds it as the remainder of all other terms.
    pub energy_remainder: Option<f64>,
}

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
