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
use super::grid::Grid;
use super::kernel::with_shape;
use super::particles::Body;
use super::transfer_gather::{gather, gather_gradient};
use super::transfer_scatter::scatter_scalars;
use super::{Locking, health};
use crate::error::StepError;
use crate::math::{Tensor, Vector};
use rayon::prelude::*;

/// Strains a body by the grid velocity (ghosts filled) over `dt` [s] and updates its stresses.
///
/// # Errors
/// When a particle's volume would become negative or is not a number.
pub fn update_stress<const D: usize>(
    grid: &Grid<D>,
    ghosts: &Ghosts<D>,
    velocity: &[Vector<D>],
    body: &mut Body<D>,
    dt: f64,
    locking: Locking,
) -> Result<(), StepError> {
    let position = &body.particles.position;
    with_shape!(body.kernel, shape => gather_gradient(shape, grid, velocity, position, &mut body.work.gradient));
    body.work.stretch.clear();
    body.work
        .gradient
        .par_iter()
        .map(|l| (Tensor::identity() + *l * dt).determinant())
        .collect_into_vec(&mut body.work.stretch);
    if let Locking::Average { blend } = locking
        && dt > 0.0
    {
        average_stretch(grid, ghosts, body, dt, blend);
    }
    health::check_stretch(body)?;
    body.update_law(dt, grid.cell);
    Ok(())
}

/// Blends the volume ratios with their average over the grid and scales the gradients to fit.
fn average_stretch<const D: usize>(grid: &Grid<D>, ghosts: &Ghosts<D>, body: &mut Body<D>, dt: f64, blend: f64) {
    let (position, volume, stretch) = (&body.particles.position, &body.particles.volume, &body.work.stretch);
    let mut nodal = vec![[0.0; 2]; grid.node_count()];
    let weighted = |p: usize| [volume[p], volume[p] * stretch[p]];
    with_shape!(body.kernel, shape => scatter_scalars(shape, grid, position, weighted, &mut nodal));
    ghosts.fold(&mut nodal, |_, _, _| {});
    let mut mean: Vec<[f64; 1]> = nodal.iter().map(|[v, vj]| [if *v > 0.0 { vj / v } else { 0.0 }]).collect();
    ghosts.fill(&mut mean);
    let mut averaged = vec![[0.0]; position.len()];
    with_shape!(body.kernel, shape => gather(shape, grid, &mean, position, &mut averaged));

    let columns = body.work.gradient.par_iter_mut().zip(&mut body.work.stretch).zip(averaged);
    columns.for_each(|((l, stretch), [average])| {
        let blended = *stretch + blend * (average - *stretch);
        let growth = (((blended - *stretch) / *stretch).ln_1p() / D as f64).exp_m1();
        *l = *l * (1.0 + growth);
        for axis in 0..D {
            l[axis][axis] += growth / dt;
        }
        *stretch = blended;
    });
}
