//! A solver whose formulas are tried out before every step.
//!
//! `lateen check` tries formulas at some times; a pole may lie between them. What it would do to the state is found much
//! later, and far from its cause.

use super::{Column, Snapshot, Solver};
use crate::error::{Place, StepError};
use crate::math::Signal;

/// A formula of the case that depends on the time.
#[derive(Debug, Clone)]
pub struct Watched {
    /// Its key in the case.
    pub key: String,
    /// Its value.
    pub signal: Signal,
    /// Where it is tried [m].
    pub places: Vec<[f64; 3]>,
}

/// A solver with the formulas that drive it.
pub struct Guarded {
    solver: Box<dyn Solver>,
    watched: Vec<Watched>,
}

impl Guarded {
    /// Watches the formulas of a solver.
    pub fn new(solver: Box<dyn Solver>, watched: Vec<Watched>) -> Self {
        Self { solver, watched }
    }

    /// The first formula without a value at the start, in the middle or at the end of a step.
    fn undefined(&self, t: f64, dt: f64) -> Option<StepError> {
        let times = [t, t + 0.5 * dt, t + dt];
        self.watched.iter().find_map(|Watched { key, signal, places }| {
            let tried = times.iter().flat_map(|&time| places.iter().map(move |&x| (time, x)));
            let (time, position, value) =
                tried.map(|(time, x)| (time, x, signal.value(x, time))).find(|(_, _, value)| !value.is_finite())?;
            Some(StepError {
                what: format!("the formula of `{key}` has no value"),
                time,
                step: 0,
                place: Place::Point { position },
                quantity: "value",
                value,
                advice: "it divides by zero or leaves the domain of a function there: write another formula, or end \
                         the run before"
                    .to_owned(),
            })
        })
    }
}

impl Solver for Guarded {
    fn stable_dt(&self) -> f64 {
        self.solver.stable_dt()
    }

    fn recommended_dt(&self) -> f64 {
        self.solver.recommended_dt()
    }

    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        self.undefined(t, dt).map_or(Ok(()), Err)?;
        self.solver.step(t, dt)
    }

    fn snapshot(&self) -> Snapshot<'_> {
        self.solver.snapshot()
    }

    fn forces(&self, visit: &mut dyn FnMut([f64; 3])) {
        self.solver.forces(visit);
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        self.solver.columns(visit);
    }

    fn restored(&mut self) {
        self.solver.restored();
    }

    fn notices(&mut self) -> Vec<String> {
        self.solver.notices()
    }

    fn stage_times(&self) -> Vec<(&'static str, f64)> {
        self.solver.stage_times()
    }

    fn particle_count(&self) -> usize {
        self.solver.particle_count()
    }
}
