//! How much of what they bring ghosts extrapolate: no more than their rows inside can give.
//!
//! A particle of mass m at the distance s < ½ [cells] from a wall brings, with quadratic splines and all of its ghost extrapolated, s m to
//! row 1, and its pressure pushes there with V p/h: the acceleration V p/(h s m) has no bound, no time step is short enough for it, and a
//! particle that carries the slope of that motion (APIC) gains the speed as it leaves the wall. Where material fills the rows, the ghost has a
//! forty-eighth of their mass, and nothing is wrong. Each ghost extrapolates by a share θ and gives the rest to the wall:
//!
//! ```text
//! u_{−k} = (1 + k θ) u_0 − k θ u_1,      θ = 1 for r ≤ r_all,  0 for r ≥ r_none,  linear between,      r = k m_{−k} / min(m_1, m_2)
//! ```
//!
//! with the masses before folding. Fold and fill are adjoint for every θ and rigid motions exact, so that momentum is; linear motions are
//! exact where θ = 1: under more than one and a half cells of material. At θ = 0 the nodes hold means of the particles' motion, and no
//! particle gets more energy from them than it brought. The row m_2 tells a film from what fills the rows, since a particle at the wall doesn't
//! reach it.
//!
//! Positions follow the full extrapolation towards a wall, so that nothing passes it: [`Limits::hold_off`].
//!
//! The affine part of momentum has the place of the node that receives it for what is extrapolated (`sweep::shape`), and keeps that of the ghost
//! for the rest: [`Limits::place`].

use super::{Ghost, Ghosted, Ghosts};
use crate::math::{Tensor, Vector};
use crate::mpm::ghost::Fold;
use crate::mpm::{Body, Grid, Node};
use crate::parallel::CHUNK;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Up to which mass over that of the rows inside a ghost extrapolates all, r_all: five times that of ghosts where material fills the rows.
const ALL: f64 = 0.1;

/// From which on it extrapolates nothing, r_none.
const NONE: f64 = 0.5;

/// The shares θ of the ghosts of one velocity field; the default: all of them one.
#[derive(Debug, Clone, Default)]
pub struct Limits {
    /// By axis, in the order of its ghosts.
    shares: Vec<Vec<f64>>,
    /// A share is less than one.
    limited: bool,
}

/// Momentum by node [N s], of few nodes.
type Sparse<const D: usize> = BTreeMap<u32, Vector<D>>;

impl Limits {
    /// The share of a ghost, by its number among those of the axis.
    #[inline]
    pub(super) fn share(&self, axis: usize, number: usize) -> f64 {
        self.shares.get(axis).map_or(1.0, |shares| shares[number])
    }

    /// Finds the shares for the masses of `nodes`, before they are folded.
    pub fn measure<const D: usize>(&mut self, ghosts: &Ghosts<D>, nodes: &[Node<D>]) {
        self.shares.resize(D, Vec::new());
        for (shares, ghosts) in self.shares.iter_mut().zip(&ghosts.axes) {
            let share = |ghost: &Ghost| share(ghost, |node| nodes[node as usize].mass);
            ghosts.par_iter().with_min_len(CHUNK).map(share).collect_into_vec(shares);
        }
        self.limited = self.shares.iter().flatten().any(|&share| share < 1.0);
    }

    /// What the momentum of nodes lacks [N s], before it is folded, for the affine parts of what ghosts don't extrapolate.
    ///
    /// A scatter moves 2 S from row 1 to the wall, S = Σ m_p N C_p (x_0 − x_{−1}), which is right for θ = 1; (1 − θ) of it go back.
    pub fn place<'a, const D: usize>(
        &self,
        ghosts: &Ghosts<D>,
        grid: &Grid<D>,
        bodies: impl Iterator<Item = &'a Body<D>>,
        mut add: impl FnMut(usize, Vector<D>),
    ) {
        if !self.limited {
            return;
        }
        let (mut moments, mut change) = (std::array::from_fn::<_, D, _>(|_| Sparse::new()), Sparse::new());
        for (axis, node, moment) in bodies.flat_map(|body| moments_on_ghosts(grid, body)) {
            *moments[axis].entry(node).or_default() += moment;
        }
        for axis in 0..D {
            moments[axis + 1..].iter_mut().chain([&mut change]).for_each(|few| self.fold_few(ghosts, axis, few));
            for (node, moment) in std::mem::take(&mut moments[axis]) {
                let Some(number) = number(&ghosts.axes[axis], node) else { continue };
                let back = moment * (2.0 * (1.0 - self.share(axis, number)));
                let [(wall, _), (inside, _)] = ghosts.axes[axis][number].images;
                *change.entry(wall).or_default() -= back;
                *change.entry(inside).or_default() += back;
            }
        }
        change.into_iter().for_each(|(node, change)| add(node as usize, change));
    }

    /// Folds the ghosts of one axis.
    fn fold_few<const D: usize>(&self, ghosts: &Ghosts<D>, axis: usize, few: &mut Sparse<D>) {
        let outside = |node: u32| Some((node, number(&ghosts.axes[axis], node)?));
        let outside: Vec<_> = few.keys().filter_map(|&node| outside(node)).collect();
        for (node, number) in outside {
            let (ghost, value) = (&ghosts.axes[axis][number], few.remove(&node).unwrap_or_default());
            let value = if ghost.mirror { value.mirrored(axis) } else { value };
            for (image, factor) in ghost.images(self.share(axis, number)) {
                *few.entry(image as u32).or_default() += value * factor;
            }
        }
    }
}

impl Limits {
    /// How much less far than with the nodes' velocities particles next to walls come towards them in `dt` [s]: particle and displacement [m].
    ///
    /// At the wall a linear velocity that is extrapolated in full is that of the wall, but with θ < 1 it has a part (1 − θ) N_{−1} (u_1 − u_0) of that of row 1.
    /// Velocities and momentum keep it; a particle that moved by it would pass the wall. Nodes hold (m, v⁺, a).
    pub fn hold_off<const D: usize>(
        &self,
        ghosts: &Ghosts<D>,
        grid: &Grid<D>,
        (nodes, dt): (&[Node<D>], f64),
        body: &Body<D>,
    ) -> Vec<(usize, Vector<D>)> {
        if !self.limited {
            return Vec::new();
        }
        let held = |(p, &x): (usize, &Vector<D>)| {
            let mut by = Vector::ZERO;
            for End { axis, plane, inward } in ends_near(grid, x) {
                let mut excess = 0.0;
                body.kernel.for_each(grid, x, |node, n, _| {
                    if n > 0.0 && grid.coordinates(node)[axis] == plane - inward {
                        excess += n * self.excess(ghosts, (axis, axis), nodes, node);
                    }
                });
                let inward = f64::from(inward);
                by[axis] += inward * (excess * inward * dt).max(0.0);
            }
            (by != Vector::ZERO).then_some((p, by))
        };
        body.particles.position.par_iter().enumerate().with_min_len(CHUNK).filter_map(held).collect()
    }

    /// (1 − θ) (u_0 − u_1) along the axis [m/s] at a ghost beyond one of its ends, which may be a ghost of the axes before `last`, too.
    fn excess<const D: usize>(
        &self,
        ghosts: &Ghosts<D>,
        (axis, last): (usize, usize),
        nodes: &[Node<D>],
        node: usize,
    ) -> f64 {
        let other = (0..last).rev().find_map(|a| Some((a, number(&ghosts.axes[a], node as u32)?)));
        if let Some((a, number)) = other {
            let images = ghosts.axes[a][number].images(self.share(a, number));
            return images.map(|(image, factor)| factor * self.excess(ghosts, (axis, a), nodes, image)).sum();
        }
        let Some(number) = number(&ghosts.axes[axis], node as u32) else { return 0.0 };
        let [(wall, _), (inside, _)] = ghosts.axes[axis][number].images;
        let v = |node: u32| nodes[node as usize].momentum[axis];
        (1.0 - self.share(axis, number)) * (v(wall) - v(inside))
    }
}

/// An end of an axis beyond which ghosts extrapolate: its plane of nodes, and the direction into the domain.
struct End {
    axis: usize,
    plane: i32,
    inward: i32,
}

/// Those that are less than a cell from `x` [m].
fn ends_near<const D: usize>(grid: &Grid<D>, x: Vector<D>) -> impl Iterator<Item = End> {
    let near = move |(axis, end): (usize, usize)| {
        let (plane, inward) = if end == 0 { (0, 1) } else { (grid.cells[axis], -1) };
        let away = (x[axis] - grid.origin[axis]) / grid.cell - f64::from(plane);
        (grid.folds[axis][end] != Fold::Mirror && away.abs() < 1.0).then_some(End { axis, plane, inward })
    };
    (0..2 * D).map(|side| (side / 2, side % 2)).filter_map(near)
}

/// θ of a ghost among nodes of these masses [kg].
fn share(ghost: &Ghost, mass: impl Fn(u32) -> f64) -> f64 {
    let [_, (inside, factor)] = ghost.images;
    if ghost.mirror || factor == 0.0 {
        return 1.0;
    }
    let (brought, row) = (-factor * mass(ghost.node), mass(inside));
    let least = ghost.next.map_or(row, |next| row.min(mass(next)));
    if brought <= ALL * least {
        return 1.0;
    }
    ((NONE * least - brought) / ((NONE - ALL) * least)).max(0.0)
}

/// The number of a node among the ghosts of an axis, which are in the order of their nodes.
fn number(ghosts: &[Ghost], node: u32) -> Option<usize> {
    ghosts.binary_search_by_key(&node, |ghost| ghost.node).ok()
}

/// Axis, ghost, and m_p N C_p (x_0 − x_{−1}) [N s] of a body's particles next to walls that extrapolate.
fn moments_on_ghosts<const D: usize>(grid: &Grid<D>, body: &Body<D>) -> Vec<(usize, u32, Vector<D>)> {
    let particles = &body.particles;
    let of_particle = |(p, c): (usize, &Tensor<D>)| {
        let (x, mut moments) = (particles.position[p], Vec::new());
        for End { axis, plane, inward } in ends_near(grid, x) {
            let moment = Vector::from_fn(|a| c[a][axis]) * (particles.mass[p] * grid.cell * f64::from(inward));
            body.kernel.for_each(grid, x, |node, n, _| {
                if n > 0.0 && grid.coordinates(node)[axis] == plane - inward {
                    moments.push((axis, node as u32, moment * n));
                }
            });
        }
        moments
    };
    particles.affine.par_iter().enumerate().with_min_len(CHUNK).flat_map_iter(of_particle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpm::{ActiveBlocks, Kernel, KernelKind};

    const SMOOTH: [KernelKind; 3] = [KernelKind::Gimp, KernelKind::Quadratic, KernelKind::Cubic];

    /// Masses of particles of mass one at these heights above the bottom of a grid of unit cells whose walls extrapolate.
    fn masses(kernel: Kernel, heights: &[f64]) -> (Grid<2>, Ghosts<2>, Vec<Node<2>>) {
        let mut grid = Grid::new(Vector::ZERO, 1.0, [8, 8], 1);
        grid.folds = [[Fold::Extrapolate; 2]; 2];
        let place = |y: f64| Vector([3.6, y]);
        let mut active = ActiveBlocks::new(&grid);
        heights.iter().for_each(|&y| active.touch(kernel, place(y)));
        grid.set_blocks(active.into_sorted());
        let mut nodes = vec![Node::default(); grid.node_count()];
        for &y in heights {
            kernel.for_each(&grid, place(y), |node, n, _| nodes[node].mass += n);
        }
        let ghosts = Ghosts::new(&grid);
        (grid, ghosts, nodes)
    }

    /// The least and the largest share of the ghosts that have mass.
    fn shares(kernel: Kernel, heights: &[f64]) -> [f64; 2] {
        let (_, ghosts, nodes) = masses(kernel, heights);
        let mut limits = Limits::default();
        limits.measure(&ghosts, &nodes);
        let own = ghosts.axes.iter().enumerate().flat_map(|(a, own)| own.iter().enumerate().map(move |g| (a, g)));
        let laden = own.filter(|(_, (_, ghost))| nodes[ghost.node as usize].mass > 0.0);
        let all = laden.map(|(axis, (number, _))| limits.share(axis, number));
        all.fold([f64::INFINITY, 0.0], |[least, most], share| [least.min(share), most.max(share)])
    }

    /// Rows that material fills, ordered or not, are extrapolated from in full; a film of two particles per cell is from none at a depth of one cell.
    #[test]
    fn what_fills_the_rows_extrapolates_and_a_film_does_not() {
        for kind in SMOOTH {
            let kernel = Kernel::new(kind, 0.25);
            let column = |count: usize, shift: f64| -> Vec<f64> {
                (0..count).map(|k| 0.25 + 0.5 * k as f64 + shift * (-1.0_f64).powi(k as i32)).collect()
            };
            for shift in [0.0, 0.1] {
                assert_eq!(shares(kernel, &column(8, shift)), [1.0; 2], "{kind:?} {shift}");
            }
        }
        let quadratic = Kernel::new(KernelKind::Quadratic, 0.25);
        assert_eq!(shares(quadratic, &[0.2, 0.7]), [0.0; 2]);
        // m_{−1} = ½ (½ − ¼)² = 1/32 and m_2 = ½ (¾ − ½)² + ½ (1 − ½)² = 1/32 + 1/8: between the two.
        let between = shares(quadratic, &[0.25, 0.75, 1.0]);
        let ratio = (1.0 / 32.0) / (1.0 / 32.0 + 1.0 / 8.0);
        assert!(between.iter().all(|share| (share - (0.5 - ratio) / 0.4).abs() < 1e-12), "{between:?}");
    }

    /// However near a particle is to a wall, folding leaves row 1 what the particle brings there; sums and adjoints stay.
    #[test]
    fn a_particle_alone_keeps_the_mass_of_its_rows() {
        for kind in SMOOTH {
            let kernel = Kernel::new(kind, 0.25);
            for height in [0.0, 1e-9, 1e-3, 0.1, 0.3, 0.499, 0.7, 0.95] {
                let (grid, ghosts, nodes) = masses(kernel, &[height]);
                let mut limits = Limits::default();
                limits.measure(&ghosts, &nodes);
                let (mut folded, mut filled): (Vec<_>, Vec<_>) =
                    (0..nodes.len()).map(|n| ([nodes[n].mass], [(n as f64).sin()])).unzip();
                let inside = filled.clone();
                ghosts.fold(&limits, &mut folded, |_, _, _| {});
                ghosts.fill(&limits, &mut filled);
                for (n, [mass]) in folded.iter().enumerate().filter(|&(n, _)| grid.coordinates(n)[1] == 1) {
                    assert!(*mass >= 0.9 * nodes[n].mass, "{kind:?} {height}: {mass} of {}", nodes[n].mass);
                }
                let sum: f64 = folded.iter().map(|[mass]| mass).sum();
                assert!((sum - 1.0).abs() < 1e-14);
                let dot = |a: &dyn Fn(usize) -> f64, b: &[[f64; 1]]| (0..b.len()).map(|n| a(n) * b[n][0]).sum::<f64>();
                let power = dot(&|n| folded[n][0], &inside) - dot(&|n| nodes[n].mass, &filled);
                assert!(power.abs() < 1e-14, "{kind:?} {height}: {power}");
            }
        }
    }
}
