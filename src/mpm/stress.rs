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
use super::motion::{Landing, Summary, Transport};
use super::particles::Body;
use super::sweep::{Bins, Chunk, Content, Extent, Sweep, Wanted, record};
use super::{Locking, health};
use crate::error::StepError;
use crate::material::PointLaw;
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
            let (mean, _) = average(sweep, (grid, ghosts), body, Content::Volumes);
            let node = |n: usize| record(mean[n][0], &strain.velocity[n], &Vector::ZERO);
            let (law, view) = body.view();
            sweep.gather(node, view, Wanted::MotionAndGradient, |chunk| {
                measure(chunk, &strain);
                blend_stretch(chunk, strain.dt, blend);
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
    Sweep::new(grid, body.kernel, bins).gather(node, body.view().1, Wanted::Motion, |chunk| {
        chunk.particles.excess.iter_mut().zip(chunk.scalar).for_each(|(p, mean)| *p = blend * (mean - *p));
    });
}

/// Blends the volume ratios of a chunk with their average over the grid and scales the gradients to fit.
fn blend_stretch<const D: usize>(chunk: &mut Chunk<'_, D>, dt: f64, blend: f64) {
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
