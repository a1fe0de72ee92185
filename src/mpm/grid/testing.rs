//! Grids around points, for tests; a step activates the blocks of its sorted particles.

use super::{EDGE, Grid};
use crate::math::Vector;
use crate::mpm::Kernel;
use std::collections::BTreeSet;

/// Makes the blocks active that lie in the supports of `points` [m], and those that ghosts in these are folded into, in
/// the order that the blocks of a step have.
pub fn activate<const D: usize>(grid: &mut Grid<D>, kernel: Kernel, points: &[Vector<D>]) {
    let mut reversed = BTreeSet::new();
    for x in points {
        let first: [i32; D] = std::array::from_fn(|a| kernel.first((x[a] - grid.origin[a]) * (1.0 / grid.cell)));
        let last = first.map(|i| i + kernel.support() - 1);
        let block = |i: i32| i.div_euclid(EDGE as i32);
        let lower: [i32; D] =
            std::array::from_fn(|a| block(first[a].min(2 * grid.cells[a] - last[a]).max(first[a] - 1)));
        let upper: [i32; D] = std::array::from_fn(|a| block(last[a].max(-first[a]).min(last[a] + 1)));
        for corner in 0..1 << D {
            let at = |a: usize| if corner >> a & 1 == 0 { lower[a] } else { upper[a] };
            reversed.insert(std::array::from_fn::<i32, D, _>(|a| at(D - 1 - a)));
        }
    }
    let forward = |mut block: [i32; D]| {
        block.reverse();
        block
    };
    grid.set_blocks(reversed.into_iter().map(forward).collect());
}
