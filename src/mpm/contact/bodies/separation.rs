//! The plane of widest margin between two clouds of points: it halves the shortest line between their convex hulls
//! (Bennett & Bredensteiner 2000), which the algorithm of Gilbert, Johnson & Keerthi (1988) finds (theory D.14).
//!
//! ```text
//! v = argmin |v|,  v in hull{b} − hull{a}:     a simplex S of differences b − a grows by the support point
//! w = argmin v·(b − a)                          until  |v|² − v·w ≤ ε |v|²;   v ← point of hull S next to 0
//! ```
//!
//! Against a flat face the normal is that of the face, for any shape of the other body: a disc or the corner of a block
//! slides over it without resistance. Fits of a plane to whole clouds, and gradients of mass, are tilted there.

use crate::math::Vector;
use crate::math::dense::solve_semidefinite;

/// Pivots below this part of the largest diagonal entry are round-off.
pub(super) const LEAST_PIVOT: f64 = 1e-12;

/// Relative accuracy of |v|²: normals to 10⁻⁴.
const ACCURACY: f64 = 1e-8;
const ITERATIONS: usize = 64;

/// The shortest vector from the hull of `first` to that of `second`, starting from a guess of its direction; `None`
/// if the hulls meet or a cloud is empty.
pub fn separation<const D: usize>(first: &[Vector<D>], second: &[Vector<D>], guess: Vector<D>) -> Option<Vector<D>> {
    let support = |direction: Vector<D>| {
        let height = |x: &&Vector<D>| x.dot(direction);
        let a = first.iter().max_by(|x, y| height(x).total_cmp(&height(y)))?;
        let b = second.iter().min_by(|x, y| height(x).total_cmp(&height(y)))?;
        Some(*b - *a)
    };
    let mut v = support(guess)?;
    let mut simplex = vec![v];
    for _ in 0..ITERATIONS {
        let square = v.norm_squared();
        let w = support(v)?;
        if square - v.dot(w) <= ACCURACY * square {
            break;
        }
        simplex.push(w);
        v = reduce(&mut simplex);
        if simplex.len() > D {
            return None;
        }
    }
    (v.norm_squared() > 0.0).then_some(v)
}

/// The point of a simplex's hull next to the origin; vertices that it doesn't need are dropped.
fn reduce<const D: usize>(simplex: &mut Vec<Vector<D>>) -> Vector<D> {
    let (mut best, mut kept) = (simplex[0], 1);
    for subset in 1..1_u32 << simplex.len() {
        if subset.count_ones() as usize > D + 1 {
            continue;
        }
        let face = simplex.iter().enumerate().filter(|(i, _)| subset >> i & 1 == 1).map(|(_, &x)| x);
        if let Some(v) = next_to_origin(face).filter(|v| v.norm_squared() < best.norm_squared()) {
            (best, kept) = (v, subset);
        }
    }
    let mut index = 0;
    simplex.retain(|_| {
        index += 1;
        kept >> (index - 1) & 1 == 1
    });
    best
}

/// The point next to the origin of the plane through the vertices of a face, if it lies within the face.
fn next_to_origin<const D: usize>(mut face: impl Iterator<Item = Vector<D>>) -> Option<Vector<D>> {
    let corner = face.next()?;
    let edges: Vec<Vector<D>> = face.map(|x| x - corner).collect();
    let (mut matrix, mut right) = ([[0.0; 4]; 4], [0.0; 4]);
    for (i, e) in edges.iter().enumerate() {
        right[i] = -e.dot(corner);
        for (j, f) in edges.iter().enumerate() {
            matrix[i][j] = e.dot(*f);
        }
    }
    let weights = solve_semidefinite(matrix, right, LEAST_PIVOT);
    let inside = weights.iter().all(|s| *s >= 0.0) && weights.iter().sum::<f64>() <= 1.0;
    inside.then(|| edges.iter().zip(weights).fold(corner, |x, (e, s)| x + *e * s))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two boxes, corner to corner, edge to face and face to face: known shortest lines.
    #[test]
    fn boxes_are_as_far_apart_as_their_nearest_points() {
        let corners = |centre: [f64; 3]| -> Vec<Vector<3>> {
            let sign = |n: usize, a: usize| if n >> a & 1 == 1 { 0.5 } else { -0.5 };
            (0..8).map(|n| Vector(std::array::from_fn(|a| centre[a] + sign(n, a)))).collect()
        };
        let a = corners([0.0; 3]);
        for (centre, expected) in [
            ([2.0, 3.0, 2.5], [1.0, 2.0, 1.5]),
            ([0.3, 3.0, 2.5], [0.0, 2.0, 1.5]),
            ([0.3, -0.2, -4.0], [0.0, 0.0, -3.0]),
        ] {
            let b = corners(centre);
            let v = separation(&a, &b, Vector([0.3, 0.2, 0.9])).unwrap();
            assert!((v - Vector(expected)).norm() < 1e-7, "{centre:?}: {v:?}");
        }
        let b = corners([0.7, 0.3, 0.2]);
        assert!(separation(&a, &b, Vector([0.3, 0.2, 0.9])).is_none(), "they overlap");
    }

    /// The nearest points of two polygons on circles lie within a sagitta of the centre line, over many turns.
    #[test]
    fn polygons_are_as_far_apart_as_their_circles() {
        let circle = |centre: Vector<2>, turn: f64| -> Vec<Vector<2>> {
            let angle = |k: usize| turn + k as f64 * std::f64::consts::TAU / 48.0;
            (0..48).map(|k| centre + Vector([angle(k).cos(), angle(k).sin()])).collect()
        };
        for k in 0..20 {
            let (a, b) = (circle(Vector::ZERO, 0.01 * f64::from(k)), circle(Vector([1.8, 1.6]), 0.003 * f64::from(k)));
            let v = separation(&a, &b, Vector([1.0, 0.0])).unwrap();
            let expected = 1.8_f64.hypot(1.6) - 2.0;
            assert!((0.0..0.005).contains(&(v.norm() - expected)), "{}", v.norm() - expected);
            let widest = a.iter().map(|x| x.dot(v)).fold(f64::MIN, f64::max);
            let nearest = b.iter().map(|x| x.dot(v)).fold(f64::MAX, f64::min);
            assert!((nearest - widest - v.norm_squared()).abs() < 1e-6, "the plane touches neither");
        }
    }
}
