//! Elements of files as quadrilaterals and hexahedra of second order: triangles and tetrahedra are parted, those of
//! first order get nodes inside.
//!
//! ```text
//! triangle, corner k:       k, middles of its two sides, centroid                      3 quadrilaterals
//! tetrahedron, corner k:    k, middles of its 3 edges, centroids of its 3 faces, its own     4 hexahedra
//! vertex of a piece = mean of k and some of the other corners;    nodes between them: means of the vertices around
//! ```
//!
//! A node is identified by the corners of the file around it and their weights, so that elements with a side or a face
//! in common share its nodes. Weights are whole numbers of 96ths: vertices of pieces are means of up to 4 corners,
//! whose weights are 12ths, and nodes are means of up to 8 vertices. Beside triangles quadrilaterals are parted in four.
//! Sides of second order stay curved: nodes lie where the shape functions of the file's elements put them.

use super::{QUADRILATERAL, QuadraticMesh};
use crate::mesh::gmsh::{Cell, CellKind, GmshMesh};
use hashbrown::HashMap;

/// Weights of the corners that make a node, by nodes of the file, in parts of [`WHOLE`].
type NodeKey = Vec<(u32, u16)>;

/// Sum of the weights of a node.
const WHOLE: u16 = 96;

/// Sum of the weights of the vertex of a piece.
const OF_VERTEX: u16 = 12;

/// The pieces of an element: of each the weights of the corners of the element at its vertices, 2ᴰ of them, in 12ths.
type Pieces = Vec<Vec<[u16; 8]>>;

/// A mesh of second order.
pub(super) struct Raised {
    /// The mesh, in units of the file.
    pub mesh: QuadraticMesh,
    /// The file's number of the element from which each of its elements comes.
    pub cells: Vec<i64>,
}

/// True if elements of a file are taken as they are.
pub(super) fn is_as_read(cells: &[Cell<27>]) -> bool {
    let kinds = [CellKind::QuadraticQuadrilateral, CellKind::QuadraticHexahedron];
    cells.iter().all(|cell| kinds.contains(&cell.kind))
}

/// The elements of a file, with nodes at places in its units.
///
/// # Errors
/// Kinds that don't fit together.
pub(super) fn raised(file: &GmshMesh<27>, cells: &[Cell<27>], dimension: usize) -> Result<Raised, String> {
    let is_simplex = |cell: &Cell<27>| corners(cell.kind) == dimension + 1;
    let is_parted = cells.iter().any(is_simplex);
    if dimension == 3 && is_parted && !cells.iter().all(is_simplex) {
        return Err("hexahedra and tetrahedra in one solid don't fit together; mesh it with tetrahedra alone".into());
    }
    let mut made = RaisedNodes { file, known: HashMap::new(), nodes: Vec::new() };
    let (mut elements, mut numbers) = (Vec::new(), Vec::new());
    for cell in cells {
        for piece in pieces(cell.kind, is_parted) {
            elements.push(keys(cell, &piece).into_iter().map(|key| made.node(cell, key)).collect());
            numbers.push(cell.number);
        }
    }
    let members = |cell: &Cell<27>| -> Vec<u32> {
        let all = pieces(cell.kind, is_parted).into_iter().flat_map(|piece| keys(cell, &piece));
        all.filter_map(|key| made.known.get(&key).copied()).collect()
    };
    let sets = file.node_sets_of(members);
    let mesh = QuadraticMesh { dimension, nodes: made.nodes, elements, sets };
    Ok(Raised { mesh, cells: numbers })
}

/// Nodes made so far.
struct RaisedNodes<'a> {
    file: &'a GmshMesh<27>,
    known: HashMap<NodeKey, u32>,
    nodes: Vec<[f64; 3]>,
}

impl RaisedNodes<'_> {
    /// The node of an element with this key.
    fn node(&mut self, cell: &Cell<27>, key: NodeKey) -> u32 {
        if let Some(&node) = self.known.get(&key) {
            return node;
        }
        let weight = |corner: u32| key.iter().find(|(node, _)| *node == corner).map_or(0, |&(_, weight)| weight);
        let own = &cell.nodes()[..corners(cell.kind)];
        let weights: Vec<f64> = own.iter().map(|&corner| f64::from(weight(corner)) / f64::from(WHOLE)).collect();
        let shape = shape(cell.kind, &weights);
        let at = |axis: usize| -> f64 {
            cell.nodes().iter().zip(&shape).map(|(&node, shape)| self.file.nodes[node as usize][axis] * shape).sum()
        };
        let position = [at(0), at(1), at(2)];
        let node = self.nodes.len() as u32;
        self.nodes.push(position);
        self.known.insert(key, node);
        node
    }
}

/// Number of corners of a kind of element.
fn corners(kind: CellKind) -> usize {
    match kind {
        CellKind::Point => 1,
        CellKind::Line | CellKind::QuadraticLine => 2,
        CellKind::Triangle | CellKind::QuadraticTriangle => 3,
        CellKind::Quadrilateral
        | CellKind::QuadraticQuadrilateral
        | CellKind::Tetrahedron
        | CellKind::QuadraticTetrahedron => 4,
        CellKind::Hexahedron | CellKind::QuadraticHexahedron => 8,
    }
}

/// The pieces of an element; lines and quadrilaterals, too, have some where simplices are parted.
fn pieces(kind: CellKind, is_parted: bool) -> Pieces {
    match kind {
        CellKind::Point => vec![vec![unit(0)]],
        CellKind::Triangle | CellKind::QuadraticTriangle => of_simplex(2),
        CellKind::Tetrahedron | CellKind::QuadraticTetrahedron => of_simplex(3),
        CellKind::Line | CellKind::QuadraticLine if is_parted => of_simplex(1),
        CellKind::Line | CellKind::QuadraticLine => vec![vec![unit(0), unit(1)]],
        CellKind::Quadrilateral | CellKind::QuadraticQuadrilateral if is_parted => {
            let quarter = |k: u16| (0..4).map(|b| bilinear(k % 2 + b % 2, k / 2 + b / 2)).collect();
            (0..4).map(quarter).collect()
        }
        CellKind::Quadrilateral | CellKind::QuadraticQuadrilateral => vec![[0, 1, 3, 2].map(unit).to_vec()],
        CellKind::Hexahedron | CellKind::QuadraticHexahedron => vec![[0, 1, 3, 2, 4, 5, 7, 6].map(unit).to_vec()],
    }
}

/// A corner itself.
fn unit(corner: usize) -> [u16; 8] {
    std::array::from_fn(|k| if k == corner { OF_VERTEX } else { 0 })
}

/// Weights of the corners of a quadrilateral at (x/2, y/2) of it.
fn bilinear(x: u16, y: u16) -> [u16; 8] {
    let [left, low] = [2 - x, 2 - y];
    let quarter = OF_VERTEX / 4;
    [left * low * quarter, x * low * quarter, x * y * quarter, left * y * quarter, 0, 0, 0, 0]
}

/// A piece at each corner of a simplex: its vertices are the means of that corner and of some of the others.
fn of_simplex(dimension: usize) -> Pieces {
    let piece = |k: usize| {
        let vertex = |chosen: usize| {
            let count = chosen.count_ones() as u16 + 1;
            let is_in = |corner: usize| {
                let others = (corner + dimension - k) % (dimension + 1);
                corner == k || others < dimension && chosen >> others & 1 == 1
            };
            std::array::from_fn(|corner| if corner <= dimension && is_in(corner) { OF_VERTEX / count } else { 0 })
        };
        (0..1 << dimension).map(vertex).collect()
    };
    (0..=dimension).map(piece).collect()
}

/// The keys of the 3ᴰ nodes of a piece, in the order of elements of second order.
fn keys(cell: &Cell<27>, piece: &[[u16; 8]]) -> Vec<NodeKey> {
    let dimension = piece.len().trailing_zeros() as usize;
    let count = corners(cell.kind);
    let part = (WHOLE / OF_VERTEX) >> dimension;
    let node = |a: usize| {
        let along = |k: usize| (a / 3usize.pow(k as u32) % 3) as u16;
        let vertex_weight =
            |b: usize| (0..dimension).map(|k| if b >> k & 1 == 1 { along(k) } else { 2 - along(k) }).product::<u16>();
        let weight = |corner: usize| (0..piece.len()).map(|b| vertex_weight(b) * piece[b][corner]).sum::<u16>() * part;
        let all = cell.nodes()[..count].iter().enumerate().map(|(corner, &node)| (node, weight(corner)));
        let mut key: NodeKey = all.filter(|(_, weight)| *weight > 0).collect();
        key.sort_unstable();
        key
    };
    (0..3usize.pow(dimension as u32)).map(node).collect()
}

/// Shape functions of all nodes of an element where its corners have these weights: barycentric or multilinear
/// coordinates.
fn shape(kind: CellKind, weights: &[f64]) -> Vec<f64> {
    let edges: &[[usize; 2]] = match kind {
        CellKind::QuadraticTriangle => &[[0, 1], [1, 2], [2, 0]],
        CellKind::QuadraticTetrahedron => &[[0, 1], [1, 2], [2, 0], [3, 0], [2, 3], [1, 3]],
        CellKind::QuadraticQuadrilateral => return biquadratic(weights[1] + weights[2], weights[2] + weights[3]),
        _ => return weights.to_vec(),
    };
    let at_corners = weights.iter().map(|w| w * (2.0 * w - 1.0));
    at_corners.chain(edges.iter().map(|&[a, b]| 4.0 * weights[a] * weights[b])).collect()
}

/// Shape functions of a quadrilateral of nine nodes at (s, t), both from 0 to 1, in the order of the file.
fn biquadratic(s: f64, t: f64) -> Vec<f64> {
    let along = |s: f64| [(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)];
    let (x, y) = (along(s), along(t));
    let mut shape = vec![0.0; 9];
    QUADRILATERAL.iter().enumerate().for_each(|(a, &number)| shape[number] = x[a % 3] * y[a / 3]);
    shape
}
