//! Particles sorted by grid block, so that transfers stream memory and node data stays in the first-level cache.
//!
//! Block b owns the positions [4b + w, 4b + 4 + w) in cells, where w is 0 for the linear kernel and ½ for the others.
//! A particle may leave its block by the kernel's slack before the body must be sorted again. It is sorted sooner when
//! so many particles have left their cells that reading the nodes of each run of particles anew has cost more than a
//! sort.

mod sort;

use crate::math::Vector;
use crate::mpm::Kernel;
use crate::mpm::grid::tile::{Extent, TILE};
use crate::mpm::grid::{EDGE, Grid};
use crate::parallel;
use crate::simulation::Record;
use bytemuck::{Pod, Zeroable};
use sort::{slowest_last, sort};
use std::ops::Range;

/// Consecutive particles of one block.
#[derive(Debug, Clone)]
pub(crate) struct Bin<const D: usize> {
    /// Block coordinates.
    pub block: [i32; D],
    /// Range of the particles of the bin.
    pub range: Range<usize>,
}

/// The blocks of one body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bins<const D: usize> {
    /// Bins in the order of the particles.
    pub bins: Vec<Bin<D>>,
    /// 3ᴰ grid slots around each bin.
    pub slots: Vec<Vec<u32>>,
    /// Part of each bin's tile that its particles reached in the last scatter; positions have not changed since.
    pub extents: Vec<Extent>,
    /// Bin numbers per colour; tiles of one colour are disjoint.
    pub colours: Vec<Vec<usize>>,
    /// The loss of order since the sort.
    pub disorder: Disorder,
}

/// The loss of order of a body since it was sorted.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Disorder {
    /// Largest distance that a particle may have moved along an axis [cells].
    pub drift: f64,
    /// Visits of nodes in the first gather; 0 before it.
    fresh: f64,
    /// Visits beyond those since then.
    excess: f64,
}

impl Record for Disorder {
    type Number = f64;
}

/// Bins per piece of a parallel loop.
const BINS: usize = 64;

/// A sort takes about as long as this many visits of nodes per particle.
const SORT_COST: f64 = 0.7;

impl Disorder {
    /// Notes the visits of nodes of a gather.
    pub fn note(&mut self, visits: usize) {
        if self.fresh == 0.0 {
            self.fresh = visits as f64;
        }
        self.excess += visits as f64 - self.fresh;
    }
}

impl<const D: usize> Bins<D> {
    /// The bins of particles at `position` [m] by block and cell, and the old numbers of the particles in their order.
    pub fn sort(position: &[Vector<D>], kernel: Kernel, origin: Vector<D>, cell: f64) -> (Self, Vec<u32>) {
        let sorted = sort(kernel, position, origin, cell);
        let mut end = 0;
        let bin = |(block, count)| {
            end += count;
            Bin { block, range: end - count..end }
        };
        (Self::new(sorted.blocks.into_iter().map(bin).collect(), Disorder::default()), sorted.order)
    }

    fn new(bins: Vec<Bin<D>>, disorder: Disorder) -> Self {
        let mut colours = vec![Vec::new(); 1 << D];
        for (b, bin) in bins.iter().enumerate() {
            colours[colour(bin.block)].push(b);
        }
        let extents = vec![Extent::EMPTY; bins.len()];
        Self { bins, slots: Vec::new(), extents, colours, disorder }
    }

    /// Block coordinates, and first particle and one past the last, of each bin: with the disorder all that a
    /// checkpoint keeps.
    pub fn to_columns(&self) -> (Vec<[i32; D]>, Vec<[u32; 2]>) {
        let range = |bin: &Bin<D>| [bin.range.start as u32, bin.range.end as u32];
        (self.bins.iter().map(|bin| bin.block).collect(), self.bins.iter().map(range).collect())
    }

    /// Restores what [`Self::to_columns`] gave.
    pub fn from_columns(blocks: &[[i32; D]], ranges: &[[u32; 2]], disorder: Disorder) -> Self {
        let bin = |(&block, range): (&[i32; D], &[u32; 2])| Bin { block, range: range[0] as usize..range[1] as usize };
        Self::new(blocks.iter().zip(ranges).map(bin).collect(), disorder)
    }

    /// True if the bins follow each other, and each holds particles that a sweep of `kernel` may find there.
    pub fn hold(&self, position: &[Vector<D>], kernel: Kernel, origin: Vector<D>, cell: f64) -> bool {
        let (window, slack) = (kernel.window(), kernel.slack());
        let reach = window - slack..=window + EDGE as f64 + slack;
        let near = |block: [i32; D], x: &Vector<D>| {
            (0..D).all(|a| reach.contains(&((x[a] - origin[a]) / cell - f64::from(block[a]) * EDGE as f64)))
        };
        let mut end = 0;
        self.bins.iter().all(|Bin { block, range }| {
            let follows = range.start == end;
            end = range.end;
            follows && position.get(range.clone()).is_some_and(|own| own.iter().all(|x| near(*block, x)))
        })
    }

    /// Number of particles in the bins.
    pub fn sorted(&self) -> usize {
        self.bins.last().map_or(0, |bin| bin.range.end)
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.bins.is_empty()
    }

    /// True if the particles must be sorted before the next sweep of `kernel`.
    pub fn stale(&self, kernel: Kernel, particles: usize) -> bool {
        let Disorder { drift, excess, .. } = self.disorder;
        drift > 0.99 * kernel.slack() || excess > SORT_COST * particles as f64 || self.sorted() != particles
    }

    /// True if the slots must be looked up.
    pub fn lost(&self) -> bool {
        self.slots.len() != self.bins.len()
    }

    /// The blocks that the tiles of all these bins reach, each bin's block and its neighbours, z slowest.
    pub fn blocks<'a>(all: impl Iterator<Item = &'a Self>) -> Vec<[i32; D]> {
        let bins = all.flat_map(|bins| &bins.bins);
        let mut blocks: Vec<_> = bins.flat_map(|bin| neighbours(bin.block)).collect();
        parallel::sort_unstable_by(&mut blocks, slowest_last);
        blocks.dedup();
        blocks
    }

    /// Looks the slots up after the grid's blocks have changed.
    pub fn locate(&mut self, grid: &Grid<D>) {
        let slot =
            |block: [i32; D]| grid.find(block.map(|b| b * EDGE as i32)).map_or(0, |n| (n / Grid::<D>::BLOCK) as u32);
        let bins = &self.bins;
        self.slots = parallel::collect(bins.len(), BINS, |b| neighbours(bins[b].block).map(slot).collect());
    }
}

/// Position of a tile's first node, in cells.
pub(crate) fn tile_origin<const D: usize>(block: [i32; D]) -> [f64; 3] {
    std::array::from_fn(|a| if a < D { f64::from(block[a] * EDGE as i32 - 1) } else { 0.0 })
}

/// Tiles of blocks of the same colour share no node: they are at least two blocks, a tile's width, apart.
fn colour<const D: usize>(block: [i32; D]) -> usize {
    const { assert!(TILE == 2 * EDGE) };
    (0..D).map(|a| (block[a].rem_euclid(2) as usize) << a).sum()
}

/// The 3ᴰ blocks around a block, x fastest.
fn neighbours<const D: usize>(block: [i32; D]) -> impl Iterator<Item = [i32; D]> {
    (0..3usize.pow(D as u32))
        .map(move |n| std::array::from_fn(|a| block[a] + (n / 3usize.pow(a as u32)) as i32 % 3 - 1))
}
