//! Discs and ellipses: rings of elements around a square whose sides are half chords, half arcs, so that no corner
//! degenerates.
//!
//! ```text
//! side k of the square:  p_k(t) = ½ ρ [(1 − t) e(θ_k) + t e(θ_k + π/2) + e(θ_k + π t/2)],
//!                        e(θ) = (cos θ, sin θ),  θ_k = (2k − 3) π/4
//! square:                p(u, v), blended from its sides (Coons);     rings: (1 − s) p_k(t) + s e(θ_k + π t/2)
//! ```

use super::frame::Frame;
use super::{QuadraticMesh, divisions};
use crate::geometry::Region;
use crate::math::Vector;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// ρ: distance of the square's corners from the centre, over the radius.
const CORNER: f64 = 0.55;

/// An ellipse that is longer, over its width, is meshed as other regions are.
const LARGEST_ASPECT_RATIO: f64 = 3.0;

/// The mesh of a disc or of an ellipse; `None` for other regions.
pub fn of_region(region: &Region, cell: f64) -> Option<QuadraticMesh> {
    let (frame, inner) = Frame::of(region);
    let (center, semi_axes) = match inner {
        Region::Sphere { center, radius } => (*center, [*radius; 2]),
        Region::Ellipsoid { center, semi_axes } => (*center, [semi_axes[0], semi_axes[1]]),
        _ => return None,
    };
    let (short, long) = (semi_axes[0].min(semi_axes[1]), semi_axes[0].max(semi_axes[1]));
    if long > LARGEST_ASPECT_RATIO * short {
        return None;
    }
    let mut mesh = unit_disc(long, cell);
    for x in &mut mesh.nodes {
        *x = frame.place([center[0] + semi_axes[0] * x[0], center[1] + semi_axes[1] * x[1], 0.0]);
    }
    Some(mesh)
}

/// The disc of radius 1, with elements for a radius [m].
pub(super) fn unit_disc(radius: f64, cell: f64) -> QuadraticMesh {
    // The sides of the square are 0.8 of a radius long, the quarters of the circle twice that.
    let (side, rings) = (divisions(1.2 * radius, cell), divisions(0.5 * radius, cell));
    let lines = 2 * side;
    let t = |i: usize| i as f64 / lines as f64;
    let mut mesh = QuadraticMesh::lattice(2, [side, side, 0], |at| square(t(at[0]), t(at[1])).to3());
    let number = |i: usize, j: usize| (j * (lines + 1) + i) as u32;
    let around = |c: usize| match (c / lines, c % lines) {
        (0, i) => number(i, 0),
        (1, i) => number(lines, i),
        (2, i) => number(lines - i, lines),
        (_, i) => number(0, lines - i),
    };
    let (columns, first) = (4 * lines, mesh.nodes.len());
    for row in 1..=2 * rings {
        let s = row as f64 / (2 * rings) as f64;
        let place = |c: usize| edge(c / lines, t(c % lines)) * (1.0 - s) + arc(c / lines, t(c % lines)) * s;
        mesh.nodes.extend((0..columns).map(|c| place(c).to3()));
    }
    let node = |row: usize, c: usize| match row {
        0 => around(c % columns),
        _ => (first + (row - 1) * columns + c % columns) as u32,
    };
    for (ring, sector) in (0..rings).flat_map(|ring| (0..columns / 2).map(move |sector| (ring, sector))) {
        mesh.elements.push((0..9).map(|a| node(2 * ring + a % 3, 2 * sector + a / 3)).collect());
    }
    mesh
}

/// The circle over side k of the square.
fn arc(k: usize, t: f64) -> Vector<2> {
    let angle = (2.0 * k as f64 - 3.0) * FRAC_PI_4 + FRAC_PI_2 * t;
    Vector([angle.cos(), angle.sin()])
}

/// Side k of the square.
fn edge(k: usize, t: f64) -> Vector<2> {
    (arc(k, 0.0) * (1.0 - t) + arc(k, 1.0) * t + arc(k, t)) * (0.5 * CORNER)
}

/// The square, from its sides.
fn square(u: f64, v: f64) -> Vector<2> {
    let corner = |k: usize| arc(k, 0.0) * CORNER;
    let between = edge(0, u) * (1.0 - v) + edge(2, 1.0 - u) * v + edge(3, 1.0 - v) * (1.0 - u) + edge(1, v) * u;
    let corners = (corner(0) * (1.0 - u) + corner(1) * u) * (1.0 - v) + (corner(3) * (1.0 - u) + corner(2) * u) * v;
    between - corners
}

#[cfg(test)]
mod tests {
    use super::super::tests::parabolic_disc;
    use super::*;

    #[test]
    fn a_disc_has_its_area_and_nodes_on_its_circle() {
        let disc = Region::Sphere { center: [0.3, -0.2, 0.0], radius: 0.1 };
        for (cell, side) in [(0.05, 2), (0.0125, 10)] {
            let mesh = QuadraticMesh::fill(&disc, cell, 2).unwrap();
            for &n in &mesh.set("surface").unwrap() {
                let [x, y, _] = mesh.nodes[n as usize];
                assert!(((x - 0.3).hypot(y + 0.2) - 0.1).abs() < 1e-15);
            }
            assert!((mesh.volume() / (0.01 * parabolic_disc(4 * side)) - 1.0).abs() < 1e-12, "{}", mesh.volume());
        }
    }

    #[test]
    fn an_ellipse_is_stretched() {
        let ellipse = Region::Ellipsoid { center: [0.0; 3], semi_axes: [2.0, 1.0, f64::INFINITY] };
        let mesh = QuadraticMesh::fill(&ellipse, 0.4, 2).unwrap();
        assert!((mesh.volume() / (2.0 * parabolic_disc(24)) - 1.0).abs() < 1e-12, "{}", mesh.volume());
    }
}
