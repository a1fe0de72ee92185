//! How particles move: velocities from the grid (65), then their places (19).
//!
//! ```text
//! v_p ← (1 − β)(v_p + Δt Σ N_Ip a_I) + β Σ N_Ip v_I⁺       β: PIC share; 1 for APIC
//! C_p = Σ N_Ip v_I⁺ ⊗ (x_I − x_p) D⁻¹,  or Σ v_I⁺ ⊗ ∇N_Ip where D is not constant
//! x_p ← x_p + Δt Σ N_Ip v_I⁺
//! ```

use super::grid::Node;
use super::kernel::Kernel;
use super::particles::Body;
use super::sweep::{Answer, Chunk, Sweep, View, Wanted, record};
use crate::math::{Tensor, Vector};

/// What the end of a step tells about a body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Summary {
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Internal energy [J].
    pub internal: f64,
    /// Largest signal + |v| [m/s].
    pub fastest: f64,
    /// Largest displacement along an axis [m].
    pub shift: f64,
    /// A particle was turned inside out.
    pub inverted: bool,
    /// A particle is not finite, or not in the domain.
    pub lost: bool,
}

impl Summary {
    /// A particle was turned inside out.
    pub fn inverted() -> Self {
        Self { inverted: true, ..Self::default() }
    }
}

impl Answer for Summary {
    fn and(self, other: Self) -> Self {
        Self {
            kinetic: self.kinetic + other.kinetic,
            internal: self.internal + other.internal,
            fastest: self.fastest.max(other.fastest),
            shift: self.shift.max(other.shift),
            inverted: self.inverted | other.inverted,
            lost: self.lost | other.lost,
        }
    }
}

/// Where particles go after their stresses are known.
#[derive(Debug, Clone, Copy)]
pub(super) enum Landing<const D: usize> {
    /// Nowhere: the step is not over.
    Stay,
    /// x += Δt ẋ, then the books: the end of the step.
    Move {
        /// Δt [s].
        dt: f64,
        /// Lower and upper corner of the domain [m].
        domain: [Vector<D>; 2],
    },
}

impl<const D: usize> Landing<D> {
    /// Moves the particles by their rates and sums up.
    pub fn land(&self, particles: &mut View<'_, D>) -> Summary {
        let Self::Move { dt, domain: [lower, upper] } = self else { return Summary::default() };
        let mut summary = Summary::default();
        // Slices of one length: the loop is free of bounds checks.
        let n = particles.len();
        let (position, rate) = (&mut particles.position[..n], &particles.rate[..n]);
        let (velocity, mass, signal) = (&particles.velocity[..n], &particles.mass[..n], &particles.signal[..n]);
        let (pressure, energy) = (&particles.pressure[..n], &particles.energy[..n]);
        for p in 0..n {
            let mut inside = true;
            for a in 0..D {
                let shift = rate[p][a] * dt;
                let x = position[p][a] + shift;
                position[p][a] = x;
                // Written so that a NaN is outside.
                inside &= (x >= lower[a]) & (x <= upper[a]);
                summary.shift = larger(summary.shift, shift.abs());
            }
            let square = velocity[p].norm_squared();
            let state = square + pressure[p] + energy[p];
            summary.lost |= !(inside & state.is_finite());
            summary.kinetic += 0.5 * mass[p] * square;
            summary.internal += energy[p];
            summary.fastest = larger(summary.fastest, signal[p] + square.sqrt());
        }
        summary
    }
}

/// The larger of two numbers; one instruction, unlike `f64::max`, whose care for NaN is not needed here.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// How a gather turns grid motion into particle motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transport {
    /// Step of the momentum [s].
    pub dt: f64,
    /// PIC share β.
    pub share: f64,
    /// 1/D of the affine matrix [1/m²]; `None`: the gradient itself.
    pub per_inertia: Option<f64>,
}

impl Transport {
    /// For a kernel and cell size [m].
    pub fn new(dt: f64, share: f64, kernel: Kernel, cell: f64) -> Self {
        Self { dt, share, per_inertia: kernel.inertia().map(|inertia| 1.0 / (inertia * cell * cell)) }
    }

    /// What must be gathered for particles with or without an affine matrix, and with a gradient if `strained`.
    pub fn wanted(&self, affine: bool, strained: bool) -> Wanted {
        match (affine, strained) {
            (true, _) => Wanted::MotionAndMoment,
            (false, true) => Wanted::MotionAndGradient,
            (false, false) => Wanted::Motion,
        }
    }

    /// New velocities and affine matrices of a chunk, and its rates.
    pub fn carry<const D: usize>(&self, chunk: &mut Chunk<'_, D>) {
        let (dt, share) = (self.dt, self.share);
        let particles = &mut chunk.particles;
        particles.rate.copy_from_slice(chunk.velocity);
        if !particles.affine.is_empty() {
            particles.velocity.copy_from_slice(chunk.velocity);
            for (p, c) in particles.affine.iter_mut().enumerate() {
                *c = match self.per_inertia {
                    Some(scale) => chunk.moment[p] * scale,
                    None => Tensor::from_fn(|i, j| chunk.gradient[p][i][j]),
                };
            }
            return;
        }
        for ((v, v_plus), a) in particles.velocity.iter_mut().zip(chunk.velocity).zip(chunk.acceleration) {
            *v = (*v + *a * dt) * (1.0 - share) + *v_plus * share;
        }
    }
}

/// New velocities of a body and the rates of its positions, from nodes that hold (m, v⁺, a).
pub(super) fn gather_motion<const D: usize>(
    sweep: &Sweep<'_, D>,
    nodes: &[Node<D>],
    transport: Transport,
    body: &mut Body<D>,
) {
    let wanted = transport.wanted(!body.particles.affine.is_empty(), false);
    let node = |n: usize| record(0.0, &nodes[n].momentum, &nodes[n].force);
    sweep.gather(node, body.view().1, wanted, |chunk| transport.carry(chunk));
}

/// Σ N v̂ of the particles on which external forces work, v̂ = v⁺ − ½ Δt a.
pub(super) fn gather_mean<const D: usize>(sweep: &Sweep<'_, D>, nodes: &[Node<D>], dt: f64, body: &mut Body<D>) {
    if !body.work.mean.is_empty() {
        let node = |n: usize| record(0.0, &(nodes[n].momentum - nodes[n].force * (0.5 * dt)), &Vector::ZERO);
        sweep.gather(node, body.view().1, Wanted::Motion, |chunk| chunk.particles.mean.copy_from_slice(chunk.velocity));
    }
}
