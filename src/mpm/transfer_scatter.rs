//! Particles to grid: mass, momentum and force (theory 2.1, 2.3).
//!
//! ```text
//! m_I = Σ m_p N_Ip                                           (60)
//! p_I = Σ m_p N_Ip (v_p + C_p (x_I − x_p))                   (61; C = 0 for FLIP)
//! f_I = Σ −V_p σ_p ∇N_Ip + F_p N_Ip                          (17, 18; F = m b + A t̄)
//! ```
//!
//! Plain loops in the order of the particles: the specification that faster variants are compared with.
//! Ghost nodes receive their share like all others; see `ghost` for what becomes of it.

use super::grid::{Grid, Node};
use super::kernel::Shape;
use super::particles::Particles;
use super::stencil::Stencil;
use crate::math::Vector;

/// The stencil of a particle, whose blocks the step has activated.
#[inline(always)]
pub(super) fn stencil<const D: usize, const S: usize>(
    grid: &Grid<D>,
    shape: impl Shape<S>,
    x: Vector<D>,
) -> Stencil<D, S> {
    Stencil::new(grid, shape, x).expect("blocks around every particle are active")
}

/// Mass and momentum of the particles (60, 61).
pub fn scatter_mass_and_momentum<const D: usize, const S: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    particles: &Particles<D>,
    nodes: &mut [Node<D>],
) {
    for p in 0..particles.len() {
        let (m, v, c) = (particles.mass[p], particles.velocity[p], particles.affine(p));
        stencil(grid, shape, particles.position[p]).for_each_offset(|i, n, dx| {
            nodes[i].mass += m * n;
            nodes[i].momentum += (v + c.apply(dx)) * (m * n);
        });
    }
}

/// The particles' present momentum, re-mapped with the weights of the same positions (theory 2.4, MUSL).
pub fn scatter_momentum<const D: usize, const S: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    particles: &Particles<D>,
    momentum: &mut [Vector<D>],
) {
    for p in 0..particles.len() {
        let (m, v, c) = (particles.mass[p], particles.velocity[p], particles.affine(p));
        stencil(grid, shape, particles.position[p]).for_each_offset(|i, n, dx| {
            momentum[i] += (v + c.apply(dx)) * (m * n);
        });
    }
}

/// Forces of stresses and of `external` forces per particle [N] (17, 18); `external` is empty where there are none.
pub fn scatter_force<const D: usize, const S: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    particles: &Particles<D>,
    external: &[Vector<D>],
    nodes: &mut [Node<D>],
) {
    for p in 0..particles.len() {
        let v_sigma = particles.stress(p).full() * particles.volume[p];
        let f = external.get(p).copied().unwrap_or_default();
        stencil(grid, shape, particles.position[p]).for_each_gradient(|i, n, dn| {
            let internal = Vector::from_fn(|a| (0..D).map(|b| v_sigma[a][b] * dn[b]).sum());
            nodes[i].force += f * n - internal;
        });
    }
}

/// Scalars of the particles, `value(p)` each, as Σ N_Ip value_p.
pub fn scatter_scalars<const D: usize, const S: usize, const N: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    position: &[Vector<D>],
    value: impl Fn(usize) -> [f64; N],
    nodes: &mut [[f64; N]],
) {
    for (p, &x) in position.iter().enumerate() {
        let values = value(p);
        stencil(grid, shape, x).for_each(|i, n| {
            for (sum, value) in nodes[i].iter_mut().zip(values) {
                *sum += value * n;
            }
        });
    }
}
