//! The order of particles: by block, then by the cell in which their support begins, then as they were.
//!
//! A counting sort: particles are nearly in order from the last time, so that its reads and writes are nearly
//! sequential.

use crate::math::Vector;
use crate::mpm::Kernel;
use crate::mpm::grid::EDGE;
use crate::parallel::{self, CHUNK};
use hashbrown::HashMap;
use std::ops::Range;
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
    let mut places: Vec<CellInBlock<D>> = vec![([0; D], 0); x.len()];
    parallel::fill(&mut places, CHUNK, |p| place(kernel, (x[p] - origin) * (1.0 / cell)));
    let blocks = blocks(&places);
    let cells = CELLS.pow(D as u32);
    let slots: HashMap<[i32; D], usize> =
        blocks.iter().enumerate().map(|(slot, &block)| (block, slot * cells)).collect();
    let part_len = places.len().div_ceil(PARTS).max(CHUNK);
    let parts: Vec<&[CellInBlock<D>]> = places.chunks(part_len).collect();
    let mut next: Vec<Vec<u32>> = parallel::map_parts(&parts, |part| count(part, &slots, cells));
    let total = |b: usize| next.iter().flat_map(|counts| &counts[b * cells..][..cells]).map(|&n| n as usize).sum();
    let blocks = blocks.iter().enumerate().map(|(b, &block)| (block, total(b))).collect();
    place_after(&mut next);
    // Places are given once each, so that no two threads write to one.
    let order: Vec<AtomicU32> = std::iter::repeat_with(AtomicU32::default).take(x.len()).collect();
    parallel::change(&mut next, 1, |number, next| {
        let mut last = LastSlot { slots: &slots, block: [i32::MIN; D], slot: 0 };
        for ((block, local), p) in parts[number].iter().zip((number * part_len) as u32..) {
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
    let first = |range: Range<usize>| {
        let mut blocks: Vec<[i32; D]> = places[range].iter().map(|place| place.0).collect();
        blocks.dedup();
        blocks.sort_unstable_by(slowest_last);
        blocks.dedup();
        blocks
    };
    let mut blocks: Vec<[i32; D]> = parallel::map_ranges(places.len(), CHUNK, first).concat();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpm::KernelKind;

    /// As a plain stable sort by block and cell, with more particles than the parts of the sort have in a chunk.
    #[test]
    fn the_order_is_that_of_a_stable_sort_by_block_and_cell() {
        let count = 5 * CHUNK + 321;
        let coordinate = |n: usize, factor: usize| (n * factor % 100_003) as f64 / 100_003.0 * 40.0 - 13.0;
        let x: Vec<Vector<2>> =
            (0..count).map(|n| Vector([coordinate(n, 7919), coordinate(n, 104_729)]) * 0.1).collect();
        for &kind in KernelKind::ALL {
            let kernel = Kernel::new(kind, 0.25);
            let places: Vec<CellInBlock<2>> = x.iter().map(|&x| place(kernel, x * (1.0 / 0.1))).collect();
            let mut expected: Vec<u32> = (0..count as u32).collect();
            expected.sort_by_key(|&p| {
                let (block, cell) = places[p as usize];
                (block[1], block[0], cell)
            });
            let sorted = sort(kernel, &x, Vector::ZERO, 0.1);
            assert_eq!(sorted.order, expected);
            let mut rest = &expected[..];
            for (block, count) in sorted.blocks {
                let own = rest.split_off(..count).unwrap();
                assert!(!own.is_empty() && own.iter().all(|&p| places[p as usize].0 == block));
            }
            assert!(rest.is_empty());
        }
    }
}
