//! Grid to particles: velocity, acceleration (65, 19), velocity gradient (62, 63), affine moment (APIC).

use super::bins::Bin;
use super::dispatch::{Task, widest};
use super::kernel::{self, numbers};
use super::lanes::{Lanes, Record};
use super::scatter::Frame;
use super::shape::{Cubic, Gimp, Linear, Quadratic, Shape};
use super::tile::{Extent, TILE_NODES, Tile, for_each_run};
use super::view::View;
use super::{Kernel, Sweep, with_shape};
use crate::math::{Tensor, Vector};

/// Particles per call of a visitor: their gathered values stay in the first-level cache.
pub(crate) const CHUNK: usize = 128;

/// Few enough bins for one thread.
const FEW: usize = 16;

/// What the grid says at a few consecutive particles.
pub(crate) struct Chunk<'a, const D: usize> {
    /// Their columns.
    pub particles: View<'a, D>,
    /// Σ N s of the scalar slot.
    pub scalar: &'a [f64],
    /// Σ N v [m/s].
    pub velocity: &'a [Vector<D>],
    /// Σ N a [m/s²]; not meaningful when the moment is gathered.
    pub acceleration: &'a [Vector<D>],
    /// Σ v ⊗ ∇N [1/s], embedded in three dimensions; meaningful when it is gathered.
    pub gradient: &'a mut [Tensor<3>],
    /// Σ N v ⊗ (x_I − x_p) [m²/s]; meaningful when it is gathered.
    pub moment: &'a [Tensor<D>],
}

/// What a gather computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// Scalar, velocity and acceleration only.
    Motion,
    /// Scalar, velocity and acceleration, and the velocity gradient.
    MotionAndGradient,
    /// Scalar, velocity, its gradient and its affine moment.
    MotionAndMoment,
}

/// An answer of visitors that can be combined; combined in a fixed order.
pub(crate) trait Answer: Send + Default {
    /// Both.
    fn and(self, other: Self) -> Self;
}

impl Answer for () {
    fn and(self, (): ()) {}
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
        let cell = self.cell;
        // Behind a pointer, so that visitors are not compiled once more for every shape function.
        let gather: &ChunkFn<'_, D> = with_shape!(self, shape => {
            &move |tile, frame, positions, buffer| widest(ChunkGather { tile, shape, frame, positions, wanted, cell, buffer })
        });
        let work = GatherPart { sweep: self, node: &node, gather, wanted };
        split(all, particles, &|part: Part<'_, D>, particles: View<'_, D>| work.run(part, particles, &visit))
    }
}

/// Gathers for the particles of a chunk from a tile.
type ChunkFn<'a, const D: usize> = dyn Fn(&Tile, Frame<D>, &[Vector<D>], &mut Buffer<D>) + Sync + 'a;

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
    wanted: Wanted,
}

impl<N: Fn(usize) -> Record + Sync, const D: usize> GatherPart<'_, N, D> {
    fn run<A: Answer>(
        &self,
        Part { bins, slots, extents }: Part<'_, D>,
        mut particles: View<'_, D>,
        visit: &(impl Fn(&mut Chunk<'_, D>) -> A + Sync),
    ) -> A {
        let mut tile = Box::new([Record::default(); TILE_NODES]);
        let mut buffer = Box::new(Buffer::default());
        let mut answer = A::default();
        for ((bin, slots), extent) in bins.iter().zip(slots).zip(extents) {
            for_each_run::<D>(slots, extent, |node, t, count| {
                for (i, record) in tile[t..t + count].iter_mut().enumerate() {
                    *record = prepare::<D>((self.node)(node + i), self.wanted);
                }
            });
            let frame = Frame::new(self.sweep, bin.block);
            let mut left = bin.range.len();
            while left > 0 {
                let len = CHUNK.min(left);
                let (chunk, rest) = particles.split_at(len);
                (particles, left) = (rest, left - len);
                (self.gather)(&tile, frame, chunk.position, &mut buffer);
                answer = answer.and(visit(&mut buffer.chunk(chunk)));
            }
        }
        answer
    }
}

/// A node's record for a gather: the affine moment needs a second copy of the velocity.
#[inline(always)]
fn prepare<const D: usize>(record: Record, wanted: Wanted) -> Record {
    match wanted {
        Wanted::Motion | Wanted::MotionAndGradient => record,
        Wanted::MotionAndMoment => {
            let mut r = record.0;
            r.copy_within(1..=D, 1 + D);
            Record(r)
        }
    }
}

/// What is gathered for the particles of a chunk.
struct Buffer<const D: usize> {
    scalar: [f64; CHUNK],
    velocity: [Vector<D>; CHUNK],
    acceleration: [Vector<D>; CHUNK],
    gradient: [Tensor<3>; CHUNK],
    moment: [Tensor<D>; CHUNK],
}

impl<const D: usize> Default for Buffer<D> {
    fn default() -> Self {
        Self {
            scalar: [0.0; CHUNK],
            velocity: [Vector::ZERO; CHUNK],
            acceleration: [Vector::ZERO; CHUNK],
            gradient: [Tensor::ZERO; CHUNK],
            moment: [Tensor::ZERO; CHUNK],
        }
    }
}

impl<const D: usize> Buffer<D> {
    fn chunk<'a>(&'a mut self, particles: View<'a, D>) -> Chunk<'a, D> {
        let len = particles.len();
        Chunk {
            particles,
            scalar: &self.scalar[..len],
            velocity: &self.velocity[..len],
            acceleration: &self.acceleration[..len],
            gradient: &mut self.gradient[..len],
            moment: &self.moment[..len],
        }
    }
}

struct ChunkGather<'a, S, const W: usize, const D: usize> {
    tile: &'a Tile,
    shape: S,
    frame: Frame<D>,
    positions: &'a [Vector<D>],
    wanted: Wanted,
    cell: f64,
    buffer: &'a mut Buffer<D>,
}

impl<S: Shape<W>, const W: usize, const D: usize> Task for ChunkGather<'_, S, W, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        match self.wanted {
            Wanted::Motion => self.motion::<L>(),
            Wanted::MotionAndGradient => self.slopes::<L, false>(),
            Wanted::MotionAndMoment => self.slopes::<L, true>(),
        }
    }
}

impl<S: Shape<W>, const W: usize, const D: usize> ChunkGather<'_, S, W, D> {
    #[inline(always)]
    fn motion<L: Lanes>(self) {
        for (p, &x) in self.positions.iter().enumerate() {
            let w = self.shape.weights(self.frame.coordinates(x));
            let r = numbers(kernel::gather_value::<L, W, D>(self.tile, &w));
            self.buffer.put(p, &r);
        }
    }

    #[inline(always)]
    fn slopes<L: Lanes, const AFFINE: bool>(self) {
        let per_cell = 1.0 / self.cell;
        for (p, &x) in self.positions.iter().enumerate() {
            let w = self.shape.weights(self.frame.coordinates(x));
            let (value, slopes) = kernel::gather::<L, W, D, AFFINE>(self.tile, &w);
            self.buffer.put(p, &numbers(value));
            for (axis, slope) in slopes.into_iter().enumerate() {
                let g = numbers(slope);
                for a in 0..D {
                    self.buffer.gradient[p][a][axis] = g[1 + a] * per_cell;
                    if AFFINE {
                        self.buffer.moment[p][a][axis] = g[1 + D + a] * self.cell;
                    }
                }
            }
        }
    }
}

impl<const D: usize> Buffer<D> {
    #[inline(always)]
    fn put(&mut self, p: usize, r: &[f64; 8]) {
        self.scalar[p] = r[0];
        for a in 0..D {
            self.velocity[p][a] = r[1 + a];
            self.acceleration[p][a] = r[1 + D + a];
        }
    }
}
