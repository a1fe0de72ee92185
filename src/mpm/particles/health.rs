//! Checks of the particles of a body; the first violation stops the run with its place and advice.

use super::Body;
use crate::error::{Place, StepError};
use crate::mpm::grid::Grid;
use crate::mpm::traction::no_load;
use crate::parallel;

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

/// The external force on every particle is a number.
///
/// # Errors
/// Names the first particle whose force is not.
pub fn check_external<const D: usize>(body: &Body<D>) -> Result<(), StepError> {
    let external = &body.work.external;
    let bad = parallel::first(external.len(), |p| !external[p].is_finite());
    bad.map_or(Ok(()), |p| Err(no_load(particle(body, p), external[p].norm())))
}

/// The place of a particle of a body.
fn particle<const D: usize>(body: &Body<D>, p: usize) -> Place {
    Place::Particle { body: body.name.clone(), id: body.particles.id[p], position: body.particles.position[p].to3() }
}
