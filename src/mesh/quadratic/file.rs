//! Meshes of solids from Gmsh files.

use super::raised::{self, Raised};
use super::{QUADRILATERAL, QuadraticMesh};
use crate::error::Diagnostic;
use crate::mesh::gmsh::{self, Cell, GmshMesh};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The same as [`QUADRILATERAL`] of a hexahedron: corners, middles of edges, of faces, of the element.
const HEXAHEDRON: [usize; 27] =
    [0, 8, 1, 9, 20, 11, 3, 13, 2, 10, 21, 12, 22, 26, 23, 15, 24, 14, 4, 16, 5, 17, 25, 18, 7, 19, 6];

/// A mesh from a Gmsh file (`.msh`, versions 2.2 and 4.1): triangles and quadrilaterals in 2D, tetrahedra or hexahedra
/// in 3D, of first or, for curved sides, of second order (`Mesh.ElementOrder = 2`). Triangles are parted in three
/// quadrilaterals, tetrahedra in four hexahedra, all of second order. The physical groups of the file are the names of
/// its node sets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QuadraticFile {
    /// The file, relative to the case file.
    pub path: PathBuf,
    /// Physical group of the solid's elements; by default all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Length of one unit of the file [m]: `unit = "1 mm"` for a file in millimetres.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub unit: f64,
}

fn one() -> f64 {
    1.0
}

impl QuadraticFile {
    /// Reads the mesh. The file is looked for below `base_dir`.
    ///
    /// # Errors
    /// A finding with a key relative to this mesh: an unreadable file, kinds of elements that aren't read, no such
    /// group, elements that fold.
    pub fn read(&self, base_dir: &Path, dimension: usize) -> Result<QuadraticMesh, Diagnostic> {
        if !(self.unit > 0.0 && self.unit.is_finite()) {
            return Err(Diagnostic::error("unit", format!("must be positive and finite, not {}", self.unit)));
        }
        let wrong = |key: &str, why: String| Diagnostic::error(key, format!("{}: {why}", self.path.display()));
        let file = gmsh::read_quadratic(&base_dir.join(&self.path)).map_err(|why| wrong("path", why.to_string()))?;
        let key = if self.group.is_some() { "group" } else { "path" };
        QuadraticMesh::from_gmsh(&file, self.group.as_deref(), dimension, self.unit).map_err(|why| wrong(key, why))
    }
}

impl QuadraticMesh {
    /// The elements of a physical group, or all of them; `unit` is the length of one unit of the file [m].
    ///
    /// # Errors
    /// No such group or element; in 2D a mesh that leaves the plane z = 0; elements that fold.
    fn from_gmsh(file: &GmshMesh<27>, group: Option<&str>, dimension: usize, unit: f64) -> Result<Self, String> {
        let cells = file.cells_of(group, dimension)?;
        let Raised { mut mesh, cells: numbers } = match raised::is_as_read(&cells) {
            true => Self::as_read(file, &cells, dimension),
            false => raised::raised(file, &cells, dimension)?,
        };
        mesh.nodes.iter_mut().for_each(|x| *x = x.map(|c| c * unit));
        if dimension == 2 {
            gmsh::flatten(&mut mesh.nodes)?;
        }
        mesh.turn_inverted();
        match mesh.folded() {
            Some((e, [x, y, z])) => Err(format!("element {} is folded at ({x:.6}, {y:.6}, {z:.6})", numbers[e])),
            None => Ok(mesh),
        }
    }

    /// Quadrilaterals of 9 nodes or hexahedra of 27.
    fn as_read(file: &GmshMesh<27>, cells: &[Cell<27>], dimension: usize) -> Raised {
        let mut used: Vec<u32> = cells.iter().flat_map(|cell| cell.nodes()).copied().collect();
        used.sort_unstable();
        used.dedup();
        let nodes = used.iter().map(|&n| file.nodes[n as usize]).collect();
        let order = if dimension == 2 { &QUADRILATERAL[..] } else { &HEXAHEDRON[..] };
        let element =
            |own: &[u32]| order.iter().filter_map(|&a| used.binary_search(&own[a]).ok()).map(|n| n as u32).collect();
        let elements = cells.iter().map(|cell| element(cell.nodes())).collect();
        let mesh = Self { dimension, nodes, elements, sets: file.node_sets(&used) };
        Raised { mesh, cells: cells.iter().map(|cell| cell.number).collect() }
    }

    /// Elements whose nodes run clockwise, or left-handed, change their first two directions.
    fn turn_inverted(&mut self) {
        for e in 0..self.elements.len() {
            if self.jacobian(e, [0.0; 3]) < 0.0 {
                let own = self.elements[e].clone();
                self.elements[e] = (0..own.len()).map(|a| own[a / 9 * 9 + a % 3 * 3 + a / 3 % 3]).collect();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;

    /// A file as Gmsh writes it for one element of second order; `places` of its nodes in Gmsh's order.
    fn file(kind: usize, places: &[[f64; 3]], line: &str) -> String {
        let nodes: String = (1..).zip(places).map(|(n, [x, y, z])| format!("{n} {x} {y} {z}\n")).collect();
        let own: Vec<String> = (1..=places.len()).map(|n| n.to_string()).collect();
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n1 7 \"held\"\n$EndPhysicalNames\n$Nodes\n{}\n{nodes}$EndNodes\n\
             $Elements\n2\n{line}\n2 {kind} 2 3 1 {}\n$EndElements\n",
            places.len(),
            own.join(" ")
        )
    }

    fn read(text: &str, dimension: usize) -> Result<QuadraticMesh, Diagnostic> {
        let home = tempfile::tempdir().unwrap();
        std::fs::write(home.path().join("solid.msh"), text).unwrap();
        QuadraticFile { path: "solid.msh".into(), group: None, unit: 1e-3 }.read(home.path(), dimension)
    }

    /// Nodes of a rectangle in the order that the manual of Gmsh draws: corners, then edges 0-1, 1-2, 2-3, 3-0, then
    /// the middle.
    const RECTANGLE: [[f64; 3]; 9] = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [2.0, 0.5, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 0.5, 0.0],
        [1.0, 0.5, 0.0],
    ];

    #[test]
    fn a_quadrilateral_of_nine_nodes_is_read_with_its_groups() {
        let mesh = read(&file(10, &RECTANGLE, "1 8 2 7 1 1 4 8"), 2).unwrap();
        assert!((mesh.volume() - 2e-6).abs() < 1e-18);
        // Nodes 1, 4 and 8 of the file: the left side.
        let held: Vec<[f64; 3]> = mesh.sets["held"].iter().map(|&n| mesh.nodes[n as usize]).collect();
        assert!(held.len() == 3 && held.iter().all(|x| x[0] == 0.0));
        let mut mirrored = RECTANGLE;
        mirrored.iter_mut().for_each(|x| x[0] = -x[0]);
        assert!((read(&file(10, &mirrored, "1 8 2 7 1 1 4 8"), 2).unwrap().volume() - 2e-6).abs() < 1e-18);
    }

    /// The edges and faces of the manual's drawing of a hexahedron, by the corners that they join.
    #[test]
    fn a_hexahedron_of_27_nodes_is_read() {
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 2.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.0, 0.0, 3.0],
            [1.0, 0.0, 3.0],
            [1.0, 2.0, 3.0],
            [0.0, 2.0, 3.0],
        ];
        let joined: [&[usize]; 19] = [
            &[0, 1],
            &[0, 3],
            &[0, 4],
            &[1, 2],
            &[1, 5],
            &[2, 3],
            &[2, 6],
            &[3, 7],
            &[4, 5],
            &[4, 7],
            &[5, 6],
            &[6, 7],
            &[0, 1, 2, 3],
            &[0, 1, 5, 4],
            &[0, 3, 7, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[4, 5, 6, 7],
            &[0, 1, 2, 3, 4, 5, 6, 7],
        ];
        let middle = |own: &&[usize]| {
            std::array::from_fn(|k| own.iter().map(|&c| corners[c][k]).sum::<f64>() / own.len() as f64)
        };
        let places: Vec<[f64; 3]> = corners.into_iter().chain(joined.iter().map(middle)).collect();
        let mesh = read(&file(12, &places, "1 8 2 7 1 1 2 9"), 3).unwrap();
        assert!((mesh.volume() - 6e-9).abs() < 1e-21);
        let place = Vector(mesh.position(0, [0.5, -0.5, 0.5]));
        assert!((place - Vector([0.75e-3, 0.5e-3, 2.25e-3])).norm() < 1e-17);
    }

    #[test]
    fn what_is_not_read_is_refused_with_what_to_do() {
        let incomplete = read(&file(16, &RECTANGLE[..8], "1 8 2 7 1 1 4 8"), 2).unwrap_err();
        assert!(incomplete.key == "path" && incomplete.message.contains("SecondOrderIncomplete"), "{incomplete:?}");
        let prism = read(&file(6, &RECTANGLE[..6], "1 8 2 7 1 1 2 4"), 3).unwrap_err();
        assert!(prism.message.contains("tetrahedra or hexahedra"), "{prism:?}");
        let mut folded = RECTANGLE;
        folded[2] = [0.1, 0.1, 0.0];
        let folded = read(&file(10, &folded, "1 8 2 7 1 1 4 8"), 2).unwrap_err();
        assert!(folded.message.contains("element 2 is folded"), "{folded:?}");
    }

    /// A file of nodes and elements, each of a kind with its group, as Gmsh writes it.
    fn mixed(places: &[[f64; 3]], elements: &[(usize, usize, &[usize])]) -> String {
        let nodes: String = (1..).zip(places).map(|(n, [x, y, z])| format!("{n} {x} {y} {z}\n")).collect();
        let line = |(number, (kind, group, own)): (usize, &(usize, usize, &[usize]))| {
            let own: Vec<String> = own.iter().map(|n| (n + 1).to_string()).collect();
            format!("{number} {kind} 2 {group} 1 {}\n", own.join(" "))
        };
        let lines: String = (1..).zip(elements).map(line).collect();
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 7 \"line\"\n2 8 \"face\"\n3 9 \"part\"\n$EndPhysicalNames\n\
             $Nodes\n{}\n{nodes}$EndNodes\n$Elements\n{}\n{lines}$EndElements\n",
            places.len(),
            elements.len()
        )
    }

    /// A cube of side 2 in five tetrahedra, of first and of second order: its volume, and faces that fit together: the
    /// surface of the parts is that of the cube.
    #[test]
    fn tetrahedra_are_parted_in_hexahedra_that_fit_together() {
        let corners: Vec<[f64; 3]> =
            (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| 2.0 * f64::from(bit))).collect();
        let cut: [[usize; 4]; 5] = [[0, 3, 5, 6], [1, 0, 3, 5], [2, 0, 6, 3], [4, 0, 5, 6], [7, 3, 6, 5]];
        let face: [usize; 3] = [1, 3, 5];
        for order in [1, 2] {
            let mut places = corners.clone();
            let mut with_middles = |own: &[usize], edges: &[[usize; 2]]| -> Vec<usize> {
                let mut all = own.to_vec();
                for edge in edges.iter().filter(|_| order == 2) {
                    let [a, b] = edge.map(|k| places[own[k]]);
                    let middle = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
                    let known = places.iter().position(|x| *x == middle);
                    all.push(known.unwrap_or(places.len()));
                    if known.is_none() {
                        places.push(middle);
                    }
                }
                all
            };
            let edges = [[0, 1], [1, 2], [2, 0], [3, 0], [2, 3], [1, 3]];
            let whole: Vec<Vec<usize>> = cut.iter().map(|own| with_middles(own, &edges)).collect();
            let side = with_middles(&face, &edges[..3]);
            let mut elements: Vec<(usize, usize, &[usize])> =
                whole.iter().map(|own| (if order == 1 { 4 } else { 11 }, 9, &own[..])).collect();
            elements.push((if order == 1 { 2 } else { 9 }, 8, &side));
            let mesh = read(&mixed(&places, &elements), 3).unwrap();
            assert!((mesh.volume() - 8e-9).abs() < 1e-21, "{}", mesh.volume());
            assert_eq!((mesh.elements.len(), mesh.sets["part"].len()), (20, mesh.nodes.len()));
            // Three corners, nine nodes on edges, seven inside.
            let face = &mesh.sets["face"];
            assert!(face.len() == 19 && face.iter().all(|&n| (mesh.nodes[n as usize][0] - 2e-3).abs() < 1e-18));
            let surface = mesh.set("surface").unwrap();
            let is_outside = |&n: &u32| mesh.nodes[n as usize].iter().any(|c| !(1e-12..=2e-3 - 1e-12).contains(c));
            assert!(surface.iter().all(is_outside), "faces inside don't fit together");
        }
    }

    /// A quarter of a disc of a curved triangle beside a curved quadrilateral: they fit together, and the arcs stay
    /// those of the file's shape functions.
    #[test]
    fn triangles_beside_quadrilaterals_fit_together_and_keep_curved_sides() {
        let on = |radius: f64, degrees: f64| {
            let angle = degrees.to_radians();
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        };
        let places = [
            [0.0; 3],
            on(1.0, 0.0),
            on(1.0, 90.0),
            [0.5, 0.0, 0.0],
            on(1.0, 45.0),
            [0.0, 0.5, 0.0],
            on(2.0, 0.0),
            on(2.0, 90.0),
            on(1.5, 0.0),
            on(2.0, 45.0),
            on(1.5, 90.0),
            on(1.5, 45.0),
        ];
        let elements: [(usize, usize, &[usize]); 3] =
            [(9, 8, &[0, 1, 2, 3, 4, 5]), (10, 8, &[1, 6, 7, 2, 8, 9, 10, 4, 11]), (8, 7, &[6, 7, 9])];
        let mesh = read(&mixed(&places, &elements), 2).unwrap();
        assert_eq!((mesh.elements.len(), mesh.sets["line"].len()), (7, 5));
        // A parabola through the ends and the middle of an arc: half the triangle, and two thirds of the sagitta.
        let (chord, sagitta) = (2.0f64.sqrt(), 1.0 - 0.5f64.sqrt());
        let exact = 4.0 * (0.5 + 2.0 / 3.0 * chord * sagitta);
        assert!((mesh.volume() * 1e6 - exact).abs() < 1e-12, "{} {exact}", mesh.volume() * 1e6);
        let surface = mesh.set("surface").unwrap();
        let inner = |n: &u32| Vector(mesh.nodes[*n as usize]).norm() < 1.2e-3;
        assert!(
            surface.iter().filter(|n| inner(n)).all(|&n| mesh.nodes[n as usize][..2].iter().any(|c| c.abs() < 1e-12))
        );
    }
}
