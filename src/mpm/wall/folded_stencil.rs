//! The active grid nodes around a point, with mirrored walls folded back into the domain.
//!
//! A symmetry plane is exact: what a point gives to a ghost node −i goes to node i with the component
//! normal to the plane reversed, and is read back the same way (theory D.8). Ghosts beyond all other walls
//! extrapolate the two nodes next to the wall, as the bodies' ghosts do, or are none where a field has nodes there.

use crate::math::Vector;
use crate::mpm::grid::Fold;
use crate::mpm::kernel::{Kernel, ShapeFunction, with_shape};
use crate::mpm::{EDGE, Grid, Wall, WallKind};

/// Axes along which a vector is reversed on its way through a symmetry plane: one bit per axis.
pub type Flips = u8;

/// `v` with the components of the axes in `flips` reversed.
#[inline]
pub fn flip<const D: usize>(v: Vector<D>, flips: Flips) -> Vector<D> {
    if flips == 0 {
        return v;
    }
    Vector::from_fn(|axis| if flips >> axis & 1 == 1 { -v[axis] } else { v[axis] })
}

/// Shape functions of the bodies with the folding at walls, and the axes along which walls let contact act.
#[derive(Debug, Clone, Copy)]
pub struct FoldedStencil<const D: usize> {
    kernel: Kernel,
    walls: [[WallKind; 2]; D],
    folds: [[Fold; 2]; D],
    /// Nodes of bodies up to this mass don't touch anything [kg].
    pub cutoff: f64,
}

/// Weights of one axis over the folded nodes.
#[derive(Clone, Copy)]
struct AxisNodes<const S: usize> {
    weight: [f64; S],
    flipped: [bool; S],
    /// The lower of the at most two blocks.
    block: i32,
    upper: [bool; S],
    local: [usize; S],
}

impl<const D: usize> FoldedStencil<D> {
    /// The stencil for the shape functions of the bodies and the domain's walls.
    pub fn new(kernel: Kernel, walls: &[[Wall; 2]; D]) -> Self {
        let kind = |a: usize, end: usize| walls[a][end].kind;
        let fold = |a: usize, end: usize| walls[a][end].kind.fold(&walls[a][end].velocity[a]);
        Self {
            kernel,
            walls: std::array::from_fn(|a| [kind(a, 0), kind(a, 1)]),
            folds: std::array::from_fn(|a| [fold(a, 0), fold(a, 1)]),
            cutoff: 0.0,
        }
    }

    /// This stencil without the bodies' nodes up to the mass `cutoff` [kg].
    #[must_use]
    pub fn without_nodes_below(self, cutoff: f64) -> Self {
        Self { cutoff, ..self }
    }

    /// This stencil for the nodes of a field.
    #[must_use]
    pub fn of_field(self, grid: &Grid<D>, field: usize) -> Self {
        Self { folds: *grid.folds_in(field), ..self }
    }

    /// First node of the support of `x` [m], unfolded.
    pub fn first(&self, grid: &Grid<D>, x: Vector<D>) -> [i32; D] {
        std::array::from_fn(|a| self.kernel.first((x[a] - grid.origin[a]) / grid.cell))
    }

    /// Number of nodes of the support along one axis.
    pub fn support(&self) -> i32 {
        self.kernel.support()
    }

    /// Calls `visit(node, N, flips)` for every active node in the support of `x` [m]; with `flips`, the node
    /// stands for its mirror image.
    #[inline]
    pub fn for_each(&self, grid: &Grid<D>, x: Vector<D>, visit: impl FnMut(usize, f64, Flips)) {
        with_shape!(self.kernel, shape => self.visit(grid, shape, x, visit));
    }

    #[inline]
    fn visit<const S: usize>(
        &self,
        grid: &Grid<D>,
        shape: impl ShapeFunction<S>,
        x: Vector<D>,
        mut visit: impl FnMut(usize, f64, Flips),
    ) {
        let axes: [AxisNodes<S>; D] = std::array::from_fn(|a| {
            let at = shape.at((x[a] - grid.origin[a]) / grid.cell);
            self.fold(a, at.first, at.weight, grid.cells[a])
        });
        let corners: [Option<usize>; 8] = std::array::from_fn(|corner| {
            let wanted = corner < 1 << D && (0..D).all(|a| corner >> a & 1 == 0 || axes[a].upper.contains(&true));
            let block = std::array::from_fn(|a| axes[a].block + (corner >> a & 1) as i32);
            if wanted { grid.corners(block).map(|nodes| nodes[0] as usize) } else { None }
        });
        for n in 0..S.pow(D as u32) {
            let (mut rest, mut corner, mut local, mut flips, mut weight) = (n, 0, 0, 0, 1.0);
            for (a, axis) in axes.iter().enumerate() {
                let i = rest % S;
                rest /= S;
                weight *= axis.weight[i];
                corner |= usize::from(axis.upper[i]) << a;
                local += axis.local[i] * EDGE.pow(a as u32);
                flips |= Flips::from(axis.flipped[i]) << a;
            }
            if weight == 0.0 {
                continue;
            }
            if let Some(first) = corners[corner] {
                visit(first + local, weight, flips);
            }
        }
    }

    #[inline]
    fn fold<const S: usize>(&self, axis: usize, first: i32, weight: [f64; S], cells: i32) -> AxisNodes<S> {
        let [lower, upper] = self.folds[axis].map(|fold| fold == Fold::Mirror);
        let folded: [(i32, bool); S] = std::array::from_fn(|i| match first + i as i32 {
            node if node < 0 && lower => (-node, true),
            node if node > cells && upper => (2 * cells - node, true),
            node => (node, false),
        });
        let mut weight = weight;
        for (end, fold) in [0, cells].into_iter().zip(self.folds[axis]) {
            if fold == Fold::Extrapolate {
                extrapolate(&folded.map(|(node, _)| if end == 0 { node } else { cells - node }), &mut weight);
            }
        }
        let block = folded.iter().map(|(node, _)| node.div_euclid(EDGE as i32)).min().unwrap_or(0);
        AxisNodes {
            weight,
            flipped: folded.map(|(_, flipped)| flipped),
            block,
            upper: folded.map(|(node, _)| node.div_euclid(EDGE as i32) > block),
            local: folded.map(|(node, _)| node.rem_euclid(EDGE as i32) as usize),
        }
    }

    /// The mirror image of the point `x` [m] behind the symmetry planes nearest to it along `flips`.
    #[inline]
    pub fn mirror(&self, grid: &Grid<D>, x: Vector<D>, flips: Flips) -> Vector<D> {
        if flips == 0 {
            return x;
        }
        let (lower, upper) = (grid.origin, grid.upper());
        Vector::from_fn(|a| {
            let plane = if x[a] - lower[a] < upper[a] - x[a] { lower[a] } else { upper[a] };
            if flips >> a & 1 == 1 { 2.0 * plane - x[a] } else { x[a] }
        })
    }

    /// Axes along which contact may push a node: not the normal of a symmetry plane, none on a fixed wall
    /// (theory D.8).
    pub fn free(&self, grid: &Grid<D>, node: usize) -> [bool; D] {
        let ijk = grid.coordinates(node);
        let mut free = [true; D];
        for axis in 0..D {
            for (end, outside) in [(0, ijk[axis] <= 0), (1, ijk[axis] >= grid.cells[axis])] {
                match self.walls[axis][end] {
                    WallKind::Slip if outside => free[axis] = false,
                    WallKind::Fixed if outside => return [false; D],
                    _ => {}
                }
            }
        }
        free
    }
}

/// Moves the weights of ghosts (`inward` < 0) to the first two nodes of the domain: u₋ₖ = (1 + k) u₀ − k u₁.
#[inline]
fn extrapolate<const S: usize>(inward: &[i32; S], weight: &mut [f64; S]) {
    for ghost in 0..S {
        let depth = -inward[ghost];
        if depth <= 0 {
            continue;
        }
        let lent = std::mem::take(&mut weight[ghost]);
        let place = |wanted: i32| inward.iter().position(|&node| node == wanted);
        match (place(0), place(1)) {
            (Some(plane), Some(next)) => {
                weight[plane] += f64::from(1 + depth) * lent;
                weight[next] -= f64::from(depth) * lent;
            }
            (Some(plane), None) => weight[plane] += lent,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Signal;
    use crate::mpm::KernelKind;

    fn stencil(kind: WallKind) -> FoldedStencil<2> {
        let wall = || Wall { kind, ..Wall::default() };
        FoldedStencil::new(Kernel::new(KernelKind::Quadratic, 0.25), &std::array::from_fn(|_| [wall(), wall()]))
    }

    /// Other walls keep the linear completeness without ghosts.
    #[test]
    fn walls_extrapolate() {
        let mut grid = Grid::<2>::new(Vector::ZERO, 0.5, [4, 4], 1);
        grid.set_blocks(vec![[0, 0], [1, 0], [0, 1], [1, 1]]);
        for x in [Vector([0.05, 0.3]), Vector([1.95, 1.99]), Vector([1.0, 0.0])] {
            let (mut sum, mut centre) = (0.0, Vector::ZERO);
            stencil(WallKind::Separate).for_each(&grid, x, |node, weight, flips| {
                assert!(flips == 0 && grid.contains(grid.coordinates(node)));
                sum += weight;
                centre += grid.position(node) * weight;
            });
            assert!((sum - 1.0).abs() < 1e-14 && (centre - x).norm() < 1e-14, "{x:?} {centre:?}");
        }
    }

    /// A linear field that is odd across the planes where it should be is reproduced next to them.
    #[test]
    fn symmetry_planes_are_read_back_as_mirror_images() {
        let mut grid = Grid::<2>::new(Vector::ZERO, 0.5, [4, 4], 1);
        grid.set_blocks(vec![[0, 0], [1, 0], [0, 1], [1, 1]]);
        let stencil = stencil(WallKind::Slip);
        for x in [Vector([0.05, 0.3]), Vector([1.95, 1.99]), Vector([1.0, 0.0])] {
            let (mut sum, mut centre) = (0.0, Vector::ZERO);
            stencil.for_each(&grid, x, |node, weight, flips| {
                sum += weight;
                centre += stencil.mirror(&grid, grid.position(node), flips) * weight;
            });
            assert!((sum - 1.0).abs() < 1e-14 && (centre - x).norm() < 1e-14, "{x:?} {centre:?}");
        }
        assert_eq!(stencil.free(&grid, grid.find([0, 2]).unwrap()), [false, true]);
    }

    /// A slip wall that moves along its normal is no mirror: its ghosts extrapolate, as the bodies' do.
    #[test]
    fn slip_walls_that_move_along_their_normal_extrapolate() {
        let moving = Wall { kind: WallKind::Slip, velocity: std::array::from_fn(|_| Signal::Constant(1.0)) };
        let stencil = FoldedStencil::<2>::new(
            Kernel::new(KernelKind::Quadratic, 0.25),
            &std::array::from_fn(|_| [moving.clone(), moving.clone()]),
        );
        let mut grid = Grid::<2>::new(Vector::ZERO, 0.5, [4, 4], 1);
        grid.set_blocks(vec![[0, 0], [1, 0], [0, 1], [1, 1]]);
        let x = Vector([0.05, 0.3]);
        let (mut sum, mut centre) = (0.0, Vector::ZERO);
        stencil.for_each(&grid, x, |node, weight, flips| {
            assert_eq!(flips, 0);
            sum += weight;
            centre += grid.position(node) * weight;
        });
        assert!((sum - 1.0).abs() < 1e-14 && (centre - x).norm() < 1e-14, "{centre:?}");
    }

    /// Inactive blocks are left out, whichever corner of the support they are.
    #[test]
    fn only_active_nodes_are_visited() {
        let mut grid = Grid::<2>::new(Vector::ZERO, 1.0, [40, 40], 1);
        grid.set_blocks(vec![[1, 1]]);
        let mut visited = Vec::new();
        stencil(WallKind::Open).for_each(&grid, Vector([3.9, 4.2]), |node, weight, _| {
            visited.push((grid.coordinates(node), weight));
        });
        let nodes: Vec<_> = visited.iter().map(|v| v.0).collect();
        assert_eq!(nodes, [[4, 4], [5, 4], [4, 5], [5, 5]]);
        assert!(visited.iter().map(|v| v.1).sum::<f64>() < 1.0);
    }
}
