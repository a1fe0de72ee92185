//! The motion of the particles: velocities from the grid, Lian (65), then positions, Lian (19); theory A.6, A.9.
//!
//! ```text
//! v_p ← (1 − β)(v_p + Δt Σ N_Ip a_I) + β Σ N_Ip v_I⁺       β: PIC fraction; 1 for APIC
//! C_p = Σ N_Ip v_I⁺ ⊗ (x_I − x_p) D⁻¹,  or Σ v_I⁺ ⊗ ∇N_Ip where D is not constant
//! x_p ← x_p + Δt Σ N_Ip w_I                             w: ṽ of solids that ṽ strains; else v⁺
//! ```
//!
//! **Solids move with the velocity that strains them.** Of the accelerations a = f/m of the nodes particles bring only
//! A a back to the grid, A = M⁻¹ Σ m_p N_Ip N_Jp: ṽ = v⁻ + Δt A a, and of waves as short as a cell A leaves a seventh
//! along each axis. Stresses that are updated with ṽ (`average`, `modified-last`) don't see the rest; particles that
//! move with v⁺ do, and with them the slopes by which stresses push. Let u be the amplitude of such a wave in the
//! strains, z how far the positions are ahead of it, ω its frequency with A = 1, and κ ω² the stiffness of the stresses
//! that are there when the positions move, κ ≈ σ/E:
//!
//! ```text
//! ü = −A ω² ((1 + κ) u + κ z),   ż = −(1 − A) Δt ω² ((1 + κ) u + κ z)   ⇒   ü + (1 − A) Δt κ ω² u̇ + A ω² (1 + κ) u = const
//! ```
//!
//! If κ < 0 the wave grows, by (1 − A) |κ| (ω Δt)²/2 a step: stripes of stress a cell wide in a body at rest. With
//! w = ṽ there is no z. `last` strains and moves by v⁺, and damps such waves; `first` strains by v⁻, and they grow in
//! it.
//!
//! FLIP loses no angular momentum by it, Σ m_p (Σ N_Ip ṽ_I) × v_p = Σ m_I ṽ_I × ṽ_I = 0; APIC, which keeps it if
//! particles move with their velocity v⁺, would, and moves so. It damps such waves; bodies that are strained by
//! more than a tenth and rest for long want FLIP. Liquids and gases move with v⁺, in which contact and walls have acted
//! in full: they must not leak.
//!
//! **Walls of the domain hold positions.** Where a film or a single particle is next to a wall, velocities there keep
//! up to a sixth of that of the row of nodes inside (`ghost::limit`). What it would carry beyond the wall stays on it.

use crate::math::simd::{Lanes, Task, WIDTH, widest};
use crate::math::{Tensor, Vector};
use crate::mpm::grid::Grid;
use crate::mpm::kernel::Kernel;
use crate::mpm::particles::Summary;
use crate::mpm::transfer::{CHUNK_LEN, Chunk, ChunkColumn, GatherFields, Rows, View};

/// A particle up to this far beyond a wall is set back onto it [cells]; one that moves farther in a step is lost.
const HELD: f64 = 0.25;

/// The end of a step: x += Δt ẋ, then the sums of the ledger.
#[derive(Debug, Clone, Copy)]
pub(in crate::mpm) struct Landing<const D: usize> {
    /// Δt [s].
    dt: f64,
    /// Lower and upper corner of the domain [m].
    domain: [Vector<D>; 2],
    /// Distance beyond them up to which walls hold particles [m]; zero where there is no wall.
    held: [Vector<D>; 2],
}

impl<const D: usize> Landing<D> {
    /// Motion in a step of `dt` [s] in a grid between walls, of which some hold positions, by axis and end.
    pub fn new(grid: &Grid<D>, walls: impl Fn(usize, usize) -> bool, dt: f64) -> Self {
        let held = |end| Vector::from_fn(|a| if walls(a, end) { HELD * grid.cell } else { 0.0 });
        Self { dt, domain: [grid.origin, grid.upper()], held: [held(0), held(1)] }
    }
}

impl<const D: usize> Landing<D> {
    /// Moves the particles by the rates of their column, or by their velocities if it is empty, and sums up.
    pub fn land(&self, particles: &mut View<'_, D>) -> Summary {
        if particles.rate.is_empty() {
            return self.land_by(particles, Carried);
        }
        let rate = std::mem::take(&mut particles.rate);
        let summary = self.land_by(particles, &*rate);
        particles.rate = rate;
        summary
    }

    /// Moves the particles by rates [m/s] and sums up.
    pub fn land_by(&self, particles: &mut View<'_, D>, rates: impl PositionRates<D>) -> Summary {
        widest(Land { particles, rates, landing: *self })
    }
}

/// Rates of the positions of a chunk's particles.
pub(in crate::mpm) trait PositionRates<const D: usize> {
    /// Component `a` of the rate of particle `p` [m/s], whose velocity is `v`.
    fn rate(&self, p: usize, v: &Vector<D>, a: usize) -> f64;
}

impl<const D: usize> PositionRates<D> for &[Vector<D>] {
    #[inline(always)]
    fn rate(&self, p: usize, _: &Vector<D>, a: usize) -> f64 {
        self[p][a]
    }
}

impl<const D: usize> PositionRates<D> for &Rows<D> {
    #[inline(always)]
    fn rate(&self, p: usize, _: &Vector<D>, a: usize) -> f64 {
        self.velocity[a][p]
    }
}

/// Particles move with their velocities: these are the nodes' (APIC).
struct Carried;

impl<const D: usize> PositionRates<D> for Carried {
    #[inline(always)]
    fn rate(&self, _: usize, v: &Vector<D>, a: usize) -> f64 {
        v[a]
    }
}

/// The landing of a chunk.
struct Land<'a, 'b, R, const D: usize> {
    particles: &'a mut View<'b, D>,
    rates: R,
    landing: Landing<D>,
}

impl<R: PositionRates<D>, const D: usize> Task for Land<'_, '_, R, D> {
    type Output = Summary;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Summary {
        let Landing { dt, domain: [lower, upper], held: [below, above] } = self.landing;
        let (lowest, highest) = (lower - below, upper + above);
        // Slices of one length: the loops are free of bounds checks, and without sums they become vectors.
        let n = self.particles.len().min(CHUNK_LEN);
        let (position, velocity) = (&mut self.particles.position[..n], &self.particles.velocity[..n]);
        let (mass, wave_speed) = (&self.particles.mass[..n], &self.particles.wave_speed[..n]);
        let (pressure, energy) = (&self.particles.pressure[..n], &self.particles.energy[..n]);
        let [mut shift, mut lost, mut kinetic, mut internal, mut speed] = [[0.0; CHUNK_LEN]; 5];
        for p in 0..n {
            let (mut outside, mut square) = (0.0, 0.0);
            for a in 0..D {
                let step = self.rates.rate(p, &velocity[p], a) * dt;
                let x = position[p][a] + step; // Lian (19)
                let x = if (x < lower[a]) & (x > lowest[a]) { lower[a] } else { x };
                let x = if (x > upper[a]) & (x < highest[a]) { upper[a] } else { x };
                position[p][a] = x;
                // Written so that a NaN is outside.
                outside = if (x >= lower[a]) & (x <= upper[a]) { outside } else { 1.0 };
                shift[p] = larger(shift[p], step.abs());
                square += velocity[p][a] * velocity[p][a];
            }
            let state = square + pressure[p] + energy[p];
            lost[p] = if state.abs() < f64::INFINITY { outside } else { 1.0 };
            kinetic[p] = 0.5 * mass[p] * square;
            internal[p] = energy[p];
            speed[p] = wave_speed[p] + square.sqrt();
        }
        Summary {
            kinetic: fold::<L>(&kinetic, L::add, |a, b| a + b),
            internal: fold::<L>(&internal, L::add, |a, b| a + b),
            largest_wave_speed: fold::<L>(&speed, L::max, larger),
            shift: fold::<L>(&shift, L::max, larger),
            lost: fold::<L>(&lost, L::max, larger) > 0.0,
            ..Summary::default()
        }
    }
}

/// Folds the numbers of a chunk: each lane first, then the lanes in order.
#[inline(always)]
fn fold<L: Lanes>(numbers: &[f64; CHUNK_LEN], lanes: impl Fn(L, L) -> L, one: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sum = L::splat(0.0);
    for row in numbers.as_chunks::<WIDTH>().0 {
        sum = lanes(L::load(row), sum);
    }
    let mut row = [0.0; WIDTH];
    sum.store(&mut row);
    row.into_iter().fold(0.0, one)
}

/// The larger of two numbers; one instruction, unlike `f64::max`, whose care for NaN is not needed here.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The motion of particles from that of the grid.
#[derive(Debug, Clone, Copy)]
pub(in crate::mpm) struct Transport {
    /// Step of the momentum [s].
    pub dt: f64,
    /// PIC fraction β.
    pub pic_fraction: f64,
    /// 1/D of the affine matrix [1/m²]; `None`: the gradient itself.
    pub per_inertia: Option<f64>,
}

impl Transport {
    /// The transport of a step with a PIC fraction, for a kernel and cell size [m].
    pub fn new(dt: f64, pic_fraction: f64, kernel: Kernel, cell: f64) -> Self {
        Self { dt, pic_fraction, per_inertia: kernel.inertia().map(|inertia| 1.0 / (inertia * cell * cell)) }
    }

    /// The sums for particles with or without an affine matrix, and with a gradient if `strained`.
    pub fn fields(&self, affine: bool, strained: bool) -> GatherFields {
        match (affine, strained) {
            (true, false) if self.per_inertia.is_some() => GatherFields::Moment,
            (true, false) => GatherFields::Gradient,
            (true, true) => GatherFields::GradientAndMoment,
            (false, true) => GatherFields::MotionAndGradient,
            (false, false) => GatherFields::Motion,
        }
    }

    /// New velocities and affine matrices of a chunk.
    pub fn carry<const D: usize>(&self, chunk: &mut Chunk<'_, D>) {
        let Chunk { particles, rows, .. } = chunk;
        let pic_fraction = if particles.affine.is_empty() { self.pic_fraction } else { 1.0 };
        widest(Carry { velocity: particles.velocity, rows, dt: self.dt, pic_fraction });
        let (from, scale) = match self.per_inertia {
            Some(scale) => (&rows.moment, scale),
            None => (&rows.gradient, 1.0),
        };
        widest(CarryAffine { affine: particles.affine, from, scale });
    }
}

/// New affine matrices of a chunk.
struct CarryAffine<'a, const D: usize> {
    affine: &'a mut [Tensor<D>],
    /// Components of the moment, by axis and component.
    from: &'a [[ChunkColumn; D]; D],
    scale: f64,
}

impl<const D: usize> Task for CarryAffine<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { affine, from, scale } = self;
        for (group, affine) in affine.chunks_mut(WIDTH).enumerate() {
            let p = group * WIDTH;
            let entry = |i: usize| &from[i % D][i / D];
            let mut rows = [L::splat(0.0); WIDTH];
            for (i, row) in rows.iter_mut().enumerate().take(D * D) {
                let column = entry(i)[p..].first_chunk().expect("columns end eight numbers beyond the chunk");
                *row = L::load(column).mul(L::splat(scale));
            }
            for (k, (c, row)) in affine.iter_mut().zip(L::transpose(rows)).enumerate() {
                let mut numbers = [0.0; WIDTH];
                row.store(&mut numbers);
                let c = c.0.as_flattened_mut();
                let common = c.len().min(WIDTH);
                c[..common].copy_from_slice(&numbers[..common]);
                if D == 3 {
                    c[D * D - 1] = entry(D * D - 1)[p + k] * scale;
                }
            }
        }
    }
}

/// New velocities of a chunk.
struct Carry<'a, const D: usize> {
    velocity: &'a mut [Vector<D>],
    rows: &'a Rows<D>,
    dt: f64,
    pic_fraction: f64,
}

impl<const D: usize> Task for Carry<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { velocity, rows, dt, pic_fraction } = self;
        let n = velocity.len().min(CHUNK_LEN);
        if pic_fraction == 1.0 {
            // Nothing of the old velocity remains; accelerations may not have been gathered.
            for (p, v) in velocity[..n].iter_mut().enumerate() {
                *v = rows.velocity(p);
            }
            return;
        }
        for (p, v) in velocity[..n].iter_mut().enumerate() {
            for a in 0..D {
                // Lian (65), drawn to the grid's velocity by the fraction β.
                v[a] =
                    (v[a] + rows.acceleration[a][p] * dt) * (1.0 - pic_fraction) + rows.velocity[a][p] * pic_fraction;
            }
        }
    }
}

/// Sets a column of vectors to what was gathered as velocity.
pub(in crate::mpm) fn keep_velocity<const D: usize>(column: &mut [Vector<D>], rows: &Rows<D>) {
    column.iter_mut().enumerate().for_each(|(p, v)| *v = rows.velocity(p));
}
