//! Gmsh files: one mesh written by Gmsh 4.15 in four formats; errors of torn and wrong files.
//! `tests/fixtures/gmsh/make.py` made the files.

use lateen::mesh::check::check;
use lateen::mesh::gmsh::{CellKind, GmshMesh, parse};
use lateen::mesh::{Facets, MembraneShape};
use proptest::prelude::*;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

const FORMATS: [&str; 4] = ["2.2-ascii", "2.2-binary", "4.1-ascii", "4.1-binary"];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/gmsh")
}

fn bytes(format: &str) -> Vec<u8> {
    std::fs::read(folder().join(format!("plate-{format}.msh"))).unwrap()
}

fn mesh(format: &str) -> GmshMesh {
    parse(&bytes(format)).unwrap_or_else(|why| panic!("{format}: {why}"))
}

fn build(toml: &str, dimension: usize) -> Result<Facets, lateen::error::Diagnostic> {
    let table: HashMap<String, MembraneShape> = toml::from_str(&format!("s = {toml}")).expect(toml);
    table.into_values().next().unwrap().build(&folder(), dimension)
}

#[test]
fn every_format_gives_the_mesh_that_gmsh_wrote() {
    for format in FORMATS {
        let mesh = mesh(format);
        assert_eq!(mesh.nodes.len(), 19, "{format}");
        let of_kind = |kind| {
            let dimension = match kind {
                CellKind::Point => 0,
                CellKind::Line => 1,
                CellKind::Tetrahedron => 3,
                _ => 2,
            };
            mesh.cells_of(None, dimension).unwrap().iter().filter(|c| c.kind == kind).count()
        };
        let kinds =
            [CellKind::Point, CellKind::Line, CellKind::Triangle, CellKind::Quadrilateral, CellKind::Tetrahedron];
        assert_eq!(kinds.map(of_kind), [1, 2, 8, 4, 1], "{format}");
        let groups: Vec<_> = mesh.groups.iter().map(|g| (g.dimension, g.tag, g.name.as_str())).collect();
        let expected = [(0, 1, "corner"), (1, 2, "left side"), (2, 3, "sheet"), (2, 4, "triangles"), (3, 5, "block")];
        assert_eq!(groups, expected, "{format}");
    }
}

#[test]
fn groups_become_membranes_with_named_nodes() {
    for format in FORMATS {
        let sheet = mesh(format).facets(Some("sheet"), 3, 1e-3).unwrap();
        assert_eq!(check(&sheet), [], "{format}");
        assert_eq!((sheet.nodes.len(), sheet.elements.len()), (15, 12), "{format}");
        assert!((sheet.area() - 2e-6).abs() < 1e-17, "{format}");
        let left = sheet.set("left side").unwrap();
        assert_eq!(left.len(), 3, "{format}");
        assert!(left.iter().all(|&n| sheet.nodes[n as usize][0] == 0.0), "{format}");
        assert_eq!(sheet.set("corner").map(|n| sheet.nodes[n[0] as usize]), Some([0.0; 3]), "{format}");
        assert_eq!(sheet.set("block"), None, "{format}: shares no node");
        let part = mesh(format).facets(Some("triangles"), 3, 1.0).unwrap();
        assert_eq!((part.nodes.len(), part.elements.len()), (9, 8), "{format}");
    }
}

#[test]
fn the_lines_of_a_file_are_a_membrane_in_2d() {
    let chain = build(r#"{ shape = "file", path = "plate-4.1-binary.msh", group = "left side" }"#, 2).unwrap();
    assert_eq!(chain.elements.len(), 2);
    assert!((chain.area() - 1.0).abs() < 1e-12);
    let all = build(r#"{ shape = "file", path = "plate-2.2-ascii.msh", group = "sheet", unit = 2.0 }"#, 3).unwrap();
    assert!((all.area() - 8.0).abs() < 1e-12);
}

#[test]
fn unknown_groups_are_errors_that_list_the_known_ones() {
    let told = |toml: &str| build(toml, 3).unwrap_err();
    let unknown = told(r#"{ shape = "file", path = "plate-4.1-ascii.msh", group = "shet" }"#);
    assert_eq!(unknown.key, "group");
    assert!(unknown.message.contains("`sheet`, `triangles`"), "{unknown}");
    let lines = told(r#"{ shape = "file", path = "plate-4.1-ascii.msh", group = "left side" }"#);
    assert!(lines.message.contains("dimension 1"), "{lines}");
    let other = told(r#"{ shape = "file", path = "make.py" }"#);
    assert!(other.message.contains("ending"), "{other}");
}

fn edited(from: &str, to: &str) -> String {
    let text = String::from_utf8(bytes("2.2-ascii")).unwrap();
    assert!(text.contains(from), "{from}");
    parse(text.replacen(from, to, 1).as_bytes()).unwrap_err().to_string()
}

#[test]
fn wrong_files_are_errors_with_their_line() {
    let cases = [
        ("2.2 0 8", "3.0 0 8", "line 2: version 3.0 of the format is not read"),
        ("\n19\n", "\n19000000\n", "line 13: 19000000 entries are promised"),
        ("\n19\n", "\n-1\n", "line 13: a count can't be -1"),
        ("3 2 0 0", "3 2 zero 0", "line 16: expected a number, found `zero`"),
        ("3 2 0 0", "3 2 nan 0", "line 16: node 3 has a coordinate that is not finite"),
        ("3 2 0 0", "2 2 0 0", "line 16: there are two nodes of number 2"),
        ("4 2 2 3 2 2 12 17", "4 2 2 3 2 2 12 170", "an element names node 170"),
        ("4 2 2 3 2 2 12 17", "4 9 2 3 2 2 12 17", "Mesh.ElementOrder = 1"),
        ("4 2 2 3 2 2 12 17", "4 5 2 3 2 2 12 17", "hexahedra are not read"),
        ("4 2 2 3 2 2 12 17", "4 0 2 3 2 2 12 17", "there is no element type 0"),
        ("$EndNodes", "$EndNods", "expected $EndNodes"),
        ("\"left side\"", "left side", "line 7: expected a name in double quotes"),
        ("$MeshFormat", "$NOD", "not a Gmsh file"),
    ];
    for (from, to, message) in cases {
        let told = edited(from, to);
        assert!(told.contains(message), "{from} → {to}: {told}");
    }
}

/// A section of version 4.1 begins with counts and the range of its numbers, a block with its entity.
#[test]
fn headers_of_version_4_that_contradict_the_file_are_errors() {
    let text = String::from_utf8(bytes("4.1-ascii")).unwrap();
    let told = |section: &str, from: &str, to: &str| {
        let (before, after) = text.split_once(section).unwrap();
        assert!(after.contains(from), "{from}");
        parse(format!("{before}{section}{}", after.replacen(from, to, 1)).as_bytes()).unwrap_err().to_string()
    };
    for (from, to, message) in [
        ("20 19 1 19", "20 18 1 19", "the section promises 18 nodes, and has 19"),
        ("20 19 1 19", "20 19 2 19", "node 1 is there, where the section promises numbers from 2 to 19"),
        ("20 19 1 19", "20 19 1 18", "node 19 is there"),
        ("0 1 0 1\n1\n", "0 1 7 1\n1\n", "nodes have parameters (1) or not (0), not 7"),
        ("0 1 0 1\n1\n", "-1 1 0 1\n1\n", "an entity has dimension 0 to 3, not -1"),
    ] {
        let told = told("$Nodes\n", from, to);
        assert!(told.contains(message) && told.starts_with("line "), "{from} → {to}: {told}");
    }
    for (from, to, message) in [
        ("5 16 1 16", "5 15 1 16", "the section promises 15 elements, and has 16"),
        ("5 16 1 16", "5 16 1 9", "promises numbers from 1 to 9"),
        ("2 2 2 8", "1 2 2 8", "elements of dimension 2 in a block of dimension 1"),
        ("2 2 2 8", "2 77 2 8", "entity 77 of dimension 2 is not in $Entities"),
    ] {
        let told = told("$Elements\n", from, to);
        assert!(told.contains(message), "{from} → {to}: {told}");
    }
}

/// Broken elements are named by the numbers that the file has for them.
#[test]
fn broken_elements_are_errors_with_the_number_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let told = |from: &str, to: &str| {
        let text = String::from_utf8(bytes("2.2-ascii")).unwrap();
        std::fs::write(folder.path().join("a.msh"), text.replacen(from, to, 1)).unwrap();
        let shape: MembraneShape = toml::from_str("shape = \"file\"\npath = \"a.msh\"\ngroup = \"sheet\"").unwrap();
        shape.build(folder.path(), 3).unwrap_err().message
    };
    assert!(told("18 0.5000000000003758 0.5000000000003758 0", "18 -0.2 -0.2 0").contains("element 20 is folded"));
    assert!(told("8 2 2 3 2 17 19 5", "8 2 2 3 2 17 5 19").contains("element 8 is inverted"));
    assert!(told("8 2 2 3 2 17 19 5", "8 2 2 3 2 17 19 19").contains("element 8 covers nothing"));
}

#[test]
fn unknown_sections_are_skipped() {
    let mut text = String::from_utf8(bytes("4.1-ascii")).unwrap();
    text = text.replace("$Nodes", "$Comments\nmade for a test\n$EndComments\n$Nodes");
    assert_eq!(parse(text.as_bytes()).unwrap(), mesh("4.1-ascii"));
    assert!(parse(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n").unwrap_err().to_string().contains("no $Nodes"));
}

#[test]
fn every_truncation_is_an_error_or_the_whole_mesh() {
    for format in FORMATS {
        let (whole, bytes) = (mesh(format), bytes(format));
        let end = bytes.trim_ascii_end().len();
        for length in 0..bytes.len() {
            match parse(&bytes[..length]) {
                Ok(mesh) => assert!(length >= end && mesh == whole, "{format}: cut at {length}"),
                Err(why) => assert!(!why.message.is_empty()),
            }
        }
    }
}

proptest! {
    #[test]
    fn random_bytes_are_an_error(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        prop_assert!(parse(&bytes).is_err());
    }

    #[test]
    fn random_bytes_behind_a_header_are_an_error(binary in any::<bool>(), version in 0..2usize, bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut file = format!("$MeshFormat\n{} {} 8\n", ["2.2", "4.1"][version], u8::from(binary)).into_bytes();
        if binary {
            file.extend(1i32.to_le_bytes());
        }
        file.extend(b"\n$EndMeshFormat\n$Nodes\n");
        file.extend(bytes);
        prop_assert!(parse(&file).is_err());
    }

    #[test]
    fn changed_bytes_never_panic_the_reader(format in 0..4usize, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = bytes(FORMATS[format]);
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Ok(mesh) = parse(&bytes) {
            for dimension in [2, 3] {
                let _ = mesh.facets(None, dimension, 1.0).map(|facets| check(&facets));
            }
        }
    }
}
