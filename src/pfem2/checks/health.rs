//! Conditions that must hold after a step; the first violation stops the run with its place and advice (theory F.14).

use crate::error::{Place, StepError};
use crate::parallel;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::particles::Particles;

/// Velocity and pressure are numbers at all nodes, and so are their squares, of which energies are made.
///
/// # Errors
/// Names the first node where they are not.
pub fn check_nodes<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>) -> Result<(), StepError> {
    let finite = |i: usize| {
        system.velocity[i].norm_squared().is_finite() && (system.pressure[i] * system.pressure[i]).is_finite()
    };
    let Some(bad) = parallel::first(system.velocity.len(), |i| !finite(i)) else { return Ok(()) };
    let advice = "look for formulas of boundaries or gravity that are no numbers there, or properties in wrong units";
    let what = "velocity or pressure is not a number";
    Err(StepError::new(system.place(bad), what, "speed", system.velocity[bad].norm(), advice))
}

/// There are particles left.
///
/// # Errors
/// All have left the mesh.
pub fn check_particles<const D: usize>(particles: &Particles<D>) -> Result<(), StepError> {
    if !particles.is_empty() {
        return Ok(());
    }
    let advice = "check the directions of inlets and outlets, and that a region of a fluid covers the mesh";
    Err(StepError::new(Place::Everywhere, "all particles have left the mesh", "particles", 0.0, advice))
}

/// The flow has gained many times the energy [J] that there was: an error at the fastest node.
pub fn runaway<const D: usize, const N: usize>(
    system: &VelocityPressureSystem<D, N>,
    gained: f64,
    at_hand: f64,
) -> StepError {
    let speed = |i: usize| system.velocity[i].norm();
    let fastest = (0..system.velocity.len()).max_by(|&i, &j| speed(i).total_cmp(&speed(j)).then(j.cmp(&i)));
    let what = format!("the flow runs away: errors have given it {gained:.3e} J, and {at_hand:.3e} J were at hand");
    let advice = "take a shorter step (`time.step`, `pfem2.courant`), or smaller elements where fluids meet; look at the \
                  last pictures for where it began";
    let node = fastest.unwrap_or(0);
    StepError::new(system.place(node), what, "speed", speed(node), advice)
}
