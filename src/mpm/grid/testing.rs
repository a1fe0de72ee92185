//! Grids around points and the nodes in the support of one, for tests; a step activates the blocks of its sorted
//! particles, and goes through nodes by tiles.

use super::stencil::Stencil;
use super::{EDGE, Grid};
use crate::math::Vector;
use crate::mpm::Kernel;
use crate::mpm::kernel::with_shape;
use std::collections::BTreeSet;

impl Kernel {
    /// Calls `visit(node, N, ∇N)` for every node (ghosts included) in the support of the point `x` [m];
    /// ∇N in 1/m. The blocks around `x` must be active; `false` if they are not.
    pub fn for_each<const D: usize>(
        self,
        grid: &Grid<D>,
        x: Vector<D>,
        visit: impl FnMut(usize, f64, Vector<D>),
    ) -> bool {
        with_shape!(self, shape => match Stencil::new(grid, shape, x) {
            Some(stencil) => {
                stencil.for_each_gradient(visit);
                true
            }
            None => false,
        })
    }
}

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
