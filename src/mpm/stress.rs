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

use super::ghost::Ghosts;
use super::grid::{Grid, Node};
use super::motion::{Landing, Summary, Transport};
use super::particles::Body;
use super::sweep::{Chunk, Content, Sweep, Wanted, record};
use super::{Locking, health};
use crate::error::StepError;
use crate::material::PointLaw;
use crate::math::{Tensor, Vector};

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
    let node = |n: usize| record(0.0, &strain.velocity[n], &Vector::ZERO);
    let summary = match strain.locking {
        Locking::Average { blend } if strain.dt > 0.0 => {
            let (_, view) = body.view();
            sweep.gather(node, view, Wanted::MotionAndGradient, |chunk| measure(chunk, &strain));
            let mean = mean_stretch(sweep, (grid, ghosts), body);
            let node = |n: usize| record(mean[n][0], &strain.velocity[n], &Vector::ZERO);
            let (law, view) = body.view();
            sweep.gather(node, view, Wanted::MotionAndGradient, |chunk| {
                measure(chunk, &strain);
                average(chunk, strain.dt, blend);
                advance(law, chunk, &strain, (sweep.cell, landing))
            })
        }
        _ => {
            let (law, view) = body.view();
            sweep.gather(node, view, Wanted::MotionAndGradient, |chunk| {
                measure(chunk, &strain);
                advance(law, chunk, &strain, (sweep.cell, landing))
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
    let strain = Strain { velocity: &[], dt, locking: Locking::None, backwards: false };
    let wanted = transport.wanted(!body.particles.affine.is_empty(), true);
    let node = |n: usize| record(0.0, &nodes[n].momentum, &nodes[n].force);
    let (law, view) = body.view();
    let summary = sweep.gather(node, view, wanted, |chunk| {
        transport.carry(chunk);
        measure(chunk, &strain);
        advance(law, chunk, &strain, (sweep.cell, landing))
    });
    if summary.inverted { Err(health::inverted(body)) } else { Ok(summary) }
}

/// Sets the volume ratios of a chunk; its gradients are then over the positions at the start of the increment.
fn measure<const D: usize>(chunk: &mut Chunk<'_, D>, strain: &Strain<'_, D>) {
    for (l, stretch) in chunk.gradient.iter_mut().zip(chunk.particles.stretch.iter_mut()) {
        if strain.backwards {
            // x at the start is (1 − dt L) x at the end.
            let back = (Tensor::identity() - *l * strain.dt).inverse();
            *l = back.map_or(Tensor::identity() * f64::NAN, |back| l.dot(&back));
        }
        *stretch = (Tensor::identity() + *l * strain.dt).determinant();
    }
}

/// Updates the stresses of a chunk and lands its particles, unless one was turned inside out.
fn advance<const D: usize>(
    law: &dyn PointLaw,
    chunk: &mut Chunk<'_, D>,
    strain: &Strain<'_, D>,
    (cell, landing): (f64, Landing<D>),
) -> Summary {
    if chunk.particles.stretch.iter().any(|j| !(*j > 0.0 && j.is_finite())) {
        return Summary::inverted();
    }
    chunk.particles.update_law(law, chunk.gradient, strain.dt, cell);
    landing.land(&mut chunk.particles)
}

/// The volume ratio averaged over the grid, ghosts filled.
fn mean_stretch<const D: usize>(
    sweep: &Sweep<'_, D>,
    (grid, ghosts): (&Grid<D>, &Ghosts<D>),
    body: &Body<D>,
) -> Vec<[f64; 1]> {
    let mut nodal = vec![[0.0; 2]; grid.node_count()];
    sweep.scatter(&mut nodal, body, Content::Volumes);
    ghosts.fold(&mut nodal, |_, _, _| {});
    let mut mean: Vec<[f64; 1]> = nodal.iter().map(|[v, vj]| [if *v > 0.0 { vj / v } else { 0.0 }]).collect();
    ghosts.fill(&mut mean);
    mean
}

/// Blends the volume ratios of a chunk with their average over the grid and scales the gradients to fit.
fn average<const D: usize>(chunk: &mut Chunk<'_, D>, dt: f64, blend: f64) {
    for ((l, stretch), mean) in chunk.gradient.iter_mut().zip(chunk.particles.stretch.iter_mut()).zip(chunk.scalar) {
        let blended = *stretch + blend * (mean - *stretch);
        let growth = (((blended - *stretch) / *stretch).ln_1p() / D as f64).exp_m1();
        *l = *l * (1.0 + growth);
        for axis in 0..D {
            l[axis][axis] += growth / dt;
        }
        *stretch = blended;
    }
}
