//! The FMPM(k) filter: an approximate inverse of the full mass matrix (theory 2.3; Nairn & Hammerquist 2021).
//!
//! FLIP keeps velocity modes that the grid can't see. One update of order k now and then replaces the
//! particles' velocity v_p by Σ N v⁽ᵏ⁾, where
//!
//! ```text
//! A = M⁻¹ Σ m_p N_Ip N_Jp,   w₁ = M⁻¹ Σ m_p N_Ip v_p,   w_{j+1} = w_j − A w_j,   v⁽ᵏ⁾ = Σ_{j=1..k} w_j
//! ```
//!
//! With w₁ = v⁺, as in FMPM, the nodes would give once more what the particles had not taken of their increments; so it is an
//! operator with eigenvalues in 0..=1, which never adds energy.
//!
//! Order 1 is PIC; higher orders keep more of what the grid can see. Corrections don't act along axes
//! that a wall binds.

use super::ghost::Ghosts;
use super::grid::{Field, Grid};
use super::heat::{Dissipation, nodal, warm_by_filter};
use super::motion::keep_velocity;
use super::particles::Body;
use super::sweep::{Bins, Content, Record, Sweep, Wanted, put_scalar, put_velocity};
use super::wall::Walls;
use crate::math::Vector;
use crate::parallel::CHUNK;
use rayon::prelude::*;

/// Replaces the velocities of the bodies of one field by Σ N v⁽ᵏ⁾, with w₁ in `w`, ghosts filled. Returns the heat [J] that
/// it becomes in the bodies that keep it.
pub fn filter<const D: usize>(
    grid: &Grid<D>,
    (ghosts, walls): (&Ghosts<D>, &Walls<D>),
    field: &Field<D>,
    bodies: &mut [(&mut Body<D>, &Bins<D>)],
    mut w: Vec<Vector<D>>,
    (order, dissipation): (u32, Dissipation),
) -> f64 {
    let (mut v, mut smooth) = (w.clone(), Vec::new());
    for (body, _) in bodies.iter_mut().filter(|(body, _)| dissipation.warms(body)) {
        body.work.noise.clone_from(&body.particles.velocity);
    }
    let mut heat = gather(grid, ghosts, &w, bodies, (1, order));
    for j in 2..=order {
        let bodies_now = bodies.iter().map(|(body, bins)| (&**body, *bins));
        smooth = velocity_on_grid(grid, ghosts, field, bodies_now, smooth);
        w.iter_mut().zip(&smooth).for_each(|(w, s)| *w -= *s);
        walls.constrain_correction(&mut w);
        ghosts.fill(&mut w);
        v.iter_mut().zip(&w).for_each(|(v, w)| *v += *w);
        heat += gather(grid, ghosts, &w, bodies, (j, order));
    }
    for (body, bins) in bodies {
        body.work.noise.clear();
        gather_velocity(&Sweep::new(grid, body.kernel, bins), &v, body);
    }
    heat
}

/// Σ m_p N_Ip v_p / m_I [m/s] of the bodies of a field, in the memory of `velocity`; nothing on the ghosts.
pub fn velocity_on_grid<'a, const D: usize>(
    grid: &Grid<D>,
    ghosts: &Ghosts<D>,
    field: &Field<D>,
    bodies: impl Iterator<Item = (&'a Body<D>, &'a Bins<D>)>,
    mut velocity: Vec<Vector<D>>,
) -> Vec<Vector<D>> {
    velocity.clear();
    velocity.resize(field.nodes.len(), Vector::ZERO);
    for (body, bins) in bodies {
        Sweep::new(grid, body.kernel, bins).scatter(&mut velocity, body, Content::Momentum);
    }
    divide_by_mass(ghosts, field, &mut velocity);
    velocity
}

/// Makes velocities of momentum that was scattered; nothing on the ghosts.
pub fn divide_by_mass<const D: usize>(ghosts: &Ghosts<D>, field: &Field<D>, momentum: &mut [Vector<D>]) {
    ghosts.fold(momentum, |_, _, _| {});
    momentum.par_iter_mut().zip(&field.nodes).with_min_len(CHUNK).for_each(|(v, node)| {
        *v = if node.mass > 0.0 { *v / node.mass } else { Vector::ZERO };
    });
    field.faint.iter().for_each(|faint| faint.follow(momentum));
}

/// v_p = Σ N w_j; of bodies that keep the heat, what that becomes [J].
fn gather<const D: usize>(
    grid: &Grid<D>,
    ghosts: &Ghosts<D>,
    w: &[Vector<D>],
    bodies: &mut [(&mut Body<D>, &Bins<D>)],
    (j, order): (u32, u32),
) -> f64 {
    let warmed = bodies.iter().any(|(body, _)| !body.work.noise.is_empty());
    let squares = if warmed { nodal(ghosts, w.len(), |n| w[n].norm_squared()) } else { Vec::new() };
    let mut heat = 0.0;
    for (body, bins) in bodies {
        let sweep = Sweep::new(grid, body.kernel, bins);
        if !body.work.noise.is_empty() {
            let node = |n: usize, record: &mut Record| {
                put_scalar(record, squares[n][0]);
                put_velocity(record, &w[n]);
            };
            heat += sweep.gather(node, body.view().1, Wanted::Gradient, |chunk| {
                keep_velocity(chunk.particles.velocity, chunk.rows);
                warm_by_filter(chunk, j, order)
            });
        } else if j < order {
            gather_velocity(&sweep, w, body);
        }
    }
    heat
}

/// v_p = Σ N_Ip u_I.
fn gather_velocity<const D: usize>(sweep: &Sweep<'_, D>, nodal: &[Vector<D>], body: &mut Body<D>) {
    let node = |n: usize, record: &mut Record| put_velocity(record, &nodal[n]);
    sweep.gather(node, body.view().1, Wanted::Motion, |chunk| keep_velocity(chunk.particles.velocity, chunk.rows));
}
