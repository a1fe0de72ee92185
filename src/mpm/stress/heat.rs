//! The dissipation of the transfer as heat of the particles that lost it (theory A.16).
//!
//! **FLIP.** Of the velocity v_I⁺ that forces f_I make on the grid, particles bring ṽ_I = Σ m_p N_Ip v_p/m_I back. With
//! nodal accelerations a, lumped and consistent masses M_L and M, that dissipates
//!
//! ```text
//! D = Σ_I ½ Δt f_I·(v_I⁺ − ṽ_I) = ½ Δt² aᵀ(M_L − M) a
//! ```
//!
//! A stress update with ṽ (`average`, `modified-last`) takes so much less from the internal energy for the work of the
//! stresses: the part of D that their forces have is kept, as "stress update error" of the ledger, and gas that moves
//! by itself loses nothing. Left is the part of the other forces, of contact and walls, which nodes hand on:
//!
//! ```text
//! h_I = ½ Δt (f_I − f_I^applied)·(v_I⁺ − ṽ_I),      q_p = m_p Σ N_Ip h_I/m_I,      Σ q_p = Σ h_I
//! ```
//!
//! **The noise filter** of order k (`filter`) makes v − u_k of the velocities v, with u_0 = v, u_j = u_{j−1} − Σ N_Ip
//! w_j. That is u_j = (1 − A) u_{j−1} with A, to the grid and back. With the masses A is its own adjoint, so that the
//! energy Σ m_p (v·u_k − ½ |u_k|²) which the filter takes is, with h = ⌈k/2⌉, the sum of
//!
//! ```text
//! q_p = m_p [ ½ |u_h|² + (k odd) (Σ N_Ip |w_h|² − |Σ N_Ip w_h|²) + Σ_{j=h+1..k} (Σ N_Ip |w_j|² − ½ |Σ N_Ip w_j|²) ]
//! ```
//!
//! all of them ≥ 0, because N_Ip are the weights of a mean: the heat stays where the noise was, and nothing is cooled.
//!
//! Heat enters the energy before the law is called, as viscous heating does, so that the pressure follows it.

use crate::math::Vector;
use crate::mpm::Dissipation;
use crate::mpm::grid::{GhostFractions, Ghosts, NodeMotion, VelocityField};
use crate::mpm::particles::Body;
use crate::mpm::transfer::Chunk;
use crate::parallel::{self, CHUNK};

impl Dissipation {
    /// True if a body keeps as heat what it loses in the transfer.
    pub(in crate::mpm) fn warms<const D: usize>(self, body: &Body<D>) -> bool {
        self == Self::Heat && body.law.is_thermal()
    }
}

/// A number on each of `count` nodes, ghosts filled, for the scalar slot of a gather.
pub(in crate::mpm) fn nodal<const D: usize>(
    ghosts: &Ghosts<D>,
    limits: &GhostFractions,
    count: usize,
    number: impl Fn(usize) -> f64 + Sync + Send,
) -> Vec<[f64; 1]> {
    let mut numbers = parallel::collect(count, CHUNK, |node| [number(node)]);
    ghosts.fill(limits, &mut numbers);
    numbers
}

/// h_I/m_I [J/kg] of a field whose nodes hold (m, v⁺, a), and ṽ as velocities; `dt` is the step of the momentum [s].
pub(in crate::mpm) fn of_contact<const D: usize>(
    ghosts: &Ghosts<D>,
    field: &VelocityField<D>,
    dt: f64,
) -> Vec<[f64; 1]> {
    let VelocityField { nodes, applied, velocity, limits, .. } = field;
    let nodes = NodeMotion::of(nodes);
    nodal(ghosts, limits, nodes.len(), |n| {
        let node = &nodes[n];
        if node.mass() <= 0.0 {
            return 0.0;
        }
        let by_others = node.acceleration() - applied[n] / node.mass();
        0.5 * dt * by_others.dot(node.velocity() - velocity[n])
    })
}

/// Adds the heat per mass that was gathered as scalar to the energies of a chunk; returns what it adds [J].
pub(in crate::mpm) fn warm<const D: usize>(chunk: &mut Chunk<'_, D>) -> f64 {
    let (particles, rows) = (&mut chunk.particles, &chunk.rows);
    let columns = particles.energy.iter_mut().zip(particles.mass).zip(&rows.scalar);
    columns.fold(0.0, |sum, ((energy, mass), per_mass)| {
        *energy += mass * per_mass;
        sum + mass * per_mass
    })
}

/// Takes Σ N w_j from the noise u_{j−1} of a chunk, for a filter of order `order`, and adds to the energies what
/// becomes heat; returns its sum [J]. The scalar that was gathered is Σ N |w_j|².
pub(in crate::mpm) fn warm_by_filter<const D: usize>(chunk: &mut Chunk<'_, D>, j: u32, order: u32) -> f64 {
    let (particles, rows) = (&mut chunk.particles, &chunk.rows);
    let mut sum = 0.0;
    for (p, noise) in particles.noise.iter_mut().enumerate() {
        let smooth = rows.velocity(p);
        *noise -= smooth;
        let per_mass = filter_heat(j, order, *noise, smooth, rows.scalar[p]);
        particles.energy[p] += particles.mass[p] * per_mass;
        sum += particles.mass[p] * per_mass;
    }
    sum
}

/// The part of q_p/m_p [J/kg] of stage `j` of a filter of order `order`, from the noise u_j, `smooth` = Σ N w_j, and
/// `squares` = Σ N |w_j|².
#[inline(always)]
pub(in crate::mpm) fn filter_heat<const D: usize>(
    j: u32,
    order: u32,
    noise: Vector<D>,
    smooth: Vector<D>,
    squares: f64,
) -> f64 {
    let half = order.div_ceil(2);
    // Rounding alone makes it negative.
    let spread = (squares - smooth.norm_squared()).max(0.0);
    match j {
        _ if j < half => 0.0,
        _ if j > half => spread + 0.5 * smooth.norm_squared(),
        _ if order % 2 == 1 => spread + 0.5 * noise.norm_squared(),
        _ => 0.5 * noise.norm_squared(),
    }
}
