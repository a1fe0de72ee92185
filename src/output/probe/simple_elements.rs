//! The points of simplices and quadrilaterals that are nearest to a place, by their shape functions.

use crate::math::Vector;
use crate::math::dense::solve;

/// The place with these shape functions.
pub(super) fn blend(corners: &[Vector<3>], weights: &[f64]) -> Vector<3> {
    corners.iter().zip(weights).map(|(x, weight)| *x * *weight).sum()
}

/// Barycentric coordinates of the point of a simplex (a point to a tetrahedron) that is nearest to `x`.
pub(super) fn in_simplex(corners: &[Vector<3>], x: Vector<3>) -> Vec<f64> {
    let [first, others @ ..] = corners else { return Vec::new() };
    let sides: Vec<Vector<3>> = others.iter().map(|corner| *corner - *first).collect();
    // The foot of x in the plane of the simplex: Gram's matrix of its sides.
    let mut rows: Vec<Vec<f64>> = sides.iter().map(|a| sides.iter().map(|b| a.dot(*b)).collect()).collect();
    rows.iter_mut().zip(&sides).for_each(|(row, side)| row.push(side.dot(x - *first)));
    if let Some(inner) = solve(rows) {
        let weights: Vec<f64> = std::iter::once(1.0 - inner.iter().sum::<f64>()).chain(inner).collect();
        if weights.iter().all(|weight| *weight >= 0.0) {
            return weights;
        }
    }
    let face = |left_out: usize| {
        let face: Vec<Vector<3>> = (0..corners.len()).filter(|k| *k != left_out).map(|k| corners[k]).collect();
        let mut weights = in_simplex(&face, x);
        weights.insert(left_out, 0.0);
        weights
    };
    let distance = |weights: &Vec<f64>| (blend(corners, weights) - x).norm_squared();
    (0..corners.len()).map(face).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or_default()
}

/// Bilinear shape functions at the point of a quadrilateral that is nearest to `x`: Gauss–Newton in its square.
pub(super) fn in_quadrilateral(corners: &[Vector<3>], x: Vector<3>) -> Vec<f64> {
    const ROUNDS: usize = 30;
    let shape = |[s, t]: [f64; 2]| vec![(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t];
    let along_s = |t: f64| (corners[1] - corners[0]) * (1.0 - t) + (corners[2] - corners[3]) * t;
    let along_t = |s: f64| (corners[3] - corners[0]) * (1.0 - s) + (corners[2] - corners[1]) * s;
    let mut at = [0.5; 2];
    for _ in 0..ROUNDS {
        let (away, tangents) = (x - blend(corners, &shape(at)), [along_s(at[1]), along_t(at[0])]);
        let row = |a: Vector<3>| vec![a.dot(tangents[0]), a.dot(tangents[1]), a.dot(away)];
        let Some(step) = solve(tangents.map(row).to_vec()) else { break };
        at = std::array::from_fn(|i| (at[i] + step[i]).clamp(0.0, 1.0));
        // A side holds one of the two: the other moves along it.
        for (i, other) in [(0, 1), (1, 0)] {
            if at[i] > 0.0 && at[i] < 1.0 {
                continue;
            }
            let tangent = if other == 0 { along_s(at[1]) } else { along_t(at[0]) };
            let away = x - blend(corners, &shape(at));
            at[other] = (at[other] + away.dot(tangent) / tangent.norm_squared()).clamp(0.0, 1.0);
        }
    }
    shape(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = [f64; 3]> {
        [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64]
    }

    proptest! {
        /// A point made from weights is found again, and no point of the simplex is nearer to any other one.
        #[test]
        fn the_nearest_point_of_a_simplex(corners in proptest::collection::vec(point(), 2..5), x in point(), parts in proptest::collection::vec(0.01..1.0f64, 4)) {
            let corners: Vec<_> = corners.into_iter().map(Vector).collect();
            let sum: f64 = parts[..corners.len()].iter().sum();
            let weights: Vec<f64> = parts[..corners.len()].iter().map(|part| part / sum).collect();
            let inside = blend(&corners, &weights);
            prop_assert!((blend(&corners, &in_simplex(&corners, inside)) - inside).norm() < 1e-7);
            let found = in_simplex(&corners, Vector(x));
            prop_assert!(found.iter().all(|w| *w >= 0.0) && (found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!((blend(&corners, &found) - Vector(x)).norm() <= (inside - Vector(x)).norm() + 1e-7);
        }

        /// The two triangles that a flat quadrilateral is cut into cover it.
        #[test]
        fn the_nearest_point_of_a_quadrilateral(offset in proptest::collection::vec(-0.2..0.2f64, 8), x in point()) {
            let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let corners: Vec<Vector<3>> =
                (0..4).map(|k| Vector([square[k][0] + offset[2 * k], square[k][1] + offset[2 * k + 1], 0.0])).collect();
            let distance = |corners: &[Vector<3>], weights: &[f64]| (blend(corners, weights) - Vector(x)).norm();
            let found = distance(&corners, &in_quadrilateral(&corners, Vector(x)));
            let halves = [[0, 1, 2], [0, 2, 3]].map(|half| half.map(|k: usize| corners[k]));
            let wanted = halves.iter().map(|half| distance(half, &in_simplex(half, Vector(x)))).fold(f64::INFINITY, f64::min);
            prop_assert!((found - wanted).abs() < 1e-4, "{found} {wanted}");
        }
    }
}
