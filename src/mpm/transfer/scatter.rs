//! Particles to grid: mass and momentum, Lian (60, 61), internal and body force, Lian (17, 18), sums of scalars.
//! The same sums one particle at a time: `executor::plain`.

use super::Sweep;
use super::column::CHUNK_LEN;
use super::frame::TileFrame;
use super::group::LaneGroup;
use super::place::Places;
use super::scatter_kernel::{self, Alone, Packing, Paired, ScatterKernel, Slope};
use super::source::{ScatterContent, ScatterSource};
use crate::math::Vector;
use crate::math::simd::{Lanes, Row, Task, WIDTH, widest};
use crate::mpm::grid::Node;
use crate::mpm::grid::tile::{Extent, NodeRecord, ScalarTile, TILE_NODES, Tile, for_each_run};
use crate::mpm::kernel::{Kernel, ShapeFunction, with_shape};
use crate::mpm::particles::Body;
use rayon::prelude::*;

/// A quantity of every node to which particles scatter, and the tile that collects it.
pub(crate) trait Target<const D: usize>: Copy + Send + Sync {
    /// The tile's memory: sums of the quantity at its nodes.
    type Sums: Send;

    /// An empty tile.
    fn tile() -> Box<Self::Sums>;

    /// Adds the particles of a chunk to a tile; `per_cell` is 1/h [1/m].
    fn collect(
        tile: &mut Self::Sums,
        kernel: Kernel,
        frame: TileFrame<D>,
        places: &Places<D>,
        source: &ScatterSource<'_, D>,
    );

    /// Adds what a tile has collected from node `t` on to consecutive nodes, and clears it there.
    fn add(nodes: &mut [Self], tile: &mut Self::Sums, t: usize, content: ScatterContent);
}

/// Mass, momentum, force.
impl<const D: usize> Target<D> for Node<D> {
    type Sums = Tile;

    fn tile() -> Box<Tile> {
        Box::new([NodeRecord::default(); TILE_NODES])
    }

    fn collect(
        tile: &mut Tile,
        kernel: Kernel,
        frame: TileFrame<D>,
        places: &Places<D>,
        source: &ScatterSource<'_, D>,
    ) {
        with_shape!(kernel, shape => widest(ScatterRecords { tile, shape, frame, places, source }));
    }

    fn add(nodes: &mut [Self], tile: &mut Tile, t: usize, content: ScatterContent) {
        for (node, record) in nodes.iter_mut().zip(&mut tile[t..]) {
            let Row(r) = std::mem::take(record);
            let both = |lane: usize| r[lane] + r[lane + WIDTH / 2];
            match content {
                ScatterContent::Momentum => {
                    node.mass += both(0); // Lian (60)
                    node.momentum += Vector::from_fn(|a| both(1 + a)); // Lian (61)
                }
                ScatterContent::Force => node.force += Vector::from_fn(|a| both(1 + a)), // Lian (17, 18)
                _ => {
                    node.mass += r[0]; // Lian (60)
                    node.momentum += Vector::from_fn(|a| r[1 + a]); // Lian (61)
                    node.force += Vector::from_fn(|a| r[1 + D + a]); // Lian (17)
                }
            }
        }
    }
}

/// Momentum only.
impl<const D: usize> Target<D> for Vector<D> {
    type Sums = Tile;

    fn tile() -> Box<Tile> {
        Node::<D>::tile()
    }

    fn collect(
        tile: &mut Tile,
        kernel: Kernel,
        frame: TileFrame<D>,
        places: &Places<D>,
        source: &ScatterSource<'_, D>,
    ) {
        Node::<D>::collect(tile, kernel, frame, places, source);
    }

    fn add(nodes: &mut [Self], tile: &mut Tile, t: usize, _content: ScatterContent) {
        for (node, record) in nodes.iter_mut().zip(&mut tile[t..]) {
            let Row(r) = std::mem::take(record);
            *node += Self::from_fn(|a| r[1 + a] + r[1 + a + WIDTH / 2]);
        }
    }
}

/// Two scalars.
impl<const D: usize> Target<D> for [f64; 2] {
    type Sums = ScalarTile;

    fn tile() -> Box<ScalarTile> {
        Box::new([[0.0; 2]; TILE_NODES + 4])
    }

    fn collect(
        tile: &mut ScalarTile,
        kernel: Kernel,
        _: TileFrame<D>,
        places: &Places<D>,
        source: &ScatterSource<'_, D>,
    ) {
        with_shape!(kernel, shape => widest(ScatterScalars { tile, shape, places, source }));
    }

    fn add(nodes: &mut [Self], tile: &mut ScalarTile, t: usize, _content: ScatterContent) {
        for (node, sums) in nodes.iter_mut().zip(&mut tile[t..]) {
            let sums = std::mem::take(sums);
            node[0] += sums[0];
            node[1] += sums[1];
        }
    }
}

impl<const D: usize> Sweep<'_, D> {
    /// Adds the particles' contributions to `nodes`. Returns the part of each tile that was reached.
    pub fn scatter<T: Target<D>>(&self, nodes: &mut [T], body: &Body<D>, content: ScatterContent) -> Vec<Extent> {
        let source = ScatterSource::of_body(body, content);
        if content == ScatterContent::MomentumAndForce && !source.is_simple() {
            // The lanes of a record are too few for the slopes of both.
            self.scatter(nodes, body, ScatterContent::Momentum);
            return self.scatter(nodes, body, ScatterContent::Force);
        }
        let nodes = SharedNodes::new(nodes);
        let mut extents = vec![Extent::EMPTY; self.bins.bins.len()];
        for colour in &self.bins.colours {
            let scratch = || (T::tile(), Box::<Places<D>>::default());
            let reached = colour.par_iter().with_min_len(4).map_init(scratch, |(tile, places), &b| {
                let bin = &self.bins.bins[b];
                let frame = TileFrame::new(self, bin.block);
                let mut extent = Extent::EMPTY;
                for start in bin.range.clone().step_by(CHUNK_LEN) {
                    let chunk = source.range(start..bin.range.end.min(start + CHUNK_LEN));
                    extent = extent.union(&places.locate(self.kernel, frame, chunk.position));
                    T::collect(tile, self.kernel, frame, places, &chunk);
                }
                nodes.add(&self.bins.slots[b], &extent, tile, content);
                extent
            });
            let reached: Vec<Extent> = reached.collect();
            for (&b, extent) in colour.iter().zip(reached) {
                extents[b] = extent;
            }
        }
        extents
    }
}

/// Scatters the particles of a chunk into a tile of records.
struct ScatterRecords<'a, 'b, S, const W: usize, const D: usize> {
    tile: &'a mut Tile,
    shape: S,
    frame: TileFrame<D>,
    places: &'a Places<D>,
    source: &'a ScatterSource<'b, D>,
}

impl<S: ShapeFunction<W>, const W: usize, const D: usize> Task for ScatterRecords<'_, '_, S, W, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        match self.source.content {
            ScatterContent::MomentumAndForce => self.whole::<L>(),
            _ if self.source.is_simple() => self.products::<L>(),
            _ => self.slopes::<L>(),
        }
    }
}

impl<S: ShapeFunction<W>, const W: usize, const D: usize> ScatterRecords<'_, '_, S, W, D> {
    /// The slope weights that the source takes.
    #[inline(always)]
    fn slope(&self) -> Slope {
        match self.source.pushes() {
            true => Slope::Gradient,
            false if self.source.is_affine() => Slope::Moment,
            false => Slope::Value,
        }
    }

    /// One particle at a time, mass, momentum and the force of a pressure at once.
    #[inline(always)]
    fn whole<L: Lanes>(self) {
        let (mut kernel, slope) = (ScatterKernel::<W>::default(), self.slope());
        let mut p = 0;
        while p < self.places.len() {
            let count = self.places.run(p);
            let (weights, _) = self.places.weights::<L, S, W>(self.shape, p);
            kernel.weigh(&weights, slope);
            let values = L::transpose(self.source.whole(LaneGroup::new(p, count), self.frame.scale));
            kernel.pack_products::<L, Alone, D>(&values[..count.min(WIDTH)]);
            kernel.add_products::<L, D>(self.tile, self.places.first(p), count);
            p += count;
        }
    }

    /// Two particles at a time, products.
    #[inline(always)]
    fn products<L: Lanes>(self) {
        let (mut kernel, slope, zero) = (ScatterKernel::<W>::default(), self.slope(), [L::splat(0.0); 4]);
        let mut p = 0;
        while p < self.places.len() {
            let count = self.places.run(p);
            let (weights, _) = self.places.weights::<L, S, W>(self.shape, p);
            kernel.weigh(&weights, slope);
            let [values, _] = pairs(self.source.product(LaneGroup::new(p, count), self.frame.scale), zero, count);
            let pairs = count.div_ceil(Paired::PARTICLES);
            kernel.pack_products::<L, Paired, D>(&values[..pairs]);
            kernel.add_products::<L, D>(self.tile, self.places.first(p), pairs);
            p += count;
        }
    }

    /// Two particles at a time, values and slopes.
    #[inline(always)]
    fn slopes<L: Lanes>(self) {
        let (mut kernel, slope) = (ScatterKernel::<W>::default(), self.slope());
        let mut p = 0;
        while p < self.places.len() {
            let count = self.places.run(p);
            let (mut weights, base) = self.places.weights::<L, S, W>(self.shape, p);
            if self.source.is_affine() {
                self.frame.fold_moments(&mut weights, &base);
            }
            kernel.weigh(&weights, slope);
            let (value, by) = self.source.sloped::<L>(LaneGroup::new(p, count), self.frame.scale);
            let mut slopes = [[L::splat(0.0); WIDTH / 2]; D];
            let [values, along_x] = pairs(value, by[0], count);
            slopes[0] = along_x;
            [slopes[1], slopes[D - 1]] = pairs(by[1], by[D - 1], count);
            let pairs = count.div_ceil(Paired::PARTICLES);
            kernel.pack_slopes::<L, D>(&values[..pairs], &slopes);
            kernel.add_slopes::<L, D>(self.tile, self.places.first(p), pairs);
            p += count;
        }
    }
}

/// Turns two times four numbers of eight particles into pairs of particles, four lanes each; zero beyond the first
/// `count`.
#[inline(always)]
fn pairs<L: Lanes>(a: [L; 4], b: [L; 4], count: usize) -> [[L; WIDTH / 2]; 2] {
    let zero = L::splat(0.0);
    let particles = L::transpose([a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]]);
    let mut pairs = [[zero; WIDTH / 2]; 2];
    for k in 0..WIDTH / 2 {
        let second = if 2 * k + 1 < count { particles[2 * k + 1] } else { zero };
        [pairs[0][k], pairs[1][k]] = particles[2 * k].halves(second);
    }
    pairs
}

/// Scatters the particles of a chunk into a tile of scalars.
struct ScatterScalars<'a, 'b, S, const W: usize, const D: usize> {
    tile: &'a mut ScalarTile,
    shape: S,
    places: &'a Places<D>,
    source: &'a ScatterSource<'b, D>,
}

impl<S: ShapeFunction<W>, const W: usize, const D: usize> Task for ScatterScalars<'_, '_, S, W, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut p = 0;
        while p < self.places.len() {
            let count = self.places.run(p);
            let (weights, _) = self.places.weights::<L, S, W>(self.shape, p);
            let scalars = self.source.scalars::<L>(LaneGroup::new(p, count));
            scatter_kernel::add_scalars::<L, W, D>(self.tile, &weights, self.places.first(p), scalars, count);
            p += count;
        }
    }
}

/// Nodes that the blocks of one colour may write at the same time.
pub(crate) struct SharedNodes<'a, T> {
    first: *mut T,
    len: usize,
    lifetime: std::marker::PhantomData<&'a mut [T]>,
}

// SAFETY: only `add` reaches the nodes, and blocks that run at the same time have disjoint tiles (`colour`).
#[allow(unsafe_code)]
unsafe impl<T: Send> Sync for SharedNodes<'_, T> {}

impl<'a, T> SharedNodes<'a, T> {
    pub fn new(nodes: &'a mut [T]) -> Self {
        Self { first: nodes.as_mut_ptr(), len: nodes.len(), lifetime: std::marker::PhantomData }
    }

    /// Adds the part `extent` of a block's tile and clears it.
    #[allow(unsafe_code)]
    pub fn add<const D: usize>(&self, slots: &[u32], extent: &Extent, tile: &mut T::Sums, content: ScatterContent)
    where
        T: Target<D>,
    {
        for_each_run::<D>(slots, extent, |first, t, count| {
            assert!(first + count <= self.len);
            // SAFETY: in bounds, and no other block of this colour reaches these nodes.
            let nodes = unsafe { std::slice::from_raw_parts_mut(self.first.add(first), count) };
            T::add(nodes, tile, t, content);
        });
    }
}
