//! Meshes of domains against their geometry: areas, angles, names, symmetry, sizes.

use lateen::geometry::{BoxShape, CylinderShape, Shape, SphereShape, UnionShape};
use lateen::math::Vector;
use lateen::mesh::domain::{BoxMesh, BuildMesh, CellPattern, Hole, Refinement};
use lateen::mesh::{CellCut, Mesh};
use std::f64::consts::TAU;
use std::path::Path;

fn plain(lower: &[f64], upper: &[f64], cell: f64) -> BoxMesh {
    BoxMesh {
        lower: lower.to_vec(),
        upper: upper.to_vec(),
        cell,
        pattern: CellPattern::Auto,
        growth: 0.2,
        refine: Vec::new(),
        holes: Vec::new(),
    }
}

fn rectangle(lower: [f64; 2], upper: [f64; 2]) -> Shape {
    Shape::BoxShape(BoxShape { lower: lower.to_vec(), upper: upper.to_vec() })
}

fn disc(center: [f64; 2], radius: f64) -> Shape {
    Shape::SphereShape(SphereShape { center: center.to_vec(), radius })
}

/// The channel of Turek and Hron with the cylinder and its bar.
fn channel() -> BoxMesh {
    let body = Shape::UnionShape(UnionShape { of: vec![disc([0.2, 0.2], 0.05), rectangle([0.2, 0.19], [0.6, 0.21])] });
    BoxMesh {
        holes: vec![Hole { name: "body".into(), region: body, cell: Some(0.005) }],
        ..plain(&[0.0, 0.0], &[2.5, 0.41], 0.04)
    }
}

fn smallest_angle(mesh: &Mesh<2, 3>) -> f64 {
    let angle = |x: [Vector<2>; 3], i: usize| {
        let (u, v) = (x[(i + 1) % 3] - x[i], x[(i + 2) % 3] - x[i]);
        (u.dot(v) / (u.norm() * v.norm())).acos().to_degrees()
    };
    let of = |e: usize| (0..3).map(|i| angle(mesh.corners(e), i)).fold(180.0, f64::min);
    (0..mesh.elements().len()).map(of).fold(180.0, f64::min)
}

/// The chords of the mesh cut a sliver r² (θ − sin θ)/2 off the disc for every node.
#[test]
fn a_channel_with_a_cylinder_and_a_bar_has_its_area_outline_and_angles() {
    let mesh = channel().triangles(Path::new("")).unwrap();
    let half = (0.2f64).asin();
    let hidden = 0.05 * 0.05 * half - 0.01 * 0.05 * half.cos();
    let bar = 0.02 * (0.4 - 0.05 * half.cos());
    let body = TAU / 2.0 * 0.0025 - hidden + bar;
    let chords = 0.0025 * TAU * (0.005f64 / 0.05).powi(2) / 12.0;
    let missing = 2.5 * 0.41 - body - mesh.volume();
    assert!((missing + chords).abs() < 0.2 * chords, "{missing} for {chords}");
    // No theorem bounds the angles of this method; the guarantee of Delaunay refinement (Ruppert 1995) is 20.7°.
    assert!(smallest_angle(&mesh) > 22.0, "{}", smallest_angle(&mesh));
    let named: usize = mesh.sets.values().map(Vec::len).sum();
    assert_eq!(named, mesh.boundary().len());
    let around: f64 = mesh.sets["body"].iter().map(|&facet| mesh.facet_area(facet).norm()).sum();
    let exact = 0.05 * (TAU - 2.0 * half) + 2.0 * (0.4 - 0.05 * half.cos()) + 0.02;
    assert!((around - exact).abs() < 2e-3 * exact, "{around} {exact}");
    let height: f64 = mesh.sets["left"].iter().map(|&facet| mesh.facet_area(facet).norm()).sum();
    assert!((height - 0.41).abs() < 1e-12);
}

#[test]
fn no_element_has_all_its_nodes_on_the_boundary() {
    let mesh = channel().triangles(Path::new("")).unwrap();
    let mut on = vec![false; mesh.nodes().len()];
    mesh.boundary().iter().flat_map(|&facet| mesh.facet_nodes(facet)).for_each(|n| on[n as usize] = true);
    assert!(!mesh.elements().iter().any(|element| element.iter().all(|&n| on[n as usize])));
}

#[test]
fn edges_of_elements_have_the_size_that_was_asked_for() {
    let fine = Refinement { region: rectangle([0.4, 0.4], [0.6, 0.6]), cell: 0.01, growth: None };
    let spec = BoxMesh { refine: vec![fine], ..plain(&[0.0, 0.0], &[1.0, 1.0], 0.08) };
    let mesh = spec.triangles(Path::new("")).unwrap();
    let mean = |near: f64, far: f64| {
        let inside = |e: &usize| {
            let x = mesh.center(*e);
            let away = (x[0] - 0.5).abs().max((x[1] - 0.5).abs());
            (near..far).contains(&away)
        };
        let volumes: Vec<f64> = (0..mesh.elements().len()).filter(inside).map(|e| mesh.simplex(e).volume).collect();
        // An equilateral triangle of this area has this edge.
        (volumes.iter().sum::<f64>() / volumes.len() as f64 * 4.0 / 3f64.sqrt()).sqrt()
    };
    assert!((mean(0.0, 0.1) - 0.01).abs() < 0.0015, "{}", mean(0.0, 0.1));
    let middle = 0.01 + 0.2 * 0.15;
    assert!((mean(0.23, 0.27) - middle).abs() < 0.25 * middle, "{}", mean(0.23, 0.27));
}

#[test]
fn a_mesh_is_the_same_bits_every_time() {
    let [a, b] = [0, 1].map(|_| channel().triangles(Path::new("")).unwrap());
    assert_eq!(a.nodes(), b.nodes());
    assert_eq!(a.elements(), b.elements());
}

/// With an even number of cells the mirror image of a union jack is itself.
#[test]
fn a_mirrored_lattice_is_symmetric() {
    let mesh = plain(&[-1.0, 0.0], &[1.0, 2.0], 0.25).triangles(Path::new("")).unwrap();
    let place = |x: Vector<2>| [(x[0] * 1e6).round() as i64, (x[1] * 1e6).round() as i64];
    let triangle = |e: &[u32; 3], sign: f64| {
        let mut corners = e.map(|n| place(Vector([sign * mesh.nodes()[n as usize][0], mesh.nodes()[n as usize][1]])));
        corners.sort_unstable();
        corners
    };
    let mut own: Vec<_> = mesh.elements().iter().map(|e| triangle(e, 1.0)).collect();
    let mut mirror: Vec<_> = mesh.elements().iter().map(|e| triangle(e, -1.0)).collect();
    own.sort_unstable();
    mirror.sort_unstable();
    assert_eq!(own, mirror);
}

/// Graded planes in 3D: volume, names of all six sides, closer planes in the refined slab.
#[test]
fn a_graded_box_of_tetrahedra_keeps_volume_and_sides_and_is_finer_in_its_slab() {
    let region = Shape::BoxShape(BoxShape { lower: vec![0.0, 0.4, 0.0], upper: vec![1.0, 0.6, 1.0] });
    let fine = Refinement { region, cell: 0.05, growth: None };
    let spec = BoxMesh { refine: vec![fine], ..plain(&[0.0; 3], &[1.0, 1.0, 1.0], 0.25) };
    let mesh = spec.tetrahedra(Path::new("")).unwrap();
    assert!((mesh.volume() - 1.0).abs() < 1e-12);
    for name in ["left", "right", "front", "back", "bottom", "top"] {
        let area: f64 = mesh.sets[name].iter().map(|&facet| mesh.facet_area(facet).norm()).sum();
        assert!((area - 1.0).abs() < 1e-12, "{name} {area}");
    }
    let fine = (0..mesh.elements().len()).filter(|&e| (mesh.center(e)[1] - 0.5).abs() < 0.1).count();
    // Even planes would put a fifth of the elements into the slab.
    assert!(fine > mesh.elements().len() / 5, "{fine} of {}", mesh.elements().len());
}

#[test]
fn mirrored_tetrahedra_are_conforming() {
    let line: Vec<f64> = (0..=4).map(|i| i as f64).collect();
    let mesh = Mesh::<3, 4>::lattice(&[line.clone(), line.clone(), line], CellCut::Mirrored).unwrap();
    assert!((mesh.volume() - 64.0).abs() < 1e-12);
    assert_eq!(mesh.boundary().len(), 6 * 16 * 2);
}

#[test]
fn an_obstacle_is_cut_out_of_a_box_of_tetrahedra() {
    // Its sides lie on no plane of an even lattice; it stands on the floor and at the front.
    let obstacle = Shape::BoxShape(BoxShape { lower: vec![0.37, 0.0, 0.0], upper: vec![0.52, 0.21, 0.161] });
    let holes = vec![Hole { name: "obstacle".into(), region: obstacle, cell: None }];
    let spec = BoxMesh { holes, ..plain(&[0.0; 3], &[1.0, 0.5, 0.4], 0.05) };
    let mesh = spec.tetrahedra(Path::new("")).unwrap();
    assert!((mesh.volume() - (0.2 - 0.15 * 0.21 * 0.161)).abs() < 1e-14);
    let area = |name: &str| mesh.sets[name].iter().map(|&facet| mesh.facet_area(facet).norm()).sum::<f64>();
    let wetted = 2.0 * 0.21 * 0.161 + 0.15 * 0.161 + 0.15 * 0.21;
    assert!((area("obstacle") - wetted).abs() < 1e-14, "{}", area("obstacle"));
    assert!((area("bottom") - (0.5 - 0.15 * 0.21)).abs() < 1e-14 && (area("top") - 0.5).abs() < 1e-14);
    assert!((area("front") - (0.4 - 0.15 * 0.161)).abs() < 1e-14);
    assert_eq!(mesh.sets.values().map(Vec::len).sum::<usize>(), mesh.boundary().len());
}

#[test]
fn wrong_boxes_and_holes_are_errors_at_their_key() {
    let key = |spec: BoxMesh| spec.triangles(Path::new("")).unwrap_err().key;
    assert_eq!(key(plain(&[0.0, 0.0], &[1.0, 0.0], 0.1)), "upper");
    assert_eq!(key(plain(&[0.0, 0.0, 0.0], &[1.0, 1.0], 0.1)), "lower");
    assert_eq!(key(plain(&[0.0, 0.0], &[1.0, 1.0], -0.1)), "cell");
    let hole = |region: Shape| Hole { name: "hole".into(), region, cell: None };
    let holed = |region: Shape| BoxMesh { holes: vec![hole(region)], ..plain(&[0.0, 0.0], &[1.0, 1.0], 0.1) };
    assert_eq!(key(holed(rectangle([0.5, 0.5], [0.5, 0.6]))), "holes[0].region.upper");
    assert_eq!(key(holed(rectangle([-1.0, -1.0], [2.0, 2.0]))), "cell");
    let lattice = BoxMesh { pattern: CellPattern::Mirrored, ..holed(disc([0.5, 0.5], 0.1)) };
    assert_eq!(key(lattice), "holes");
    let solid = Shape::CylinderShape(CylinderShape { from: [0.0; 3], to: [0.0, 0.0, 1.0], radius: 1.0 });
    assert_eq!(key(holed(solid)), "holes[0].region.shape");
    let free = BoxMesh { pattern: CellPattern::Free, ..plain(&[0.0; 3], &[1.0; 3], 0.5) };
    assert_eq!(free.tetrahedra(Path::new("")).unwrap_err().key, "pattern");
    let ball = Shape::SphereShape(SphereShape { center: vec![0.5; 3], radius: 0.1 });
    let round = BoxMesh { holes: vec![hole(ball)], ..plain(&[0.0; 3], &[1.0; 3], 0.5) };
    assert_eq!(round.tetrahedra(Path::new("")).unwrap_err().key, "holes[0].region");
}
