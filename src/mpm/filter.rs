//! The FMPM(k) filter: an approximate inverse of the full mass matrix (theory 2.3; Nairn & Hammerquist 2021).
//!
//! FLIP keeps velocity modes that the grid can't see. One update of order k now and then replaces the
//! particles' velocity by Σ N v⁽ᵏ⁾, where
//!
//! ```text
//! A = M⁻¹ Σ m_p N_Ip N_Jp,   w₁ = v⁺,   w_{j+1} = w_j − A w_j,   v⁽ᵏ⁾ = Σ_{j=1..k} w_j
//! ```
//!
//! Order 1 is PIC; higher orders keep more of what the grid can see. Corrections don't act along axes
//! that a wall binds.

use super::ghost::Ghosts;
use super::grid::{Field, Grid};
use super::motion::keep_velocity;
use super::particles::Body;
use super::sweep::{Bins, Content, Sweep, Wanted, record};
use super::wall::Walls;
use crate::math::Vector;

/// Replaces the velocities of the bodies of one field by Σ N v⁽ᵏ⁾; nodes hold (m, v⁺, a), ghosts filled.
pub fn filter<const D: usize>(
    grid: &Grid<D>,
    (ghosts, walls): (&Ghosts<D>, &Walls<D>),
    field: &Field<D>,
    bodies: &mut [(&mut Body<D>, &Bins<D>)],
    order: u32,
) {
    let mut w: Vec<Vector<D>> = field.nodes.iter().map(|node| node.momentum).collect();
    let mut v = w.clone();
    for _ in 1..order {
        gather(grid, &w, bodies);
        let mut smooth = vec![Vector::ZERO; w.len()];
        for (body, bins) in bodies.iter() {
            Sweep::new(grid, body.kernel, bins).scatter(&mut smooth, body, Content::Momentum);
        }
        ghosts.fold(&mut smooth, |_, _, _| {});
        for (node, s) in field.nodes.iter().zip(&mut smooth) {
            *s = if node.mass > 0.0 { *s / node.mass } else { Vector::ZERO };
        }
        w.iter_mut().zip(smooth).for_each(|(w, s)| *w -= s);
        walls.constrain_correction(&mut w);
        ghosts.fill(&mut w);
        v.iter_mut().zip(&w).for_each(|(v, w)| *v += *w);
    }
    gather(grid, &v, bodies);
}

/// v_p = Σ N_Ip u_I.
fn gather<const D: usize>(grid: &Grid<D>, nodal: &[Vector<D>], bodies: &mut [(&mut Body<D>, &Bins<D>)]) {
    for (body, bins) in bodies {
        let node = |n: usize| record(0.0, &nodal[n], &Vector::ZERO);
        Sweep::new(grid, body.kernel, bins).gather(node, body.view().1, Wanted::Motion, |chunk| {
            keep_velocity(chunk.particles.velocity, chunk.rows);
        });
    }
}
