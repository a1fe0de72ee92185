//! A solver whose formulas are evaluated before every step, and at the place where a step failed.
//!
//! `lateen check` tries formulas at some times; a pole may lie between them. What it would do to the state is found
//! much later, and far from its cause. Formulas that depend on the place alone have a value wherever something is at
//! the start; when a step fails, they are tried where it failed.

use super::{Column, Snapshot, Solver};
use crate::error::{Place, StepError};
use crate::math::Signal;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A formula of the case that drives a solver.
#[derive(Debug, Clone)]
pub struct DrivingFormula {
    /// Key of the signal in the case.
    pub key: String,
    /// Its value.
    pub signal: Signal,
    /// Places at which it is evaluated before every step [m].
    pub places: Vec<[f64; 3]>,
    /// Acts on a part of the boundary, and need not have a value away from it.
    pub on_boundary: bool,
}

/// A solver with the formulas that drive it.
pub struct Guarded {
    solver: Box<dyn Solver>,
    formulas: Vec<DrivingFormula>,
}

impl Guarded {
    /// A solver, with the formulas that are evaluated before its steps.
    pub fn new(solver: Box<dyn Solver>, formulas: Vec<DrivingFormula>) -> Self {
        Self { solver, formulas }
    }

    /// The first formula without a value at the start, in the middle or at the end of a step, at the places that
    /// `places` picks.
    fn undefined<'a>(
        &'a self,
        t: f64,
        dt: f64,
        places: impl Fn(&'a DrivingFormula) -> &'a [[f64; 3]],
    ) -> Option<StepError> {
        let times = [t, t + 0.5 * dt, t + dt];
        self.formulas.iter().find_map(|formula| {
            let DrivingFormula { key, signal, .. } = formula;
            let tried = times.iter().flat_map(|&time| places(formula).iter().map(move |&x| (time, x)));
            let (time, position, value) =
                tried.map(|(time, x)| (time, x, signal.value(x, time))).find(|(_, _, value)| !value.is_finite())?;
            let what = format!("the formula of `{key}` has no value");
            let advice = "it divides by zero or leaves the domain of a function there: write another formula, or end the run before";
            Some(StepError { time, ..StepError::new(Place::Point { position }, what, "value", value, advice) })
        })
    }

    /// The error of a step, or that of a formula which has no value where the step failed.
    fn explained(&self, t: f64, dt: f64, error: StepError) -> StepError {
        let failed = error.place.position().filter(|x| x.iter().all(|c| c.is_finite()));
        let places = |formula: &DrivingFormula| if formula.on_boundary { &[][..] } else { failed.as_slice() };
        let Some(found) = self.undefined(t, dt, places) else { return error };
        StepError { place: error.place, ..found }
    }
}

impl Solver for Guarded {
    fn stable_dt(&self) -> f64 {
        self.solver.stable_dt()
    }

    fn recommended_dt(&self) -> f64 {
        self.solver.recommended_dt()
    }

    fn foreseen_dt(&self, end: f64) -> Option<[f64; 2]> {
        self.solver.foreseen_dt(end)
    }

    fn largest_change(&self) -> f64 {
        self.solver.largest_change()
    }

    fn stop_on(&mut self, flag: Arc<AtomicBool>) {
        self.solver.stop_on(flag);
    }

    fn begin(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        self.solver.begin(t, dt)
    }

    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        self.undefined(t, dt, |formula| &formula.places).map_or(Ok(()), Err)?;
        self.solver.step(t, dt).map_err(|error| self.explained(t, dt, error))
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

    fn misfit(&self) -> Option<String> {
        self.solver.misfit()
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

    fn element_count(&self) -> usize {
        self.solver.element_count()
    }

    fn substeps(&self, dt: f64) -> u64 {
        self.solver.substeps(dt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fails at x = 2.
    struct Failing;

    impl Solver for Failing {
        fn stable_dt(&self) -> f64 {
            1.0
        }

        fn step(&mut self, time: f64, _: f64) -> Result<(), StepError> {
            let place = Place::Node { body: "net".into(), index: 3, position: [2.0, 0.0, 0.0] };
            let (what, advice) = ("a force is not a number".to_owned(), String::new());
            Err(StepError { what, time, step: 0, place, quantity: "force", value: f64::NAN, advice })
        }

        fn snapshot(&self) -> Snapshot<'_> {
            unreachable!("nobody looks")
        }

        fn forces(&self, _: &mut dyn FnMut([f64; 3])) {}

        fn columns(&mut self, _: &mut dyn FnMut(&str, Column<'_>)) {}

        fn particle_count(&self) -> usize {
            0
        }
    }

    #[test]
    fn a_formula_without_a_value_where_a_step_failed_is_named() {
        let driven = |formula: &str, on_boundary| {
            let signal = Signal::formula(formula).unwrap();
            let formula = DrivingFormula { key: "load".into(), signal, places: Vec::new(), on_boundary };
            Guarded::new(Box::new(Failing), vec![formula])
        };
        let guarded = |formula| driven(formula, false);
        let error = guarded("sqrt(1.9 - x)").step(0.5, 0.1).unwrap_err();
        assert_eq!((error.what.as_str(), error.time), ("the formula of `load` has no value", 0.5));
        assert!(matches!(error.place, Place::Node { index: 3, .. }));
        let elsewhere = [guarded("sqrt(2.1 - x)"), driven("sqrt(1.9 - x)", true)];
        for error in elsewhere.map(|mut solver| solver.step(0.5, 0.1).unwrap_err()) {
            assert_eq!(error.what, "a force is not a number");
        }
    }
}
