//! Particles sorted by grid block, so that transfers stream memory and node data stays in the first-level cache.
//!
//! Block b owns positions [4b + ½, 4b + 4½) in cells. A particle may leave its block by the kernel's slack
//! before the body must be sorted again: every few dozen steps.

use super::shape::slack;
use super::tile::{Extent, TILE};
use crate::math::Vector;
use crate::mpm::Kernel;
use crate::mpm::grid::{EDGE, Grid};
use crate::mpm::particles::Particles;
use rayon::prelude::*;
use std::ops::Range;

/// Consecutive particles of one block.
#[derive(Debug, Clone)]
pub(crate) struct Bin<const D: usize> {
    /// Block coordinates.
    pub block: [i32; D],
    /// Its particles.
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
    /// How far any particle has moved along an axis since the sort, in cells, at most.
    pub drift: f64,
}

impl<const D: usize> Bins<D> {
    /// Sorts a body's particles by block and cell.
    pub fn sort(particles: &mut Particles<D>, origin: Vector<D>, cell: f64) -> Self {
        let keys: Vec<u64> = particles.position.par_iter().map(|&x| key((x - origin) * (1.0 / cell))).collect();
        let mut order: Vec<(u64, u32)> = keys.iter().zip(0u32..).map(|(&key, p)| (key, p)).collect();
        if !order.is_sorted() {
            order.par_sort_unstable();
            let order: Vec<u32> = order.iter().map(|&(_, p)| p).collect();
            particles.permute(&order);
        }
        let mut bins: Vec<Bin<D>> = Vec::new();
        for (p, &(key, _)) in order.iter().enumerate() {
            let block = block_of_key(key);
            match bins.last_mut() {
                Some(bin) if bin.block == block => bin.range.end = p + 1,
                _ => bins.push(Bin { block, range: p..p + 1 }),
            }
        }
        Self::new(bins, 0.0)
    }

    fn new(bins: Vec<Bin<D>>, drift: f64) -> Self {
        let mut colours = vec![Vec::new(); 1 << D];
        for (b, bin) in bins.iter().enumerate() {
            colours[colour(bin.block)].push(b);
        }
        let extents = vec![Extent::EMPTY; bins.len()];
        Self { bins, slots: Vec::new(), extents, colours, drift }
    }

    /// Block coordinates, first particle and one past the last of each bin, and the drift: for checkpoints.
    pub fn to_numbers(&self) -> (Vec<i32>, Vec<u32>, Vec<f64>) {
        let blocks = self.bins.iter().flat_map(|bin| bin.block).collect();
        let starts = self.bins.iter().flat_map(|bin| [bin.range.start as u32, bin.range.end as u32]).collect();
        (blocks, starts, vec![self.drift])
    }

    /// Restores what [`Self::to_numbers`] gave.
    pub fn from_numbers(blocks: &[i32], starts: &[u32], drift: &[f64]) -> Self {
        let bins = blocks.chunks_exact(D).zip(starts.chunks_exact(2)).map(|(block, range)| Bin {
            block: std::array::from_fn(|a| block[a]),
            range: range[0] as usize..range[1] as usize,
        });
        Self::new(bins.collect(), drift.first().copied().unwrap_or(f64::INFINITY))
    }

    /// True if the particles must be sorted before the next sweep of `kernel`.
    pub fn stale(&self, kernel: Kernel, particles: usize) -> bool {
        let sorted = self.bins.last().map_or(0, |bin| bin.range.end);
        self.drift > 0.99 * slack(kernel) || sorted != particles
    }

    /// True if the slots must be looked up.
    pub fn lost(&self) -> bool {
        self.slots.len() != self.bins.len()
    }

    /// The blocks that the tiles of all bodies reach, each bin's block and its neighbours, z slowest.
    pub fn blocks(bodies: &[Self]) -> Vec<[i32; D]> {
        let mut blocks: Vec<_> =
            bodies.iter().flat_map(|bins| &bins.bins).flat_map(|bin| neighbours(bin.block)).collect();
        blocks.sort_unstable_by(|a, b| a.iter().rev().cmp(b.iter().rev()));
        blocks.dedup();
        blocks
    }

    /// Looks the slots up after the grid's blocks have changed.
    pub fn locate(&mut self, grid: &Grid<D>) {
        let slot =
            |block: [i32; D]| grid.find(block.map(|b| b * EDGE as i32)).map_or(0, |n| (n / Grid::<D>::BLOCK) as u32);
        self.slots = self.bins.par_iter().map(|bin| neighbours(bin.block).map(slot).collect()).collect();
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

const BITS: u32 = 18;
const BIAS: i32 = 1 << (BITS - 1);

/// Sort key: block coordinates (z slowest), then the cell inside the block.
fn key<const D: usize>(s: Vector<D>) -> u64 {
    let cell: [i32; D] = std::array::from_fn(|a| (s[a] - 0.5).floor() as i32);
    let block = |a: usize| (cell[a].div_euclid(EDGE as i32) + BIAS) as u64 & ((1 << BITS) - 1);
    let local = |a: usize| cell[a].rem_euclid(EDGE as i32) as u64;
    let blocks = (0..D).rev().fold(0, |key, a| key << BITS | block(a));
    (0..D).rev().fold(blocks, |key, a| key << 2 | local(a))
}

fn block_of_key<const D: usize>(key: u64) -> [i32; D] {
    let blocks = key >> (2 * D);
    std::array::from_fn(|a| (blocks >> (BITS * a as u32) & ((1 << BITS) - 1)) as i32 - BIAS)
}
