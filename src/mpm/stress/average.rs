//! Averages over the nodes, the cure of volumetric locking (theory A.10).
//!
//! ```text
//! A q = Σ N_Ip q̃_I,      q̃_I = Σ V_p q_p N_Ip / Σ V_p N_Ip
//! ```
//!
//! of volume ratios before the law is called (`strain` blends them), and of pressures before they make forces. The average of a
//! field of particles is its own adjoint, Σ V p A q = Σ V q A p. The forces are therefore made of the averaged pressure
//!
//! ```text
//! p̃ = (1 − β) p + β A p        so that      Σ V_p p_p tr L̄_p = Σ V_p p̃_p tr L_p
//! ```
//!
//! and do the work that the laws store. With p itself they don't: they push on volume changes that no stress sees,
//! and a column of liquid under its pressure gains energy from them without end.

use crate::mpm::grid::{GhostFractions, Ghosts};
use crate::mpm::transfer::Chunk;
use crate::parallel;

/// q̃_I of the `sums` Σ V N and Σ V q N, ghosts filled; 0 where no particle is near.
pub(in crate::mpm) fn divide<const D: usize>(
    ghosts: &Ghosts<D>,
    limits: &GhostFractions,
    sums: &mut [[f64; 2]],
    means: &mut Vec<[f64; 1]>,
) {
    ghosts.fold(limits, sums, |_, _, _| {});
    parallel::map_into(sums, means, |[v, vq]| [if *v > 0.0 { vq / v } else { 0.0 }]);
    ghosts.fill(limits, means);
}

/// p̃ − p of a chunk, whose averaged pressures were gathered as scalar.
pub(in crate::mpm) fn average_pressure<const D: usize>(chunk: &mut Chunk<'_, D>, blend: f64) {
    for p in 0..chunk.particles.len() {
        let more = chunk.rows.scalar[p] - chunk.particles.mean_pressure(p);
        chunk.particles.excess[p] = blend * more;
    }
}
