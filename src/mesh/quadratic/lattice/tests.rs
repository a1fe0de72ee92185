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

/// The best that facets let one hope for: errors of the area fall with the square of the cell at least until elements
/// are as small as triangles.
#[test]
fn balls_and_rings_converge() {
    let ball = icosphere(3);
    assert_eq!(ball.triangles.len(), 1280);
    let coarse = errors(&ball, &filled(&ball, 1.0));
    expect(&ball, 0.25, 2e-3, 0.5 * coarse[1].abs());
    let ring = torus(2.0, 0.7, 48);
    let coarse = errors(&ring, &filled(&ring, 0.7));
    expect(&ring, 0.35, 0.5 * coarse[0].abs(), 0.8 * coarse[1].abs());
}

/// Flat and plane-sided: exact whatever the directions, as long as each sharp edge is one of elements and no corner is
/// cut off.
#[test]
fn oblique_sides_keep_their_edges_and_corners() {
    let vertices = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]];
    let tetrahedron = Triangles { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] };
    let wedge = shapes::prism(&[[0.0, 0.0], [3.0, 0.0], [0.0, 1.0]], &[[0, 1, 2]], [0.0, 1.0]);
    let around = [0, 1, 2, 3, 4, 5].map(|k| (f64::from(k) * std::f64::consts::FRAC_PI_3).sin_cos());
    let nut = shapes::prism(&around.map(|(y, x)| [x, y]), &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], [0.0, 1.0]);
    for (surface, cell) in [(tetrahedron, 0.5), (wedge, 0.3), (nut, 0.4)] {
        expect(&surface, cell, 1e-9, 1e-9);
        expect(&turned(surface, 30.0), cell, 1e-9, 1e-9);
    }
}

/// Sharp edges that are circles, convex, at a hole, concave: only the parabolas between nodes on them are not exact.
#[test]
fn round_edges_are_kept() {
    let plate = expect(&plate_with_hole([0.0, 0.5], 64), 0.5, 1e-3, 1e-3);
    assert_eq!(plate.thinnest().elements, 1);
    let rod = revolved(&[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]], 48);
    expect(&rod, 0.5, 3e-3, 1e-3);
    // One cell across, and a layer around it.
    assert_eq!(expect(&rod, 1.5, 2e-2, 2e-2).elements.len(), 5);
    let rim = |x: &&[f64; 3]| x[2] == 2.0 && (x[0].hypot(x[1]) - 1.0).abs() < 5e-3;
    assert!(filled(&rod, 0.5).nodes.iter().filter(rim).count() == 16);
    let boss = revolved(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.8, 0.5], [0.8, 1.5], [0.0, 1.5]], 48);
    expect(&boss, 0.3, 1e-3, 3e-3);
}

/// A ring with an oval hole and a cup whose elements are as wide as the hole and the walls are thick: edges inside bend
/// with the boundary, and no node is off the surface.
#[test]
fn coarse_elements_follow_curved_sides() {
    let (radius, thin, short) = (0.22, 0.08, 0.9);
    let mut ring = torus(radius, thin, 48);
    ring.vertices.iter_mut().for_each(|x| x[1] *= short);
    // Facets lie inside by 1 − cos of half of their angle, about each axis.
    let facets = [(radius + thin, 48.0), (thin, 24.0)].map(|(r, n)| r * (1.0 - (std::f64::consts::PI / n).cos()));
    let mesh = expect(&ring, 0.125, 1e-2, 1e-2);
    assert!(mesh.elements.len() < 100, "{}", mesh.elements.len());
    for node in mesh.surface_nodes() {
        let [x, y, z] = mesh.nodes[node as usize];
        let away = (x.hypot(y / short) - radius).hypot(z) - thin;
        assert!(away.abs() < facets[0] + facets[1] + 1e-9, "{away} at {:?}", [x, y, z]);
    }
    let cup = revolved(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.8, 1.0], [0.8, 0.2], [0.0, 0.2]], 32);
    let mesh = expect(&cup, 0.4, 1e-2, 1e-2);
    let region = crate::geometry::Region::Surface(Surface::new(cup).unwrap().into());
    let most = mesh.deviation(&region).unwrap();
    assert!(mesh.elements.len() < 200 && most.length < 1e-9, "{} {most:?}", mesh.elements.len());
}

/// A hollow is kept; two blocks in one file are two bodies.
#[test]
fn a_hollow_is_kept_and_two_pieces_are_refused() {
    let with = |mut whole: Triangles, other: Triangles, is_hollow: bool| {
        let first = whole.vertices.len() as u32;
        whole.vertices.extend(other.vertices);
        let turn = |[a, b, c]: [u32; 3]| if is_hollow { [a, c, b] } else { [a, b, c] };
        whole.triangles.extend(other.triangles.into_iter().map(|t| turn(t.map(|v| v + first))));
        whole
    };
    let block = || cuboid([0.0; 3], [3.0; 3]);
    let hollow = with(block(), cuboid([1.0; 3], [2.0; 3]), true);
    assert_eq!(expect(&hollow, 1.0, 1e-14, 1e-14).elements.len(), 26);
    let two = with(block(), cuboid([4.0, 0.0, 0.0], [5.0, 3.0, 3.0]), false);
    assert!(of_surface(two, 1.0).err().is_some_and(|why| why.contains("2 pieces")));
}

#[test]
fn the_sides_are_the_farthest_nodes() {
    let region = crate::geometry::Region::Surface(Surface::new(bracket()).unwrap().into());
    let mesh = QuadraticMesh::fill(&region, 0.5, 3).unwrap();
    // The face x = 3 has 2 × 4 elements.
    assert_eq!(mesh.sets["right"].len(), 5 * 9);
    assert!(mesh.sets["right"].iter().all(|&n| mesh.nodes[n as usize][0] == 3.0));
    assert_eq!(mesh, QuadraticMesh::fill(&region, 0.5, 3).unwrap());
}

/// A neck, walls and a rod that are thinner than elements: meshed, or refused where they are lost.
#[test]
fn what_is_thinner_than_elements_is_meshed_or_refused_with_its_place() {
    let refused = |surface: &Triangles, cell: f64| of_surface(surface.clone(), cell).err().unwrap_or_default();
    let ends = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.15, 1.0], [0.15, 1.4], [1.0, 1.4], [1.0, 2.4], [0.0, 2.4]];
    expect(&revolved(&ends, 32), 0.3, 1e-2, 2e-2);
    let cup = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.8, 1.0], [0.8, 0.2], [0.0, 0.2]];
    // Filled up it would have nearly twice the volume.
    for cell in [0.6, 0.9] {
        let why = refused(&revolved(&cup, 32), cell);
        assert!(why.contains("at (") && why.contains("a hollow as small as one"), "{why}");
    }
    expect(&revolved(&cup, 32), 0.2, 1e-2, 1e-2);
    let rod = turned(revolved(&[[0.0, 0.0], [0.1, 0.0], [0.1, 5.0], [0.0, 5.0]], 24), 30.0);
    // One cell across, however long cells are.
    expect(&rod, 0.3, 3e-2, 3e-2);
    expect(&rod, 0.1, 5e-3, 5e-3);
    assert!(refused(&icosphere(1), 1e-6).contains("elements"));
}
