//! Meshes of solids: quadrilaterals with 9 nodes in 2D, hexahedra with 27 nodes in 3D.
//!
//! ```text
//! x(ξ) = Σ_a N_a(ξ) x_a,   N_a = Π_k L_{a_k}(ξ_k),   L_0 = ½ ξ (ξ − 1),  L_1 = 1 − ξ²,  L_2 = ½ ξ (ξ + 1),
//!                                                   ξ_k ∈ [−1, 1]
//! local node a = a_0 + 3 a_1 (+ 9 a_2);      det ∂x/∂ξ > 0 in every element
//! ```
//!
//! [`QuadraticMesh::fill`] makes one of a region, the first that fits of
//!
//! | region | mesh | file |
//! |---|---|---|
//! | box, also one whose ends other shapes cut off | block of rows | `block` |
//! | closed surface of triangles from a file | cells of a lattice inside of it | `lattice` |
//! | disc, ball or cylinder with a hole | rings, shells or tubes around the hole | `ring` |
//! | ball, ellipsoid | shells around a cube | `ball` |
//! | other regions in space: cylinders, polygons with heights | the plane mesh, drawn along an axis | `extrude` |
//! | disc, ellipse | rings around a square | `disc` |
//! | other plane regions | triangles, each parted in three | `split` |
//!
//! [`QuadraticFile`] (`file`) reads one from a Gmsh file; triangles, tetrahedra and elements of first order become such
//! elements in `raised`.

mod ball;
mod block;
mod disc;
mod extrude;
mod file;
mod frame;
mod lattice;
mod measure;
mod patches;
mod raised;
mod ring;
mod split;
mod thickness;

pub use file::QuadraticFile;
pub use measure::Deviation;
pub use patches::SurfacePatches;
pub use thickness::Thickness;

use crate::geometry::Region;
use crate::math::Vector;
use crate::mesh::domain::size::too_many;
use crate::mesh::side_names;
use std::collections::BTreeMap;

/// Gmsh's number of the node at each place of a quadrilateral of ours: corners first, then the middles of edges and of
/// the element (Gmsh reference manual, section on node ordering).
const QUADRILATERAL: [usize; 9] = [0, 4, 1, 7, 8, 5, 3, 6, 2];

/// Nodes this near to a side or region, over the extent of the mesh, lie on it.
const DISTANCE_ON_SIDE: f64 = 1e-9;

/// A mesh of quadrilaterals with 9 nodes or hexahedra with 27.
#[derive(Debug, Clone, PartialEq)]
pub struct QuadraticMesh {
    /// 2 or 3.
    pub dimension: usize,
    /// Node positions [m]; in 2D the third component is zero.
    pub nodes: Vec<[f64; 3]>,
    /// Nodes of each element, 3ᴰ of them in the order of the module's head.
    pub elements: Vec<Vec<u32>>,
    /// Named sets of nodes, in ascending order.
    pub sets: BTreeMap<String, Vec<u32>>,
}

/// Size of the elements of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementSize {
    /// Length of edges [m].
    pub cell: f64,
    /// Number of elements across the region, at least.
    pub across: usize,
}

impl ElementSize {
    /// Number of elements along a length [m].
    fn divisions(self, length: f64) -> usize {
        divisions(length, self.cell).max(self.across)
    }
}

impl QuadraticMesh {
    /// A mesh of a bounded region whose elements have edges of about `cell` [m], at least one element along every
    /// extent.
    ///
    /// Sides of a box are the sets `left`, `right` (x), `front`, `back` (y, in 3D) and `bottom`, `top` (the last axis),
    /// also where the box is turned or an end of it is cut off; of other regions they are the nodes farthest in these
    /// directions.
    ///
    /// # Errors
    /// A region that is not bounded, more elements than a mesh can have, a region in 3D that can't be meshed, elements
    /// that fold.
    ///
    /// ```
    /// use lateen::geometry::Region;
    /// use lateen::mesh::QuadraticMesh;
    ///
    /// let bar = Region::Box { lower: [0.0, 0.0, f64::NEG_INFINITY], upper: [3.0, 1.0, f64::INFINITY] };
    /// let mesh = QuadraticMesh::fill(&bar, 0.5, 2).unwrap();
    /// assert_eq!((mesh.elements.len(), mesh.nodes.len(), mesh.sets["left"].len()), (12, 13 * 5, 5));
    /// assert!((mesh.volume() - 3.0).abs() < 1e-12);
    /// ```
    pub fn fill(region: &Region, cell: f64, dimension: usize) -> Result<Self, String> {
        Self::fill_across(region, ElementSize { cell, across: 1 }, dimension)
    }

    /// The same with at least so many elements across boxes, rings, tubes, hollow balls and polygons with heights, which
    /// may be longer than they are wide there.
    ///
    /// # Errors
    /// As [`QuadraticMesh::fill`].
    pub fn fill_across(region: &Region, size: ElementSize, dimension: usize) -> Result<Self, String> {
        let cell = size.cell;
        let bounds = region.bounds();
        if !bounds.is_bounded(dimension) {
            return Err("the region of a solid must have an end in every direction".into());
        }
        let count = (0..dimension).map(|i| ((bounds.upper[i] - bounds.lower[i]) / cell).max(1.0)).product();
        if let Some(why) = too_many(count) {
            return Err(why);
        }
        let mut mesh = Self::unchecked(region, size, dimension)?;
        if mesh.sets.is_empty() {
            mesh.name_sides();
        }
        mesh.check()?;
        Ok(mesh)
    }

    fn unchecked(region: &Region, size: ElementSize, dimension: usize) -> Result<Self, String> {
        let cell = size.cell;
        if let Some(mesh) = block::of_region(region, size, dimension) {
            return Ok(mesh);
        }
        if let (3, Some(triangles)) = (dimension, region.triangles()) {
            return lattice::of_surface(triangles, cell);
        }
        if let Some(mesh) = ring::of_region(region, size, dimension) {
            return Ok(mesh);
        }
        if dimension == 3 {
            return ball::of_region(region, cell).map_or_else(|| extrude::of_region(region, size), Ok);
        }
        match disc::of_region(region, cell) {
            Some(mesh) => Ok(mesh),
            None => split::of_region(region, cell),
        }
    }

    /// Elements must not fold.
    fn check(&self) -> Result<(), String> {
        let Some((element, x)) = self.folded() else { return Ok(()) };
        let place = x[..self.dimension].iter().map(|c| format!("{c:.6}")).collect::<Vec<_>>().join(", ");
        Err(format!("element {element} of the solid is folded at ({place})"))
    }

    /// The nodes farthest in the directions of the axes are the sides.
    fn name_sides(&mut self) {
        let extent = self.extent();
        let most = (0..self.dimension).map(|i| extent[1][i] - extent[0][i]).fold(0.0, f64::max);
        for axis in 0..self.dimension {
            let names = if self.dimension == 2 { side_names::<2>(axis) } else { side_names::<3>(axis) };
            for (end, name) in names.into_iter().enumerate() {
                let at_end = |x: &[f64; 3]| (x[axis] - extent[end][axis]).abs() <= DISTANCE_ON_SIDE * most;
                let nodes = (0u32..).zip(&self.nodes).filter(|(_, x)| at_end(x)).map(|(node, _)| node).collect();
                self.sets.insert(name.to_owned(), nodes);
            }
        }
    }

    /// Lower and upper corner of the box around all nodes [m].
    pub fn extent(&self) -> [[f64; 3]; 2] {
        let end = |i: usize, pick: fn(f64, f64) -> f64, from: f64| self.nodes.iter().map(|x| x[i]).fold(from, pick);
        [
            std::array::from_fn(|i| end(i, f64::min, f64::INFINITY)),
            std::array::from_fn(|i| end(i, f64::max, f64::NEG_INFINITY)),
        ]
    }

    /// The nodes of a named set: `all`, `surface` (nodes on the boundary) or one of `sets`.
    pub fn set(&self, name: &str) -> Option<Vec<u32>> {
        match (self.sets.get(name), name) {
            (Some(nodes), _) => Some(nodes.clone()),
            (None, "all") => Some((0..self.nodes.len() as u32).collect()),
            (None, "surface") => Some(self.surface_nodes()),
            (None, _) => None,
        }
    }

    /// The names that [`QuadraticMesh::set`] knows.
    pub fn set_names(&self) -> Vec<&str> {
        let own = self.sets.keys().map(String::as_str).filter(|name| !["all", "surface"].contains(name));
        ["all", "surface"].into_iter().chain(own).collect()
    }

    /// The node nearest to `x` [m]; the first of several. `None` without nodes.
    pub fn nearest_node(&self, x: [f64; 3]) -> Option<u32> {
        let away = |node: &[f64; 3]| (Vector(*node) - Vector(x)).norm_squared();
        let nearest = self.nodes.iter().enumerate().min_by(|a, b| away(a.1).total_cmp(&away(b.1)));
        nearest.map(|(index, _)| index as u32)
    }

    /// Nodes inside or on the boundary of a region, up to rounding; ascending.
    pub fn nodes_in(&self, region: &Region) -> Vec<u32> {
        let [lower, upper] = self.extent();
        let near = DISTANCE_ON_SIDE * (Vector(upper) - Vector(lower)).norm();
        let held = (0u32..).zip(&self.nodes).filter(|(_, x)| region.signed_distance(**x) <= near);
        held.map(|(index, _)| index).collect()
    }
}

/// Number of elements of about `cell` along a length.
fn divisions(length: f64, cell: f64) -> usize {
    (length / cell).round().max(1.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    pub(super) fn plate(lower: [f64; 2], upper: [f64; 2]) -> Region {
        Region::Box { lower: [lower[0], lower[1], f64::NEG_INFINITY], upper: [upper[0], upper[1], f64::INFINITY] }
    }

    pub(super) fn without(whole: Region, taken: Region) -> Region {
        Region::Intersection(vec![whole, Region::Complement(Box::new(taken))])
    }

    /// Area of a disc of radius 1 whose circle is `count` parabolas through the ends and the middle of its arcs, of the
    /// angle 2φ each:
    /// triangles and, by Archimedes, two thirds of chord times height.
    pub(super) fn parabolic_disc(count: usize) -> f64 {
        let (sin, cos) = (PI / count as f64).sin_cos();
        count as f64 * (sin * cos + 4.0 / 3.0 * sin * (1.0 - cos))
    }

    #[test]
    fn sides_of_a_disc_are_its_farthest_nodes() {
        let disc = Region::Sphere { center: [1.0, 2.0, 0.0], radius: 0.5 };
        let mesh = QuadraticMesh::fill(&disc, 0.2, 2).unwrap();
        let left = &mesh.sets["left"];
        assert_eq!(left.len(), 1);
        assert!((mesh.nodes[left[0] as usize][0] - 0.5).abs() < 1e-15);
        assert_eq!(mesh.set_names(), ["all", "surface", "bottom", "left", "right", "top"]);
        assert_eq!(
            mesh.set("surface").unwrap().len(),
            mesh.nodes_in(&without(plate([0.0, 1.0], [2.0, 3.0]), disc)).len()
        );
    }

    #[test]
    fn regions_without_end_or_room_are_refused() {
        let half = Region::HalfSpace { point: [0.0; 3], normal: [1.0, 0.0, 0.0] };
        assert!(QuadraticMesh::fill(&half, 0.1, 2).unwrap_err().contains("end in every direction"));
        let ball = Region::Sphere { center: [0.0; 3], radius: 1.0 };
        assert!(QuadraticMesh::fill(&ball, 1e-9, 2).is_err());
    }

    #[test]
    fn cylinders_and_prisms_have_their_volumes() {
        let rod = Region::Cylinder { from: [1.0, 0.0, 0.0], to: [1.0, 3.0, 0.0], radius: 0.5 };
        let mesh = QuadraticMesh::fill(&rod, 0.25, 3).unwrap();
        assert!((mesh.volume() / (0.75 * parabolic_disc(8)) - 1.0).abs() < 1e-12, "{}", mesh.volume());
        let corners = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]].map(Vector);
        let prism = crate::geometry::Polygon::new(corners.to_vec(), 1.0, 2.0).unwrap();
        let mesh = QuadraticMesh::fill(&Region::Polygon(prism.into()), 0.2, 3).unwrap();
        assert!((mesh.volume() - 1.0).abs() < 1e-12, "{}", mesh.volume());
        assert_eq!(mesh.sets["top"].len(), mesh.sets["bottom"].len());
    }
}
