//! Grid to particles: velocity, acceleration (65, 19), velocity gradient (62, 63), affine moment (APIC).

use super::bins::Bin;
use super::frame::{self, Frame};
use super::group::Group;
use super::kernel::{self, Gathered, Sums};
use super::rows::{CHUNK, Column, Rows};
use super::shape::{Cubic, Gimp, Linear, Quadratic, Shape};
use super::tile::{Extent, Record, TILE_NODES, Tile, for_each_run};
use super::view::View;
use super::{Kernel, Sweep, with_shape};
use crate::math::Vector;
use crate::math::simd::{Lanes, Task, WIDTH, widest};

/// Few enough bins for one thread.
const FEW: usize = 16;

/// A few consecutive particles, and what the grid says there.
pub(crate) struct Chunk<'a, const D: usize> {
    /// Their columns.
    pub particles: View<'a, D>,
    /// What was gathered.
    pub rows: &'a mut Rows<D>,
    /// How many times nodes were read: once per run of particles, up to eight, with the same nodes.
    pub visits: usize,
}

/// What a gather computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// Scalar and velocity.
    Scalar,
    /// Velocity and acceleration.
    Motion,
    /// Scalar, velocity and its gradient.
    Gradient,
    /// Velocity, acceleration, and the velocity gradient.
    MotionAndGradient,
    /// Velocity, its gradient and its affine moment.
    MotionAndMoment,
}

/// Makes the types of [`Sums`].
macro_rules! sums {
    ($($Name:ident: $scalar:literal, $acceleration:literal, $slopes:literal;)+) => {
        $(
            #[derive(Clone, Copy)]
            struct $Name;
            impl Sums for $Name {
                const SCALAR: bool = $scalar;
                const ACCELERATION: bool = $acceleration;
                const SLOPES: usize = $slopes;
            }
        )+
    };
}
sums! {
    ScalarSums: true, false, 0;
    MotionSums: false, true, 0;
    GradientSums: true, false, 1;
    MotionAndGradientSums: false, true, 1;
    MotionAndMomentSums: false, false, 2;
}

/// An answer of visitors that can be combined; combined in a fixed order.
pub(crate) trait Answer: Send + Default {
    /// Both.
    fn and(self, other: Self) -> Self;
}

impl Answer for () {
    fn and(self, (): ()) {}
}

/// A sum.
impl Answer for f64 {
    fn and(self, other: Self) -> Self {
        self + other
    }
}

impl<const D: usize> Sweep<'_, D> {
    /// Visits all particles, a chunk at a time, with what the nodes say there. `node` gives a node's record:
    /// a scalar, the velocity, the acceleration (see [`super::tile::record`]).
    pub fn gather<A: Answer>(
        &self,
        node: impl Fn(usize) -> Record + Sync,
        particles: View<'_, D>,
        wanted: Wanted,
        visit: impl Fn(&mut Chunk<'_, D>) -> A + Sync,
    ) -> A {
        let all = Part { bins: &self.bins.bins, slots: &self.bins.slots, extents: &self.bins.extents };
        // Behind a pointer, so that visitors are not compiled once more for every shape function.
        let gather: &ChunkFn<'_, D> = with_shape!(self, shape => {
            &move |tile, frame, positions, rows| widest(ChunkGather { tile, shape, frame, positions, wanted, rows })
        });
        let work = GatherPart { sweep: self, node: &node, gather };
        split(all, particles, &|part: Part<'_, D>, particles: View<'_, D>| work.run(part, particles, &visit))
    }
}

/// Gathers for the particles of a chunk from a tile; returns how many times nodes were read.
type ChunkFn<'a, const D: usize> = dyn Fn(&Tile, Frame<D>, &[Vector<D>], &mut Rows<D>) -> usize + Sync + 'a;

/// Consecutive bins.
#[derive(Clone, Copy)]
struct Part<'a, const D: usize> {
    bins: &'a [Bin<D>],
    slots: &'a [Vec<u32>],
    extents: &'a [Extent],
}

impl<const D: usize> Part<'_, D> {
    fn split_at(&self, n: usize) -> (Self, Self) {
        let (bins, slots, extents) = (self.bins.split_at(n), self.slots.split_at(n), self.extents.split_at(n));
        (
            Part { bins: bins.0, slots: slots.0, extents: extents.0 },
            Part { bins: bins.1, slots: slots.1, extents: extents.1 },
        )
    }
}

/// Hands halves of the bins to other threads until few are left; the tree depends on the number of bins only.
fn split<const D: usize, A: Answer>(
    part: Part<'_, D>,
    particles: View<'_, D>,
    work: &(impl Fn(Part<'_, D>, View<'_, D>) -> A + Sync),
) -> A {
    if part.bins.len() <= FEW {
        return work(part, particles);
    }
    let (first, second) = part.split_at(part.bins.len() / 2);
    let (left, right) = particles.split_at(second.bins[0].range.start - first.bins[0].range.start);
    let (a, b) = rayon::join(|| split(first, left, work), || split(second, right, work));
    a.and(b)
}

/// The work of one thread.
struct GatherPart<'a, N, const D: usize> {
    sweep: &'a Sweep<'a, D>,
    node: &'a N,
    gather: &'a ChunkFn<'a, D>,
}

impl<N: Fn(usize) -> Record + Sync, const D: usize> GatherPart<'_, N, D> {
    fn run<A: Answer>(
        &self,
        Part { bins, slots, extents }: Part<'_, D>,
        mut particles: View<'_, D>,
        visit: &(impl Fn(&mut Chunk<'_, D>) -> A + Sync),
    ) -> A {
        let mut tile = Box::new([Record::default(); TILE_NODES]);
        let mut rows = Box::new(Rows::default());
        let mut answer = A::default();
        for ((bin, slots), extent) in bins.iter().zip(slots).zip(extents) {
            for_each_run::<D>(slots, extent, |node, t, count| {
                for (i, record) in tile[t..t + count].iter_mut().enumerate() {
                    *record = (self.node)(node + i);
                }
            });
            let frame = Frame::new(self.sweep, bin.block);
            let mut left = bin.range.len();
            while left > 0 {
                let len = CHUNK.min(left);
                let (chunk, rest) = particles.split_at(len);
                (particles, left) = (rest, left - len);
                let visits = (self.gather)(&tile, frame, chunk.position, &mut rows);
                answer = answer.and(visit(&mut Chunk { particles: chunk, rows: &mut rows, visits }));
            }
        }
        answer
    }
}

struct ChunkGather<'a, S, const W: usize, const D: usize> {
    tile: &'a Tile,
    shape: S,
    frame: Frame<D>,
    positions: &'a [Vector<D>],
    wanted: Wanted,
    rows: &'a mut Rows<D>,
}

impl<S: Shape<W>, const W: usize, const D: usize> Task for ChunkGather<'_, S, W, D> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self) -> usize {
        match self.wanted {
            Wanted::Scalar => self.sums::<L, ScalarSums>(),
            Wanted::Motion => self.sums::<L, MotionSums>(),
            Wanted::Gradient => self.sums::<L, GradientSums>(),
            Wanted::MotionAndGradient => self.sums::<L, MotionAndGradientSums>(),
            Wanted::MotionAndMoment => self.sums::<L, MotionAndMomentSums>(),
        }
    }
}

/// Tile coordinates of the particles of a chunk, and where their supports begin.
#[repr(C, align(64))]
struct Places<const D: usize> {
    s: [Column; D],
    first: [u32; CHUNK + WIDTH],
}

impl<const D: usize> Places<D> {
    /// How many of the eight particles from `p` on have the same support as the first of them.
    #[inline(always)]
    fn run(&self, p: usize) -> usize {
        let mut same = 0u32;
        for k in 0..WIDTH {
            same |= u32::from(self.first[p + k] == self.first[p]) << k;
        }
        same.trailing_ones() as usize
    }
}

impl<S: Shape<W>, const W: usize, const D: usize> ChunkGather<'_, S, W, D> {
    #[inline(always)]
    fn places<L: Lanes>(&self) -> Places<D> {
        let mut places = Places { s: [[0.0; CHUNK + WIDTH]; D], first: [u32::MAX; CHUNK + WIDTH] };
        let n = self.positions.len();
        for p in (0..n).step_by(WIDTH) {
            let group = Group::new(p, n);
            let s = self.frame.coordinates::<L>(group, self.positions);
            let mut base = s;
            for axis in 0..D {
                base[axis] = frame::base(self.shape, s[axis]);
                put(s[axis], p, &mut places.s[axis]);
            }
            let mut first = [0.0; WIDTH];
            frame::tile_number(&base).store(&mut first);
            for k in 0..group.count() {
                places.first[p + k] = first[k] as u32;
            }
        }
        places
    }

    /// Takes runs of particles with the same support, eight at a time: what is stored beyond a run is wrong, and is
    /// replaced by the next.
    #[inline(always)]
    fn sums<L: Lanes, Q: Sums>(self) -> usize {
        let places = self.places::<L>();
        let (mut p, mut visits) = (0, 0);
        while p < self.positions.len() {
            let mut s = [L::splat(0.0); D];
            for axis in 0..D {
                s[axis] = get(p, &places.s[axis]);
            }
            let mut base = s;
            for axis in 0..D {
                // Of the first particle of the run.
                base[axis] = frame::base(self.shape, L::splat(places.s[axis][p]));
            }
            let weights = frame::weights(self.shape, &s, &base);
            let sums = kernel::gather::<L, Q, W, D>(self.tile, places.first[p] as usize, &weights);
            put_rows::<L, Q, D>(&sums, self.frame.scale, p, self.rows);
            p += places.run(p);
            visits += 1;
        }
        visits
    }
}

/// Eight numbers of a column.
#[inline(always)]
fn get<L: Lanes>(p: usize, column: &Column) -> L {
    L::load(column[p..].first_chunk().expect("columns end eight numbers beyond the chunk"))
}

/// Stores eight numbers of a column.
#[inline(always)]
fn put<L: Lanes>(lanes: L, p: usize, column: &mut Column) {
    lanes.store(column[p..].first_chunk_mut().expect("columns end eight numbers beyond the chunk"));
}

/// Stores the sums of eight particles.
#[inline(always)]
fn put_rows<L: Lanes, Q: Sums, const D: usize>(sums: &Gathered<L, D>, per_cell: f64, p: usize, rows: &mut Rows<D>) {
    if Q::SCALAR {
        put(sums.value[0], p, &mut rows.scalar);
    }
    for a in 0..D {
        put(sums.value[1 + a], p, &mut rows.velocity[a]);
        if Q::ACCELERATION {
            put(sums.value[1 + D + a], p, &mut rows.acceleration[a]);
        }
        for axis in 0..D {
            if Q::SLOPES > 0 {
                put(sums.slopes[0][axis][a].mul(L::splat(per_cell)), p, &mut rows.gradient[axis][a]);
            }
            if Q::SLOPES > 1 {
                put(sums.slopes[1][axis][a].mul(L::splat(1.0 / per_cell)), p, &mut rows.moment[axis][a]);
            }
        }
    }
}
