//! The state of the time loop in checkpoints.

use super::impulse::Impulses;
use crate::simulation::{Clock, Column, Solver};

/// The state of the time loop that a checkpoint keeps.
pub(super) struct LoopState<'a> {
    pub clock: &'a mut Clock,
    pub stored_at_start: &'a mut f64,
    pub impulses: &'a mut Impulses,
}

impl LoopState<'_> {
    /// The columns of the loop, then those of the solver.
    pub fn columns(&mut self, solver: &mut dyn Solver, visit: &mut dyn FnMut(&str, Column<'_>)) {
        let mut reals = [self.clock.time, self.clock.dt, *self.stored_at_start];
        visit("loop/time, dt, stored energy", Column::record(&mut reals));
        [self.clock.time, self.clock.dt, *self.stored_at_start] = reals;
        visit("loop/step", Column::scalar(&mut self.clock.step));
        self.impulses.columns(visit);
        solver.columns(visit);
    }
}
