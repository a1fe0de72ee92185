//! Strain increments from a grid velocity, the cure of volumetric locking, and the call of the law.
//!
//! ```text
//! L_p = Σ v_I ⊗ ∇N_Ip                                  (62)
//! ΔJ_p = det(1 + Δt L_p)
//! J̃_I = Σ V_p ΔJ_p N_Ip / Σ V_p N_Ip,   ΔJ̄_p = (1 − β) ΔJ_p + β Σ N_Ip J̃_I      (theory 4.1)
//! 1 + Δt L̄_p = (ΔJ̄_p / ΔJ_p)^(1/D) (1 + Δt L_p)
//! ```
//!
//! so that det(1 + Δt L̄) = ΔJ̄: the volumetric part that laws take from `stretch` and the trace of the
//! gradient agree, and plane strain stays plane.
//!
//! The average A of a field of particles, A q = Σ N_Ip (Σ V q N_I/Σ V N_I), is its own adjoint, Σ V p A q = Σ V q A p.
//! The forces are therefore made of the averaged pressure
//!
//! ```text
//! p̃ = (1 − β) p + β A p        so that      Σ V_p p_p tr L̄_p = Σ V_p p̃_p tr L_p
//! ```
//!
//! and do the work that the laws store. With p itself they don't: they push on volume changes that no stress sees,
//! and a column of liquid under its own pressure gains energy from them without end.

use super::ghost::Ghosts;
use super::grid::{Grid, Node};
use super::heat::warm;
use super::motion::{Landing, Summary, Transport};
use super::particles::Body;
use super::sweep::{Bins, CHUNK, Chunk, Content, Extent, Record, Rows, Sweep, Wanted, record};
use super::{Locking, health};
use crate::error::StepError;
use crate::material::PointLaw;
use crate::math::simd::{Lanes, Task, widest};
use crate::math::{Tensor, Vector};
use rayon::prelude::*;

/// What strains a body, and when.
#[derive(Clone, Copy)]
pub(super) struct Strain<'a, const D: usize> {
    /// Grid velocity, ghosts filled [m/s].
    pub velocity: &'a [Vector<D>],
    /// Time increment [s].
    pub dt: f64,
    /// Cure of volumetric locking.
    pub locking: Locking,
    /// The gradient is over the positions at the end of the increment, not at its start.
    pub backwards: bool,
    /// Heat per mass that the nodes hand to the particles [J/kg] (`heat`), ghosts filled; empty: none.
    pub heat: &'a [[f64; 1]],
}

impl<const D: usize> Strain<'_, D> {
    /// What is gathered of node `n`: heat and velocity.
    #[inline]
    fn record(&self, n: usize) -> Record {
        record(self.heat.get(n).map_or(0.0, |[heat]| *heat), &self.velocity[n], &Vector::ZERO)
    }

    /// Hands the heat that was gathered to the particles of a chunk; returns its sum [J].
    fn warm(&self, chunk: &mut Chunk<'_, D>) -> f64 {
        if self.heat.is_empty() { 0.0 } else { warm(chunk) }
    }
}

/// Strains a body and updates its stresses; then its particles land where `landing` says.
///
/// # Errors
/// When a particle's volume would become negative or is not a number.
pub(super) fn update_stress<const D: usize>(
    sweep: &Sweep<'_, D>,
    (grid, ghosts): (&Grid<D>, &Ghosts<D>),
    strain: Strain<'_, D>,
    body: &mut Body<D>,
    landing: Landing<D>,
) -> Result<Summary, StepError> {
    let node = |n: usize| strain.record(n);
    let summary = match strain.locking {
        Locking::Average { blend } if strain.dt > 0.0 => {
            let (_, view) = body.view();
            let heat = sweep.gather(node, view, Wanted::Gradient, |chunk| {
                measure(chunk, &strain);
                strain.warm(chunk)
            });
            let (mean, _) = average(sweep, (grid, ghosts), body, Content::Volumes);
            let node = |n: usize| record(mean[n][0], &strain.velocity[n], &Vector::ZERO);
            let (law, view) = body.view();
            // Laws that don't need the gradient need no second look at it: the volume ratios are measured.
            let needed = law.needs_gradient();
            let wanted = if needed { Wanted::Gradient } else { Wanted::Scalar };
            let summary = sweep.gather(node, view, wanted, |chunk| {
                if needed && strain.backwards {
                    refer_to_start(chunk, strain.dt);
                }
                blend_stretch(chunk, strain.dt, blend, needed);
                let summary = advance(law, chunk, strain.dt, sweep.cell);
                summary.then(|| landing.land(&mut chunk.particles), chunk.visits)
            });
            Summary { heat, ..summary }
        }
        _ => {
            let (law, view) = body.view();
            sweep.gather(node, view, Wanted::Gradient, |chunk| {
                measure(chunk, &strain);
                let heat = strain.warm(chunk);
                if strain.backwards && law.needs_gradient() {
                    refer_to_start(chunk, strain.dt);
                }
                let summary = advance(law, chunk, strain.dt, sweep.cell);
                summary.then(|| Summary { heat, ..landing.land(&mut chunk.particles) }, chunk.visits)
            })
        }
    };
    if summary.inverted { Err(health::inverted(body)) } else { Ok(summary) }
}

/// Motion, strain with v⁺, stress and landing in one sweep (stress last, without cure of locking); nodes hold (m, v⁺, a).
///
/// # Errors
/// When a particle's volume would become negative or is not a number.
pub(super) fn strain_and_land<const D: usize>(
    sweep: &Sweep<'_, D>,
    nodes: &[Node<D>],
    transport: Transport,
    dt: f64,
    body: &mut Body<D>,
    landing: Landing<D>,
) -> Result<Summary, StepError> {
    let strain = Strain { velocity: &[], dt, locking: Locking::None, backwards: false, heat: &[] };
    let wanted = transport.wanted(!body.particles.affine.is_empty(), true);
    let node = |n: usize| record(0.0, &nodes[n].momentum, &nodes[n].force);
    let (law, view) = body.view();
    let summary = sweep.gather(node, view, wanted, |chunk| {
        transport.carry(chunk);
        measure(chunk, &strain);
        let summary = advance(law, chunk, dt, sweep.cell);
        summary.then(|| landing.land_by(&mut chunk.particles, &*chunk.rows), chunk.visits)
    });
    if summary.inverted { Err(health::inverted(body)) } else { Ok(summary) }
}

/// Sets the volume ratios of a chunk: det(1 + Δt L), or 1/det(1 − Δt L) for gradients over the positions at the end.
fn measure<const D: usize>(chunk: &mut Chunk<'_, D>, strain: &Strain<'_, D>) {
    let Strain { dt, backwards, .. } = *strain;
    widest(Measure { rows: chunk.rows, stretch: chunk.particles.stretch, dt, backwards });
}

struct Measure<'a, const D: usize> {
    rows: &'a Rows<D>,
    stretch: &'a mut [f64],
    dt: f64,
    backwards: bool,
}

impl<const D: usize> Task for Measure<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let n = self.stretch.len().min(CHUNK);
        let stretch = &mut self.stretch[..n];
        if self.backwards {
            for (p, j) in stretch.iter_mut().enumerate() {
                *j = 1.0 / determinant(self.rows, p, -self.dt);
            }
        } else {
            for (p, j) in stretch.iter_mut().enumerate() {
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

/// Gradients over the positions at the start, where x is (1 − Δt L) times x at the end.
fn refer_to_start<const D: usize>(chunk: &mut Chunk<'_, D>, dt: f64) {
    for p in 0..chunk.particles.len() {
        let l = chunk.rows.gradient(p).embed(0.0);
        let back = (Tensor::identity() - l * dt).inverse();
        let l = back.map_or(Tensor::identity() * f64::NAN, |back| l.dot(&back));
        chunk.rows.set_gradient(p, &Tensor::from_fn(|i, j| l[i][j]));
    }
}

/// True if a volume ratio is not positive or not finite.
struct AnyUnsound<'a>(&'a [f64]);

impl Task for AnyUnsound<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        // A count instead of an early end: the loop becomes vectors.
        self.0.iter().fold(0, |count, &j| count + u64::from(!(j > 0.0 && j < f64::INFINITY))) > 0
    }
}

/// Updates the stresses of a chunk, unless a particle was turned inside out.
fn advance<const D: usize>(law: &dyn PointLaw, chunk: &mut Chunk<'_, D>, dt: f64, cell: f64) -> Summary {
    let particles = &mut chunk.particles;
    if widest(AnyUnsound(particles.stretch)) {
        return Summary::inverted();
    }
    if law.needs_gradient() {
        let mut gradient = [Tensor::ZERO; CHUNK];
        let n = particles.len();
        gradient[..n].iter_mut().enumerate().for_each(|(p, l)| *l = chunk.rows.gradient(p).embed(0.0));
        particles.update_law(law, &gradient[..n], dt, cell);
    } else {
        particles.update_law(law, &[], dt, cell);
    }
    Summary::default()
}

/// Volume ratio or pressure averaged over the grid, ghosts filled; and the part of each tile that was reached.
fn average<const D: usize>(
    sweep: &Sweep<'_, D>,
    (grid, ghosts): (&Grid<D>, &Ghosts<D>),
    body: &Body<D>,
    content: Content,
) -> (Vec<[f64; 1]>, Vec<Extent>) {
    let mut nodal = vec![[0.0; 2]; grid.node_count()];
    let extents = sweep.scatter(&mut nodal, body, content);
    ghosts.fold(&mut nodal, |_, _, _| {});
    let mut mean: Vec<[f64; 1]> = nodal.iter().map(|[v, vq]| [if *v > 0.0 { vq / v } else { 0.0 }]).collect();
    ghosts.fill(&mut mean);
    (mean, extents)
}

/// What averaging adds to the pressures that make forces, p̃ − p = β (A p − p).
pub(super) fn average_pressure<const D: usize>(
    (grid, ghosts): (&Grid<D>, &Ghosts<D>),
    locking: Locking,
    body: &mut Body<D>,
    bins: &mut Bins<D>,
) {
    let Locking::Average { blend } = locking else { return };
    let (mean, extents) = average(&Sweep::new(grid, body.kernel, bins), (grid, ghosts), body, Content::Pressures);
    bins.extents = extents;
    body.work.excess = (0..body.particles.len()).into_par_iter().map(|p| body.particles.mean_pressure(p)).collect();
    let node = |n: usize| record(mean[n][0], &Vector::<D>::ZERO, &Vector::ZERO);
    Sweep::new(grid, body.kernel, bins).gather(node, body.view().1, Wanted::Scalar, |chunk| {
        chunk.particles.excess.iter_mut().zip(&chunk.rows.scalar).for_each(|(p, mean)| *p = blend * (mean - *p));
    });
}

/// Blends the volume ratios of a chunk with their average over the grid, and scales the gradients to fit where they
/// are needed.
fn blend_stretch<const D: usize>(chunk: &mut Chunk<'_, D>, dt: f64, blend: f64, needed: bool) {
    for (p, stretch) in chunk.particles.stretch.iter_mut().enumerate() {
        let blended = *stretch + blend * (chunk.rows.scalar[p] - *stretch);
        if needed {
            let growth = growth::<D>((blended - *stretch) / *stretch);
            let mut l = chunk.rows.gradient(p) * (1.0 + growth);
            for axis in 0..D {
                l[axis][axis] += growth / dt;
            }
            chunk.rows.set_gradient(p, &l);
        }
        *stretch = blended;
    }
}

/// g with (1 + g)^D = 1 + `change`.
#[inline(always)]
fn growth<const D: usize>(change: f64) -> f64 {
    // Newton's iteration doubles the digits; from |g| < 0.1, change/D has two of them. Logarithms take ten times as long.
    if change.abs() > 0.1 {
        return (change.ln_1p() / D as f64).exp_m1();
    }
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
