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

/// Elements along a side of the cube, at least: with one the ball would lack 3 % of its volume.
pub const LEAST_SIDE: usize = 2;

/// The lattice of lines on the faces of a cube, so many elements along each side.
pub struct Faces {
    side: usize,
    /// Lattice numbers of the nodes on the faces, ascending.
    outer: Vec<usize>,
    /// Number of each lattice node among those.
    place: Vec<usize>,
}

impl Faces {
    pub fn new(side: usize) -> Self {
        let mut faces = Self { side, outer: Vec::new(), place: vec![0; (2 * side + 1).pow(3)] };
        let on_face = |n: &usize| faces.at(*n).iter().any(|&i| i == 0 || i == 2 * side);
        faces.outer = (0..faces.place.len()).filter(on_face).collect();
        faces.outer.iter().enumerate().for_each(|(k, &n)| faces.place[n] = k);
        faces
    }

    /// Lattice coordinates of a node.
    fn at(&self, n: usize) -> [usize; 3] {
        let nodes = 2 * self.side + 1;
        [n % nodes, n / nodes % nodes, n / nodes / nodes]
    }

    /// Coordinates t of the nodes on the faces.
    fn coordinates(&self) -> impl Iterator<Item = [f64; 3]> {
        self.outer.iter().map(|&n| self.at(n).map(|i| i as f64 / self.side as f64 - 1.0))
    }

    /// Unit vectors to the nodes on the faces.
    pub fn directions(&self) -> Vec<Vector<3>> {
        self.coordinates().map(ball).collect()
    }

    /// So many shells of elements over the faces; `node` numbers the node in a row above a node on a face, which is
    /// given by its place among these and by its lattice number.
    pub fn shells(&self, shells: usize, node: impl Fn(usize, usize, usize) -> u32) -> Vec<Vec<u32>> {
        let (side, nodes) = (self.side, 2 * self.side + 1);
        let mut elements = Vec::new();
        for (axis, is_upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            // Outward with the right hand.
            let [u, v] = if is_upper { [(axis + 1) % 3, (axis + 2) % 3] } else { [(axis + 2) % 3, (axis + 1) % 3] };
            for cell in 0..side * side * shells {
                let corner = [2 * (cell % side), 2 * (cell / side % side), 2 * (cell / side / side)];
                let own = |a: usize| {
                    let mut at = [0; 3];
                    at[axis] = if is_upper { 2 * side } else { 0 };
                    (at[u], at[v]) = (corner[0] + a % 3, corner[1] + a / 3 % 3);
                    let number = at[0] + nodes * (at[1] + nodes * at[2]);
                    node(corner[2] + a / 9, self.place[number], number)
                };
                elements.push((0..27).map(own).collect());
            }
        }
        elements
    }
}

/// The ball of radius 1, with elements for a radius [m].
fn unit_ball(radius: f64, cell: f64) -> QuadraticMesh {
    // The sides of the cube are 0.6 to 0.9 of a radius long, those of its shadow on the sphere 1.2 to 1.6.
    let (side, shells) = (divisions(1.1 * radius, cell).max(LEAST_SIDE), divisions(0.5 * radius, cell));
    let mut mesh = QuadraticMesh::lattice(3, [side; 3], |at| cube(at.map(|i| i as f64 / side as f64 - 1.0)).0);
    let (faces, first) = (Faces::new(side), mesh.nodes.len());
    for row in 1..=2 * shells {
        let s = row as f64 / (2 * shells) as f64;
        mesh.nodes.extend(faces.coordinates().map(|t| (cube(t) * (1.0 - s) + ball(t) * s).0));
    }
    mesh.elements.extend(faces.shells(shells, |row, place, number| match row {
        0 => number as u32,
        _ => (first + (row - 1) * faces.outer.len() + place) as u32,
    }));
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
