//! Any plane region: its triangles, each parted in three quadrilaterals at its centroid and the middles of its sides.
//!
//! Nodes on the outline of the triangles are moved onto that of the region, x ← x − d ∇d, so that sides are parabolas.

use super::QuadraticMesh;
use crate::geometry::Region;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::mesh::domain::planar::{bounded, triangulate};
use crate::mesh::domain::size::SizeField;
use hashbrown::HashMap;

/// A node on the outline is moved by this part of its side at most: a greater distance is that to another part of the
/// outline.
const LARGEST_OUTLINE_MOVE: f64 = 0.3;

/// The mesh of a bounded plane region.
///
/// # Errors
/// As [`triangulate`].
pub fn of_region(region: &Region, cell: f64) -> Result<QuadraticMesh, String> {
    let size = SizeField { coarse: 2.0 * cell, refined: Vec::new() };
    bounded(region, &size)?;
    let triangles = triangulate(region, &size)?;
    let mut parted = Parted::new(&triangles, region);
    triangles.elements().iter().for_each(|&nodes| parted.triangle(nodes));
    let Parted { nodes, elements, .. } = parted;
    let nodes = nodes.into_iter().map(Vector::to3).collect();
    Ok(QuadraticMesh { dimension: 2, nodes, elements, sets: Default::default() })
}

/// Triangles and what has been made of them.
struct Parted {
    nodes: Vec<Vector<2>>,
    elements: Vec<Vec<u32>>,
    /// The three nodes inside of each side, from the lower of its ends to the higher one.
    sides: HashMap<[u32; 2], [u32; 3]>,
}

impl Parted {
    /// The nodes on all sides.
    fn new(triangles: &Mesh<2, 3>, region: &Region) -> Self {
        let nodes = triangles.nodes().to_vec();
        let mut parted = Self { nodes, elements: Vec::new(), sides: HashMap::new() };
        let outline = triangles.boundary().iter().map(|&facet| triangles.facet_nodes(facet));
        for ends in outline {
            parted.side([ends[0], ends[1]], |x, length| onto(region, x, LARGEST_OUTLINE_MOVE * length));
        }
        for &[a, b, c] in triangles.elements() {
            [[a, b], [b, c], [c, a]].into_iter().for_each(|ends| parted.side(ends, |x, _| x));
        }
        parted
    }

    fn side(&mut self, ends: [u32; 2], place: impl Fn(Vector<2>, f64) -> Vector<2>) {
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        if self.sides.contains_key(&ends) {
            return;
        }
        let [a, b] = ends.map(|n| self.nodes[n as usize]);
        let length = (b - a).norm();
        let middle = place((a + b) * 0.5, length);
        // Quarters of the halves, not of the chord: then arcs of a circle are divided evenly.
        let own = [(a + middle) * 0.5, middle, (middle + b) * 0.5].map(|x| self.add(place(x, length)));
        self.sides.insert(ends, own);
    }

    fn add(&mut self, x: Vector<2>) -> u32 {
        self.nodes.push(x);
        self.nodes.len() as u32 - 1
    }

    /// The node at a quarter of a side from `a`, and its middle.
    fn half(&self, a: u32, b: u32) -> [u32; 2] {
        let [first, middle, last] = self.sides[&[a.min(b), a.max(b)]];
        [if a < b { first } else { last }, middle]
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        let at = |own: &Self, n: u32| own.nodes[n as usize];
        let middles: [u32; 3] = std::array::from_fn(|k| self.half(corners[k], corners[(k + 1) % 3])[1]);
        let centre = middles.iter().map(|&m| at(self, m)).sum::<Vector<2>>() / 3.0;
        let centre = self.add(centre);
        let spokes = middles.map(|m| self.add((at(self, m) + at(self, centre)) * 0.5));
        for k in 0..3 {
            let (next, last) = ((k + 1) % 3, (k + 2) % 3);
            let [ahead, _] = self.half(corners[k], corners[next]);
            let [behind, _] = self.half(corners[k], corners[last]);
            let sides = [ahead, spokes[k], spokes[last], behind].iter().map(|&n| at(self, n)).sum::<Vector<2>>();
            let ends = [corners[k], middles[k], centre, middles[last]].iter().map(|&n| at(self, n)).sum::<Vector<2>>();
            let middle = self.add(sides * 0.5 - ends * 0.25);
            self.elements.push(vec![
                corners[k],
                ahead,
                middles[k],
                behind,
                middle,
                spokes[k],
                middles[last],
                spokes[last],
                centre,
            ]);
        }
    }
}

/// The point of the outline of a region nearest to `x` [m], if it is within `farthest` [m]; else `x` itself.
fn onto(region: &Region, x: Vector<2>, farthest: f64) -> Vector<2> {
    let mut moved = x;
    for _ in 0..8 {
        let (distance, normal) = region.distance_and_normal(moved.to3());
        moved -= Vector([normal[0], normal[1]]) * distance;
    }
    if (moved - x).norm() <= farthest { moved } else { x }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{parabolic_disc, plate, without};
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_plate_with_a_hole_has_its_area_and_nodes_on_the_hole() {
        let hole = Region::Sphere { center: [1.0, 0.5, 0.0], radius: 0.3 };
        let mesh = QuadraticMesh::fill(&without(plate([0.0, 0.0], [2.0, 1.0]), hole.clone()), 0.1, 2).unwrap();
        assert_eq!(mesh.elements.len() % 3, 0);
        let surface = mesh.set("surface").unwrap();
        let on_hole = surface.iter().filter(|&&n| hole.signed_distance(mesh.nodes[n as usize]).abs() < 1e-12).count();
        assert!(on_hole >= 36, "{on_hole}");
        let exact = 2.0 - 0.09 * parabolic_disc(on_hole / 2);
        assert!((mesh.volume() - exact).abs() < 1e-12, "{} {exact}", mesh.volume());
    }

    #[test]
    fn a_triangle_and_a_union_have_their_areas() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.2, 0.8]].map(Vector);
        let polygon = crate::geometry::Polygon::new(corners.to_vec(), f64::NEG_INFINITY, f64::INFINITY).unwrap();
        let mesh = QuadraticMesh::fill(&Region::Polygon(polygon.into()), 0.1, 2).unwrap();
        assert!((mesh.volume() - 0.4).abs() < 1e-12, "{}", mesh.volume());
        // Two discs of radius 1 whose centres are 1 apart share 2π/3 − √3/2.
        let disc = |x: f64| Region::Sphere { center: [x, 0.0, 0.0], radius: 1.0 };
        let mesh = QuadraticMesh::fill(&Region::Union(vec![disc(0.0), disc(1.0)]), 0.1, 2).unwrap();
        let area = 2.0 * PI - (2.0 * PI / 3.0 - 0.75f64.sqrt());
        assert!((mesh.volume() / area - 1.0).abs() < 1e-5, "{}", mesh.volume() / area);
    }
}
