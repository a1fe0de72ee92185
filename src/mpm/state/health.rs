//! Checks after each stage; the first violation stops the run with its place and advice.

use crate::error::{Place, StepError};
use crate::math::Vector;
use crate::mpm::contact::Squeeze;
use crate::mpm::grid::Grid;
use crate::mpm::membrane::Membrane;
use crate::mpm::particles::Body;
use crate::mpm::wall::Walls;
use crate::parallel;

/// A node this far beyond the end of the grid [cells] still lies on it: sheets end on planes of symmetry.
const ON_THE_END: f64 = 1e-6;

/// A free node of a membrane this deep in an obstacle [cells] went through its surface.
const THROUGH: f64 = 0.5;

/// A node this near to an obstacle [cells] touches it.
const TOUCHES: f64 = 1e-2;

/// The error of a body with a particle that was turned inside out.
pub fn inverted<const D: usize>(body: &Body<D>) -> StepError {
    let bad = body.work.volume_ratio.iter().position(|j| *j <= 0.0 || !j.is_finite()).unwrap_or(0);
    let advice = "the velocities change too fast over a cell: lower `mpm.safety`, refine the grid, \
                  or check the material and the initial velocities";
    let ratio = body.work.volume_ratio[bad];
    StepError::new(particle(body, bad), "a particle was turned inside out", "volume ratio", ratio, advice)
}

/// Positions, velocities, pressures and energies are finite, and every particle is in the domain.
///
/// # Errors
/// Names the first particle that breaks this.
pub fn check_particles<const D: usize>(grid: &Grid<D>, body: &Body<D>) -> Result<(), StepError> {
    let particles = &body.particles;
    let (lower, upper) = (grid.origin, grid.upper());
    let inside = |p: usize| (0..D).all(|a| (lower[a]..=upper[a]).contains(&particles.position[p][a]));
    let finite = |p: usize| {
        let state = particles.velocity[p].norm_squared() + particles.pressure[p] + particles.energy[p];
        particles.position[p].is_finite() && state.is_finite()
    };
    let bad = parallel::first(particles.len(), |p| !(finite(p) && inside(p)));
    bad.map_or(Ok(()), |p| {
        if finite(p) {
            let x = particles.position[p];
            let axis = (0..D).find(|&a| !(lower[a]..=upper[a]).contains(&x[a])).unwrap_or(0);
            let quantity = ["x", "y", "z"][axis];
            let advice = "enlarge the grid, or give that wall a kind that holds the material (`slip`, `separate`, …)";
            Err(StepError::new(particle(body, p), "a particle left the domain", quantity, x[axis], advice))
        } else {
            let advice = "lower `mpm.safety`; if it stays, look for parameters of the material in wrong units";
            let value = particles.velocity[p].norm();
            Err(StepError::new(particle(body, p), "a particle's state is not a number", "speed", value, advice))
        }
    })
}

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

/// The error of a membrane that has no way out between walls, obstacles and supports.
pub fn squeezed<const D: usize>(membrane: &Membrane<D>, squeeze: &Squeeze<D>) -> StepError {
    let Squeeze { node, place, solid, other, distance } = squeeze;
    let place = Place::Node { body: membrane.name.clone(), index: *node, position: place.to3() };
    match other {
        Some(other) => StepError::new(
            place,
            format!("`{solid}` and `{other}` close on a membrane and leave it no way out"),
            "their distance",
            *distance,
            "keep them apart by its thickness at least (`velocity` of the obstacles), or end the run before they meet (`time.end`)",
        ),
        None => StepError::new(
            place,
            format!("supports hold a node of a membrane, and `{solid}` went over it"),
            "depth",
            *distance,
            "neither gives way: stop one of the two before they meet, or free that axis in `supports`",
        ),
    }
}

/// The external force on every particle is a number.
///
/// # Errors
/// Names the first particle whose force is not.
pub fn check_external<const D: usize>(body: &Body<D>) -> Result<(), StepError> {
    let external = &body.work.external;
    let bad = parallel::first(external.len(), |p| !external[p].is_finite());
    bad.map_or(Ok(()), |p| Err(no_load(particle(body, p), external[p].norm())))
}

/// The error of a load that is not a number at a place; `value` is the norm of its force [N].
pub fn no_load(place: Place, value: f64) -> StepError {
    let advice = "look for a formula or value of gravity, pressure or traction beyond what numbers can hold";
    StepError::new(place, "an external force is not a number", "force", value, advice)
}

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

/// The place of a particle of a body.
fn particle<const D: usize>(body: &Body<D>, p: usize) -> Place {
    Place::Particle { body: body.name.clone(), id: body.particles.id[p], position: body.particles.position[p].to3() }
}
