//! The order of particles: by block, then by the cell in which their support begins, then as they were.
//!
//! A counting sort: particles are nearly in order from the last time, so that its reads and writes are nearly
//! sequential.

use super::shape::window;
use crate::math::Vector;
use crate::mpm::Kernel;
use crate::mpm::grid::EDGE;
use hashbrown::HashMap;
use rayon::prelude::*;

/// Cells of a block along an axis; a window that begins half a cell beyond the supports has one more.
const CELLS: usize = EDGE + 1;

/// Where particles belong.
pub(super) struct Order<const D: usize> {
    /// Old numbers of the particles in their new order.
    pub order: Vec<u32>,
    /// Blocks with particles, z slowest, and the number of their particles.
    pub blocks: Vec<([i32; D], usize)>,
}

/// Sorts positions [m]; the kernel decides about the cells.
pub(super) fn sort<const D: usize>(kernel: Kernel, x: &[Vector<D>], origin: Vector<D>, cell: f64) -> Order<D> {
    let places: Vec<([i32; D], u32)> = x.par_iter().map(|&x| place(kernel, (x - origin) * (1.0 / cell))).collect();
    let blocks = blocks(&places);
    let cells = CELLS.pow(D as u32);
    let slots: HashMap<[i32; D], usize> =
        blocks.iter().enumerate().map(|(slot, &block)| (block, slot * cells)).collect();
    // Next place of each cell's particles, after those of all cells before it.
    let mut next = vec![0u32; blocks.len() * cells + 1];
    let mut last = LastSlot { slots: &slots, block: [i32::MIN; D], slot: 0 };
    places.iter().for_each(|(block, local)| next[last.find(block) + *local as usize + 1] += 1);
    let counts = (0..blocks.len()).map(|b| next[b * cells + 1..][..cells].iter().map(|&n| n as usize).sum());
    let blocks = blocks.iter().copied().zip(counts.collect::<Vec<usize>>()).collect();
    let mut sum = 0;
    for count in &mut next {
        sum += *count;
        *count = sum;
    }
    let mut order = vec![0; x.len()];
    for ((block, local), p) in places.iter().zip(0u32..) {
        let place = &mut next[last.find(block) + *local as usize];
        order[*place as usize] = p;
        *place += 1;
    }
    Order { order, blocks }
}

/// Block and cell of a position in cells.
#[inline(always)]
fn place<const D: usize>(kernel: Kernel, s: Vector<D>) -> ([i32; D], u32) {
    let window = window(kernel);
    let block: [i32; D] = std::array::from_fn(|a| ((s[a] - window).floor() as i32).div_euclid(EDGE as i32));
    let begin = |a: usize| (kernel.first(s[a]) - kernel.first(window) - block[a] * EDGE as i32) as u32;
    (block, (0..D).rev().fold(0, |local, a| local * CELLS as u32 + begin(a)))
}

/// The different blocks, z slowest.
fn blocks<const D: usize>(places: &[([i32; D], u32)]) -> Vec<[i32; D]> {
    // Neighbours in memory are mostly neighbours in space.
    let first = |part: &[([i32; D], u32)]| {
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
