//! The point of a hexahedron that is nearest to a place.

use super::simple_elements::{blend, in_quadrilateral};
use crate::math::Vector;
use crate::math::dense::solve;
use crate::simulation::SIDES_OF_HEXAHEDRON;

/// Coordinates of the corners: those of the lower side, then those of the upper one.
const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

/// Trilinear shape functions at the point of a hexahedron that is nearest to `x`: Newton inside, else the nearest of its
/// sides.
pub(super) fn in_hexahedron(corners: &[Vector<3>], x: Vector<3>) -> Vec<f64> {
    inside_hexahedron(corners, x).unwrap_or_else(|| {
        let on_side = |side: &[usize; 4]| {
            let mut weights = vec![0.0; 8];
            let own = in_quadrilateral(&side.map(|corner| corners[corner]), x);
            side.iter().zip(own).for_each(|(&corner, weight)| weights[corner] = weight);
            weights
        };
        let distance = |weights: &Vec<f64>| (blend(corners, weights) - x).norm_squared();
        let sides = SIDES_OF_HEXAHEDRON.iter().map(on_side);
        sides.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or_default()
    })
}

/// Trilinear shape functions at a point inside of a hexahedron; `None` outside.
fn inside_hexahedron(corners: &[Vector<3>], x: Vector<3>) -> Option<Vec<f64>> {
    const ROUNDS: usize = 20;
    /// Convergence of the coordinates, and how far beyond a side still counts.
    const CLOSE: f64 = 1e-12;
    let mut at = [0.5; 3];
    for _ in 0..ROUNDS {
        let factor = |corner: usize, i: usize| if CORNERS[corner][i] == 1.0 { at[i] } else { 1.0 - at[i] };
        let shape: Vec<f64> = (0..8).map(|k| (0..3).map(|i| factor(k, i)).product()).collect();
        let slope = |k: usize, i: usize| {
            let others: f64 = (0..3).filter(|j| *j != i).map(|j| factor(k, j)).product();
            (2.0 * CORNERS[k][i] - 1.0) * others
        };
        let tangents: [Vector<3>; 3] =
            std::array::from_fn(|i| corners.iter().enumerate().map(|(k, corner)| *corner * slope(k, i)).sum());
        let away = x - blend(corners, &shape);
        let rows = (0..3).map(|i| vec![tangents[0][i], tangents[1][i], tangents[2][i], away[i]]).collect();
        let step = solve(rows)?;
        at = std::array::from_fn(|i| at[i] + step[i]);
        if step.iter().all(|step| step.abs() < CLOSE) {
            return at.iter().all(|c| (-CLOSE..=1.0 + CLOSE).contains(c)).then_some(shape);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A place inside is found again, and no place of the hexahedron is nearer to one outside.
        #[test]
        fn the_nearest_point_of_a_hexahedron(
            offset in proptest::collection::vec(-0.1..0.1f64, 24),
            inner in [0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64],
            x in [-1.0..2.0f64, -1.0..2.0f64, -1.0..2.0f64],
        ) {
            let corners: Vec<Vector<3>> =
                (0..8).map(|k| Vector(std::array::from_fn(|i| CORNERS[k][i] + offset[3 * k + i]))).collect();
            let part = |k: usize, i: usize| if CORNERS[k][i] == 1.0 { inner[i] } else { 1.0 - inner[i] };
            let weights: Vec<f64> = (0..8).map(|k| (0..3).map(|i| part(k, i)).product()).collect();
            let inside = blend(&corners, &weights);
            prop_assert!((blend(&corners, &in_hexahedron(&corners, inside)) - inside).norm() < 1e-9);
            let found = in_hexahedron(&corners, Vector(x));
            prop_assert!(found.iter().all(|w| *w >= -1e-9) && (found.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            prop_assert!((blend(&corners, &found) - Vector(x)).norm() <= (inside - Vector(x)).norm() + 1e-4);
        }
    }
}
