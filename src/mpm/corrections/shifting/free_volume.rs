//! Free volume ∫N_I dx around nodes beside walls and planes (theory A.11).

use crate::mpm::Grid;
use crate::mpm::grid::Fold;
use crate::mpm::kernel::{Kernel, ShapeFunction, with_shape};

/// Rows of nodes next to a wall that lack a part of their support.
const ROWS: usize = 3;

/// Points per cell that integrate the shape functions.
const POINTS: usize = 64;

/// ∫N_I dx / hᴰ of the rows of nodes next to the ends of each axis.
pub(super) type WallRows<const D: usize> = [[[f64; ROWS]; 2]; D];

/// ∫N_I dx of a node over the volume of a cell.
pub(super) fn of_node<const D: usize>(grid: &Grid<D>, rows: &WallRows<D>, node: usize) -> f64 {
    let ijk = grid.coordinates(node);
    let along = |a: usize| {
        let ends = [ijk[a], grid.cells[a] - ijk[a]];
        let of_end = |end: usize| usize::try_from(ends[end]).ok().and_then(|row| rows[a][end].get(row)).copied();
        of_end(0).unwrap_or(1.0) * of_end(1).unwrap_or(1.0)
    };
    (0..D).map(along).product()
}

/// Free volumes of the rows of nodes next to walls.
pub(super) fn at_walls<const D: usize>(grid: &Grid<D>, kernel: Kernel) -> WallRows<D> {
    grid.folds.map(|folds| folds.map(|fold| with_shape!(kernel, shape => integrate(shape, fold))))
}

/// ∫N_I dx of the rows of nodes next to a wall, over the size of a cell.
fn integrate<const S: usize>(shape: impl ShapeFunction<S>, fold: Fold) -> [f64; ROWS] {
    let mut rows = [0.0; ROWS];
    let mut add = |row: i32, weight: f64| {
        if let Some(volume) = usize::try_from(row).ok().and_then(|row| rows.get_mut(row)) {
            *volume += weight / POINTS as f64;
        }
    };
    for point in 0..POINTS * (ROWS + 2) {
        let at = shape.at((point as f64 + 0.5) / POINTS as f64);
        for (i, weight) in at.weight.into_iter().enumerate() {
            match (at.first + i as i32, fold) {
                (row, Fold::Mirror) if row < 0 => add(-row, weight),
                (row, Fold::Extrapolate) if row < 0 => {
                    add(0, f64::from(1 - row) * weight);
                    add(1, f64::from(row) * weight);
                }
                (row, _) => add(row, weight),
            }
        }
    }
    rows
}

/// The fraction of a quadratic spline's integral in front of a plane at the distance `x` [cells] behind its node.
pub(super) fn fraction_beside(x: f64) -> f64 {
    match x {
        x if x <= -1.5 => 0.0,
        x if x < -0.5 => (x + 1.5).powi(3) / 6.0,
        x if x <= 0.5 => 0.5 + 0.75 * x - x.powi(3) / 3.0,
        x if x < 1.5 => 1.0 - (1.5 - x).powi(3) / 6.0,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpm::kernel::Quadratic;

    /// Of the integral of a quadratic spline on a wall a half lies inside; what its neighbour beyond the wall has
    /// inside, a forty-eighth, is folded: onto the first row inside by a mirror, linearly onto the first two rows else.
    #[test]
    fn free_volumes_at_walls() {
        let near = |rows: [f64; ROWS], exact: [f64; ROWS]| {
            rows.iter().zip(exact).for_each(|(row, exact)| assert!((row - exact).abs() < 1e-4, "{rows:?}"));
        };
        let (half, ghost) = (0.5, 1.0 / 48.0);
        near(integrate(Quadratic, Fold::Mirror), [half, 1.0, 1.0]);
        near(integrate(Quadratic, Fold::Extrapolate), [half + 2.0 * ghost, 1.0 - 2.0 * ghost, 1.0]);
    }

    /// The integral of the spline up to a plane, summed point by point.
    #[test]
    fn free_volumes_beside_planes() {
        for distance in [-2.0, -1.2, -0.5, 0.0, 0.3, 0.5, 1.1, 2.0] {
            let points = (0..40_000).map(|k| -2.0 + (f64::from(k) + 0.5) * 1e-4).filter(|x| *x < distance);
            let spline = |x: f64| match x.abs() {
                x if x < 0.5 => 0.75 - x * x,
                x if x < 1.5 => 0.5 * (1.5 - x).powi(2),
                _ => 0.0,
            };
            let exact: f64 = points.map(|x| spline(x) * 1e-4).sum();
            assert!((fraction_beside(distance) - exact).abs() < 1e-4, "{distance}");
        }
    }
}
