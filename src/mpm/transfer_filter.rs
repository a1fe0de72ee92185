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
use super::kernel::{Shape, with_shape};
use super::particles::Body;
use super::stencil::Stencil;
use super::transfer_gather::gather;
use super::transfer_scatter::stencil;
use super::wall::Walls;
use crate::math::Vector;

/// Replaces the velocities of the bodies of one field by Σ N v⁽ᵏ⁾; nodes hold (m, v⁺, a), ghosts filled.
pub fn filter<const D: usize>(
    grid: &Grid<D>,
    ghosts: &Ghosts<D>,
    walls: &Walls<D>,
    field: &Field<D>,
    bodies: &mut [&mut Body<D>],
    order: u32,
) {
    let mut w: Vec<Vector<D>> = field.nodes.iter().map(|node| node.momentum).collect();
    let mut v = w.clone();
    for _ in 1..order {
        let mut smooth = vec![Vector::ZERO; w.len()];
        for body in bodies.iter_mut() {
            let Body { kernel, particles, work, .. } = &mut **body;
            with_shape!(*kernel, shape => gather(shape, grid, &w, &particles.position, &mut work.motion.mean));
            let values = (&particles.mass[..], &work.motion.mean[..]);
            with_shape!(*kernel, shape => scatter(shape, grid, &particles.position, values, &mut smooth));
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
    for body in bodies.iter_mut() {
        let particles = &mut body.particles;
        with_shape!(body.kernel, shape => gather(shape, grid, &v, &particles.position, &mut particles.velocity));
    }
}

/// Σ m_p N_Ip u_p.
fn scatter<const D: usize, const S: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    position: &[Vector<D>],
    (mass, values): (&[f64], &[Vector<D>]),
    nodes: &mut [Vector<D>],
) {
    for ((&x, &m), &u) in position.iter().zip(mass).zip(values) {
        let around: Stencil<D, S> = stencil(grid, shape, x);
        around.for_each(|i, n| nodes[i] += u * (m * n));
    }
}
