//! A block's private copy of the grid around it: scattered into without locks, gathered from without look-ups.
//!
//! A tile covers nodes −1..=6 of a block of 4ᴰ nodes along each axis: the support of every particle that is
//! still within the kernel's slack of its block. Blocks whose coordinates have the same parities have disjoint
//! tiles, so that all blocks of one colour add their tiles to the grid at the same time, and colour after
//! colour in a fixed order: the sums don't depend on the number of threads.

use super::EDGE;
use crate::math::Vector;
use crate::math::simd::{Lanes, Row};

/// Nodes of a tile along each axis.
pub(crate) const TILE: usize = 2 * EDGE;
/// Distance between planes; not a multiple of a page, which would make stores collide with loads.
pub(crate) const PLANE: usize = TILE * TILE + TILE;
/// Nodes of a tile in memory.
pub(crate) const TILE_NODES: usize = TILE * PLANE;

/// A node's eight numbers, a cache line.
pub(crate) type NodeRecord = Row;

/// The tile's memory.
pub(crate) type Tile = [NodeRecord; TILE_NODES];

/// Two numbers per node; rows along x are read four nodes at a time, so the end may overrun.
pub(crate) type ScalarTile = [[f64; 2]; TILE_NODES + 4];

/// The number of node (i, j, k) of a tile.
#[inline(always)]
pub(crate) fn tile_index(i: usize, j: usize, k: usize) -> usize {
    i + TILE * j + PLANE * k
}

/// The part of a tile that particles touch: node ranges per axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extent {
    /// First node per axis.
    pub from: [usize; 3],
    /// One past the last node per axis.
    pub to: [usize; 3],
}

impl Extent {
    /// Nothing yet.
    pub const EMPTY: Self = Self { from: [usize::MAX; 3], to: [0; 3] };

    /// The smallest extent that holds both.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            from: std::array::from_fn(|a| self.from[a].min(other.from[a])),
            to: std::array::from_fn(|a| self.to[a].max(other.to[a])),
        }
    }

    /// The supports of `W` nodes per axis whose first nodes lie between the lanes of `lowest` and of `highest`.
    #[inline(always)]
    pub fn around<L: Lanes, const W: usize, const D: usize>(lowest: &[L; D], highest: &[L; D]) -> Self {
        let mut extent = Self { from: [0; 3], to: [1; 3] };
        for axis in 0..D {
            let (mut from, mut to) = (Row::default(), Row::default());
            lowest[axis].store(&mut from.0);
            highest[axis].store(&mut to.0);
            extent.from[axis] = from.0.into_iter().fold(f64::INFINITY, f64::min) as usize;
            extent.to[axis] = to.0.into_iter().fold(0.0, f64::max) as usize + W;
        }
        extent
    }
}

/// Calls `visit(first node, first tile node, count)` for every run of consecutive nodes of `extent`.
///
/// `slots` are the 3ᴰ neighbouring blocks, x fastest, the block itself in the middle.
#[inline(always)]
pub(crate) fn for_each_run<const D: usize>(slots: &[u32], extent: &Extent, mut visit: impl FnMut(usize, usize, usize)) {
    let block = EDGE.pow(D as u32);
    // Node i of the tile is node i − 1 of the block: which of the three blocks, and where in it.
    let split = |i: usize| (i.div_ceil(EDGE), (i + EDGE - 1) % EDGE);
    for k in extent.from[2]..extent.to[2] {
        let (bk, lk) = if D == 3 { split(k) } else { (0, 0) };
        for j in extent.from[1]..extent.to[1] {
            let (bj, lj) = split(j);
            let mut i = extent.from[0];
            while i < extent.to[0] {
                let (bi, li) = split(i);
                let count = (EDGE - li).min(extent.to[0] - i);
                let slot = slots[bi + 3 * (bj + 3 * bk)] as usize;
                visit(slot * block + li + EDGE * (lj + EDGE * lk), tile_index(i, j, k), count);
                i += count;
            }
        }
    }
}

/// Sets a record's scalar, as a gather reads it.
#[inline(always)]
pub(crate) fn put_scalar(record: &mut NodeRecord, scalar: f64) {
    record.0[0] = scalar;
}

/// Sets a record's velocity.
#[inline(always)]
pub(crate) fn put_velocity<const D: usize>(record: &mut NodeRecord, velocity: &Vector<D>) {
    record.0[1..=D].copy_from_slice(&velocity.0);
}

/// Sets a record's acceleration.
#[inline(always)]
pub(crate) fn put_acceleration<const D: usize>(record: &mut NodeRecord, acceleration: &Vector<D>) {
    record.0[1 + D..1 + 2 * D].copy_from_slice(&acceleration.0);
}
