//! Strain increments from a grid velocity, the cure of volumetric locking, and the call of the law.
//!
//! ```text
//! L_p = Σ v_I ⊗ ∇N_Ip                                  Lian (62)
//! ΔJ_p = det(1 + Δt L_p)
//! J̃_I = Σ V_p ΔJ_p N_Ip / Σ V_p N_Ip,   ΔJ̄_p = (1 − β) ΔJ_p + β Σ N_Ip J̃_I      (theory A.10)
//! 1 + Δt L̄_p = (ΔJ̄_p / ΔJ_p)^(1/D) (1 + Δt L_p)
//! ```
//!
//! so that det(1 + Δt L̄) = ΔJ̄: the volumetric part that laws take from `volume_ratio` and the trace of the
//! gradient agree, and plane strain stays plane.
//!
//! Which averages, and what they ask of the forces, is in `average`.

use super::average::Average;
use super::heat::warm;
use super::strain::{blend_volume_ratio, blend_volume_ratio_and_gradient, measure, refer_to_start};
use crate::error::StepError;
use crate::material::PointLaw;
use crate::math::simd::{Lanes, Task, widest};
use crate::math::{Tensor, Vector};
use crate::mpm::Locking;
use crate::mpm::grid::Node;
use crate::mpm::particles::Body;
use crate::mpm::particles::motion::{Landing, Summary, Transport};
use crate::mpm::state::health;
use crate::mpm::transfer::{CHUNK, Chunk, Content, Record, Sweep, Wanted, put_acceleration, put_scalar, put_velocity};

/// What strains a body, and when.
#[derive(Clone, Copy)]
pub(in crate::mpm) struct Strain<'a, const D: usize> {
    /// Grid velocity, ghosts filled [m/s].
    pub velocity: &'a [Vector<D>],
    /// Time increment [s].
    pub dt: f64,
    /// The gradient is over the positions at the end of the increment, not at its start.
    pub backwards: bool,
    /// The particles move with the velocity that strains them, not with v⁺ (`motion`).
    pub moves: bool,
    /// Heat per mass that the nodes hand to the particles [J/kg] (`heat`), ghosts filled; empty: none.
    pub heat: &'a [[f64; 1]],
}

impl<const D: usize> Strain<'_, D> {
    /// Sets what is gathered of node `n`: velocity, and heat if there is any.
    #[inline]
    fn put(&self, n: usize, record: &mut Record) {
        put_velocity(record, &self.velocity[n]);
        if let Some([heat]) = self.heat.get(n) {
            put_scalar(record, *heat);
        }
    }

    /// Sets the volume ratios of a chunk, and hands the heat that was gathered to its particles; returns its sum [J].
    fn measure(&self, chunk: &mut Chunk<'_, D>) -> f64 {
        measure(chunk, self.dt, self.backwards);
        if self.heat.is_empty() { 0.0 } else { warm(chunk) }
    }
}

/// Strains a body and updates its stresses; then its particles land where `landing` says.
///
/// # Errors
/// When a particle's volume would become negative or is not a number.
pub(in crate::mpm) fn update_stress<const D: usize>(
    sweep: &Sweep<'_, D>,
    average: &mut Average<'_, D>,
    strain: Strain<'_, D>,
    body: &mut Body<D>,
    landing: Landing<D>,
) -> Result<Summary, StepError> {
    let (blend, given) = average_volumes(sweep, average, strain, body);
    let increment = Increment { strain, means: average.means, blend, cell: sweep.cell };
    let (law, view) = body.view();
    let wanted = increment.wanted(law);
    let node = |n: usize, record: &mut Record| increment.put(n, record, wanted);
    let summary = sweep.gather(node, view, wanted, |chunk| {
        let (summary, heat) = increment.advance(law, chunk);
        let (particles, visits) = (&mut chunk.particles, chunk.visits);
        let land = || {
            let landed = if strain.moves { landing.land_by(particles, &*chunk.rows) } else { landing.land(particles) };
            Summary { heat, ..landed }
        };
        summary.then(land, visits)
    });
    if summary.inverted { Err(health::inverted(body)) } else { Ok(Summary { heat: given + summary.heat, ..summary }) }
}

/// Strains a body, updates its stresses and scatters their forces to `nodes`.
///
/// # Errors
/// When a particle's volume would become negative or is not a number.
pub(in crate::mpm) fn update_stress_and_push<const D: usize>(
    sweep: &Sweep<'_, D>,
    average: &mut Average<'_, D>,
    strain: Strain<'_, D>,
    body: &mut Body<D>,
    nodes: &mut [Node<D>],
) -> Result<(), StepError> {
    let (blend, _) = average_volumes(sweep, average, strain, body);
    if average.blend().is_some() {
        average.begin(nodes.len());
    }
    let increment = Increment { strain, means: average.means, blend, cell: sweep.cell };
    let (law, view) = body.view();
    let wanted = increment.wanted(law);
    let node = |n: usize, record: &mut Record| increment.put(n, record, wanted);
    let visit = |chunk: &mut Chunk<'_, D>| increment.advance(law, chunk).0;
    let summary = match average.locking {
        Locking::Average { .. } => sweep.relay(node, view, (wanted, Content::Pressures), average.sums, visit),
        Locking::None => sweep.relay(node, view, (wanted, Content::Force), nodes, visit),
    };
    if summary.inverted {
        return Err(health::inverted(body));
    }
    average.push_summed(sweep, body, nodes);
    Ok(())
}

/// Volume ratios averaged over the nodes, where that is wanted in an increment that takes time; their weight β, and the
/// heat that the particles were given [J].
fn average_volumes<const D: usize>(
    sweep: &Sweep<'_, D>,
    average: &mut Average<'_, D>,
    strain: Strain<'_, D>,
    body: &mut Body<D>,
) -> (Option<f64>, f64) {
    let Some(blend) = average.blend().filter(|_| strain.dt > 0.0) else { return (None, 0.0) };
    average.begin(strain.velocity.len());
    let node = |n: usize, record: &mut Record| strain.put(n, record);
    let what = (Wanted::Gradient, Content::Volumes);
    let heat = sweep.relay(node, body.view().1, what, average.sums, |chunk| strain.measure(chunk));
    average.divide();
    (Some(blend), heat)
}

/// The call of the law, with averaged volume ratios or with those of the particles.
struct Increment<'a, const D: usize> {
    strain: Strain<'a, D>,
    /// Volume ratios averaged over the nodes.
    means: &'a [[f64; 1]],
    /// Their weight β; `None`: they are not averaged, and not yet measured.
    blend: Option<f64>,
    /// Cell size [m].
    cell: f64,
}

impl<const D: usize> Increment<'_, D> {
    /// Sets what is gathered of node `n`.
    #[inline]
    fn put(&self, n: usize, record: &mut Record, wanted: Wanted) {
        if self.blend.is_none() {
            return self.strain.put(n, record);
        }
        put_scalar(record, self.means[n][0]);
        if wanted == Wanted::Gradient {
            put_velocity(record, &self.strain.velocity[n]);
        }
    }

    /// What is gathered at the particles: laws that don't need the gradient need no second look at it.
    fn wanted(&self, law: &dyn PointLaw) -> Wanted {
        let alone = self.blend.is_some() && !law.needs_gradient() && !self.strain.moves;
        if alone { Wanted::Scalar } else { Wanted::Gradient }
    }

    /// Advances a chunk; returns the heat [J] that it was given, too.
    fn advance(&self, law: &dyn PointLaw, chunk: &mut Chunk<'_, D>) -> (Summary, f64) {
        let Strain { dt, backwards, .. } = self.strain;
        let heat = if self.blend.is_some() { 0.0 } else { self.strain.measure(chunk) };
        if law.needs_gradient() && backwards {
            refer_to_start(chunk, dt);
        }
        match self.blend {
            Some(blend) if law.needs_gradient() => blend_volume_ratio_and_gradient(chunk, dt, blend),
            Some(blend) => blend_volume_ratio(chunk, blend),
            None => {}
        }
        (advance(law, chunk, dt, self.cell), heat)
    }
}

/// Motion, strain with v⁺, stress and landing in one sweep (stress last, without cure of locking); nodes hold (m, v⁺, a).
///
/// # Errors
/// When a particle's volume would become negative or is not a number.
pub(in crate::mpm) fn strain_and_land<const D: usize>(
    sweep: &Sweep<'_, D>,
    nodes: &[Node<D>],
    transport: Transport,
    dt: f64,
    body: &mut Body<D>,
    landing: Landing<D>,
) -> Result<Summary, StepError> {
    let wanted = transport.wanted(!body.particles.affine.is_empty(), true);
    let node = |n: usize, record: &mut Record| {
        put_velocity(record, &nodes[n].momentum);
        put_acceleration(record, &nodes[n].force);
    };
    let (law, view) = body.view();
    let summary = sweep.gather(node, view, wanted, |chunk| {
        transport.carry(chunk);
        measure(chunk, dt, false);
        let summary = advance(law, chunk, dt, sweep.cell);
        summary.then(|| landing.land_by(&mut chunk.particles, &*chunk.rows), chunk.visits)
    });
    if summary.inverted { Err(health::inverted(body)) } else { Ok(summary) }
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
    if widest(AnyUnsound(particles.volume_ratio)) {
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
