//! The start of gases: at the reference density, with the energy that gives the pressure (theory B.14).

use super::{EquationOfState, FluidState};
use crate::material::StartState;

/// The state at η = 0 with the prescribed pressure or energy; a gas has no state of rest, so one is needed.
pub(super) fn start(
    eos: &(impl EquationOfState + ?Sized),
    density: f64,
    start: &StartState,
) -> Result<FluidState, String> {
    let k = eos.coefficients(density, 0.0);
    let energy = match (start.energy, start.pressure) {
        (Some(energy), _) => energy,
        (None, Some(pressure)) => (pressure - k.a) / k.b,
        (None, None) => return Err("a gas needs a `pressure` or an `energy` at the start".into()),
    };
    if energy < 0.0 {
        return Err(format!("the energy of a gas can't be negative, but here it is {energy:e} J/m³"));
    }
    Ok(FluidState { compression: 0.0, energy, pressure: k.pressure(energy) })
}
