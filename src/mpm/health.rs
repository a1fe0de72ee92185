//! What must hold after each stage; the first violation stops the run with its place and advice.

use super::grid::Grid;
use super::particles::Body;
use crate::error::{Place, StepError};
use rayon::prelude::*;

/// The error of a body with a particle that was turned inside out.
pub fn inverted<const D: usize>(body: &Body<D>) -> StepError {
    let bad = body.work.stretch.iter().position(|j| *j <= 0.0 || !j.is_finite()).unwrap_or(0);
    let advice = "the velocities change too fast over a cell: lower `mpm.safety`, refine the grid, \
                  or check the material and the initial velocities";
    error(body, bad, "a particle was turned inside out", ("volume ratio", body.work.stretch[bad]), advice)
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
    let bad = (0..particles.len()).into_par_iter().position_first(|p| !(finite(p) && inside(p)));
    bad.map_or(Ok(()), |p| {
        if finite(p) {
            let x = particles.position[p];
            let axis = (0..D).find(|&a| !(lower[a]..=upper[a]).contains(&x[a])).unwrap_or(0);
            let quantity = ["x", "y", "z"][axis];
            let advice = "enlarge the grid, or give that wall a kind that holds the material (`slip`, `separate`, …)";
            Err(error(body, p, "a particle left the domain", (quantity, x[axis]), advice))
        } else {
            let advice = "lower `mpm.safety`; if it stays, look for parameters of the material in wrong units";
            let value = particles.velocity[p].norm();
            Err(error(body, p, "a particle's state is not a number", ("speed", value), advice))
        }
    })
}

/// Time and step are filled in by the step and the time loop.
fn error<const D: usize>(
    body: &Body<D>,
    p: usize,
    what: &str,
    (quantity, value): (&'static str, f64),
    advice: &str,
) -> StepError {
    let position = body.particles.position[p].to3();
    let place = Place::Particle { body: body.name.clone(), id: body.particles.id[p], position };
    StepError { what: what.to_owned(), time: 0.0, step: 0, place, quantity, value, advice: advice.to_owned() }
}
