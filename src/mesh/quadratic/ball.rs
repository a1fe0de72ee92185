//! Balls and ellipsoids: shells of elements around a cube with faces that are half flat, half spherical, so that no
//! corner degenerates.
//!
//! ```text
//! t ∈ [−1, 1]³,   x_i = √2 sin(π t_i/4)                                         even angles along the middle of a face
//! ball:    m_i = x_i (1 − ½ (x_j² + x_k²) + ⅓ x_j² x_k²)^½                      |m| = 1 on the faces of t
//! cube:    p = ½ ρ (t/√3 + m);         shells over its faces: (1 − s) p + s m
//! ```

use super::frame::Frame;
use super::{QuadraticMesh, divisions};
use crate::geometry::Region;
use crate::math::Vector;
use std::f64::consts::{FRAC_PI_4, SQRT_2};

/// ρ: distance of the cube's corners from the centre, over the radius.
const CORNER: f64 = 0.55;

/// An ellipsoid that is longer, over its least width, isn't meshed: its elements would be as much longer than wide.
const LARGEST_ASPECT_RATIO: f64 = 3.0;

/// The mesh of a ball or of an ellipsoid; `None` for other regions.
pub fn of_region(region: &Region, cell: f64) -> Option<QuadraticMesh> {
    let (frame, inner) = Frame::of(region);
    let (center, semi_axes) = match inner {
        Region::Sphere { center, radius } => (*center, [*radius; 3]),
        Region::Ellipsoid { center, semi_axes } => (*center, *semi_axes),
        _ => return None,
    };
    let (short, long) =
        (semi_axes.iter().copied().fold(f64::INFINITY, f64::min), semi_axes.into_iter().fold(0.0, f64::max));
    if long > LARGEST_ASPECT_RATIO * short {
        return None;
    }
    let mut mesh = unit_ball(long, cell);
    for x in &mut mesh.nodes {
        *x = frame.place(std::array::from_fn(|i| center[i] + semi_axes[i] * x[i]));
    }
    Some(mesh)
}

/// The ball of radius 1, with elements for a radius [m].
fn unit_ball(radius: f64, cell: f64) -> QuadraticMesh {
    // The sides of the cube are 0.6 to 0.9 of a radius long, those of its shadow on the sphere 1.2 to 1.6.
    // At least two along a side: with one the ball would lack 3 % of its volume.
    let (side, shells) = (divisions(1.1 * radius, cell).max(2), divisions(0.5 * radius, cell));
    let lines = 2 * side;
    let t = |at: [usize; 3]| at.map(|i| i as f64 / side as f64 - 1.0);
    let mut mesh = QuadraticMesh::lattice(3, [side; 3], |at| cube(t(at)).0);
    let number = |[i, j, k]: [usize; 3]| i + (lines + 1) * (j + (lines + 1) * k);
    let at = |n: usize| [n % (lines + 1), n / (lines + 1) % (lines + 1), n / (lines + 1).pow(2)];
    let outer: Vec<usize> = (0..mesh.nodes.len()).filter(|&n| at(n).iter().any(|&i| i == 0 || i == lines)).collect();
    let mut place = vec![0; mesh.nodes.len()];
    outer.iter().enumerate().for_each(|(k, &n)| place[n] = k);
    let first = mesh.nodes.len();
    for row in 1..=2 * shells {
        let s = row as f64 / (2 * shells) as f64;
        mesh.nodes.extend(outer.iter().map(|&n| (cube(t(at(n))) * (1.0 - s) + ball(t(at(n))) * s).0));
    }
    let node = |row: usize, n: usize| match row {
        0 => n as u32,
        _ => (first + (row - 1) * outer.len() + place[n]) as u32,
    };
    for (axis, is_upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
        // Outward with the right hand.
        let [u, v] = if is_upper { [(axis + 1) % 3, (axis + 2) % 3] } else { [(axis + 2) % 3, (axis + 1) % 3] };
        for cell in 0..side * side * shells {
            let corner = [2 * (cell % side), 2 * (cell / side % side), 2 * (cell / side / side)];
            let own = |a: usize| {
                let mut at = [0; 3];
                (at[axis], at[u], at[v]) = (if is_upper { lines } else { 0 }, corner[0] + a % 3, corner[1] + a / 3 % 3);
                node(corner[2] + a / 9, number(at))
            };
            mesh.elements.push((0..27).map(own).collect());
        }
    }
    mesh
}

/// The map of the cube to the ball, m.
fn ball(t: [f64; 3]) -> Vector<3> {
    let x = t.map(|t| SQRT_2 * (FRAC_PI_4 * t).sin());
    let square = |i: usize| x[i % 3].powi(2);
    Vector::from_fn(|i| {
        let (a, b) = (square(i + 1), square(i + 2));
        x[i] * (1.0 - 0.5 * (a + b) + a * b / 3.0).sqrt()
    })
}

/// The cube, p.
fn cube(t: [f64; 3]) -> Vector<3> {
    (Vector(t) / 3f64.sqrt() + ball(t)) * (0.5 * CORNER)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// With quadratic facets the volume of a ball converges with the fourth order.
    #[test]
    fn a_ball_has_its_volume_and_nodes_on_its_sphere() {
        let center = [0.3, -0.2, 0.1];
        let region = Region::Sphere { center, radius: 0.1 };
        let error = |cell: f64| {
            let mesh = QuadraticMesh::fill(&region, cell, 3).unwrap();
            for &n in &mesh.set("surface").unwrap() {
                assert!(((Vector(mesh.nodes[n as usize]) - Vector(center)).norm() - 0.1).abs() < 1e-15);
            }
            1.0 - mesh.volume() / (4.0 / 3.0 * PI * 1e-3)
        };
        let [coarse, fine] = [0.05, 0.025].map(error);
        assert!(coarse.abs() < 5e-3 && fine.abs() < coarse.abs() / 12.0, "{coarse} {fine}");
    }

    #[test]
    fn an_ellipsoid_is_stretched_and_a_needle_refused() {
        let ellipsoid = |semi_axes| Region::Ellipsoid { center: [0.0; 3], semi_axes };
        let mesh = QuadraticMesh::fill(&ellipsoid([2.0, 1.0, 1.5]), 0.5, 3).unwrap();
        assert!((mesh.volume() / (4.0 / 3.0 * PI * 3.0) - 1.0).abs() < 1e-3, "{}", mesh.volume());
        assert_eq!(mesh.sets["right"].len(), 1);
        assert!(QuadraticMesh::fill(&ellipsoid([4.0, 1.0, 1.0]), 0.5, 3).unwrap_err().contains("Gmsh"));
    }
}
