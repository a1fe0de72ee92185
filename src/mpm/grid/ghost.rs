//! Ghost nodes: what the kernels put outside the domain is folded back into it, and read by the adjoint rule.
//!
//! A field on the lattice that the domain's nodes determine is u_ghost = Σ G u_inside; mass, momentum and
//! force go the other way, w_inside += Gᵀ w_ghost, so that power and momentum agree on both sides. Two rules,
//! for the ghost k nodes beyond the plane 0 (theory A.3):
//!
//! ```text
//! mirror       u_{−k} = u_k, normal component −u_k      (Slip: exactly the other half of a symmetric problem)
//! extrapolate  u_{−k} = (1 + k) u_0 − k u_1             (all others: the open-knot splines; linear fields exact)
//! ```
//!
//! Extrapolation takes from row 1 what particles at the wall bring there: little where material fills the rows, all of
//! it where a film or a single particle is, on which their forces still act; `limit` has the fraction that a ghost may
//! take.
//!
//! The affine part of a particle's momentum, N C (x_I − x_p), is that of the node that receives it: what a ghost
//! hands to a node further inside belongs to the place of that node (`kernel::Weights`).
//!
//! Solids that meet a wall at its surface have nodes beyond it as on both sides of an obstacle (`wall::domain`): ghosts
//! there are no ghosts of their field.
//!
//! Axes are folded one after the other and filled in the opposite order, which makes edges and corners right: a node
//! beyond two walls is a ghost of both axes, of which the second finds nothing where the first has folded it, and the
//! first overwrites what the second has filled.

mod limit;

use super::{EDGE, Fold, GhostFractions, Grid, Node};
use crate::math::Vector;
use crate::parallel::{self, CHUNK};

/// The active ghost nodes of a grid; rebuilt when its blocks change.
#[derive(Debug, Default)]
pub struct Ghosts<const D: usize> {
    axes: Vec<Vec<Ghost>>,
}

/// One ghost node: u_ghost = Σ c u_image.
#[derive(Debug, Clone, Copy)]
struct Ghost {
    node: u32,
    /// Number of the domain side, 2·axis + (0 lower | 1 upper).
    side: usize,
    mirror: bool,
    images: [(u32, f64); 2],
    /// The node after the images, if the domain has one there and it is active.
    next: Option<u32>,
}

impl Ghost {
    /// The images with their factors where the ghost extrapolates by the fraction θ: u_{−k} = (1 + k θ) u_0 − k θ u_1.
    #[inline]
    fn images(&self, fraction: f64) -> impl Iterator<Item = (usize, f64)> {
        let [(first, f), (second, s)] = self.images;
        let images = if self.mirror {
            [(first, f), (second, s)]
        } else {
            [(first, 1.0 + (f - 1.0) * fraction), (second, s * fraction)]
        };
        images.into_iter().filter(|(_, factor)| *factor != 0.0).map(|(node, factor)| (node as usize, factor))
    }
}

/// A quantity that ghosts carry.
pub trait Ghosted: Copy + Default + Send + Sync {
    /// The image in a mirror normal to `axis`.
    fn mirrored(self, axis: usize) -> Self;
    /// self + other · factor.
    fn plus(self, other: Self, factor: f64) -> Self;
    /// True if nothing lies here: most ghosts are far from any particle.
    fn is_nothing(&self) -> bool;
}

impl<const D: usize> Ghosted for Vector<D> {
    #[inline]
    fn mirrored(mut self, axis: usize) -> Self {
        self[axis] = -self[axis];
        self
    }

    #[inline]
    fn plus(self, other: Self, factor: f64) -> Self {
        self + other * factor
    }

    #[inline]
    fn is_nothing(&self) -> bool {
        *self == Self::ZERO
    }
}

impl<const D: usize> Ghosted for Node<D> {
    #[inline]
    fn mirrored(self, axis: usize) -> Self {
        Self { mass: self.mass, momentum: self.momentum.mirrored(axis), force: self.force.mirrored(axis) }
    }

    #[inline]
    fn plus(self, other: Self, factor: f64) -> Self {
        Self {
            mass: self.mass + other.mass * factor,
            momentum: self.momentum + other.momentum * factor,
            force: self.force + other.force * factor,
        }
    }

    #[inline]
    fn is_nothing(&self) -> bool {
        self.mass == 0.0 && self.momentum == Vector::ZERO && self.force == Vector::ZERO
    }
}

/// Scalars: nothing in them has a direction.
impl<const N: usize> Ghosted for [f64; N]
where
    Self: Default,
{
    #[inline]
    fn mirrored(self, _axis: usize) -> Self {
        self
    }

    #[inline]
    fn plus(self, other: Self, factor: f64) -> Self {
        std::array::from_fn(|i| self[i] + other[i] * factor)
    }

    #[inline]
    fn is_nothing(&self) -> bool {
        self.iter().all(|&value| value == 0.0)
    }
}

impl<const D: usize> Ghosts<D> {
    /// The ghosts among the active nodes of `grid`, under its rules for both ends of each axis.
    pub fn new(grid: &Grid<D>) -> Self {
        let mut axes = vec![Vec::new(); D];
        let inside =
            |block: &[i32; D]| (0..D).all(|a| block[a] >= 0 && (block[a] + 1) * EDGE as i32 <= grid.cells[a] + 1);
        let border = grid.blocks().iter().enumerate().filter(|(_, block)| !inside(block));
        for node in border.flat_map(|(slot, _)| slot * Grid::<D>::BLOCK..(slot + 1) * Grid::<D>::BLOCK) {
            let ijk = grid.coordinates(node);
            let outside = |a: usize| !(0..=grid.cells[a]).contains(&ijk[a]);
            for axis in (0..D).filter(|&a| outside(a)) {
                let end = usize::from(ijk[axis] > 0);
                axes[axis].push(ghost(grid, node, ijk, 2 * axis + end, grid.folds[axis][end] == Fold::Mirror));
            }
        }
        Self { axes }
    }

    /// Folds what lies on the ghosts into the domain within `limits` and zeroes the ghosts; `before` sees every
    /// mirrored ghost with the number of its side just before (its normal part changes sign, so the wall feels it).
    pub fn fold<T: Ghosted>(
        &self,
        limits: &GhostFractions,
        values: &mut [T],
        mut before: impl FnMut(usize, usize, &T),
    ) {
        for (axis, ghosts) in self.axes.iter().enumerate() {
            // Looking is what takes time, so that is done in parallel; few ghosts carry anything.
            let laden = |number: usize| !values[ghosts[number].node as usize].is_nothing();
            for number in parallel::collect_some(ghosts.len(), CHUNK, |number| laden(number).then_some(number)) {
                let ghost = &ghosts[number];
                let Some(fraction) = limits.fraction(axis, number) else { continue };
                let mut value = std::mem::take(&mut values[ghost.node as usize]);
                if ghost.mirror {
                    before(ghost.side, ghost.node as usize, &value);
                    value = value.mirrored(axis);
                }
                for (image, factor) in ghost.images(fraction) {
                    values[image] = values[image].plus(value, factor);
                }
            }
        }
    }

    /// Fills the ghosts from the domain within `limits`.
    pub fn fill<T: Ghosted>(&self, limits: &GhostFractions, values: &mut [T]) {
        for (axis, ghosts) in self.axes.iter().enumerate().rev() {
            // A ghost's images are no ghosts of the same axis.
            let image = |number: usize| {
                let ghost = &ghosts[number];
                let Some(fraction) = limits.fraction(axis, number) else { return values[ghost.node as usize] };
                let mut value = T::default();
                for (image, factor) in ghost.images(fraction) {
                    value = value.plus(values[image], factor);
                }
                if ghost.mirror { value.mirrored(axis) } else { value }
            };
            let images: Vec<T> = parallel::collect(ghosts.len(), CHUNK, image);
            // Ghosts are in the order of their nodes, so that no two chunks share a node.
            let nodes = ghosts.chunks(CHUNK).map(|part| part[0].node as usize..part[part.len() - 1].node as usize + 1);
            let parts = parallel::parts_mut(values, nodes).into_iter().zip(ghosts.chunks(CHUNK));
            parallel::map_parts(parts.zip(images.chunks(CHUNK)), |((values, ghosts), images)| {
                let first = ghosts[0].node as usize;
                ghosts.iter().zip(images).for_each(|(ghost, image)| values[ghost.node as usize - first] = *image);
            });
        }
    }
}

/// A node beyond a side of the domain, numbered 2·axis + (0 lower | 1 upper), that is a mirror or not.
fn ghost<const D: usize>(grid: &Grid<D>, node: usize, ijk: [i32; D], side: usize, mirror: bool) -> Ghost {
    let axis = side / 2;
    let plane = if side.is_multiple_of(2) { 0 } else { grid.cells[axis] };
    let inward = plane - ijk[axis];
    let image = |beyond: i32| {
        let mut image = ijk;
        image[axis] = plane + beyond;
        let exists = (0..=grid.cells[axis]).contains(&image[axis]);
        grid.find(image).filter(|_| exists).map(|n| n as u32)
    };
    let (depth, none) = (f64::from(inward.abs()), (node as u32, 0.0));
    let pick = |beyond, factor| image(beyond).map_or(none, |n| (n, factor));
    let images = if mirror { [pick(inward, 1.0), none] } else { [pick(0, 1.0 + depth), pick(inward.signum(), -depth)] };
    Ghost { node: node as u32, side, mirror, images, next: image(2 * inward.signum()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpm::grid::testing::activate;
    use crate::mpm::{Kernel, KernelKind};

    fn grid_around(kernel: Kernel, x: Vector<2>) -> Grid<2> {
        let mut grid = Grid::new(Vector([1.0, -2.0]), 0.5, [4, 6], 1);
        activate(&mut grid, kernel, &[x]);
        grid
    }

    /// Points in the corners, at the walls and inside of the domain [1, 3] × [−2, 1].
    fn points() -> Vec<Vector<2>> {
        let along = |n: usize| [0.0, 0.03, 0.24, 0.26, 0.6, 1.0].map(move |s| s * 0.5 * n as f64 / 2.0);
        along(4).into_iter().flat_map(|x| along(6).map(|y| Vector([1.0 + 2.0 * x.min(1.0), -2.0 + 2.0 * y]))).collect()
    }

    /// At every wall: weights folded into the domain are a partition of unity that reproduces linear fields.
    #[test]
    fn extrapolation_keeps_linear_completeness() {
        for &kind in KernelKind::ALL {
            let kernel = Kernel::new(kind, 0.25);
            for x in points() {
                let mut grid = grid_around(kernel, x);
                grid.folds = [[Fold::Extrapolate; 2]; 2];
                let ghosts = Ghosts::new(&grid);
                let mut weights = vec![[0.0; 3]; grid.node_count()];
                kernel.for_each(&grid, x, |node, n, dn| weights[node] = [n, dn[0], dn[1]]);
                ghosts.fold(&GhostFractions::default(), &mut weights, |_, _, _| {});
                let (mut sum, mut centre, mut slope) = ([0.0; 3], Vector::ZERO, Vector::ZERO);
                for (node, w) in weights.iter().enumerate() {
                    sum = sum.plus(*w, 1.0);
                    centre += grid.position(node) * w[0];
                    slope += Vector([w[1] * grid.position(node)[0], w[2] * grid.position(node)[1]]);
                    assert!(w[0] >= -1e-15, "{kind:?} {x:?}: negative weight {}", w[0]);
                    assert!(w[0] == 0.0 || grid.contains(grid.coordinates(node)));
                }
                assert!((sum[0] - 1.0).abs() < 1e-14 && sum[1].abs() < 1e-13 && sum[2].abs() < 1e-13, "{kind:?} {x:?}");
                assert!((centre - x).norm() < 1e-14 && (slope - Vector([1.0, 1.0])).norm() < 1e-13);
            }
        }
    }

    /// A mirror gives what a twice as large problem with a mirrored twin particle would give.
    #[test]
    fn mirrors_equal_the_symmetric_problem() {
        for &kind in KernelKind::ALL {
            let kernel = Kernel::new(kind, 0.25);
            for x in points().into_iter().filter(|x| x[0] < 2.0) {
                let twin = Vector([2.0 - x[0], x[1]]);
                let v = Vector([0.7, -0.4]);
                let mut grid = Grid::<2>::new(Vector([1.0, -2.0]), 0.5, [4, 6], 1);
                activate(&mut grid, kernel, &[x, twin]);
                grid.folds = [[Fold::Mirror, Fold::Extrapolate], [Fold::Extrapolate; 2]];
                let ghosts = Ghosts::new(&grid);
                let mut half = vec![Vector::<2>::ZERO; grid.node_count()];
                kernel.for_each(&grid, x, |node, n, _| half[node] += v * n);
                let mut whole = half.clone();
                kernel.for_each(&grid, twin, |node, n, _| whole[node] += v.mirrored(0) * n);
                ghosts.fold(&GhostFractions::default(), &mut half, |_, _, _| {});
                for node in 0..grid.node_count() {
                    let ijk = grid.coordinates(node);
                    if grid.contains(ijk) && ijk[0] > 0 && (2..5).contains(&ijk[1]) {
                        assert!((half[node] - whole[node]).norm() < 1e-15, "{kind:?} {x:?}");
                    }
                }
            }
        }
    }

    /// Fill is the adjoint of fold: Σ fold(w)·u = Σ w·fill(u).
    #[test]
    fn fill_is_the_adjoint_of_fold() {
        let kernel = Kernel::new(KernelKind::Cubic, 0.25);
        for x in points() {
            let mut grid = grid_around(kernel, x);
            grid.folds = [[Fold::Mirror, Fold::Extrapolate], [Fold::Extrapolate, Fold::Mirror]];
            let ghosts = Ghosts::new(&grid);
            let mut weights = vec![Vector::<2>::ZERO; grid.node_count()];
            kernel.for_each(&grid, x, |node, n, _| weights[node] = Vector([n, 2.0 * n]));
            let mut values: Vec<Vector<2>> =
                (0..grid.node_count()).map(|node| Vector([(node as f64).sin(), (node as f64).cos()])).collect();
            let scattered = weights.clone();
            ghosts.fold(&GhostFractions::default(), &mut weights, |_, _, _| {});
            let inside: f64 = weights.iter().zip(&values).map(|(w, u)| w.dot(*u)).sum();
            ghosts.fill(&GhostFractions::default(), &mut values);
            let everywhere: f64 = scattered.iter().zip(&values).map(|(w, u)| w.dot(*u)).sum();
            assert!((inside - everywhere).abs() < 1e-14);
        }
    }
}
