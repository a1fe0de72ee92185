//! The largest stable step of the bodies (theory A.15).
//!
//! ```text
//! Δt ≤ safety · min_p h / (c_p + |v_p|)       Lian (21); c_p corrected for artificial viscosity by the law
//! Δt ≤ safety · h² / (2 D ν)                  ν = 4/3 μ/ρ, explicit diffusion
//! Δt ≤ 1.05 Δt_before                         steps grow gently
//! ```

use crate::mpm::particles::Body;

/// Largest ratio of two successive steps.
pub const GROWTH: f64 = 1.05;

/// The largest wave speed + |v| of a body [m/s].
pub fn largest_wave_speed<const D: usize>(body: &Body<D>) -> f64 {
    let particles = &body.particles;
    -crate::parallel::min(particles.len(), |p| -(particles.wave_speed[p] + particles.velocity[p].norm()))
}

/// The bound of a body in cells of size `cell` [m], before the safety factor [s].
pub fn bound<const D: usize>(body: &Body<D>, cell: f64) -> f64 {
    let speed = body.largest_wave_speed;
    let waves = if speed > 0.0 { cell / speed } else { f64::INFINITY }; // Lian (21)
    let diffusivity = body.law.diffusivity();
    let diffusion = if diffusivity > 0.0 { cell * cell / (2.0 * D as f64 * diffusivity) } else { f64::INFINITY };
    waves.min(diffusion)
}
