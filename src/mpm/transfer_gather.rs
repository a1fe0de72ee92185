//! Grid to particles: motion, affine matrix, velocity gradient (theory 2.3, 2.4).
//!
//! ```text
//! v_p ← (1 − β)(v_p + Δt Σ N_Ip a_I) + β Σ N_Ip v_I⁺       β: PIC share; 1 for APIC          (65)
//! ẋ_p = Σ N_Ip v_I⁺                                                                         (19)
//! C_p = Σ N_Ip v_I⁺ ⊗ (x_I − x_p) D⁻¹,  or Σ v_I⁺ ⊗ ∇N_Ip where D is not constant
//! L_p = Σ v_I ⊗ ∇N_Ip                                                                       (62)
//! ```
//!
//! Every particle writes only its own entries, so these loops run in parallel.

use super::grid::{Grid, Node};
use super::kernel::Shape;
use super::transfer_scatter::stencil;
use crate::math::{Tensor, Vector};
use rayon::prelude::*;

/// Particles that one task handles at least.
const GRAIN: usize = 1024;

/// How the particles move during a step.
#[derive(Debug, Clone, Default)]
pub struct Motion<const D: usize> {
    /// ẋ_p = Σ N v⁺ [m/s].
    pub rate: Vec<Vector<D>>,
    /// Σ N ½(v⁻ + v⁺) [m/s]: what external forces work on.
    pub mean: Vec<Vector<D>>,
}

impl<const D: usize> Motion<D> {
    /// Room for `len` particles.
    pub fn resize(&mut self, len: usize) {
        self.rate.resize(len, Vector::ZERO);
        self.mean.resize(len, Vector::ZERO);
    }
}

/// New velocities (65) and the rates of the positions (19), from nodes that hold (m, v⁺, a).
pub fn gather_motion<const D: usize, const S: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    nodes: &[Node<D>],
    (dt, share): (f64, f64),
    position: &[Vector<D>],
    velocity: &mut [Vector<D>],
    motion: &mut Motion<D>,
) {
    let motions = motion.rate.par_iter_mut().zip(&mut motion.mean);
    let particles = position.par_iter().zip(velocity).zip(motions).with_min_len(GRAIN);
    particles.for_each(|((&x, v), (rate, mean))| {
        let (mut v_plus, mut a) = (Vector::ZERO, Vector::ZERO);
        stencil(grid, shape, x).for_each(|i, n| {
            v_plus += nodes[i].momentum * n;
            a += nodes[i].force * n;
        });
        *v = (*v + a * dt) * (1.0 - share) + v_plus * share;
        *rate = v_plus;
        *mean = v_plus - a * (0.5 * dt);
    });
}

/// The affine matrices of APIC, from nodes that hold (m, v⁺, a).
pub fn gather_affine<const D: usize, const S: usize, K: Shape<S>>(
    shape: K,
    grid: &Grid<D>,
    nodes: &[Node<D>],
    position: &[Vector<D>],
    affine: &mut [Tensor<D>],
) {
    position.par_iter().zip(affine).with_min_len(GRAIN).for_each(|(&x, c)| {
        let stencil = stencil(grid, shape, x);
        *c = Tensor::ZERO;
        match K::INERTIA {
            Some(inertia) => {
                let scale = 1.0 / (inertia * grid.cell * grid.cell);
                stencil.for_each_offset(|i, n, dx| *c += Tensor::outer(nodes[i].momentum, dx) * (n * scale));
            }
            None => stencil.for_each_gradient(|i, _, dn| *c += Tensor::outer(nodes[i].momentum, dn)),
        }
    });
}

/// The velocity gradients (62), embedded in three dimensions (plane strain).
pub fn gather_gradient<const D: usize, const S: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    velocity: &[Vector<D>],
    position: &[Vector<D>],
    gradient: &mut [Tensor<3>],
) {
    position.par_iter().zip(gradient).with_min_len(GRAIN).for_each(|(&x, out)| {
        let mut l = Tensor::<D>::ZERO;
        stencil(grid, shape, x).for_each_gradient(|i, _, dn| l += Tensor::outer(velocity[i], dn));
        *out = l.embed(0.0);
    });
}

/// Nodal values at the particles, Σ N_Ip u_I.
pub fn gather<const D: usize, const S: usize, T: super::ghost::Ghosted + Send + Sync>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    nodal: &[T],
    position: &[Vector<D>],
    values: &mut [T],
) {
    position.par_iter().zip(values).with_min_len(GRAIN).for_each(|(&x, value)| {
        let mut sum = T::default();
        stencil(grid, shape, x).for_each(|i, n| sum = sum.plus(nodal[i], n));
        *value = sum;
    });
}
