//! Particle shifting at the particles of a liquid (theory A.11); `corrections::shifting` says when and why.
//!
//! ```text
//! κ_p = min(α ‖ε̇_p‖ Δt, 0.1)                                  shift factor, kept in the first component of s_p
//! s_p = −κ_p h² ∇c(x_p)                                       shift at the end of the step
//! V_p ← V_p (1 − r_p),   r_p = min((κ_p + β) c(x_p), 10⁻³)    under pressure, p_p > 0; else r_p = 0
//! e_p ← e_p + r_p V_p (p_p + ½ K_p r_p)                       K_p = m_p c_s²/V_p
//! ```

use crate::math::{Tensor, Vector};
use crate::mpm::transfer::{Chunk, View};

/// α, and the most of the shift factor α ‖ε̇‖ Δt that is stable.
const SHIFT_COEFFICIENT: f64 = 1.0;
const LARGEST_SHIFT_FACTOR: f64 = 0.1;

/// β: the fraction of an excess that is taken from the volumes at once, and the most of a volume that is taken. Within
/// some thousand steps an excess is gone; noise in it, a few percent, makes pressures no rougher, and an impact, where
/// it is large for a moment, gets no blow from this: 0.001 is the pressure of a flow at a thirtieth of the speed
/// of sound.
const TAKEN_AT_ONCE: f64 = 2e-3;
const MOST_TAKEN: f64 = 1e-3;

/// The excess c of what particles fill, at a particle.
#[derive(Debug, Clone, Copy)]
pub(in crate::mpm) struct ExcessAtParticle<const D: usize> {
    /// c.
    pub value: f64,
    /// ∇c [1/m].
    pub slope: Vector<D>,
}

/// Sets the shift factors of a chunk in `dt` [s], which follow from the rates of strain.
pub(in crate::mpm) fn set_shift_factors<const D: usize>(chunk: &mut Chunk<'_, D>, dt: f64) {
    for p in 0..chunk.particles.len() {
        chunk.particles.shift[p][0] = shift_factor(&chunk.rows.gradient(p), dt);
    }
}

/// Sets the shifts of a chunk in cells of size `cell` [m], and takes from volumes; `sound` is the speed of sound [m/s].
/// Returns the work of that [J]. The excess was gathered as scalar, and as a velocity along x.
pub(in crate::mpm) fn set_shifts<const D: usize>(chunk: &mut Chunk<'_, D>, cell: f64, sound: f64) -> f64 {
    let mut work = 0.0;
    for p in 0..chunk.particles.len() {
        let slope = Vector::from_fn(|b| chunk.rows.gradient[b][0][p]);
        let excess = ExcessAtParticle { value: chunk.rows.scalar[p], slope };
        work += shift(&mut chunk.particles, p, excess, cell, sound);
    }
    work
}

/// κ of a particle with this velocity gradient [1/s].
pub(in crate::mpm) fn shift_factor<const D: usize>(gradient: &Tensor<D>, dt: f64) -> f64 {
    (SHIFT_COEFFICIENT * rate_of_strain(gradient) * dt).min(LARGEST_SHIFT_FACTOR)
}

/// Sets the shift of particle `p` by its shift factor, and takes from its volume; returns the work of that [J].
pub(in crate::mpm) fn shift<const D: usize>(
    particles: &mut View<'_, D>,
    p: usize,
    excess: ExcessAtParticle<D>,
    cell: f64,
    sound: f64,
) -> f64 {
    let factor = particles.shift[p][0];
    let pressed = if particles.pressure[p] > 0.0 { factor + TAKEN_AT_ONCE } else { 0.0 };
    let (volume, taken) = (particles.volume[p], (pressed * excess.value).clamp(0.0, MOST_TAKEN));
    // The mean of the pressures before and after it.
    let stiff = particles.mass[p] / volume * sound * sound;
    let work = (particles.pressure[p] + 0.5 * stiff * taken) * taken * volume;
    particles.volume[p] -= taken * volume;
    particles.energy[p] += work;
    particles.shift[p] = excess.slope * (-(cell * cell) * factor);
    work
}

/// ‖½(L + Lᵀ)‖ [1/s].
fn rate_of_strain<const D: usize>(gradient: &Tensor<D>) -> f64 {
    let entry = |n: usize| 0.5 * (gradient[n / D][n % D] + gradient[n % D][n / D]);
    (0..D * D).map(|n| entry(n).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rigid_rotation_is_no_strain() {
        assert_eq!(rate_of_strain(&Tensor::<2>([[0.0, 3.0], [-3.0, 0.0]])), 0.0);
        assert!((rate_of_strain(&Tensor::<2>([[0.0, 3.0], [3.0, 4.0]])) - 34.0_f64.sqrt()).abs() < 1e-12);
    }
}
