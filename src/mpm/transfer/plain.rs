//! The transfers as plain loops over unsorted particles, one particle at a time: the specification.
//!
//! ```text
//! m_I = Σ m_p N_Ip                                           Lian (60)
//! p_I = Σ m_p N_Ip (v_p + C_p (x_I − x_p))                   Lian (61); C = 0 for FLIP
//! f_I = Σ −V_p σ_p ∇N_Ip + F_p N_Ip                          Lian (17, 18); F: external force
//! v_p ← (1 − β)(v_p + Δt Σ N_Ip a_I) + β Σ N_Ip v_I⁺       β: PIC share; 1 for APIC          Lian (65)
//! ẋ_p = Σ N_Ip v_I⁺                                                                         Lian (19)
//! C_p = Σ N_Ip v_I⁺ ⊗ (x_I − x_p) D⁻¹,  or Σ v_I⁺ ⊗ ∇N_Ip where D is not constant
//! L_p = Σ v_I ⊗ ∇N_Ip                                                                       Lian (62)
//! ```
//!
//! The step uses the sweeps of this room, which compute the same sums over sorted particles; tests compare the two.

use crate::math::{Tensor, Vector};
use crate::mpm::grid::kernel::Shape;
use crate::mpm::grid::stencil::Stencil;
use crate::mpm::grid::{Grid, Node};
use crate::mpm::particles::Particles;

/// The stencil of a particle, whose blocks the step has activated.
#[inline(always)]
fn stencil<const D: usize, const S: usize>(grid: &Grid<D>, shape: impl Shape<S>, x: Vector<D>) -> Stencil<D, S> {
    Stencil::new(grid, shape, x).expect("blocks around every particle are active")
}

/// Mass and momentum of the particles, Lian (60, 61).
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

/// Forces of stresses and of `external` forces per particle [N], Lian (17, 18); `external` is empty where there are none.
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

/// New velocities, Lian (65), and the rates of the positions, Lian (19), from nodes that hold (m, v⁺, a); `share` is the PIC share.
pub fn gather_motion<const D: usize, const S: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    nodes: &[Node<D>],
    (dt, share): (f64, f64),
    position: &[Vector<D>],
    velocity: &mut [Vector<D>],
    rate: &mut [Vector<D>],
) {
    for ((&x, v), rate) in position.iter().zip(velocity).zip(rate) {
        let (mut v_plus, mut a) = (Vector::ZERO, Vector::ZERO);
        stencil(grid, shape, x).for_each(|i, n| {
            v_plus += nodes[i].momentum * n;
            a += nodes[i].force * n;
        });
        *v = (*v + a * dt) * (1.0 - share) + v_plus * share;
        *rate = v_plus;
    }
}

/// The affine matrices of APIC, from nodes that hold (m, v⁺, a).
pub fn gather_affine<const D: usize, const S: usize, K: Shape<S>>(
    shape: K,
    grid: &Grid<D>,
    nodes: &[Node<D>],
    position: &[Vector<D>],
    affine: &mut [Tensor<D>],
) {
    for (&x, c) in position.iter().zip(affine) {
        let stencil = stencil(grid, shape, x);
        *c = Tensor::ZERO;
        match K::INERTIA {
            Some(inertia) => {
                let scale = 1.0 / (inertia * grid.cell * grid.cell);
                stencil.for_each_offset(|i, n, dx| *c += Tensor::outer(nodes[i].momentum, dx) * (n * scale));
            }
            None => stencil.for_each_gradient(|i, _, dn| *c += Tensor::outer(nodes[i].momentum, dn)),
        }
    }
}

/// The velocity gradients, Lian (62), embedded in three dimensions (plane strain).
pub fn gather_gradient<const D: usize, const S: usize>(
    shape: impl Shape<S>,
    grid: &Grid<D>,
    velocity: &[Vector<D>],
    position: &[Vector<D>],
    gradient: &mut [Tensor<3>],
) {
    for (&x, out) in position.iter().zip(gradient) {
        let mut l = Tensor::<D>::ZERO;
        stencil(grid, shape, x).for_each_gradient(|i, _, dn| l += Tensor::outer(velocity[i], dn));
        *out = l.embed(0.0);
    }
}
