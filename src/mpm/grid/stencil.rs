//! The nodes around one point with their weights (theory A.2): the loop of `executor::plain`, with which the tiles of
//! the transfers are compared.

use super::{EDGE, Grid};
use crate::math::Vector;
use crate::mpm::kernel::{AxisWeights, ShapeFunction};

/// The Sᴰ nodes around a point, as products over the axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stencil<const D: usize, const S: usize> {
    /// Weights and slopes per axis; slopes per metre.
    axes: [AxisWeights<S>; D],
    /// First node of the blocks b + {0, 1}ᴰ, b the block of the first node.
    corners: [u32; 8],
    /// Part of the node number inside its block, per axis.
    local: [[u32; S]; D],
    /// The node's block of the two along each axis, as a bit of the corner.
    side: [[u8; S]; D],
    /// Vector from the point to the first node, and the cell size [m].
    offset: Vector<D>,
    cell: f64,
}

impl<const D: usize, const S: usize> Stencil<D, S> {
    /// The stencil of the point `x` [m]; `None` if its first block is not active.
    #[inline(always)]
    pub fn new(grid: &Grid<D>, shape: impl ShapeFunction<S>, x: Vector<D>) -> Option<Self> {
        let inverse = 1.0 / grid.cell;
        let mut axes: [AxisWeights<S>; D] = std::array::from_fn(|a| shape.at((x[a] - grid.origin[a]) * inverse));
        let first = std::array::from_fn(|a| axes[a].first);
        let offset = Vector::from_fn(|a| grid.origin[a] + f64::from(first[a]) * grid.cell - x[a]);
        for axis in &mut axes {
            axis.slope = axis.slope.map(|s| s * inverse);
        }
        let corners = *grid.corners(first.map(|i| i.div_euclid(EDGE as i32)))?;
        let edge = EDGE as u32;
        let within = |a: usize, i: usize| first[a].rem_euclid(EDGE as i32) as u32 + i as u32;
        let stride = |a: usize| edge.pow(a as u32);
        let local = std::array::from_fn(|a| std::array::from_fn(|i| within(a, i) % edge * stride(a)));
        let side = std::array::from_fn(|a| std::array::from_fn(|i| ((within(a, i) / edge) << a) as u8));
        Some(Self { axes, corners, local, side, offset, cell: grid.cell })
    }

    /// Calls `visit(node, indices)` for every node, with its place in the support along each axis; x runs fastest.
    #[inline(always)]
    fn visit(&self, mut visit: impl FnMut(usize, [usize; D])) {
        for n in 0..S.pow(D as u32) {
            let mut rest = n;
            let index: [usize; D] = std::array::from_fn(|_| {
                let i = rest % S;
                rest /= S;
                i
            });
            let (mut side, mut local) = (0, 0);
            for (a, &i) in index.iter().enumerate() {
                side |= self.side[a][i];
                local += self.local[a][i];
            }
            visit((self.corners[side as usize] + local) as usize, index);
        }
    }

    #[inline(always)]
    fn weight(&self, index: [usize; D]) -> f64 {
        (1..D).fold(self.axes[0].weight[index[0]], |n, a| n * self.axes[a].weight[index[a]])
    }

    /// Calls `visit(node, N)` for every node.
    #[inline(always)]
    pub fn for_each(&self, mut visit: impl FnMut(usize, f64)) {
        self.visit(|node, index| visit(node, self.weight(index)));
    }

    /// Calls `visit(node, N, ∇N)` for every node; ∇N in 1/m.
    #[inline(always)]
    pub fn for_each_gradient(&self, mut visit: impl FnMut(usize, f64, Vector<D>)) {
        self.visit(|node, index| {
            let gradient = Vector::from_fn(|a| {
                (0..D).fold(1.0, |n, b| {
                    n * if a == b { self.axes[b].slope[index[b]] } else { self.axes[b].weight[index[b]] }
                })
            });
            visit(node, self.weight(index), gradient);
        });
    }

    /// Calls `visit(node, N, x_I − x)` for every node; lengths in m.
    #[inline(always)]
    pub fn for_each_offset(&self, mut visit: impl FnMut(usize, f64, Vector<D>)) {
        self.visit(|node, index| {
            let offset = Vector::from_fn(|a| self.offset[a] + self.cell * index[a] as f64);
            visit(node, self.weight(index), offset);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpm::grid::testing::activate;
    use crate::mpm::{Kernel, KernelKind};

    #[test]
    fn stencils_visit_the_nodes_around_a_point_across_blocks() {
        let mut grid = Grid::<2>::new(Vector::ZERO, 0.25, [40, 40], 1);
        for &kind in KernelKind::ALL {
            let kernel = Kernel::new(kind, 0.25);
            for x in [Vector([0.9, 1.02]), Vector([0.01, 0.99]), Vector([1.88, 3.12])] {
                activate(&mut grid, kernel, &[x]);
                let (mut centre, mut sum, mut slope) = (Vector::ZERO, 0.0, Vector::ZERO);
                assert!(kernel.for_each(&grid, x, |node, weight, gradient| {
                    centre += grid.position(node) * weight;
                    sum += weight;
                    slope += gradient * grid.position(node)[0];
                }));
                assert!((centre - x).norm() < 1e-15 * 8.0 && (sum - 1.0).abs() < 1e-14);
                assert!((slope - Vector([1.0, 0.0])).norm() < 1e-13);
            }
        }
    }
}
