//! Grid to particles: velocity, acceleration, Lian (65, 19), velocity gradient, Lian (62, 63), affine moment (APIC).
//! The same sums one particle at a time: `executor::plain`.

use super::Sweep;
use super::column::{CHUNK_LEN, put};
use super::frame::TileFrame;
use super::gather_kernel::{self, GatherSums, Gathered};
use super::place::Places;
use super::rows::Rows;
use super::view::View;
use crate::math::simd::{Lanes, Task, widest};
use crate::mpm::bins::Bin;
use crate::mpm::grid::tile::{Extent, NodeRecord, TILE_NODES, Tile, for_each_run};
use crate::mpm::kernel::{Kernel, ShapeFunction, with_shape};
use crate::mpm::particles::Reduce;

/// Few enough bins for one thread.
const FEW_BINS: usize = 16;

/// A few consecutive particles, and the sums over the nodes around them.
pub(crate) struct Chunk<'a, const D: usize> {
    /// Columns of the particles of the chunk.
    pub particles: View<'a, D>,
    /// The sums that were gathered.
    pub rows: &'a mut Rows<D>,
    /// Number of times nodes were read: once per run of particles, up to eight, with the same nodes.
    pub visits: usize,
}

/// The sums that a gather forms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GatherFields {
    /// Scalar.
    Scalar,
    /// Velocity and acceleration.
    Motion,
    /// Scalar, velocity and its gradient.
    Gradient,
    /// Velocity, acceleration, and the velocity gradient.
    MotionAndGradient,
    /// Velocity and its affine moment.
    Moment,
    /// Velocity, its gradient and its affine moment.
    GradientAndMoment,
}

impl GatherFields {
    /// True if accelerations are among them.
    pub fn has_acceleration(self) -> bool {
        matches!(self, Self::Motion | Self::MotionAndGradient)
    }
}

/// Makes the types of [`GatherSums`].
macro_rules! sums {
    ($($Name:ident: $from:expr, $to:expr, $slopes:expr;)+) => {
        $(
            #[derive(Clone, Copy)]
            struct $Name;
            impl GatherSums for $Name {
                const FROM: usize = $from;
                const TO: fn(usize) -> usize = $to;
                const SLOPES: [bool; 2] = $slopes;
            }
        )+
    };
}
sums! {
    ScalarSums: 0, |_| 1, [false, false];
    MotionSums: 1, |d| 1 + 2 * d, [false, false];
    GradientSums: 0, |d| 1 + d, [true, false];
    MotionAndGradientSums: 1, |d| 1 + 2 * d, [true, false];
    MomentSums: 1, |d| 1 + d, [false, true];
    GradientAndMomentSums: 1, |d| 1 + d, [true, true];
}

/// Fills the tile of a block, given its slots and extent: called once per block, so that the visits are compiled once
/// for all that they may read.
pub(crate) type FillTile<'a> = &'a (dyn Fn(&[u32], &Extent, &mut Tile) + Sync);

/// Copies the nodes of a block to its tile; `node` sets what is read of each.
pub(crate) fn fill_tile<const D: usize>(
    slots: &[u32],
    extent: &Extent,
    tile: &mut Tile,
    node: &impl Fn(usize, &mut NodeRecord),
) {
    for_each_run::<D>(slots, extent, |first, t, count| {
        for (i, record) in tile[t..t + count].iter_mut().enumerate() {
            node(first + i, record);
        }
    });
}

impl<const D: usize> Sweep<'_, D> {
    /// Visits all particles, a chunk at a time, with nodal values interpolated to them, Σ N_Ip q_I, Lian (19, 65).
    /// `node` sets what is read of a node's record: a scalar, the velocity, the acceleration.
    pub fn gather<A: Reduce>(
        &self,
        node: impl Fn(usize, &mut NodeRecord) + Sync,
        particles: View<'_, D>,
        fields: GatherFields,
        visit: impl Fn(&mut Chunk<'_, D>) -> A + Sync,
    ) -> A {
        let fill = |slots: &[u32], extent: &Extent, tile: &mut Tile| fill_tile::<D>(slots, extent, tile, &node);
        self.gather_filled(&fill, particles, fields, &visit)
    }

    fn gather_filled<A: Reduce>(
        &self,
        fill: FillTile<'_>,
        particles: View<'_, D>,
        fields: GatherFields,
        visit: &(dyn Fn(&mut Chunk<'_, D>) -> A + Sync),
    ) -> A {
        let all = BinRun { bins: &self.bins.bins, slots: &self.bins.slots, extents: &self.bins.extents };
        split(all, particles, &|part: BinRun<'_, D>, particles: View<'_, D>| {
            let mut reader = NodeReader::default();
            let mut sum = A::default();
            let (bins, mut rest) = (part.bins.iter().zip(part.slots).zip(part.extents), particles);
            for ((bin, slots), extent) in bins {
                let (mine, others) = rest.split_at(bin.range.len());
                rest = others;
                fill(slots, extent, &mut reader.tile);
                let frame = TileFrame::new(self, bin.block);
                sum = sum.plus(reader.read(self.kernel, frame, mine, fields, |chunk, _| visit(chunk)));
            }
            sum
        })
    }
}

/// The memory in which a thread reads nodes at particles.
pub(crate) struct NodeReader<const D: usize> {
    /// The nodes of a block.
    pub tile: Box<Tile>,
    places: Box<Places<D>>,
    rows: Box<Rows<D>>,
}

impl<const D: usize> Default for NodeReader<D> {
    fn default() -> Self {
        Self { tile: Box::new([NodeRecord::default(); TILE_NODES]), places: Box::default(), rows: Box::default() }
    }
}

impl<const D: usize> NodeReader<D> {
    /// Visits the particles of a block, a chunk at a time.
    pub fn read<A: Reduce>(
        &mut self,
        kernel: Kernel,
        frame: TileFrame<D>,
        mut particles: View<'_, D>,
        fields: GatherFields,
        mut visit: impl FnMut(&mut Chunk<'_, D>, &Places<D>) -> A,
    ) -> A {
        let Self { tile, places, rows } = self;
        let mut sum = A::default();
        while particles.len() > 0 {
            let len = CHUNK_LEN.min(particles.len());
            let (chunk, rest) = particles.split_at(len);
            particles = rest;
            places.locate(kernel, frame, chunk.position);
            let visits = gather_chunk(kernel, tile, places, frame.scale, fields, rows);
            sum = sum.plus(visit(&mut Chunk { particles: chunk, rows, visits }, places));
        }
        sum
    }
}

/// Gathers for the particles of a chunk from a tile; returns how many times nodes were read.
fn gather_chunk<const D: usize>(
    kernel: Kernel,
    tile: &Tile,
    places: &Places<D>,
    per_cell: f64,
    fields: GatherFields,
    rows: &mut Rows<D>,
) -> usize {
    with_shape!(kernel, shape => widest(ChunkGather { tile, shape, places, per_cell, fields, rows }))
}

/// Consecutive bins.
#[derive(Clone, Copy)]
struct BinRun<'a, const D: usize> {
    bins: &'a [Bin<D>],
    slots: &'a [Vec<u32>],
    extents: &'a [Extent],
}

impl<const D: usize> BinRun<'_, D> {
    fn split_at(&self, n: usize) -> (Self, Self) {
        let (bins, slots, extents) = (self.bins.split_at(n), self.slots.split_at(n), self.extents.split_at(n));
        (
            BinRun { bins: bins.0, slots: slots.0, extents: extents.0 },
            BinRun { bins: bins.1, slots: slots.1, extents: extents.1 },
        )
    }
}

/// Hands halves of the bins to other threads until few are left; the tree depends on the number of bins only.
fn split<const D: usize, A: Reduce>(
    part: BinRun<'_, D>,
    particles: View<'_, D>,
    work: &(impl Fn(BinRun<'_, D>, View<'_, D>) -> A + Sync),
) -> A {
    if part.bins.len() <= FEW_BINS {
        return work(part, particles);
    }
    let (first, second) = part.split_at(part.bins.len() / 2);
    let (left, right) = particles.split_at(second.bins[0].range.start - first.bins[0].range.start);
    let (a, b) = rayon::join(|| split(first, left, work), || split(second, right, work));
    a.plus(b)
}

struct ChunkGather<'a, S, const W: usize, const D: usize> {
    tile: &'a Tile,
    shape: S,
    places: &'a Places<D>,
    /// 1/h [1/m].
    per_cell: f64,
    fields: GatherFields,
    rows: &'a mut Rows<D>,
}

impl<S: ShapeFunction<W>, const W: usize, const D: usize> Task for ChunkGather<'_, S, W, D> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self) -> usize {
        match self.fields {
            GatherFields::Scalar => self.sums::<L, ScalarSums>(),
            GatherFields::Motion => self.sums::<L, MotionSums>(),
            GatherFields::Gradient => self.sums::<L, GradientSums>(),
            GatherFields::MotionAndGradient => self.sums::<L, MotionAndGradientSums>(),
            GatherFields::Moment => self.sums::<L, MomentSums>(),
            GatherFields::GradientAndMoment => self.sums::<L, GradientAndMomentSums>(),
        }
    }
}

impl<S: ShapeFunction<W>, const W: usize, const D: usize> ChunkGather<'_, S, W, D> {
    /// Takes runs of particles with the same support, eight at a time: what is stored beyond a run is wrong, and is
    /// replaced by the next.
    #[inline(always)]
    fn sums<L: Lanes, Q: GatherSums>(self) -> usize {
        let (mut p, mut visits) = (0, 0);
        while p < self.places.len() {
            let (weights, _) = self.places.weights::<L, S, W>(self.shape, p);
            let sums = gather_kernel::gather::<L, Q, W, D>(self.tile, self.places.first(p), &weights);
            put_rows::<L, Q, D>(&sums, self.per_cell, p, self.rows);
            p += self.places.run(p);
            visits += 1;
        }
        visits
    }
}

/// Stores the sums of eight particles.
#[inline(always)]
fn put_rows<L: Lanes, Q: GatherSums, const D: usize>(
    sums: &Gathered<L, D>,
    per_cell: f64,
    p: usize,
    rows: &mut Rows<D>,
) {
    for lane in Q::FROM..(Q::TO)(D) {
        let column = match lane {
            0 => &mut rows.scalar,
            _ if lane <= D => &mut rows.velocity[lane - 1],
            _ => &mut rows.acceleration[lane - 1 - D],
        };
        put(sums.value[lane], p, column);
    }
    for a in 0..D {
        for axis in 0..D {
            if Q::SLOPES[0] {
                // L, whose symmetric and skew parts are the rates of Lian (62, 63).
                put(sums.slopes[0][axis][a].mul(L::splat(per_cell)), p, &mut rows.gradient[axis][a]);
            }
            if Q::SLOPES[1] {
                put(sums.slopes[1][axis][a].mul(L::splat(1.0 / per_cell)), p, &mut rows.moment[axis][a]);
            }
        }
    }
}
