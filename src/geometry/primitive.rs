//! Exact signed distance d and outward normal n = ∇d of the primitives.
//!
//! Each function returns (d, n). Where the nearest boundary point is not unique (a centre, an axis) n is
//! one of the possible directions.

use crate::math::Vector;

/// Signed distance [m] and outward unit normal.
pub type Distance = (f64, Vector<3>);

/// The direction of `v`, or `fallback` where it has none.
pub fn direction(v: Vector<3>, fallback: Vector<3>) -> Vector<3> {
    v.normalized().unwrap_or(fallback)
}

/// A unit vector perpendicular to the unit vector `a`.
pub fn perpendicular(a: Vector<3>) -> Vector<3> {
    let axis = (0..3).min_by(|&i, &j| a[i].abs().total_cmp(&a[j].abs())).unwrap_or(0);
    direction(a.cross(Vector::unit(axis)), Vector::unit(0))
}

/// The product of two regions whose distances are measured in perpendicular directions.
pub fn product(a: Distance, b: Distance) -> Distance {
    let ((d_a, n_a), (d_b, n_b)) = (a, b);
    if d_a > 0.0 && d_b > 0.0 {
        let d = d_a.hypot(d_b);
        (d, n_a * (d_a / d) + n_b * (d_b / d))
    } else if d_a >= d_b {
        a
    } else {
        b
    }
}

/// The layer lower ≤ x_i ≤ upper.
pub fn layer(axis: usize, lower: f64, upper: f64, x: f64) -> Distance {
    if lower - x > x - upper { (lower - x, -Vector::unit(axis)) } else { (x - upper, Vector::unit(axis)) }
}

/// The box lower ≤ x ≤ upper: the product of three layers.
pub fn cuboid(lower: [f64; 3], upper: [f64; 3], x: Vector<3>) -> Distance {
    let side = |axis: usize| layer(axis, lower[axis], upper[axis], x[axis]);
    product(product(side(0), side(1)), side(2))
}

/// The sphere |x − c| ≤ R.
pub fn sphere(centre: Vector<3>, radius: f64, x: Vector<3>) -> Distance {
    let r = x - centre;
    (r.norm() - radius, direction(r, Vector::unit(0)))
}

/// The half-space (x − p)·n ≤ 0.
pub fn half_space(point: Vector<3>, normal: Vector<3>, x: Vector<3>) -> Distance {
    ((x - point).dot(normal), normal)
}

/// The cylinder around the axis between two points, with flat ends.
pub fn cylinder(from: Vector<3>, to: Vector<3>, radius: f64, x: Vector<3>) -> Distance {
    let length = (to - from).norm();
    let axis = (to - from) / length;
    let along = (x - from).dot(axis);
    let radial = x - from - axis * along;
    let side = (radial.norm() - radius, direction(radial, perpendicular(axis)));
    let ends = if along < 0.5 * length { (-along, -axis) } else { (along - length, axis) };
    product(side, ends)
}

/// The ellipsoid Σ (x_i/e_i)² ≤ 1 about `centre`; an infinite semi-axis e_2 makes it an ellipse.
///
/// The nearest boundary point is e_i² y_i/(t + e_i²), where t solves Σ (e_i y_i/(t + e_i²))² = 1
/// (D. Eberly, *Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid*).
/// With m the least semi-axis, r_i = (e_i/m)² and z_i = |y_i|/e_i the unknown is u = 1 + t/m² > 0,
/// which keeps full precision next to the medial plane.
pub fn ellipsoid(centre: Vector<3>, semi_axes: [f64; 3], x: Vector<3>) -> Distance {
    const MEDIAL: f64 = 1e-14;
    let axes = if semi_axes[2].is_finite() { 3 } else { 2 };
    let y = x - centre;
    let least = (0..axes).min_by(|&i, &j| semi_axes[i].total_cmp(&semi_axes[j])).unwrap_or(0);
    let ratio = |i: usize| (semi_axes[i] / semi_axes[least]).powi(2);
    let scaled = |i: usize| {
        let z = y[i].abs() / semi_axes[i];
        if i == least { z.max(MEDIAL) } else { z }
    };
    let nearest = |i: usize, u: f64| ratio(i) * scaled(i) / (u + (ratio(i) - 1.0));
    let excess = |u: f64| (0..axes).map(|i| nearest(i, u).powi(2)).sum::<f64>() - 1.0;
    let (mut lo, mut hi) =
        (scaled(least), (0..axes).map(|i| (ratio(i) * scaled(i)).powi(2)).sum::<f64>().sqrt().max(1.0));
    loop {
        let mid = 0.5 * (lo + hi);
        if mid <= lo || mid >= hi {
            break;
        }
        if excess(mid) > 0.0 { lo = mid } else { hi = mid }
    }
    let foot = Vector::from_fn(|i| if i < axes { (semi_axes[i] * nearest(i, lo)).copysign(y[i]) } else { y[i] });
    let normal = Vector::from_fn(|i| if i < axes { foot[i] / semi_axes[i].powi(2) } else { 0.0 });
    let level: f64 = (0..axes).map(|i| (y[i] / semi_axes[i]).powi(2)).sum();
    let d = (y - foot).norm();
    (if level < 1.0 { -d } else { d }, direction(normal, Vector::unit(least)))
}
