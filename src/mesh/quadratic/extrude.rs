//! Plane meshes drawn along a third axis: cylinders, and polygons between two heights.

use super::disc::unit_disc;
use super::frame::Frame;
use super::{ElementSize, QuadraticMesh};
use crate::geometry::{Polygon, Region};
use crate::math::Vector;

/// The mesh of a cylinder or of an extruded polygon.
///
/// # Errors
/// Another region, or a polygon that can't be meshed.
pub fn of_region(region: &Region, size: ElementSize) -> Result<QuadraticMesh, String> {
    let (frame, inner) = Frame::of(region);
    match inner {
        Region::Cylinder { from, to, radius } => {
            let (axis, mut disc) = (Vector(*to) - Vector(*from), unit_disc(*radius, size.cell));
            disc.nodes.iter_mut().for_each(|x| *x = x.map(|c| c * radius));
            let upright = Frame::along(axis / axis.norm(), *from);
            Ok(extruded(&disc, [0.0, axis.norm()], size, &frame.after(&upright)))
        }
        Region::Polygon(polygon) => {
            let wrong = |why: String| format!("the polygon can't be meshed: {why}");
            let corners = polygon.corners().to_vec();
            let plane = Polygon::new(corners, f64::NEG_INFINITY, f64::INFINITY).map_err(wrong)?;
            let base = QuadraticMesh::fill(&Region::Polygon(plane.into()), size.cell, 2)?;
            Ok(extruded(&base, polygon.heights(), size, &frame))
        }
        _ => Err("in 3D a mesh can be made of boxes, also where other shapes cut an end off, of cylinders and tubes, of balls, hollow balls and ellipsoids up to three times as \
                  long as thin, of polygons with heights, and of closed surfaces from STL or OBJ files; others come from a Gmsh file of tetrahedra or hexahedra, `mesh = { path = \"...\" }`"
            .into()),
    }
}

/// Layers of a plane mesh between two heights [m].
pub(super) fn extruded(
    base: &QuadraticMesh,
    [lower, upper]: [f64; 2],
    size: ElementSize,
    frame: &Frame,
) -> QuadraticMesh {
    let (layers, count) = (size.divisions(upper - lower), base.nodes.len());
    let height = |row: usize| lower + (upper - lower) * row as f64 / (2 * layers) as f64;
    let place = |row: usize| base.nodes.iter().map(move |x| frame.place([x[0], x[1], height(row)]));
    let element = |layer: usize, own: &[u32]| {
        let rows = 2 * layer..2 * layer + 3;
        rows.flat_map(|row| own.iter().map(move |&n| (row * count) as u32 + n)).collect()
    };
    QuadraticMesh {
        dimension: 3,
        nodes: (0..=2 * layers).flat_map(place).collect(),
        elements: (0..layers).flat_map(|layer| base.elements.iter().map(move |own| element(layer, own))).collect(),
        sets: Default::default(),
    }
}
