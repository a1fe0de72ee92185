//! Files of Gmsh (`.msh`), versions 2.2 and 4.1, ASCII and binary (Gmsh reference manual, chapter 10).
//!
//! Points, lines, triangles, quadrilaterals and tetrahedra of first order are read, for solids also hexahedra, and all
//! of these of second order, quadrilaterals and hexahedra with all their nodes; with the physical groups that they
//! belong to. Counts are checked against the bytes that are left before memory is taken.

mod cursor;
mod select;
mod version2;
mod version4;

pub use cursor::{FilePlace, GmshError};
pub(super) use select::flatten;

use crate::input;
use crate::math::Vector;
use cursor::Cursor;
use hashbrown::HashMap;
use std::collections::BTreeMap;
use std::path::Path;

/// Contents of a Gmsh file, whose elements have `MOST_NODES` nodes at most: 4 in a file of first order, 27 in one for
/// solids.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GmshMesh<const MOST_NODES: usize = 4> {
    /// Node positions, in units of the file.
    pub nodes: Vec<[f64; 3]>,
    /// Numbers that the nodes have in the file.
    pub numbers: Vec<i64>,
    /// Elements of all dimensions, in the order of the file.
    pub cells: Vec<Cell<MOST_NODES>>,
    /// Physical groups.
    pub groups: Vec<PhysicalGroup>,
    /// Lists of physical tags; cells name theirs by number.
    memberships: Vec<Vec<i64>>,
}

/// A physical group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhysicalGroup {
    /// Dimension of its elements: 0 to 3.
    pub dimension: usize,
    /// Its number in the file.
    pub tag: i64,
    /// Its name; the number as text if it has none.
    pub name: String,
}

/// An element, with `MOST_NODES` nodes at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell<const MOST_NODES: usize = 4> {
    /// Its kind.
    pub kind: CellKind,
    /// Its number in the file.
    pub number: i64,
    nodes: [u32; MOST_NODES],
    membership: u32,
}

impl<const MOST_NODES: usize> Cell<MOST_NODES> {
    /// Its nodes, as indices into [`GmshMesh::nodes`].
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.kind.node_count()]
    }
}

/// Kinds of elements that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CellKind {
    /// A point.
    Point,
    /// A line of two nodes.
    Line,
    /// A triangle of three nodes.
    Triangle,
    /// A quadrilateral of four nodes.
    Quadrilateral,
    /// A tetrahedron of four nodes.
    Tetrahedron,
    /// A hexahedron of eight nodes.
    Hexahedron,
    /// A line of three nodes.
    QuadraticLine,
    /// A triangle of six nodes.
    QuadraticTriangle,
    /// A tetrahedron of ten nodes.
    QuadraticTetrahedron,
    /// A quadrilateral of nine nodes.
    QuadraticQuadrilateral,
    /// A hexahedron of 27 nodes.
    QuadraticHexahedron,
}

/// Orders of the elements of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum ElementOrder {
    /// Nodes at the corners.
    #[default]
    First,
    /// Or nodes at corners and in the middles of edges, and of the faces and insides of quadrilaterals and hexahedra.
    FirstOrSecond,
}

impl CellKind {
    /// Number of nodes.
    pub fn node_count(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Line => 2,
            Self::Triangle => 3,
            Self::Quadrilateral | Self::Tetrahedron => 4,
            Self::Hexahedron => 8,
            Self::QuadraticLine => 3,
            Self::QuadraticTriangle => 6,
            Self::QuadraticTetrahedron => 10,
            Self::QuadraticQuadrilateral => 9,
            Self::QuadraticHexahedron => 27,
        }
    }

    /// 0 for points to 3 for tetrahedra and hexahedra.
    pub fn dimension(self) -> usize {
        match self {
            Self::Point => 0,
            Self::Line | Self::QuadraticLine => 1,
            Self::Triangle | Self::Quadrilateral | Self::QuadraticTriangle | Self::QuadraticQuadrilateral => 2,
            Self::Tetrahedron | Self::Hexahedron | Self::QuadraticTetrahedron | Self::QuadraticHexahedron => 3,
        }
    }

    /// From Gmsh's number of the element type, in a file for elements of some orders.
    fn from_number(number: i64, order: ElementOrder) -> Result<Self, String> {
        match order {
            ElementOrder::First => Self::linear(number),
            ElementOrder::FirstOrSecond => Self::linear_or_quadratic(number),
        }
    }

    fn linear_or_quadratic(number: i64) -> Result<Self, String> {
        Ok(match number {
            15 => Self::Point,
            1 => Self::Line,
            2 => Self::Triangle,
            3 => Self::Quadrilateral,
            4 => Self::Tetrahedron,
            5 => Self::Hexahedron,
            8 => Self::QuadraticLine,
            9 => Self::QuadraticTriangle,
            10 => Self::QuadraticQuadrilateral,
            11 => Self::QuadraticTetrahedron,
            12 => Self::QuadraticHexahedron,
            6 | 7 => return Err("prisms and pyramids are not read; mesh with tetrahedra or hexahedra".into()),
            16 | 17 => {
                let message =
                    format!("element type {number} has no nodes inside; save with Mesh.SecondOrderIncomplete = 0");
                return Err(message);
            }
            13 | 14 | 18..=140 => {
                return Err(format!(
                    "element type {number} is not read; mesh with elements of order 1 or 2, triangles or quadrilaterals, tetrahedra or hexahedra"
                ));
            }
            _ => return Err(format!("there is no element type {number}")),
        })
    }

    fn linear(number: i64) -> Result<Self, String> {
        Ok(match number {
            15 => Self::Point,
            1 => Self::Line,
            2 => Self::Triangle,
            3 => Self::Quadrilateral,
            4 => Self::Tetrahedron,
            5 => return Err("hexahedra are not read; mesh with tetrahedra".into()),
            6 => return Err("prisms are not read; mesh with tetrahedra".into()),
            7 => return Err("pyramids are not read; mesh with tetrahedra".into()),
            8..=14 | 16..=140 => {
                return Err(format!("element type {number} is not of first order; save with Mesh.ElementOrder = 1"));
            }
            _ => return Err(format!("there is no element type {number}")),
        })
    }
}

/// Reads a file.
///
/// # Errors
/// Unreadable, torn, of another version, or with elements that are not read; with line or byte.
pub fn read(path: &Path) -> Result<GmshMesh, GmshError> {
    parse(&bytes(path)?)
}

/// Reads a file of triangles, quadrilaterals, tetrahedra and hexahedra of first or second order.
///
/// # Errors
/// As [`read`].
pub fn read_quadratic(path: &Path) -> Result<GmshMesh<27>, GmshError> {
    parse_as(&bytes(path)?, ElementOrder::FirstOrSecond)
}

fn bytes(path: &Path) -> Result<Vec<u8>, GmshError> {
    input::read(path).map_err(|why| GmshError { message: format!("can't be read: {why}"), place: FilePlace::File })
}

/// Reads the bytes of a file.
///
/// # Errors
/// As [`read`].
///
/// ```
/// use lateen::mesh::gmsh;
///
/// let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 9 \"plate\"\n$EndPhysicalNames\n\
///             $Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
///             $Elements\n2\n1 2 2 9 1 1 2 3\n2 2 2 9 1 1 3 4\n$EndElements\n";
/// let mesh = gmsh::parse(text.as_bytes()).unwrap();
/// assert_eq!((mesh.nodes.len(), mesh.cells[1].nodes()), (4, &[0, 2, 3][..]));
/// assert_eq!(mesh.groups[0].name, "plate");
/// assert!(gmsh::parse(b"solid cube\n").is_err());
/// ```
pub fn parse(bytes: &[u8]) -> Result<GmshMesh, GmshError> {
    parse_as(bytes, ElementOrder::First)
}

fn parse_as<const MOST_NODES: usize>(bytes: &[u8], order: ElementOrder) -> Result<GmshMesh<MOST_NODES>, GmshError> {
    let mut cursor = Cursor::new(bytes);
    let major = header(&mut cursor)?;
    let mut builder = Builder { order, ..Builder::default() };
    let mut sections = Vec::new();
    while let Some(name) = cursor.section()? {
        match (name.as_str(), major) {
            ("PhysicalNames", _) => physical_names(&mut cursor, &mut builder)?,
            ("Entities", 4) => version4::entities(&mut cursor, &mut builder)?,
            ("Nodes", 2) => version2::nodes(&mut cursor, &mut builder)?,
            ("Nodes", _) => version4::nodes(&mut cursor, &mut builder)?,
            ("Elements", 2) => version2::elements(&mut cursor, &mut builder)?,
            ("Elements", _) => version4::elements(&mut cursor, &mut builder)?,
            ("PartitionedEntities", _) => {
                return cursor.fail("partitioned meshes are not read; save the mesh in one part");
            }
            (other, _) => cursor.skip_section(other)?,
        }
        if ["PhysicalNames", "Entities", "Nodes", "Elements"].contains(&name.as_str()) {
            cursor.expect(&format!("$End{name}"))?;
        }
        sections.push(name);
    }
    for needed in ["Nodes", "Elements"] {
        if !sections.iter().any(|name| name == needed) {
            return Err(GmshError { message: format!("the file has no ${needed}"), place: FilePlace::File });
        }
    }
    Ok(builder.finish())
}

/// `$MeshFormat`: version, ASCII or binary, byte order. Returns 2 or 4.
fn header(cursor: &mut Cursor<'_>) -> Result<u32, GmshError> {
    match cursor.section()?.as_deref() {
        Some("MeshFormat") => {}
        _ => return cursor.fail("not a Gmsh file: it doesn't begin with $MeshFormat"),
    }
    let version = cursor.word()?;
    let major = match version {
        "2" | "2.1" | "2.2" => 2,
        "4.1" => 4,
        other => {
            let message = format!("version {other} of the format is not read; save as version 4.1 or 2.2");
            return cursor.fail(message);
        }
    };
    let binary = cursor.integer()?;
    if cursor.integer()? != 8 {
        return cursor.fail("numbers that don't have 8 bytes are not read");
    }
    match binary {
        0 => {}
        1 => cursor.begin_binary()?,
        other => return cursor.fail(format!("the file type is 0 (ASCII) or 1 (binary), not {other}")),
    }
    cursor.expect("$EndMeshFormat")?;
    Ok(major)
}

/// Text even in binary files: `dimension tag "name"`.
fn physical_names<const MOST_NODES: usize>(
    cursor: &mut Cursor<'_>,
    builder: &mut Builder<MOST_NODES>,
) -> Result<(), GmshError> {
    let count = cursor.text_integer()?;
    for _ in 0..cursor.checked_count(count, 6)? {
        let dimension = cursor.text_integer()?;
        if !(0..=3).contains(&dimension) {
            return cursor.fail(format!("a group has dimension 0 to 3, not {dimension}"));
        }
        let tag = cursor.text_integer()?;
        let name = cursor.quoted()?;
        builder.mesh.groups.push(PhysicalGroup { dimension: dimension as usize, tag: tag.abs(), name });
    }
    Ok(())
}

/// A mesh in the making: the file's numbers of nodes, entities and groups become indices.
#[derive(Default)]
struct Builder<const MOST_NODES: usize> {
    order: ElementOrder,
    mesh: GmshMesh<MOST_NODES>,
    index_of: HashMap<i64, u32>,
    membership_of: HashMap<Vec<i64>, u32>,
    /// Physical tags of each entity (dimension, tag), version 4 only.
    entities: BTreeMap<(i64, i64), Vec<i64>>,
}

impl<const MOST_NODES: usize> Builder<MOST_NODES> {
    fn node(&mut self, cursor: &Cursor<'_>, tag: i64, position: [f64; 3]) -> Result<(), GmshError> {
        if !Vector(position).is_finite() {
            return cursor.fail(format!("node {tag} has a coordinate that is not finite"));
        }
        if self.index_of.insert(tag, self.mesh.nodes.len() as u32).is_some() {
            return cursor.fail(format!("there are two nodes of number {tag}"));
        }
        self.mesh.nodes.push(position);
        self.mesh.numbers.push(tag);
        Ok(())
    }

    /// The number of a list of physical tags.
    fn membership(&mut self, mut tags: Vec<i64>) -> u32 {
        tags.iter_mut().for_each(|tag| *tag = tag.abs());
        tags.sort_unstable();
        let next = self.mesh.memberships.len() as u32;
        *self.membership_of.entry(tags).or_insert_with_key(|tags| {
            self.mesh.memberships.push(tags.clone());
            next
        })
    }

    /// A cell of a kind, with its number, whose nodes are read with `number`.
    fn cell<'a>(
        &mut self,
        cursor: &mut Cursor<'a>,
        kind: CellKind,
        own: i64,
        membership: u32,
        number: impl Fn(&mut Cursor<'a>) -> Result<i64, GmshError>,
    ) -> Result<(), GmshError> {
        let mut nodes = [0; MOST_NODES];
        for node in &mut nodes[..kind.node_count()] {
            let tag = number(cursor)?;
            match self.index_of.get(&tag) {
                Some(&index) => *node = index,
                None => return cursor.fail(format!("an element names node {tag}, which the file doesn't have")),
            }
        }
        self.mesh.cells.push(Cell { kind, number: own, nodes, membership });
        Ok(())
    }

    /// Groups without a name get their number as name.
    fn finish(mut self) -> GmshMesh<MOST_NODES> {
        for cell in &self.mesh.cells {
            for &tag in &self.mesh.memberships[cell.membership as usize] {
                let dimension = cell.kind.dimension();
                if !self.mesh.groups.iter().any(|g| g.dimension == dimension && g.tag == tag) {
                    self.mesh.groups.push(PhysicalGroup { dimension, tag, name: tag.to_string() });
                }
            }
        }
        self.mesh
    }
}
