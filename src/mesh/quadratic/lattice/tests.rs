//! Meshes of surfaces with known volumes, areas and edges.

use super::shapes::{bracket, cuboid, icosphere, plate_with_hole, revolved, torus, turned};
use super::*;
use crate::mesh::quadratic::measure::ElementSide;

fn filled(surface: &Triangles, cell: f64) -> QuadraticMesh {
    let mesh = of_surface(surface.clone(), cell).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!(mesh.folded(), None);
    mesh
}

/// Area of the boundary of a mesh [m²], by three Gauss points along each direction of a side.
fn boundary_area(mesh: &QuadraticMesh) -> f64 {
    let gauss = [(-0.6f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)];
    let of = |side: ElementSide| {
        let at = |u: f64, v: f64| {
            let mut xi = [u; 3];
            (xi[side.axis], xi[(side.axis + 2) % 3]) = (if side.upper { 1.0 } else { -1.0 }, v);
            Vector(mesh.position(side.element, xi))
        };
        // Quadratic along both: central differences of any width are exact.
        let slope = |u: f64, v: f64| {
            ((at(u + 1.0, v) - at(u - 1.0, v)) * 0.5).cross((at(u, v + 1.0) - at(u, v - 1.0)) * 0.5).norm()
        };
        gauss.iter().flat_map(|(u, a)| gauss.map(|(v, b)| a * b * slope(*u, v))).sum::<f64>()
    };
    mesh.surface().into_iter().map(of).sum()
}

fn area(surface: &Triangles) -> f64 {
    surface.triangles.iter().map(|t| axes::area(surface, t)).sum()
}

/// Volume and area of a mesh over those of the surface, less one.
fn errors(surface: &Triangles, mesh: &QuadraticMesh) -> [f64; 2] {
    let volume = Surface::new(surface.clone()).unwrap().volume();
    [mesh.volume() / volume - 1.0, boundary_area(mesh) / area(surface) - 1.0]
}

#[track_caller]
fn expect(surface: &Triangles, cell: f64, volume: f64, area: f64) -> QuadraticMesh {
    let mesh = filled(surface, cell);
    let found = errors(surface, &mesh);
    assert!(found[0].abs() < volume && found[1].abs() < area, "{found:?} of {} elements", mesh.elements.len());
    mesh
}

/// Lattices as they are: as many elements as the extents have cells, and nothing rounded.
#[test]
fn boxes_and_brackets_are_their_lattices_also_turned() {
    let block = cuboid([0.0; 3], [3.0, 2.0, 1.0]);
    assert_eq!(expect(&block, 0.5, 1e-14, 1e-14).elements.len(), 6 * 4 * 2);
    assert_eq!(expect(&bracket(), 0.5, 1e-14, 1e-14).elements.len(), (6 * 2 + 2 * 4) * 4);
    for degrees in [30.0, 75.0] {
        assert_eq!(expect(&turned(block.clone(), degrees), 0.5, 1e-9, 1e-9).elements.len(), 6 * 4 * 2);
        assert_eq!(expect(&turned(bracket(), degrees), 0.5, 1e-9, 1e-9).elements.len(), (6 * 2 + 2 * 4) * 4);
    }
    // Thinner than half an element, and with sides as other blocks have them.
    let sheet = expect(&cuboid([1.0, 0.0, 0.0], [4.0, 2.0, 0.05]), 0.5, 1e-14, 1e-14);
    assert_eq!((sheet.elements.len(), sheet.thinnest().elements), (24, 1));
    assert!((sheet.thinnest().length - 0.05).abs() < 1e-15);
}
