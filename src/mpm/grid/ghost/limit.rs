//! The fraction by which ghosts extrapolate, which leaves the rows inside most of their mass (theory A.3).
//!
//! A particle of mass m at the distance s < ½ [cells] from a wall brings, with quadratic splines and all of its ghost
//! extrapolated, s m to row 1, and its pressure pushes there with V p/h: the acceleration V p/(h s m) has no bound, no
//! time step is short enough for it, and a particle that carries the slope of that motion (APIC) takes it along as it
//! leaves the wall. Each ghost extrapolates by a fraction θ, so that it takes no more than a part β of what lies on
//! the rows inside, and gives the rest to the wall:
//!
//! ```text
//! u_{−k} = (1 + k θ) u_0 − k θ u_1,      θ = min(1, β min(m_1, m_2) / (k m_{−k}))
//! ```
//!
//! with the masses before folding. Where material fills the rows a ghost has a forty-eighth of their mass, and θ = 1.
//! Row 2 tells a film from that, since a particle at the wall doesn't reach it: under a film θ goes to 0, nodes and
//! ghosts hold means of the particles' motion, and no particle gets more energy from them than they have. Fold and fill
//! are adjoint for every θ and rigid motions exact, so that momentum and work are; linear motions are exact where θ =
//! 1.
//!
//! At the wall itself nodes then have the part (1 − θ) N_{−1} ≤ 1/6 of the motion of row 1: the wall holds
//! the positions (`motion`). The affine momentum of APIC is placed as for θ = 1 (`kernel::Weights`): what that moves
//! from row 1 to the wall has no sum, and a film loses shear by it.

use super::{Ghost, Ghosts};
use crate::mpm::grid::{Fold, GhostFractions, Node};
use crate::parallel;

/// The largest part of the mass of the rows inside that a ghost takes, β: ten times what it takes where material fills
/// the rows evenly, and more than the eighth that one row of particles per cell can bring there.
const LARGEST_GHOST_FRACTION: f64 = 0.2;

impl GhostFractions {
    /// Finds the fractions for the masses of `nodes`, before they are folded as the field's `folds` say.
    pub fn measure<const D: usize>(&mut self, ghosts: &Ghosts<D>, folds: &[[Fold; 2]; D], nodes: &[Node<D>]) {
        self.fractions.resize(D, Vec::new());
        for (fractions, ghosts) in self.fractions.iter_mut().zip(&ghosts.axes) {
            let folded = |ghost: &&Ghost| folds[ghost.side / 2][ghost.side % 2] != Fold::Continue;
            let fraction =
                |ghost: &Ghost| Some(ghost).filter(folded).map(|g| fraction(g, |node| nodes[node as usize].mass));
            parallel::map_into(ghosts, fractions, fraction);
        }
    }
}

/// θ of a ghost among nodes of these masses [kg].
fn fraction(ghost: &Ghost, mass: impl Fn(u32) -> f64) -> f64 {
    let [_, (inside, factor)] = ghost.images;
    if ghost.mirror || factor == 0.0 {
        return 1.0;
    }
    let taken = -factor * mass(ghost.node);
    if taken == 0.0 {
        return 1.0;
    }
    let row = mass(inside);
    let most = LARGEST_GHOST_FRACTION * ghost.next.map_or(row, |next| row.min(mass(next)));
    if taken <= most { 1.0 } else { most / taken }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::mpm::grid::testing::activate;
    use crate::mpm::{Grid, Kernel, KernelKind};

    /// Kernels whose slopes vanish at the ends of their supports, of particles of half a cell.
    fn smooth() -> impl Iterator<Item = Kernel> {
        KernelKind::ALL.iter().map(|&kind| Kernel::new(kind, 0.25)).filter(|kernel| kernel.is_smooth())
    }

    /// Masses of particles of mass one at these heights above the bottom of a grid of unit cells whose walls
    /// extrapolate.
    fn masses(kernel: Kernel, heights: &[f64]) -> (Grid<2>, Ghosts<2>, Vec<Node<2>>) {
        let mut grid = Grid::new(Vector::ZERO, 1.0, [8, 8], 1);
        grid.folds = [[Fold::Extrapolate; 2]; 2];
        let place = |y: f64| Vector([3.6, y]);
        activate(&mut grid, kernel, &heights.iter().map(|&y| place(y)).collect::<Vec<_>>());
        let mut nodes = vec![Node::default(); grid.node_count()];
        for &y in heights {
            kernel.for_each(&grid, place(y), |node, n, _| nodes[node].mass += n);
        }
        let ghosts = Ghosts::new(&grid);
        (grid, ghosts, nodes)
    }

    /// The least and the largest fraction of the ghosts that have mass.
    fn fractions(kernel: Kernel, heights: &[f64]) -> [f64; 2] {
        let (grid, ghosts, nodes) = masses(kernel, heights);
        let mut limits = GhostFractions::default();
        limits.measure(&ghosts, &grid.folds, &nodes);
        let own = ghosts.axes.iter().enumerate().flat_map(|(a, own)| own.iter().enumerate().map(move |g| (a, g)));
        let laden = own.filter(|(_, (_, ghost))| nodes[ghost.node as usize].mass > 0.0);
        let all = laden.filter_map(|(axis, (number, _))| limits.fraction(axis, number));
        all.fold([f64::INFINITY, 0.0], |[least, most], fraction| [least.min(fraction), most.max(fraction)])
    }

    /// Rows that material fills, ordered or not, are extrapolated from in full; under a film of two particles per cell,
    /// one cell thick, a fifth is; and under a single row of particles, nothing.
    #[test]
    fn ghosts_extrapolate_in_full_from_filled_rows_and_in_part_from_a_film() {
        for kernel in smooth() {
            let column = |count: usize, shift: f64| -> Vec<f64> {
                (0..count).map(|k| 0.25 + 0.5 * k as f64 + shift * (-1.0_f64).powi(k as i32)).collect()
            };
            for shift in [0.0, 0.1, -0.25] {
                assert!(fractions(kernel, &column(8, shift))[0] >= 1.0, "{kernel:?} {shift}");
            }
        }
        let quadratic = Kernel::new(KernelKind::Quadratic, 0.25);
        assert_eq!(fractions(quadratic, &[0.2]), [0.0; 2]);
        // m_{−1} = ½ (½ − ¼)² = m_2.
        let film = fractions(quadratic, &[0.25, 0.75]);
        assert!(film.iter().all(|fraction| (fraction - LARGEST_GHOST_FRACTION).abs() < 1e-12), "{film:?}");
    }

    /// However near a particle is to a wall, folding leaves row 1 what the particle brings there; sums and adjoints
    /// stay.
    #[test]
    fn a_particle_alone_keeps_the_mass_of_its_rows() {
        for kernel in smooth() {
            for height in [0.0, 1e-9, 1e-3, 0.1, 0.3, 0.499, 0.7, 0.95] {
                let (grid, ghosts, nodes) = masses(kernel, &[height]);
                let mut limits = GhostFractions::default();
                limits.measure(&ghosts, &grid.folds, &nodes);
                let (mut folded, mut filled): (Vec<_>, Vec<_>) =
                    (0..nodes.len()).map(|n| ([nodes[n].mass], [(n as f64).sin()])).unzip();
                let inside = filled.clone();
                ghosts.fold(&limits, &mut folded, |_, _, _| {});
                ghosts.fill(&limits, &mut filled);
                for (n, [mass]) in folded.iter().enumerate().filter(|&(n, _)| grid.coordinates(n)[1] == 1) {
                    assert!(
                        *mass >= (1.0 - LARGEST_GHOST_FRACTION) * nodes[n].mass - 1e-15,
                        "{kernel:?} {height}: {mass} of {}",
                        nodes[n].mass
                    );
                }
                let sum: f64 = folded.iter().map(|[mass]| mass).sum();
                assert!((sum - 1.0).abs() < 1e-14);
                let dot = |a: &dyn Fn(usize) -> f64, b: &[[f64; 1]]| (0..b.len()).map(|n| a(n) * b[n][0]).sum::<f64>();
                let power = dot(&|n| folded[n][0], &inside) - dot(&|n| nodes[n].mass, &filled);
                assert!(power.abs() < 1e-14, "{kernel:?} {height}: {power}");
            }
        }
    }
}
