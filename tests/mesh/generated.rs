//! Generated membranes: areas and enclosed volumes against formulas, consistent normals, named sets;
//! what the checks find in meshes that were broken on purpose.

use lateen::math::Vector;
use lateen::mesh::check::{Problem, check};
use lateen::mesh::{Facets, MembraneShape};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;

fn shape(toml: &str) -> MembraneShape {
    let table: HashMap<String, MembraneShape> = toml::from_str(&format!("s = {toml}")).expect(toml);
    table.into_values().next().unwrap()
}

fn build(toml: &str, dimension: usize) -> Facets {
    let facets = shape(toml).build(Path::new("."), dimension).expect(toml);
    assert_eq!(check(&facets), [], "{toml}");
    facets
}

const KINDS: [&str; 3] = ["quadrilaterals", "triangles", "union-jack"];

fn relative(value: f64, exact: f64) -> f64 {
    (value / exact - 1.0).abs()
}

#[test]
fn sheets_have_their_area_normal_and_sides() {
    for kind in KINDS {
        for (normal, axis, sides) in [("\"z\"", 2, [0, 1]), ("\"x\"", 0, [1, 2]), ("\"y\"", 1, [2, 0])] {
            let sheet = build(
                &format!(
                    "{{ shape = \"sheet\", center = [1, 2, 3], size = [4, 6], divisions = [4, 3], normal = {normal}, elements = \"{kind}\" }}"
                ),
                3,
            );
            assert_eq!(sheet.elements.len(), if kind == "quadrilaterals" { 12 } else { 24 });
            let area: Vector<3> = (0..sheet.elements.len()).map(|e| sheet.area_vector(e)).sum();
            assert!((area - Vector::unit(axis) * 24.0).norm() < 1e-12, "{kind} {normal}: {area:?}");
            let centre = [1.0, 2.0, 3.0];
            for (name, side, offset) in [("left", 0, -2.0), ("right", 0, 2.0), ("front", 1, -3.0), ("back", 1, 3.0)] {
                let nodes = sheet.set(name).unwrap();
                let along = sides[side];
                assert_eq!(nodes.len(), if side == 0 { 4 } else { 5 });
                for n in nodes {
                    assert!((sheet.nodes[n as usize][along] - centre[along] - offset).abs() < 1e-12);
                }
            }
            assert_eq!(sheet.set("edges").unwrap().len(), 14);
            assert_eq!(sheet.set("all").unwrap().len(), 20);
            assert_eq!(sheet.set("absent"), None);
        }
    }
}

#[test]
fn the_first_axis_of_a_tilted_sheet_is_the_direction_that_was_given() {
    let sheet = build(
        r#"{ shape = "sheet", center = [0, 0, 0], size = [2, 1], divisions = [2, 1], normal = [0, -1, 1], along = [1, 1, 1] }"#,
        3,
    );
    let first = Vector(sheet.nodes[1]) - Vector(sheet.nodes[0]);
    assert!((first - Vector([1.0, 1.0, 1.0]) * 3f64.sqrt().recip()).norm() < 1e-12);
}

#[test]
fn union_jack_diagonals_alternate_and_those_of_triangles_do_not() {
    let diagonals = |kind: &str| {
        let sheet = build(
            &format!(
                "{{ shape = \"sheet\", center = [0, 0, 0], size = [2, 2], divisions = [2, 2], elements = \"{kind}\" }}"
            ),
            3,
        );
        // The middle node of a union-jack square belongs to all eight triangles or to four.
        sheet.elements.iter().filter(|e| e.contains(&4)).count()
    };
    assert_eq!(diagonals("triangles"), 6);
    assert_eq!(diagonals("union-jack"), 8);
}

#[test]
fn spheres_converge_to_their_area_and_volume() {
    for kind in KINDS {
        let error = |n: usize| {
            let sphere = build(
                &format!(
                    "{{ shape = \"sphere\", center = [1, -2, 3], radius = 2, divisions = {n}, elements = \"{kind}\" }}"
                ),
                3,
            );
            assert!(sphere.boundary_nodes().is_empty());
            // Euler: nodes − edges + faces = 2.
            let edges: usize = sphere.elements.iter().map(Vec::len).sum::<usize>() / 2;
            assert_eq!(sphere.nodes.len() + sphere.elements.len(), edges + 2, "{kind}");
            let volume = sphere.enclosed(3);
            assert!(volume > 0.0, "normals point out");
            relative(volume, 4.0 / 3.0 * PI * 8.0).max(relative(sphere.area(), 16.0 * PI))
        };
        let (coarse, fine) = (error(6), error(12));
        assert!(fine < 0.01 && coarse / fine > 3.6 && coarse / fine < 4.4, "{kind}: {coarse} {fine}");
    }
}

#[test]
fn elements_of_a_sphere_have_similar_areas() {
    // No reference: guards against the ratio of 5 or more of elements at the poles or corners of a naive mapping.
    for (kind, spread) in [("quadrilaterals", 1.5), ("triangles", 2.1)] {
        let sphere = build(
            &format!("{{ shape = \"sphere\", center = [0, 0, 0], radius = 1, divisions = 8, elements = \"{kind}\" }}"),
            3,
        );
        let areas: Vec<f64> = (0..sphere.elements.len()).map(|e| sphere.area_vector(e).norm()).collect();
        let (least, most) = areas.iter().fold((f64::MAX, 0f64), |(l, m), &a| (l.min(a), m.max(a)));
        assert!(most / least < spread, "{kind}: {}", most / least);
    }
}

#[test]
fn discs_have_no_flat_corners() {
    for n in [2, 3, 5, 10] {
        let disc = build(&format!("{{ shape = \"disc\", center = [0, 0, 1], radius = 2, divisions = {n} }}"), 3);
        let corner = |e: &[u32], i: usize| {
            let x = |k: usize| Vector(disc.nodes[e[k % 4] as usize]);
            let (a, b) = (x(i + 1) - x(i), x(i + 3) - x(i));
            (a.dot(b) / (a.norm() * b.norm())).acos().to_degrees()
        };
        let angles = disc.elements.iter().flat_map(|e| (0..4).map(|i| corner(e, i)));
        let (least, most) = angles.fold((180f64, 0f64), |(l, m), a| (l.min(a), m.max(a)));
        assert!(least > 40.0 && most < 140.0, "{n}: {least}° to {most}°");
        let rim = disc.set("edges").unwrap();
        assert!(rim.iter().all(|&i| (Vector(disc.nodes[i as usize]) - Vector([0.0, 0.0, 1.0])).norm() - 2.0 < 1e-12));
        let mut sorted = rim.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, disc.boundary_nodes());
        assert_eq!(disc.set("center").map(|c| disc.nodes[c[0] as usize]), Some([0.0, 0.0, 1.0]));
        // The inscribed polygon through the rim nodes has exactly this area.
        let m = rim.len() as f64;
        assert!(relative(disc.area(), 0.5 * m * 4.0 * (2.0 * PI / m).sin()) < 1e-12);
    }
}

#[test]
fn cylinders_are_prisms_with_outward_normals() {
    for kind in KINDS {
        let mantle = build(
            &format!(
                "{{ shape = \"cylinder\", from = [0, 0, 0], to = [0, 0, 3], radius = 2, divisions = [24, 4], elements = \"{kind}\" }}"
            ),
            3,
        );
        let polygon = 2.0 * 24.0 * 2.0 * (PI / 24.0).sin();
        assert!(relative(mantle.area(), 3.0 * polygon) < 1e-12);
        for e in 0..mantle.elements.len() {
            let [x, y, _] = mantle.center(e).0;
            assert!(mantle.area_vector(e).dot(Vector([x, y, 0.0])) > 0.0);
        }
        assert_eq!(mantle.set("front").unwrap().len(), 24);
        assert_eq!(mantle.boundary_nodes().len(), 48);
    }
    let short =
        build(r#"{ shape = "cylinder", from = [0, 0, 0], to = [0, 0, 1], radius = 1, divisions = [48, 1] }"#, 3);
    assert_eq!((short.nodes.len(), short.elements.len()), (96, 48));
    let strip = build(
        r#"{ shape = "cylinder", from = [0, 0, 0], to = [0, 0, 1], radius = 1, divisions = [6, 1], arc = [0, 1.5707963267948966] }"#,
        3,
    );
    let left = strip.set("left").unwrap();
    assert!(left.iter().all(|&n| strip.nodes[n as usize][1].abs() < 1e-15));
    assert!(strip.set("right").unwrap().iter().all(|&n| strip.nodes[n as usize][0].abs() < 1e-15));
}

#[test]
fn the_quarter_tube_of_the_gas_expansion_has_15_squares_and_32_nodes() {
    let tube = build(
        r#"{ shape = "tube", points = [[0.5, 0], [0.5, 1], [0, 1]], divisions = [10, 5], heights = [0, 0.1], layers = 1 }"#,
        3,
    );
    assert_eq!((tube.elements.len(), tube.nodes.len()), (15, 32));
    for e in 0..15 {
        assert!((tube.area_vector(e).norm() - 0.01).abs() < 1e-15);
        assert!(tube.area_vector(e).dot(tube.center(e)) > 0.0, "normals point away from the gas");
    }
}

#[test]
fn closed_chains_and_circles_enclose_their_area_counter_clockwise() {
    let square = build(
        r#"{ shape = "chain", points = [[0, 0], [2, 0], [2, 1], [0, 1]], divisions = [4, 2, 4, 2], closed = true }"#,
        2,
    );
    assert_eq!((square.nodes.len(), square.elements.len()), (12, 12));
    assert!((square.enclosed(2) - 2.0).abs() < 1e-14 && (square.area() - 6.0).abs() < 1e-14);
    assert!(square.boundary_nodes().is_empty());
    let circle = build(r#"{ shape = "circle", center = [1, 1], radius = 1, divisions = 60 }"#, 2);
    assert!(relative(circle.enclosed(2), 30.0 * (PI / 30.0).sin()) < 1e-12);
    let chain = build(r#"{ shape = "chain", points = [[0, 0], [1, 0]], divisions = [10] }"#, 2);
    assert_eq!(
        (chain.set("left"), chain.set("right"), chain.set("edges")),
        (Some(vec![0]), Some(vec![10]), Some(vec![0, 10]))
    );
    assert_eq!(chain.area_vector(0).0, [0.0, -0.1, 0.0]);
    assert_eq!(chain.nearest_node([0.52, 3.0, 0.0]), Some(5));
}

#[test]
fn wrong_membranes_are_errors_at_their_key() {
    let cases = [
        (r#"{ shape = "sheet", center = [0, 0, 0], size = [1, 0], divisions = [1, 1] }"#, 3, "size"),
        (r#"{ shape = "sheet", center = [0, 0, 0], size = [1, 1], divisions = [0, 1] }"#, 3, "divisions"),
        (r#"{ shape = "sheet", center = [0, 0, 0], size = [1, 1], divisions = [100000, 100000] }"#, 3, "divisions"),
        (r#"{ shape = "sheet", center = [0, 0, 0], size = [1, 1], divisions = [1, 1] }"#, 2, "shape"),
        (r#"{ shape = "sheet", center = [0, 0, 0], size = [1, 1], divisions = [1, 1], along = "z" }"#, 3, "along"),
        (r#"{ shape = "sphere", center = [0, 0, 0], radius = 1, divisions = 9223372036854775807 }"#, 3, "divisions"),
        (r#"{ shape = "disc", center = [0, 0, 0], radius = 1, divisions = 1 }"#, 3, "divisions"),
        (r#"{ shape = "cylinder", from = [0, 0, 0], to = [0, 0, 0], radius = 1, divisions = [8, 1] }"#, 3, "to"),
        (
            r#"{ shape = "cylinder", from = [0, 0, 0], to = [0, 0, 1], radius = 1, divisions = [8, 1], arc = [1, 0] }"#,
            3,
            "arc",
        ),
        (r#"{ shape = "chain", points = [[0, 0], [0, 0]], divisions = [2] }"#, 2, "points[0]"),
        (r#"{ shape = "chain", points = [[0, 0], [0, 1]], divisions = [2, 2] }"#, 2, "divisions"),
        (r#"{ shape = "file", path = "absent.msh" }"#, 3, "path"),
    ];
    for (toml, dimension, key) in cases {
        let finding = shape(toml).build(Path::new("."), dimension).expect_err(toml);
        assert_eq!(finding.key, key, "{toml}: {finding}");
    }
}

/// Two quadrilaterals and a triangle stay what they are; a pentagon is no element.
#[test]
fn faces_of_an_obj_file_with_three_or_four_corners_become_elements() {
    let folder = tempfile::tempdir().unwrap();
    let shape: MembraneShape = toml::from_str("shape = \"file\"\npath = \"a.obj\"").unwrap();
    let read = |faces: &str| {
        let nodes = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 2 0\n";
        std::fs::write(folder.path().join("a.obj"), format!("{nodes}{faces}")).unwrap();
        shape.build(folder.path(), 3)
    };
    let facets = read("f 1 2 5 4\nf 2 3 6 5\nf 4 5 7\n").unwrap();
    assert_eq!(facets.elements.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4, 3]);
    assert!((facets.area() - 2.5).abs() < 1e-14);
    let told = read("f 1 2 5 4\nf 2 3 6 7 5\n").unwrap_err();
    assert!(told.message.contains("face 1 has 5 corners: elements have three or four"), "{told}");
}

fn sheet() -> Facets {
    build(r#"{ shape = "sheet", center = [0, 0, 0], size = [4, 4], divisions = [4, 4] }"#, 3)
}

fn problems(facets: &Facets) -> Vec<Problem> {
    check(facets).into_iter().map(|finding| finding.problem).collect()
}

#[test]
fn the_check_of_a_mesh_finds_every_kind_of_defect() {
    let mut inverted = sheet();
    inverted.elements[5].reverse();
    assert_eq!(problems(&inverted), [Problem::Inverted { element: 5, neighbour: 1 }]);

    let mut degenerate = sheet();
    degenerate.nodes[6] = degenerate.nodes[7];
    assert!(problems(&degenerate).contains(&Problem::DuplicateNodes { nodes: [6, 7] }));

    let mut flat = sheet();
    flat.elements.push(vec![0, 1, 2]);
    assert!(problems(&flat).contains(&Problem::Degenerate { element: 16 }));

    let mut folded = sheet();
    folded.elements[0].swap(2, 3);
    assert!(
        problems(&folded)
            .iter()
            .any(|p| matches!(p, Problem::Degenerate { element: 0 } | Problem::Folded { element: 0 }))
    );

    let mut fin = sheet();
    fin.nodes.push([0.0, 0.0, 1.0]);
    fin.elements.push(vec![6, 7, 25]);
    assert_eq!(problems(&fin), [Problem::NonManifold { element: 1, count: 3 }]);

    let mut loose = sheet();
    loose.nodes.push([9.0; 3]);
    assert_eq!(problems(&loose), [Problem::Unreferenced { node: 25 }]);

    let mut torn = sheet();
    torn.elements[3][0] = 99;
    torn.nodes[4][1] = f64::NAN;
    assert_eq!(problems(&torn), [Problem::Malformed { element: 3 }, Problem::NotFinite { node: 4 }]);
    assert_eq!(problems(&Facets::default()), [Problem::Empty]);

    let mut chain = build(r#"{ shape = "chain", points = [[0, 0], [1, 0]], divisions = [4] }"#, 2);
    chain.elements[2].reverse();
    assert_eq!(problems(&chain), [Problem::Inverted { element: 2, neighbour: 1 }]);
}
