use super::super::mesh::SolidMesh;
use super::super::surface::tests::{disc, interpolate, rotation, surface_of, turned_box};
use super::cut_point::LEAST_INNER_EDGE_FRACTION;
use super::*;
use crate::mesh::Simplex;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A mesh of [−half, half]ᴰ [m].
fn background<const D: usize, const N: usize>(half: f64, cells: usize) -> Mesh<D, N> {
    Mesh::block(Vector::splat(-half), Vector::splat(half), [cells; D]).unwrap()
}

/// Volume of the part of an element inside: the simplices outside if inside and outside change places.
fn volume_inside_of<const D: usize, const N: usize>(mesh: &Mesh<D, N>, cut: &SolidCut<D, N>, e: &CutBySolid<N>) -> f64 {
    let inside = e.nodes.map(|node| cut.is_inside(node));
    let parts = parts::outside(&e.nodes, inside.map(|inside| !inside));
    parts.iter().map(|part| Simplex::new(cut.corners(mesh, e, part)).unwrap().volume).sum()
}

/// Conditions that every cut of a solid with plane sides must fulfil.
fn check<const D: usize, const N: usize>(mesh: &Mesh<D, N>, solid: &SolidMesh<D>) -> SolidCut<D, N> {
    check_curved(mesh, solid, 0.0)
}

/// The same of a solid with this curvature [1/m], off whose surface cut points are by less than the rise of an arc over
/// an edge of the mesh.
fn check_curved<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    solid: &SolidMesh<D>,
    curvature: f64,
) -> SolidCut<D, N> {
    let surface = surface_of(solid).with_rigid(vec![true]);
    let cut = SolidCut::new(mesh, &surface, &[]);
    for node in &cut.inside {
        let x = mesh.nodes()[node.node as usize];
        // Nodes beside the surface count as inside, and move with its nearest point.
        let outside = surface.distance(x).max(0.0);
        assert!(outside < BESIDE_SURFACE * smallest_element(mesh, node.node as usize));
        assert!((interpolate(&node.weights, &solid.nodes) - x).norm() < outside * (1.0 + 1e-6) + 1e-10);
    }
    let on_edges = cut.points.iter().filter_map(|point| point.edge.map(|edge| (point, edge)));
    for (point, own) in on_edges {
        let [start, end] = own.map(|node| mesh.nodes()[node as usize]);
        let (edge, t) = (end - start, (point.position - start).norm() / (end - start).norm());
        assert!(!cut.is_inside(own[0]) && cut.is_inside(own[1]));
        assert!((start + edge * t - point.position).norm() < 1e-12 && (0.99e-4..1.0).contains(&t));
        let nearest = surface.nearest(point.position).unwrap();
        // Off a curved surface a cut point moves as the solid would there.
        let follows = interpolate(&point.weights, &solid.nodes);
        let is_off = curvature > 0.0 && (follows - point.position).norm() < 1e-10;
        assert!(is_off || (follows - nearest.position).norm() < 1e-10);
        let is_clamped = (t - LEAST_EDGE_FRACTION).min(1.0 - LEAST_INNER_EDGE_FRACTION - t) < 1e-9;
        // An edge that ends in a node beside the surface is cut where the distance is that of the node, or a little
        // more.
        let level =
            surface.distance(end).max(0.0) + LEAST_INNER_EDGE_FRACTION * smallest_element(mesh, own[1] as usize);
        let off = 1e-6 * edge.norm()
            + curvature * edge.norm_squared() / 4.0
            + if surface.distance(end) > 0.0 { level } else { 0.0 };
        assert!(is_clamped || nearest.distance.abs() < off, "{t} {}", nearest.distance);
    }
    for (place, e) in cut.elements.iter().enumerate() {
        assert_eq!(cut.state[e.element as usize], ElementState::Cut(place as u32));
        let part = |part| Simplex::new(cut.corners(mesh, e, part)).unwrap().volume;
        assert!(e.parts.iter().map(part).all(|volume| volume > 0.0));
        // With a corner of the solid inside, the other part is no simplex or prism between the cut points.
        if e.points.iter().any(|&point| cut.points[point as usize].edge.is_none()) {
            continue;
        }
        let (sum, whole) = (
            cut.volume_outside(mesh, e.element as usize) + volume_inside_of(mesh, &cut, e),
            mesh.simplex(e.element as usize).volume,
        );
        assert!((sum - whole).abs() < 1e-12 * whole);
    }
    check_facets(mesh, &cut);
    cut
}

/// A corner of the fluid's simplices: a background node or a cut point.
type SimplexVertex = (bool, u32);

/// Facets of the part outside match from both sides, except on the surface of the solid and at the boundary
/// of the mesh; on the surface they close.
pub(super) fn check_facets<const D: usize, const N: usize>(mesh: &Mesh<D, N>, cut: &SolidCut<D, N>) {
    let mut count: BTreeMap<Vec<SimplexVertex>, usize> = BTreeMap::new();
    let mut add = |corners: [SimplexVertex; N]| {
        for k in 0..N {
            let mut facet: Vec<SimplexVertex> = (0..N).filter(|&i| i != k).map(|i| corners[i]).collect();
            facet.sort_unstable();
            *count.entry(facet).or_default() += 1;
        }
    };
    for (e, state) in cut.state.iter().enumerate() {
        match state {
            ElementState::Fluid => add(mesh.elements()[e].map(|node| (false, node))),
            ElementState::Solid => {}
            ElementState::Cut(place) => {
                let element = &cut.elements[*place as usize];
                let corner = |vertex| match vertex {
                    Vertex::Node(k) => (false, element.nodes[usize::from(k)]),
                    Vertex::Point(k) => (true, element.points[usize::from(k)]),
                };
                element.parts.iter().for_each(|part| add(part.vertices.map(corner)));
            }
        }
    }
    let boundary = mesh.nodes().iter().fold(0.0, |most: f64, x| x.0.iter().fold(most, |a, b| a.max(b.abs())));
    let is_at_boundary = |(is_point, number): &SimplexVertex| {
        let x = if *is_point { cut.points[*number as usize].position } else { mesh.nodes()[*number as usize] };
        x.0.iter().any(|c| c.abs() > boundary - 1e-9)
    };
    for (facet, count) in count {
        let on_surface = facet.iter().all(|(is_point, _)| *is_point);
        assert!(count == 2 || count == 1 && (on_surface || facet.iter().all(is_at_boundary)), "{facet:?} {count}");
    }
}

/// Cut points beside a curve keep its area. (Polygons between points on it miss 0.18, 0.05 and 0.01 % of it
/// here.)
#[test]
fn cut_points_keep_the_volume_of_a_disc() {
    // Cut points that are kept away from nodes are off the curve to either side: the mean over several places.
    let places = [[0.0, 0.0], [0.021, 0.013], [-0.017, 0.031], [0.043, -0.026], [-0.037, -0.011], [0.009, 0.047]];
    let solids = places.map(|place| {
        let mut solid = disc(12);
        solid.nodes.iter_mut().for_each(|x| *x += Vector(place));
        solid
    });
    let error = |cells: usize| {
        let mesh = background::<2, 3>(1.53, cells);
        solids.iter().map(|solid| PI - check_curved(&mesh, solid, 1.0).volume_inside(&mesh)).sum::<f64>() / 6.0
    };
    let errors = [20, 40, 80].map(error);
    assert!(errors[0] < 4e-4 && errors[1] < 1e-4 && errors[2] < 4e-5, "{errors:?}");
}

/// Sides of a box are plane: the volume is exact but for corners, edges, and cut points that were too close to nodes.
#[test]
fn the_volume_of_turned_boxes_converges() {
    let plane = |cells| {
        let mesh = background::<2, 3>(1.4, cells);
        let solid = turned_box([0.9, 0.35], [3, 2], Vector([0.02, 0.01]), &rotation([0.4, 0.0, 0.0]));
        (check(&mesh, &solid).volume_inside(&mesh) / (1.8 * 0.7) - 1.0).abs()
    };
    let [coarse, fine] = [plane(16), plane(64)];
    assert!(coarse < 0.02 && fine < 0.002, "{coarse} {fine}");
    let space = |cells| {
        let mesh = background::<3, 4>(1.4, cells);
        let solid = turned_box([0.8, 0.5, 0.6], [2, 1, 1], Vector([0.02, 0.01, 0.0]), &rotation([0.4, 0.7, 0.2]));
        (check(&mesh, &solid).volume_inside(&mesh) / (1.6 * 1.0 * 1.2) - 1.0).abs()
    };
    let [coarse, fine] = [space(9), space(18)];
    assert!(coarse < 0.08 && fine < coarse / 2.5, "{coarse} {fine}");
}

/// In two dimensions elements keep the corners of solids, however the way from there goes to the first node inside.
/// (Turned by nothing, some lie on edges of the mesh.)
#[test]
fn a_box_keeps_its_corners() {
    let mesh = background::<2, 3>(1.4, 16);
    let lost = |k: u32| {
        let x = f64::from(k);
        let place = Vector([0.15 * (x * 0.37).sin(), 0.15 * (x * 0.73).cos()]);
        let solid = turned_box([0.9, 0.35], [3, 2], place, &rotation([0.0217 * x, 0.0, 0.0]));
        (1.8 * 0.7 - check(&mesh, &solid).volume_inside(&mesh)).abs() / mesh.simplex(0).volume
    };
    let all: Vec<f64> = (0..150).map(lost).collect();
    assert!(all.iter().all(|lost| *lost < 1e-3), "{all:?}");
}

/// A box whose corners all lie on diagonals of squares of the mesh keeps its volume when it moves by rounding, or by
/// more, to either side: else fluids at rest beside it would be pushed.
#[test]
fn a_corner_may_lie_on_an_edge_of_the_mesh() {
    let mesh = background::<2, 3>(1.0, 8);
    for (offset, way) in [([0.07, 0.07], [1.0, -1.0]), ([0.07, 0.18], [1.0, 1.0]), ([0.07, 0.07], [0.3, 1.0])] {
        for way in [way, way.map(|x| -x)] {
            for size in [0.0, 1e-17, 1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
                let lower = Vector([-0.5 + offset[0] + size * way[0], -0.25 + offset[1] + size * way[1]]);
                let solid = SolidMesh::block(lower, lower + Vector([1.0, 0.5]), [3, 2]).unwrap();
                let lost = (0.5 - check(&mesh, &solid).volume_inside(&mesh)).abs() / mesh.simplex(0).volume;
                assert!(lost < 1e-3, "{offset:?} {way:?} {size}: {lost}");
            }
        }
    }
}

/// The same in space: elements keep edges, and the corners that they hold.
#[test]
fn a_box_in_space_keeps_its_edges() {
    let mesh = background::<3, 4>(1.4, 10);
    let lost = |angle: f64| {
        let place = Vector([0.02, 0.01, 0.03]);
        let solid = turned_box([0.8, 0.5, 0.6], [2, 1, 1], place, &rotation([angle, 0.7 * angle, 0.2 + angle]));
        1.0 - check(&mesh, &solid).volume_inside(&mesh) / (1.6 * 1.0 * 1.2)
    };
    let all: Vec<f64> = (0..8).map(|k| lost(0.05 + 0.2 * f64::from(k))).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    assert!(mean < 2e-3 && all.iter().all(|lost| (0.0..3e-3).contains(lost)), "{mean:e} {all:?}");
}

/// A beam of one and a half cells, whose cut points on one side are not to be drawn by the other.
#[test]
fn a_thin_beam_keeps_its_volume() {
    let (cells, half) = (40, 1.0);
    let thickness = 1.5 * 2.0 * half / cells as f64;
    let mesh = background::<2, 3>(half, cells);
    for angle in [0.0, 0.13, 0.4, 0.785, 1.1] {
        let solid = turned_box([0.6, 0.5 * thickness], [12, 1], Vector([0.013, 0.021]), &rotation([angle, 0.0, 0.0]));
        let cut = check(&mesh, &solid);
        let volume = cut.volume_inside(&mesh) / (1.2 * thickness);
        assert!((0.95..1.01).contains(&volume), "{angle}: {volume}");
    }
}

#[test]
fn a_surface_through_nodes_and_along_edges_is_cut() {
    let mesh = background::<2, 3>(1.0, 10);
    let solid = SolidMesh::block(Vector([-0.4, -0.2]), Vector([0.4, 0.6]), [3, 3]).unwrap();
    let cut = check(&mesh, &solid);
    // Nodes on the surface are inside, and cut points of the elements around it lie beside them.
    assert!(cut.distance.iter().filter(|d| **d <= 0.0).count() == 25);
    let volume = cut.volume_inside(&mesh);
    // A corner that lies on a node is moved a thousandth into an element, of 0.02.
    assert!((volume - 0.64).abs() < 4.0 * 1e-3 * 0.02, "{volume}");
    let mesh = background::<3, 4>(1.0, 5);
    let solid = SolidMesh::block(Vector([-0.6, -0.2, -0.6]), Vector([0.2, 0.6, 0.2]), [2, 1, 1]).unwrap();
    let volume = check(&mesh, &solid).volume_inside(&mesh);
    assert!((volume - 0.512).abs() < 4.0 * LEAST_INNER_EDGE_FRACTION, "{volume}");
}

/// A solid that leaves the mesh is cut where there are elements.
#[test]
fn a_solid_may_reach_out_of_the_mesh() {
    let mesh = background::<2, 3>(1.0, 12);
    let solid = SolidMesh::block(Vector([-3.0, -0.41]), Vector([0.37, 0.33]), [9, 2]).unwrap();
    let volume = check(&mesh, &solid).volume_inside(&mesh);
    assert!((volume / (1.37 * 0.74) - 1.0).abs() < 0.02, "{volume}");
}

/// A solid between nodes is reported, one of two cells is not but for its corners.
#[test]
fn solids_too_thin_for_the_mesh_are_reported() {
    let mesh = background::<2, 3>(1.0, 10);
    let missed = |half: f64| {
        let solid = SolidMesh::block(Vector([-0.31, 0.09 - half]), Vector([0.33, 0.09 + half]), [6, 1]).unwrap();
        let surface = surface_of(&solid);
        SolidCut::new(&mesh, &surface, &[]).missed(&mesh, &Locator::new(&mesh), &surface)
    };
    assert!(missed(0.03).len() >= 6);
    assert!(missed(0.2).len() <= 4);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn turned_solids_are_cut(angles in prop::array::uniform3(0.0..6.3), x in prop::array::uniform3(-0.3..0.3)) {
        let plane = background::<2, 3>(1.0, 12);
        check(&plane, &turned_box([0.5, 0.13], [4, 1], Vector::from3(x), &rotation(angles)));
        let space = background::<3, 4>(1.0, 6);
        check(&space, &turned_box([0.5, 0.26, 0.4], [2, 1, 1], Vector::from3(x), &rotation(angles)));
    }
}

#[test]
fn a_cut_does_not_depend_on_the_number_of_threads() {
    let mesh = background::<2, 3>(1.5, 40);
    let surface = surface_of(&disc(6));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| SolidCut::new(&mesh, &surface, &[]))
    };
    assert_eq!(with(1), with(3));
}
