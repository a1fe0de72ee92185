//! Regions: distances against closed forms and against properties that define a distance; volumes
//! against counted particles; errors of wrong shapes.

use lateen::geometry::{Bounds, Polygon, Region, Shape, Surface, Triangles, centred_origin, sample};
use lateen::math::Vector;
use proptest::prelude::*;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

fn point() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-3.0..3.0f64)
}

/// Distance to what is between −half and half along each direction, where these are lengths across the shape: the
/// nearest point outside, the nearest side inside.
fn between(across: &[f64], half: &[f64]) -> f64 {
    let over: Vec<f64> = across.iter().zip(half).map(|(x, h)| x.abs() - h).collect();
    let nearest_side = over.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let outside = over.iter().map(|o| o.max(0.0).powi(2)).sum::<f64>().sqrt();
    if nearest_side > 0.0 { outside } else { nearest_side }
}

fn cube(half: f64) -> Triangles {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { half } else { -half });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Triangles {
        vertices: (0..8).map(corner).collect(),
        triangles: faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect(),
    }
}

fn stl(triangles: &Triangles) -> Vec<u8> {
    let corner = |v: u32| stl_io::Vertex::new(triangles.vertices[v as usize].map(|c| c as f32));
    let faces: Vec<stl_io::Triangle> = triangles
        .triangles
        .iter()
        .map(|t| stl_io::Triangle { normal: stl_io::Normal::new([0.0; 3]), vertices: t.map(corner) })
        .collect();
    let mut bytes = Vec::new();
    stl_io::write_stl(&mut bytes, faces.iter()).unwrap();
    bytes
}

fn shape(toml: &str) -> Shape {
    let table: std::collections::HashMap<String, Shape> = toml::from_str(&format!("s = {toml}")).unwrap();
    table.into_values().next().unwrap()
}

fn build(toml: &str, dimension: usize) -> Result<Region, lateen::error::Diagnostic> {
    shape(toml).build(Path::new("."), dimension)
}

proptest! {
    #[test]
    fn distances_to_box_sphere_and_cylinder_are_those_of_their_lengths_across(x in point()) {
        let cuboid = Region::Box { lower: [-1.0, -0.5, -2.0], upper: [1.0, 0.5, 2.0] };
        prop_assert!((cuboid.signed_distance(x) - between(&x, &[1.0, 0.5, 2.0])).abs() < 1e-12);
        let ball = Region::Sphere { center: [0.0; 3], radius: 1.3 };
        prop_assert!((ball.signed_distance(x) - (Vector(x).norm() - 1.3)).abs() < 1e-12);
        let cylinder = Region::Cylinder { from: [0.0, -1.5, 0.0], to: [0.0, 1.5, 0.0], radius: 0.7 };
        prop_assert!((cylinder.signed_distance(x) - between(&[x[1], x[0].hypot(x[2])], &[1.5, 0.7])).abs() < 1e-12);
    }

    #[test]
    fn distance_and_normal_lead_to_the_boundary(x in point()) {
        let regions = [
            Region::Ellipsoid { center: [0.2, 0.1, -0.3], semi_axes: [1.5, 0.4, 0.9] },
            Region::Ellipsoid { center: [0.0; 3], semi_axes: [0.5, 0.5, 2.0] },
            Region::Cylinder { from: [-1.0, 0.0, 0.5], to: [1.0, 1.0, -0.5], radius: 0.6 },
            Region::HalfSpace { point: [0.1, 0.2, 0.3], normal: [0.6, 0.0, 0.8] },
            build(r#"{ shape = "polygon", corners = [[0, 0], [2, 0], [2, 1], [1, 0.3], [0, 1]], heights = [-1, 0.5] }"#, 3).unwrap(),
            build(r#"{ shape = "rotated", angle = 0.7, axis = [1, 2, 3], about = [1, 0, 0], of = { shape = "box", lower = [-1, -1, -1], upper = [1, 2, 0] } }"#, 3).unwrap(),
            Region::Surface(Arc::new(Surface::new(cube(0.8)).unwrap())),
        ];
        for region in regions {
            let (d, n) = region.distance_and_normal(x);
            let foot = std::array::from_fn(|i| x[i] - d * n[i]);
            prop_assert!((Vector(n).norm() - 1.0).abs() < 1e-9, "{region:?}: |n| of {n:?}");
            prop_assert!(region.signed_distance(foot).abs() < 1e-9, "{region:?}: {x:?} {d} {n:?}");
        }
    }

    #[test]
    fn no_boundary_point_is_nearer_than_the_distance(x in point(), theta in 0.0..PI, phi in 0.0..2.0 * PI) {
        let semi_axes = [1.5, 0.4, 0.9];
        let ellipsoid = Region::Ellipsoid { center: [0.0; 3], semi_axes };
        let on = [semi_axes[0] * theta.sin() * phi.cos(), semi_axes[1] * theta.sin() * phi.sin(), semi_axes[2] * theta.cos()];
        prop_assert!((Vector(x) - Vector(on)).norm() >= ellipsoid.signed_distance(x).abs() - 1e-9);
        let level: f64 = (0..3).map(|i| (x[i] / semi_axes[i]).powi(2)).sum();
        prop_assert_eq!(level < 1.0, ellipsoid.signed_distance(x) < 0.0);
    }

    #[test]
    fn a_cube_of_triangles_is_the_box(x in point()) {
        let surface = Region::Surface(Arc::new(Surface::new(cube(0.8)).unwrap()));
        let cuboid = Region::Box { lower: [-0.8; 3], upper: [0.8; 3] };
        prop_assert!((surface.signed_distance(x) - cuboid.signed_distance(x)).abs() < 1e-12);
    }

    #[test]
    fn unions_intersections_and_differences_contain_what_sets_do(x in point()) {
        let a = || r#"{ shape = "sphere", center = [0, 0, 0], radius = 2 }"#;
        let b = || r#"{ shape = "box", lower = [0, -1, -1], upper = [3, 1, 1] }"#;
        let (in_a, in_b) = (build(a(), 3).unwrap().contains(x), build(b(), 3).unwrap().contains(x));
        let has = |toml: String| build(&toml, 3).unwrap().contains(x);
        prop_assert_eq!(has(format!(r#"{{ shape = "union", of = [{}, {}] }}"#, a(), b())), in_a || in_b);
        prop_assert_eq!(has(format!(r#"{{ shape = "intersection", of = [{}, {}] }}"#, a(), b())), in_a && in_b);
        prop_assert_eq!(has(format!(r#"{{ shape = "difference", of = {}, minus = [{}] }}"#, a(), b())), in_a && !in_b);
        prop_assert_eq!(has(format!(r#"{{ shape = "complement", of = {} }}"#, a())), !in_a);
    }

    #[test]
    fn random_bytes_never_panic_the_surface_readers(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = Triangles::from_stl(bytes.clone(), 1.0);
        let _ = Triangles::from_obj(&bytes, 1.0);
    }

    #[test]
    fn a_torn_surface_file_is_an_error(keep in 0usize..684, flip in 0usize..684, value in any::<u8>()) {
        let mut bytes = stl(&cube(1.0));
        prop_assert!(Triangles::from_stl(bytes[..keep].to_vec(), 1.0).is_err());
        bytes[flip] = value;
        let _ = Triangles::from_stl(bytes, 1.0).map(Surface::new);
    }
}

#[test]
fn surfaces_from_files_have_their_volume_and_inside() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = stl(&cube(1.5));
    bytes[..5].copy_from_slice(b"solid");
    std::fs::write(folder.path().join("cube.stl"), bytes).unwrap();
    let region = shape(r#"{ shape = "surface", file = "cube.stl", unit = 0.001 }"#).build(folder.path(), 3).unwrap();
    assert!((region.measure(3).unwrap() - 27e-9).abs() < 1e-18);
    assert!(region.contains([1.4e-3; 3]) && !region.contains([1.6e-3; 3]));
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let tetrahedron = Surface::new(Triangles::from_obj(obj.as_bytes(), 2.0).unwrap()).unwrap();
    assert!((tetrahedron.volume() - 8.0 / 6.0).abs() < 1e-15);
}

/// The roof over a unit square with heights 1, 1.2, 1, 1.2 at the corners holds 1.1; cut along one diagonal, 16/15 or
/// 17/15.
#[test]
fn the_volume_under_quadrilaterals_is_independent_of_diagonals() {
    let roof = |heights: [f64; 4]| {
        let [a, b, c, d] = heights;
        format!(
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 {a}\nv 1 0 {b}\nv 1 1 {c}\nv 0 1 {d}\n\
             f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
        )
    };
    for heights in [[1.0, 1.2, 1.0, 1.2], [1.2, 1.0, 1.2, 1.0]] {
        let surface = Surface::new(Triangles::from_obj(roof(heights).as_bytes(), 1.0).unwrap()).unwrap();
        assert!((surface.volume() - 1.1).abs() < 1e-14, "{}", surface.volume());
    }
    let dart = "v 0 0 0\nv 1 0 0\nv 0.1 0.1 0\nv 0 1 0\nf 1 2 3 4\n";
    let told = Triangles::from_obj(dart.as_bytes(), 1.0).unwrap_err();
    assert!(told.contains("face 0 has 4 corners and folds back") && told.contains("as triangles"), "{told}");
}

#[test]
fn signed_distances_to_an_l_shaped_surface_are_those_of_its_prism() {
    // The prism over an L, triangulated by hand; the same region as a polygon is the reference.
    let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let mut vertices: Vec<[f64; 3]> = l.iter().map(|c| [c[0], c[1], 0.0]).collect();
    vertices.extend(l.iter().map(|c| [c[0], c[1], 1.0]));
    let caps = [[0u32, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let mut triangles: Vec<[u32; 3]> = caps.iter().flat_map(|&[a, b, c]| [[a, c, b], [a + 6, b + 6, c + 6]]).collect();
    triangles.extend((0..6u32).flat_map(|i| {
        let j = (i + 1) % 6;
        [[i, j, j + 6], [i, j + 6, i + 6]]
    }));
    let surface = Region::Surface(Arc::new(Surface::new(Triangles { vertices, triangles }).unwrap()));
    let prism = Region::Polygon(Arc::new(Polygon::new(l.map(Vector).to_vec(), 0.0, 1.0).unwrap()));
    assert!((surface.measure(3).unwrap() - 3.0).abs() < 1e-14);
    for i in 0..20 * 20 * 5 {
        let x = [-0.43 + 0.15 * (i % 20) as f64, -0.41 + 0.15 * (i / 20 % 20) as f64, -0.3 + 0.35 * (i / 400) as f64];
        assert!((surface.signed_distance(x) - prism.signed_distance(x)).abs() < 1e-12, "{x:?}");
    }
}

/// Solid angle of the surface seen from x, over 4π: 1 inside, 0 outside (van Oosterom & Strackee 1983).
fn winding_number(surface: &Triangles, x: [f64; 3]) -> f64 {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| Vector(surface.vertices[v as usize]) - Vector(x));
        let (p, q, r) = (a.norm(), b.norm(), c.norm());
        let below = p * q * r + a.dot(b) * r + b.dot(c) * p + c.dot(a) * q;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    surface.triangles.iter().map(angle).sum::<f64>() / (4.0 * PI)
}

#[test]
fn the_inside_of_a_spiky_surface_is_where_its_winding_number_is_one() {
    let sphere: lateen::mesh::MembraneShape =
        toml::from_str("shape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\ndivisions = 5\nelements = \"triangles\"")
            .unwrap();
    let sphere = sphere.build(Path::new("."), 3).unwrap();
    // Every node moves in or out by up to a half: sharp spikes and pits.
    let spike = |i: usize| 1.0 + 0.5 * (12.9898 * i as f64).sin();
    let vertices = sphere.nodes.iter().enumerate().map(|(i, x)| x.map(|c| c * spike(i))).collect();
    let triangles = sphere.elements.iter().map(|e| [e[0], e[1], e[2]]).collect();
    let triangles = Triangles { vertices, triangles };
    let region = Region::Surface(Arc::new(Surface::new(triangles.clone()).unwrap()));
    let mut inside = 0;
    for i in 0..24 * 24 * 24 {
        let x = [i % 24, i / 24 % 24, i / 576].map(|k| -1.6 + 0.139 * k as f64);
        let winding = winding_number(&triangles, x);
        assert!((winding - winding.round()).abs() < 1e-9);
        assert_eq!(region.contains(x), winding.round() == 1.0, "{x:?}");
        inside += usize::from(region.contains(x));
    }
    assert!(inside > 500);
}

#[test]
fn volumes_agree_with_counted_particles() {
    let cases = [
        (r#"{ shape = "box", lower = [0, 0, 0], upper = [1, 0.5, 0.75] }"#, 3, 0.375),
        (r#"{ shape = "ellipsoid", center = [0, 0, 0], semi-axes = [0.5, 1, 0.7] }"#, 3, 4.0 / 3.0 * PI * 0.35),
        (r#"{ shape = "ellipsoid", center = [0, 0], semi-axes = [0.5, 1] }"#, 2, PI * 0.5),
        (r#"{ shape = "cylinder", from = [0, 0, 0], to = [1, 1, 1], radius = 0.5 }"#, 3, PI * 0.25 * 3f64.sqrt()),
        (r#"{ shape = "polygon", corners = [[0, 0], [0, 1], [0.97, 0]], heights = [0, 2] }"#, 3, 0.97),
        (r#"{ shape = "polygon", corners = [[0, 0], [0, 1], [0.97, 0]] }"#, 2, 0.485),
        (
            r#"{ shape = "translated", by = [5, 6], of = { shape = "sphere", center = [0, 0], radius = 0.5 } }"#,
            2,
            PI * 0.25,
        ),
    ];
    for (toml, dimension, exact) in cases {
        let region = build(toml, dimension).unwrap();
        assert!((region.measure(dimension).unwrap() / exact - 1.0).abs() < 1e-12, "{toml}");
        let origin = centred_origin(&region, 0.02, dimension).unwrap();
        let particles = sample(&region, 0.02, dimension, origin).unwrap();
        let counted = particles.volume * particles.position.len() as f64;
        assert!((counted / exact - 1.0).abs() < 0.02, "{toml}: {counted} for {exact}");
    }
}

#[test]
fn bounds_of_a_region_are_tight() {
    let cylinder = Region::Cylinder { from: [0.0; 3], to: [0.0, 3.0, 4.0], radius: 1.0 };
    let Bounds { lower, upper } = cylinder.bounds();
    let expected = ([-1.0, -0.8, -0.6], [1.0, 3.8, 4.6]);
    (0..3).for_each(|i| assert!((lower[i] - expected.0[i]).abs() < 1e-12 && (upper[i] - expected.1[i]).abs() < 1e-12));
    let turned = r#"{ shape = "rotated", angle = 0.7853981633974483, of = { shape = "box", lower = [-1, -1], upper = [1, 1] } }"#;
    let bounds = build(turned, 2).unwrap().bounds();
    assert!((bounds.upper[0] - 2f64.sqrt()).abs() < 1e-12 && bounds.is_bounded(2));
    let cut = r#"{ shape = "intersection", of = [{ shape = "half-space", point = [0, 0], normal = [0, 1] }, { shape = "sphere", center = [0, 0], radius = 2 }] }"#;
    assert_eq!(build(cut, 2).unwrap().bounds().upper[1], 0.0);
}

#[test]
fn wrong_shapes_are_errors_at_their_key() {
    let cases = [
        (r#"{ shape = "sphere", center = [0, 0, 0], radius = -1 }"#, 3, "radius", "positive"),
        (r#"{ shape = "sphere", center = [0, 0, 0], radius = 1 }"#, 2, "center", "2 dimensions"),
        (r#"{ shape = "box", lower = [0, 0], upper = [1, 0] }"#, 2, "upper", "along y"),
        (r#"{ shape = "half-space", point = [0, 0], normal = [0, 0] }"#, 2, "normal", "length"),
        (r#"{ shape = "cylinder", from = [0, 0, 0], to = [0, 0, 0], radius = 1 }"#, 3, "to", "coincide"),
        (r#"{ shape = "polygon", corners = [[0, 0], [1, 1], [1, 0], [0, 1]] }"#, 2, "corners", "cross"),
        (r#"{ shape = "polygon", corners = [[0, 0], [1, 0], [2, 0]] }"#, 2, "corners", "touch"),
        (r#"{ shape = "polygon", corners = [[0, 0], [1, 0], [0, 1]] }"#, 3, "heights", "3D"),
        (r#"{ shape = "surface", file = "absent.stl" }"#, 3, "file", "can't be read"),
        (r#"{ shape = "union", of = [] }"#, 3, "of", "empty"),
        (
            r#"{ shape = "union", of = [{ shape = "complement", of = { shape = "sphere", center = [0, 0], radius = 0 } }] }"#,
            2,
            "of[0].of.radius",
            "positive",
        ),
    ];
    for (toml, dimension, key, message) in cases {
        let finding = build(toml, dimension).expect_err(toml);
        assert_eq!(finding.key, key, "{toml}");
        assert!(finding.message.contains(message), "{toml}: {finding}");
    }
}

#[test]
fn open_folded_and_degenerate_surfaces_are_errors() {
    let told = |triangles: Triangles| Surface::new(triangles).expect_err("unsound");
    let mut open = cube(1.0);
    open.triangles.pop();
    assert!(told(open).contains("not closed: it has 3 open edges"));
    let mut turned = cube(1.0);
    turned.triangles[4].swap(0, 1);
    assert!(told(turned).contains("oriented alike"));
    let mut doubled = cube(1.0);
    doubled.triangles.push(doubled.triangles[0]);
    assert!(told(doubled).contains("manifold"));
    let mut flat = cube(1.0);
    flat.vertices.iter_mut().for_each(|v| v[2] = 0.0);
    assert!(told(flat).contains("degenerate"));
    let mut inward = cube(1.0);
    inward.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!((Surface::new(inward).unwrap().volume() - 8.0).abs() < 1e-12);
}

#[test]
fn unknown_keys_of_a_shape_are_refused() {
    let parsed: Result<Shape, _> = toml::from_str("shape = \"sphere\"\ncenter = [0, 0]\nradius = 1\nradios = 2");
    assert!(parsed.unwrap_err().to_string().contains("radios"));
}
