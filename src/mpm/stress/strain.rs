//! Strain increments of chunks of particles from their velocity gradients, and the cure of volumetric locking
//! (theory A.8, A.10).
//!
//! ```text
//! L_p = Σ v_I ⊗ ∇N_Ip                                                    Lian (62), Lian (63)
//! ΔJ_p = det(1 + Δt L_p)                                                 ∇N over the positions at the start
//! ΔJ_p = 1/det(1 − Δt L_p),     L_p ← L_p (1 − Δt L_p)⁻¹                 ∇N over those at the end
//! ΔJ̄_p = (1 − β) ΔJ_p + β Σ N_Ip J̃_I,     J̃_I = Σ V_p ΔJ_p N_Ip / Σ V_p N_Ip
//! 1 + Δt L̄_p = (ΔJ̄_p/ΔJ_p)^(1/D) (1 + Δt L_p)
//! ```
//!
//! so that det(1 + Δt L̄) = ΔJ̄: the volumetric part that laws take from `volume_ratio` and the trace of the gradient
//! agree, and plane strain stays plane. The averages J̃, and the forces that fit them, are in `average`; the same for
//! one particle at a time in `mpm::executor::plain`.

use crate::math::simd::{Lanes, Task, WIDTH, widest};
use crate::mpm::transfer::{CHUNK_LEN, Chunk, ChunkColumn, Rows};

/// The positions of particles that a velocity gradient refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::mpm) enum Positions {
    /// Positions at the start of the increment.
    Start,
    /// Positions at its end.
    End,
}

/// Sets the volume ratios of a chunk: det(1 + Δt L), or 1/det(1 − Δt L) for gradients over the positions at the end.
pub(in crate::mpm) fn measure<const D: usize>(chunk: &mut Chunk<'_, D>, dt: f64, positions: Positions) {
    widest(VolumeRatios { rows: chunk.rows, volume_ratio: chunk.particles.volume_ratio, dt, positions });
}

struct VolumeRatios<'a, const D: usize> {
    rows: &'a Rows<D>,
    volume_ratio: &'a mut [f64],
    dt: f64,
    positions: Positions,
}

impl<const D: usize> Task for VolumeRatios<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let n = self.volume_ratio.len().min(CHUNK_LEN);
        let volume_ratio = &mut self.volume_ratio[..n];
        if self.positions == Positions::End {
            for (p, j) in volume_ratio.iter_mut().enumerate() {
                *j = 1.0 / determinant(self.rows, p, -self.dt);
            }
        } else {
            for (p, j) in volume_ratio.iter_mut().enumerate() {
                *j = determinant(self.rows, p, self.dt);
            }
        }
    }
}

/// det(1 + Δt L) of particle `p`.
#[inline(always)]
fn determinant<const D: usize>(rows: &Rows<D>, p: usize, dt: f64) -> f64 {
    let f = |a: usize, b: usize| if a == b { 1.0 + dt * rows.gradient[b][a][p] } else { dt * rows.gradient[b][a][p] };
    let minor = |a: usize, b: usize| f(1, a) * f(D - 1, b) - f(1, b) * f(D - 1, a);
    if D == 2 {
        f(0, 0) * f(1, 1) - f(0, 1) * f(1, 0)
    } else {
        f(0, 0) * minor(1, 2) + f(0, 1) * minor(2, 0) + f(0, 2) * minor(0, 1)
    }
}

/// Replaces the gradients of a chunk by those over the positions at the start, where x is (1 − Δt L) times x at the
/// end:
/// L (1 − Δt L)⁻¹.
pub(in crate::mpm) fn refer_to_start<const D: usize>(chunk: &mut Chunk<'_, D>, dt: f64) {
    widest(ReferToStart { rows: chunk.rows, count: chunk.particles.len(), dt });
}

struct ReferToStart<'a, const D: usize> {
    rows: &'a mut Rows<D>,
    count: usize,
    dt: f64,
}

impl<const D: usize> Task for ReferToStart<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for p in (0..self.count.min(CHUNK_LEN)).step_by(WIDTH) {
            let l = self.rows.gradients::<L>(p);
            let mut back = l;
            for a in 0..D {
                for b in 0..D {
                    let unit = L::splat(if a == b { 1.0 } else { 0.0 });
                    back[a][b] = unit.sub(l[a][b].mul(L::splat(self.dt)));
                }
            }
            let inverse = inverse(&back);
            let mut start = l;
            for a in 0..D {
                for b in 0..D {
                    let mut sum = l[a][0].mul(inverse[0][b]);
                    for c in 1..D {
                        sum = l[a][c].mul_add(inverse[c][b], sum);
                    }
                    start[a][b] = sum;
                }
            }
            self.rows.set_gradients(p, &start);
        }
    }
}

/// The inverse of eight tensors; not finite where there is none.
#[inline(always)]
fn inverse<L: Lanes, const D: usize>(f: &[[L; D]; D]) -> [[L; D]; D] {
    let mut cofactors = *f;
    for a in 0..D {
        for b in 0..D {
            cofactors[a][b] = if D == 2 {
                let sign = L::splat(if a == b { 1.0 } else { -1.0 });
                f[1 - a % 2][1 - b % 2].mul(sign)
            } else {
                let ([a1, a2], [b1, b2]) = ([(a + 1) % D, (a + 2) % D], [(b + 1) % D, (b + 2) % D]);
                f[a1][b1].mul(f[a2][b2]).sub(f[a1][b2].mul(f[a2][b1]))
            };
        }
    }
    let mut determinant = f[0][0].mul(cofactors[0][0]);
    for b in 1..D {
        determinant = f[0][b].mul_add(cofactors[0][b], determinant);
    }
    let scale = L::splat(1.0).div(determinant);
    let mut inverse = *f;
    for a in 0..D {
        for b in 0..D {
            inverse[a][b] = cofactors[b][a].mul(scale);
        }
    }
    inverse
}

/// Blends the volume ratios of a chunk with their average over the grid, which was gathered as scalar.
pub(in crate::mpm) fn blend_volume_ratio<const D: usize>(chunk: &mut Chunk<'_, D>, blend: f64) {
    for (volume_ratio, mean) in chunk.particles.volume_ratio.iter_mut().zip(&chunk.rows.scalar) {
        *volume_ratio += blend * (mean - *volume_ratio);
    }
}

/// Blends volume ratios, as [`blend_volume_ratio`], and scales the gradients to fit.
pub(in crate::mpm) fn blend_volume_ratio_and_gradient<const D: usize>(chunk: &mut Chunk<'_, D>, dt: f64, blend: f64) {
    let mut change: ChunkColumn = [0.0; CHUNK_LEN + WIDTH];
    let columns = chunk.particles.volume_ratio.iter_mut().zip(&chunk.rows.scalar).zip(&mut change);
    for ((volume_ratio, mean), change) in columns {
        let more = blend * (mean - *volume_ratio);
        *change = more / *volume_ratio;
        *volume_ratio += more;
    }
    let count = chunk.particles.len().min(CHUNK_LEN);
    if change[..count].iter().all(|change| change.abs() <= LARGEST_FOR_NEWTON) {
        widest(Grow { change: &mut change, count, dimension: D });
    } else {
        change[..count].iter_mut().for_each(|change| *change = growth::<D>(*change));
    }
    widest(ScaleGradient { rows: chunk.rows, growth: &change, count, per_dt: 1.0 / dt });
}

/// Scales gradients: (1 + Δt L) ← (1 + g) (1 + Δt L).
struct ScaleGradient<'a, const D: usize> {
    rows: &'a mut Rows<D>,
    growth: &'a ChunkColumn,
    count: usize,
    per_dt: f64,
}

impl<const D: usize> Task for ScaleGradient<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for p in (0..self.count).step_by(WIDTH) {
            let growth = L::load(self.growth[p..].first_chunk().expect("columns end eight numbers beyond the chunk"));
            let mut l = self.rows.gradients::<L>(p);
            for a in 0..D {
                for b in 0..D {
                    l[a][b] = l[a][b].mul_add(growth, l[a][b]);
                }
                l[a][a] = growth.mul_add(L::splat(self.per_dt), l[a][a]);
            }
            self.rows.set_gradients(p, &l);
        }
    }
}

/// Changes of volume up to which [`newton`] has all digits.
const LARGEST_FOR_NEWTON: f64 = 0.1;

/// g with (1 + g)^D = 1 + change, in place of the changes.
struct Grow<'a> {
    change: &'a mut ChunkColumn,
    count: usize,
    dimension: usize,
}

impl Task for Grow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { change, count, dimension } = self;
        if dimension == 2 {
            change[..count].iter_mut().for_each(|change| *change = newton::<2>(*change));
        } else {
            change[..count].iter_mut().for_each(|change| *change = newton::<3>(*change));
        }
    }
}

/// g with (1 + g)^D = 1 + `change`.
#[inline(always)]
fn growth<const D: usize>(change: f64) -> f64 {
    if change.abs() > LARGEST_FOR_NEWTON { (change.ln_1p() / D as f64).exp_m1() } else { newton::<D>(change) }
}

/// The same for changes up to [`LARGEST_FOR_NEWTON`]. Newton's iteration doubles the digits, and change/D has two of them.
/// Logarithms take ten times as long.
#[inline(always)]
fn newton<const D: usize>(change: f64) -> f64 {
    let mut g = change / D as f64;
    for _ in 0..4 {
        // (1 + g)^D − 1, without loss of digits where g is small.
        let (power, slope) = match D {
            2 => (g * (2.0 + g), 2.0 * (1.0 + g)),
            _ => (g * (3.0 + g * (3.0 + g)), 3.0 * (1.0 + g) * (1.0 + g)),
        };
        g -= (power - change) / slope;
    }
    g
}

#[cfg(test)]
mod tests {
    use super::growth;

    #[test]
    fn the_growth_is_the_root_of_the_change_of_volume() {
        for change in [-0.7, -0.099, -1e-3, -1e-9, 0.0, 1e-12, 1e-6, 0.04, 0.0999, 0.5, 8.0] {
            for (found, roots) in [(growth::<2>(change), 2.0), (growth::<3>(change), 3.0)] {
                let exact = (f64::ln_1p(change) / roots).exp_m1();
                assert!((found - exact).abs() <= 1e-15 * exact.abs(), "{change}: {found} {exact}");
            }
        }
    }
}
