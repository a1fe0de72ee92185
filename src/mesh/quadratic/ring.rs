//! Rings, tubes and hollow balls: a disc, cylinder or ball without a smaller one inside of it.
//!
//! ```text
//! x(s, e) = (1 − s) (c + r e) + s (C + R e),   s ∈ [0, 1],   |C − c| + r < R
//! e: unit vectors, evenly around a ring, through the faces of a cube on a ball;   c, r: centre and radius of the hole
//! ```

use super::frame::Frame;
use super::{ElementSize, QuadraticMesh, ball, divisions, extrude};
use crate::geometry::Region;
use crate::math::Vector;
use std::f64::consts::{PI, TAU};

/// Elements around a ring, at least: with these its area lacks 4e-4.
const LEAST_AROUND: usize = 8;

/// A hole of a tube may end before the tube does by this part of its length: rounding.
const ROUNDING: f64 = 1e-9;

/// A disc or ball and the one that is taken from it.
struct Hollow {
    /// Centres of hole and outside [m].
    centers: [Vector<3>; 2],
    /// Their radii [m].
    radii: [f64; 2],
}

/// The mesh of a ring in 2D, of a hollow ball or a tube in 3D; `None` for other regions.
pub fn of_region(region: &Region, size: ElementSize, dimension: usize) -> Option<QuadraticMesh> {
    let (frame, [whole, taken]) = parts(region)?;
    if let Some(hollow) = Hollow::of(whole, taken, dimension) {
        let mut mesh = if dimension == 2 { hollow.ring(size) } else { hollow.shells(size) };
        mesh.nodes.iter_mut().for_each(|x| *x = frame.place(*x));
        return Some(mesh);
    }
    if dimension == 3 { tube(&frame, whole, taken, size) } else { None }
}

/// A region and the single one that is taken from it, with the motion of both.
fn parts(region: &Region) -> Option<(Frame, [&Region; 2])> {
    let (frame, inner) = Frame::of(region);
    let Region::Intersection(members) = inner else { return None };
    let [whole, Region::Complement(taken)] = &members[..] else { return None };
    let taken = match &**taken {
        Region::Union(all) if all.len() == 1 => &all[0],
        one => one,
    };
    Some((frame, [whole, taken]))
}

/// Centre [m] and radius [m] of a disc or ball.
fn round(region: &Region, dimension: usize) -> Option<(Vector<3>, f64)> {
    let (frame, inner) = Frame::of(region);
    let &Region::Sphere { center, radius } = inner else { return None };
    let center = Vector(frame.place(center));
    Some((if dimension == 2 { Vector([center[0], center[1], 0.0]) } else { center }, radius))
}

impl Hollow {
    fn of(whole: &Region, taken: &Region, dimension: usize) -> Option<Self> {
        let ((outside, large), (hole, small)) = (round(whole, dimension)?, round(taken, dimension)?);
        let hollow = Self { centers: [hole, outside], radii: [small, large] };
        ((outside - hole).norm() + small < large).then_some(hollow)
    }

    /// The place at the part s of the way from the hole to the outside, in the direction of a unit vector [m].
    fn place(&self, s: f64, e: Vector<3>) -> [f64; 3] {
        let [hole, outside] = [0, 1].map(|k| self.centers[k] + e * self.radii[k]);
        (hole * (1.0 - s) + outside * s).0
    }

    fn layers(&self, size: ElementSize) -> usize {
        size.divisions(self.radii[1] - self.radii[0])
    }

    fn mean_radius(&self) -> f64 {
        0.5 * (self.radii[0] + self.radii[1])
    }

    fn ring(&self, size: ElementSize) -> QuadraticMesh {
        let (layers, sectors) = (self.layers(size), divisions(TAU * self.mean_radius(), size.cell).max(LEAST_AROUND));
        let columns = 2 * sectors;
        let at = |row: usize, column: usize| {
            let (sin, cos) = (TAU * column as f64 / columns as f64).sin_cos();
            self.place(row as f64 / (2 * layers) as f64, Vector([cos, sin, 0.0]))
        };
        let node = |row: usize, column: usize| (row * columns + column % columns) as u32;
        let element =
            |layer: usize, sector: usize| (0..9).map(|a| node(2 * layer + a % 3, 2 * sector + a / 3)).collect();
        QuadraticMesh {
            dimension: 2,
            nodes: (0..=2 * layers).flat_map(|row| (0..columns).map(move |column| at(row, column))).collect(),
            elements: (0..layers).flat_map(|n| (0..sectors).map(move |sector| element(n, sector))).collect(),
            sets: Default::default(),
        }
    }

    fn shells(&self, size: ElementSize) -> QuadraticMesh {
        let faces = ball::Faces::new(divisions(0.5 * PI * self.mean_radius(), size.cell).max(ball::LEAST_SIDE));
        let (layers, count) = (self.layers(size), faces.directions().len());
        let row =
            |row: usize| faces.directions().into_iter().map(move |e| self.place(row as f64 / (2 * layers) as f64, e));
        QuadraticMesh {
            dimension: 3,
            nodes: (0..=2 * layers).flat_map(row).collect(),
            elements: faces.shells(layers, |row, place, _| (row * count + place) as u32),
            sets: Default::default(),
        }
    }
}

/// The mesh of a cylinder without one along the same axis that reaches through it.
fn tube(frame: &Frame, whole: &Region, taken: &Region, size: ElementSize) -> Option<QuadraticMesh> {
    let ((outer, whole), (inner, taken)) = (Frame::of(whole), Frame::of(taken));
    let (Region::Cylinder { from, to, radius }, Region::Cylinder { from: start, to: end, radius: hole }) =
        (whole, taken)
    else {
        return None;
    };
    let [from, to] = [from, to].map(|x| Vector(outer.place(*x)));
    let [start, end] = [start, end].map(|x| Vector(inner.place(*x)));
    let (length, axis) = ((to - from).norm(), (to - from).normalized()?);
    let [lower, upper] = [start, end].map(|x| (x - from).dot(axis) / length);
    let off = [start, end].map(|x| x - from - axis * (x - from).dot(axis));
    let through = lower.min(upper) <= ROUNDING && lower.max(upper) >= 1.0 - ROUNDING;
    if !through || off.iter().any(|off| off.norm() > ROUNDING * radius) || hole >= radius {
        return None;
    }
    let ring = Hollow { centers: [Vector([0.0; 3]); 2], radii: [*hole, *radius] }.ring(size);
    Some(extrude::extruded(&ring, [0.0, length], size, &frame.after(&Frame::along(axis, from.0))))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{parabolic_disc, without};
    use super::*;

    fn disc(x: f64, radius: f64) -> Region {
        Region::Sphere { center: [x, 0.2, 0.1], radius }
    }

    fn rod(z: [f64; 2], radius: f64) -> Region {
        Region::Cylinder { from: [0.5, 0.0, z[0]], to: [0.5, 0.0, z[1]], radius }
    }

    /// Nodes on the surface are on its two circles, at most half an element's edge apart.
    #[test]
    fn a_thin_ring_has_its_area_and_nodes_on_both_circles() {
        let mesh = QuadraticMesh::fill(&without(disc(0.3, 0.1), disc(0.3, 0.098)), 0.02, 2).unwrap();
        assert_eq!(mesh.elements.len(), 31);
        let exact = (0.01 - 0.098 * 0.098) * parabolic_disc(31);
        assert!((mesh.volume() / exact - 1.0).abs() < 1e-9, "{}", mesh.volume());
        for n in mesh.set("surface").unwrap() {
            let [x, y, _] = mesh.nodes[n as usize];
            let r = (x - 0.3).hypot(y - 0.2);
            assert!((r - 0.1).abs().min((r - 0.098).abs()) < 1e-15);
        }
        assert_eq!(mesh.thinnest().elements, 1);
    }

    #[test]
    fn a_hole_off_the_middle_is_followed() {
        let mesh = QuadraticMesh::fill(&without(disc(0.3, 0.1), disc(0.34, 0.05)), 0.01, 2).unwrap();
        assert!((mesh.volume() / (PI * (0.01 - 0.0025)) - 1.0).abs() < 1e-5, "{}", mesh.volume());
        assert!((mesh.thinnest().length - 0.01).abs() < 2e-4);
    }

    #[test]
    fn hollow_balls_and_tubes_have_their_volumes() {
        let shell = QuadraticMesh::fill(&without(disc(0.3, 0.1), disc(0.3, 0.09)), 0.02, 3).unwrap();
        let exact = 4.0 / 3.0 * PI * (1e-3 - 0.09f64.powi(3));
        assert!((shell.volume() / exact - 1.0).abs() < 1e-3, "{}", shell.volume() / exact);
        let tube = QuadraticMesh::fill(&without(rod([1.0, 3.0], 0.2), rod([0.0, 3.0], 0.1)), 0.1, 3).unwrap();
        assert_eq!(tube.elements.len(), 9 * 20);
        assert!((tube.volume() / (2.0 * 0.03 * parabolic_disc(9)) - 1.0).abs() < 1e-12, "{}", tube.volume());
        let [lower, upper] = tube.extent();
        assert!((lower[2] - 1.0).abs() < 1e-12 && (upper[2] - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_hole_that_ends_inside_of_a_cylinder_is_no_tube() {
        let cup = without(rod([0.0, 3.0], 0.2), rod([1.0, 4.0], 0.1));
        assert!(QuadraticMesh::fill(&cup, 0.1, 3).is_err());
    }
}
