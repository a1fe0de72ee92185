//! Checks after each stage; the first violation stops the run with its place and advice.

use crate::error::{Place, StepError};
use crate::math::Vector;
use crate::mpm::grid::Grid;
use crate::mpm::membrane::Membrane;
use crate::mpm::wall::Walls;
use crate::parallel;

/// A node this far beyond the end of the grid [cells] still lies on it: sheets end on planes of symmetry.
const ON_THE_END: f64 = 1e-6;

/// A free node of a membrane this deep in an obstacle [cells] went through its surface.
const THROUGH: f64 = 0.5;

/// A node this near to an obstacle [cells] touches it.
const TOUCHES: f64 = 1e-2;

/// Every node of a membrane is in the domain, and no free node deep in an obstacle.
///
/// # Errors
/// Names the first node that breaks this.
pub fn check_membrane<const D: usize>(
    grid: &Grid<D>,
    walls: &Walls<D>,
    membrane: &Membrane<D>,
) -> Result<(), StepError> {
    let slack = Vector::from_fn(|_| ON_THE_END * grid.cell);
    let (lower, upper) = (grid.origin - slack, grid.upper() + slack);
    if let Some(k) = membrane.position.iter().position(|x| !x.is_finite()) {
        let place = Place::Node { body: membrane.name.clone(), index: k, position: membrane.reference[k].to3() };
        let what = "the place of a membrane node is not a number";
        let advice = "look for loads and velocities in wrong units, then lower `mpm.membrane-safety`";
        return Err(StepError::new(place, what, "coordinate", f64::NAN, advice));
    }
    let beyond = |k: usize| (0..D).find(|&a| !(lower[a]..=upper[a]).contains(&membrane.position[k][a]));
    let obstacle = |k: usize| {
        let held = membrane.constrained(k).contains(&true);
        if held { None } else { walls.obstacle_around(membrane.position[k], THROUGH * grid.cell) }
    };
    let bad = |k: usize| beyond(k).is_some() || obstacle(k).is_some();
    let bad = parallel::collect_some(membrane.position.len(), 1024, |k| bad(k).then_some(k));
    let Some(&k) = bad.first() else {
        return Ok(());
    };
    let x = membrane.position[k];
    let wall = beyond(k).map(|axis| (axis, usize::from(x[axis] > upper[axis])));
    let pressing = wall.filter(|&(axis, end)| walls.is_closed(axis, end));
    let pressing = pressing.and_then(|_| walls.obstacle_around(x, -TOUCHES * grid.cell));
    let (what, advice) = match (wall, obstacle(k), pressing) {
        (None, Some(name), _) => (format!("a node of a membrane went into the obstacle `{name}`"), LEAVE_A_WAY_OUT),
        (.., Some(name)) => (format!("the obstacle `{name}` pressed a node of a membrane out of the grid"), KEEP_AWAY),
        _ => ("a node of a membrane left the grid".to_owned(), HOLD_IT),
    };
    let axis = wall.map_or(D - 1, |(axis, _)| axis);
    let place = Place::Node { body: membrane.name.clone(), index: k, position: x.to3() };
    Err(StepError::new(place, what, ["x", "y", "z"][axis], x[axis], advice))
}

const LEAVE_A_WAY_OUT: &str = "it moves by more than the obstacle is thick in a sub-step, or another obstacle or a support presses it \
                               in: lower `mpm.membrane-safety`, or leave it a way out";

const KEEP_AWAY: &str = "keep it away from the wall by the thickness of the membrane at least (its `velocity`), or end the run before \
                         they meet (`time.end`)";

const HOLD_IT: &str = "enlarge the grid, give that wall a kind that holds the membrane (`separate`, `friction`, …), or hold it with \
                       `supports` (on a plane of symmetry the nodes on it, across it)";

/// The energy and every term of the ledger is a number.
///
/// # Errors
/// If not: no particle need be broken, but a sum is.
pub fn check_energy(energy: f64) -> Result<(), StepError> {
    if energy.is_finite() {
        return Ok(());
    }
    let advice = "a pressure, energy or velocity at the start is beyond what numbers can hold, or the run has become \
                  unstable: look for values in wrong units, then lower `mpm.safety`";
    Err(StepError::new(Place::Everywhere, "the energy is not a number", "energy", energy, advice))
}
