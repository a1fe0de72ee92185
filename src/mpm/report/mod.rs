//! The solver as the time loop, outputs and checkpoints see it: `columns` lists what a checkpoint keeps, `snapshot`
//! what outputs show.

mod columns;
mod snapshot;

use super::LeapfrogStep;
use super::state::stability::GROWTH;
use super::step::Mpm;
use super::step::method::StepCount;
use crate::error::StepError;
use crate::simulation::{Column, Snapshot, Solver};

/// Largest ratio of two successive steps where there are membranes.
const CHANGE: f64 = 1.5;

impl<const D: usize> Solver for Mpm<D> {
    fn stable_dt(&self) -> f64 {
        self.clock.bound
    }

    /// The momentum of a step advances by half of it and half of the step before, while nodes of membranes move for
    /// the step alone: a tiny step after a long one would accelerate a sub-cycled membrane by forces that act much
    /// longer than it moves.
    fn largest_change(&self) -> f64 {
        if self.coupling.membranes.is_empty() { f64::INFINITY } else { CHANGE }
    }

    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        let step = LeapfrogStep::new(t, dt, self.clock.dt_previous);
        self.advance(&step).map_err(|error| StepError { time: t, ..error })?;
        let StepCount { bound, steps, .. } = self.clock;
        self.clock = StepCount { dt_previous: dt, bound: self.step_bound().min(GROWTH * bound), steps: steps + 1 };
        self.notices.check(self.clock.steps, t + dt, &self.energy, &self.coupling);
        Ok(())
    }

    fn snapshot(&self) -> Snapshot<'_> {
        snapshot::snapshot(self)
    }

    fn forces(&self, visit: &mut dyn FnMut([f64; 3])) {
        snapshot::forces(self, visit);
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        columns::visit(self, visit);
    }

    fn misfit(&self) -> Option<String> {
        columns::misfit(self)
    }

    fn restored(&mut self) {
        self.coupling.proximity.forget();
    }

    fn notices(&mut self) -> Vec<String> {
        let mut said = self.coupling.contact.notices();
        said.extend(self.notices.take());
        said.extend(self.coupling.proximity.take());
        said
    }

    fn stage_times(&self) -> Vec<(&'static str, f64)> {
        self.timer.seconds()
    }

    fn particle_count(&self) -> usize {
        self.bodies.iter().map(|body| body.particles.len()).sum()
    }

    fn element_count(&self) -> usize {
        self.coupling.membranes.iter().map(|membrane| membrane.elements.len()).sum()
    }

    fn substeps(&self, dt: f64) -> u64 {
        let count = || self.coupling.substeps(LeapfrogStep::new(0.0, dt, self.clock.dt_previous).longer());
        if self.coupling.membranes.is_empty() { 0 } else { count() as u64 }
    }
}
