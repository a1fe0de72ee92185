//! The order of particles: by block, then by the cell in which their support begins, then as they were.
//!
//! A counting sort: particles are nearly in order from the last time, so that its reads and writes are nearly
//! sequential.

use crate::math::Vector;
use crate::mpm::Kernel;
use crate::mpm::grid::EDGE;
use hashbrown::HashMap;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// Cells of a block along an axis; a window that begins half a cell beyond the supports has one more.
const CELLS: usize = EDGE + 1;

/// Parts of the particles that are counted at the same time.
const PARTS: usize = 4;

/// Block and cell in it.
type CellInBlock<const D: usize> = ([i32; D], u32);

/// The order of the particles.
pub(super) struct Order<const D: usize> {
    /// Old numbers of the particles in their new order.
    pub order: Vec<u32>,
    /// Blocks with particles, z slowest, and the number of their particles.
    pub blocks: Vec<([i32; D], usize)>,
}

/// Sorts positions [m]; the kernel decides about the cells.
pub(super) fn sort<const D: usize>(kernel: Kernel, x: &[Vector<D>], origin: Vector<D>, cell: f64) -> Order<D> {
    let places: Vec<CellInBlock<D>> = x.par_iter().map(|&x| place(kernel, (x - origin) * (1.0 / cell))).collect();
    let blocks = blocks(&places);
    let cells = CELLS.pow(D as u32);
    let slots: HashMap<[i32; D], usize> =
        blocks.iter().enumerate().map(|(slot, &block)| (block, slot * cells)).collect();
    let share = places.len().div_ceil(PARTS).max(crate::parallel::CHUNK);
    let parts: Vec<&[CellInBlock<D>]> = places.chunks(share).collect();
    let mut next: Vec<Vec<u32>> = parts.par_iter().map(|part| count(part, &slots, cells)).collect();
    let total = |b: usize| next.iter().flat_map(|counts| &counts[b * cells..][..cells]).map(|&n| n as usize).sum();
    let blocks = blocks.iter().enumerate().map(|(b, &block)| (block, total(b))).collect();
    place_after(&mut next);
    // Places are given once each, so that no two threads write to one.
    let order: Vec<AtomicU32> = (0..x.len()).into_par_iter().map(|_| AtomicU32::new(0)).collect();
    parts.par_iter().zip(&mut next).enumerate().for_each(|(number, (part, next))| {
        let mut last = LastSlot { slots: &slots, block: [i32::MIN; D], slot: 0 };
        for ((block, local), p) in part.iter().zip((number * share) as u32..) {
            let place = &mut next[last.find(block) + *local as usize];
            order[*place as usize].store(p, Ordering::Relaxed);
            *place += 1;
        }
    });
    Order { order: order.into_iter().map(AtomicU32::into_inner).collect(), blocks }
}

/// Numbers of a part's particles in each cell of each block.
fn count<const D: usize>(part: &[CellInBlock<D>], slots: &HashMap<[i32; D], usize>, cells: usize) -> Vec<u32> {
    let mut counts = vec![0; slots.len() * cells];
    let mut last = LastSlot { slots, block: [i32::MIN; D], slot: 0 };
    part.iter().for_each(|(block, local)| counts[last.find(block) + *local as usize] += 1);
    counts
}

/// Turns the counts of the parts into the first place of each cell's particles: after those of all cells before it, and
/// of all parts before this one.
fn place_after(counts: &mut [Vec<u32>]) {
    let mut sum = 0;
    for cell in 0..counts.first().map_or(0, Vec::len) {
        for part in &mut *counts {
            let count = std::mem::replace(&mut part[cell], sum);
            sum += count;
        }
    }
}

/// Block and cell of a position in cells.
#[inline(always)]
fn place<const D: usize>(kernel: Kernel, s: Vector<D>) -> CellInBlock<D> {
    let window = kernel.window();
    let block: [i32; D] = std::array::from_fn(|a| ((s[a] - window).floor() as i32).div_euclid(EDGE as i32));
    let begin = |a: usize| (kernel.first(s[a]) - kernel.first(window) - block[a] * EDGE as i32) as u32;
    (block, (0..D).rev().fold(0, |local, a| local * CELLS as u32 + begin(a)))
}

/// The different blocks, z slowest.
fn blocks<const D: usize>(places: &[CellInBlock<D>]) -> Vec<[i32; D]> {
    // Neighbours in memory are mostly neighbours in space.
    let first = |part: &[CellInBlock<D>]| {
        let mut blocks: Vec<[i32; D]> = part.iter().map(|place| place.0).collect();
        blocks.dedup();
        blocks.sort_unstable_by(slowest_last);
        blocks.dedup();
        blocks
    };
    let mut blocks: Vec<[i32; D]> = places.par_chunks(crate::parallel::CHUNK).flat_map_iter(first).collect();
    blocks.sort_unstable_by(slowest_last);
    blocks.dedup();
    blocks
}

/// Order of blocks, the last axis slowest.
pub(super) fn slowest_last<const D: usize>(a: &[i32; D], b: &[i32; D]) -> std::cmp::Ordering {
    a.iter().rev().cmp(b.iter().rev())
}

/// Finds the slots of blocks that are mostly the same as the last.
struct LastSlot<'a, const D: usize> {
    slots: &'a HashMap<[i32; D], usize>,
    block: [i32; D],
    slot: usize,
}

impl<const D: usize> LastSlot<'_, D> {
    #[inline(always)]
    fn find(&mut self, block: &[i32; D]) -> usize {
        if *block != self.block {
            (self.block, self.slot) = (*block, self.slots[block]);
        }
        self.slot
    }
}
