//! Errors of the time loop itself: steps that become too short, or too long.

use super::Simulation;
use crate::error::{Place, StepError};

impl Simulation {
    fn step_error(&self, what: &str, quantity: &'static str, value: f64, advice: String) -> StepError {
        let (time, step) = (self.clock.time, self.clock.step + 1);
        StepError { what: what.to_owned(), time, step, place: Place::Everywhere, quantity, value, advice }
    }

    /// The stable step `dt` [s] is too small to go on.
    pub(super) fn collapsed(&self, dt: f64) -> StepError {
        let advice = "something moves or stiffens without bound: look at the last fields, and lower `mpm.safety`";
        self.step_error("the stable step became too small to go on", "dt", dt, advice.to_owned())
    }

    /// The fixed step [s] is larger than the stable one [s].
    pub(super) fn unstable(&self, fixed: f64, stable: f64) -> StepError {
        let advice = format!("the stable step fell to {stable:.4e} s: lower `time.step` below it, or leave it out");
        self.step_error("the fixed step became larger than the stable one", "dt", fixed, advice)
    }
}
