//! Edges of solids in three dimensions, where facets meet at an angle, as straight pieces.

use super::facet::SurfaceFacet;
use super::{NodeWeights, SolidSurface, quadratic::line};
use crate::math::Vector;
use std::collections::BTreeMap;

/// Cosine of the angle between the normals of two facets below which an edge lies between them: 30° to four digits.
const EDGE_COSINE: f64 = 0.866;

/// The square of the cosine of 30°, for projections on normals of either sign.
pub const EDGE_COSINE_SQUARED: f64 = 0.75;

/// Distance of the middle of an edge from the line between its ends, over their distance, from which on it is curved.
const CURVED: f64 = 1e-3;

/// Pieces of a curved edge.
const PIECES: usize = 4;

/// Facets that meet at an end of an edge from which on it is a corner of the solid: edges go on through ends of two.
const CORNER: usize = 3;

/// An end of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeEnd<const D: usize> {
    /// A number that all pieces have in common that meet there.
    pub number: usize,
    /// True where three edges or more meet.
    pub is_corner: bool,
    /// Coordinate along the edge, −1 to 1.
    local: f64,
    /// Position [m].
    pub position: Vector<D>,
}

/// A straight piece of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgePiece<const D: usize> {
    /// The three global nodes of the edge.
    nodes: [u32; 3],
    /// Two ends of the edge.
    pub ends: [EdgeEnd<D>; 2],
    /// Mean of the normals of the facets that meet there.
    pub normal: Vector<D>,
}

impl<const D: usize> EdgePiece<D> {
    /// Shape functions of global nodes at a fraction of the way along it.
    pub fn weights(&self, fraction: f64) -> NodeWeights {
        let [start, end] = self.ends.map(|end| end.local);
        let [shape, ..] = line(start + (end - start) * fraction);
        self.nodes.into_iter().zip(shape).filter(|(_, weight)| *weight != 0.0).collect()
    }

    /// Unit tangent.
    pub fn tangent(&self) -> Option<Vector<D>> {
        (self.ends[1].position - self.ends[0].position).normalized()
    }

    /// The place there [m].
    pub fn at(&self, fraction: f64) -> Vector<D> {
        let [start, end] = self.ends.map(|end| end.position);
        start + (end - start) * fraction
    }
}

/// An edge of a solid.
struct SharpEdge<const D: usize> {
    /// Its nodes: an end, the middle, the other end.
    nodes: [u32; 3],
    /// Sum of the normals of its two facets.
    normal: Vector<D>,
}

impl<const D: usize> SolidSurface<D> {
    /// The edges of all solids, in an order that the nodes give; none in two dimensions.
    pub fn sharp_edges(&self) -> Vec<EdgePiece<D>> {
        if D != 3 {
            return Vec::new();
        }
        let mut sides: Vec<([u32; 3], Vector<D>)> = self.facets.iter().flat_map(sides).collect();
        sides.sort_by_key(|(nodes, _)| *nodes);
        let edge = |group: &[([u32; 3], Vector<D>)]| match group {
            [(nodes, first), (_, second)] if first.dot(*second) < EDGE_COSINE => {
                Some(SharpEdge { nodes: *nodes, normal: *first + *second })
            }
            _ => None,
        };
        let is_finite = |nodes: &[u32; 3]| nodes.iter().all(|&node| self.positions[node as usize].is_finite());
        let edges: Vec<SharpEdge<D>> =
            sides.chunk_by(|a, b| a.0 == b.0).filter_map(edge).filter(|edge| is_finite(&edge.nodes)).collect();
        let mut meeting: BTreeMap<u32, usize> = BTreeMap::new();
        edges
            .iter()
            .flat_map(|edge| [edge.nodes[0], edge.nodes[2]])
            .for_each(|node| *meeting.entry(node).or_default() += 1);
        let mut pieces = Vec::new();
        edges.iter().for_each(|edge| self.divide(edge, |node| meeting[&node] >= CORNER, &mut pieces));
        pieces
    }

    /// Adds the pieces of an edge.
    fn divide(&self, edge: &SharpEdge<D>, is_corner: impl Fn(u32) -> bool, pieces: &mut Vec<EdgePiece<D>>) {
        let &SharpEdge { nodes, normal } = edge;
        let x = nodes.map(|node| self.positions[node as usize]);
        let is_curved = (x[1] - (x[0] + x[2]) * 0.5).norm() > CURVED * (x[2] - x[0]).norm();
        let count = if is_curved { PIECES } else { 1 };
        let first = self.positions.len() + pieces.len();
        let end = |k: usize| {
            let local = 2.0 * k as f64 / count as f64 - 1.0;
            let node = if k == 0 { Some(nodes[0]) } else { (k == count).then_some(nodes[2]) };
            let position = x.iter().zip(line(local)[0]).map(|(x, shape)| *x * shape).sum();
            let (number, is_corner) = node.map_or((first + k, false), |node| (node as usize, is_corner(node)));
            EdgeEnd { number, is_corner, local, position }
        };
        pieces.extend((0..count).map(|k| EdgePiece { nodes, ends: [end(k), end(k + 1)], normal }));
    }
}

/// The sides of a facet of 9 nodes, from the lower end to the higher, with the normal of the facet in their middle;
/// none that are a point.
fn sides<const D: usize>(facet: &SurfaceFacet<D>) -> Vec<([u32; 3], Vector<D>)> {
    let sides = [([0, 1, 2], [0.0, -1.0]), ([6, 7, 8], [0.0, 1.0]), ([0, 3, 6], [-1.0, 0.0]), ([2, 5, 8], [1.0, 0.0])];
    let side = |(nodes, middle): ([usize; 3], [f64; 2])| {
        let [a, b, c] = nodes.map(|k| facet.nodes[k]);
        let normal = facet.normal(middle).normalized()?;
        (a != c).then_some(([a.min(c), b, a.max(c)], normal))
    };
    sides.into_iter().filter_map(side).collect()
}
