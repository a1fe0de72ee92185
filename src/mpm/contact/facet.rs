//! Elements of a sheet: areas, sizes, free edges and closest points.

use crate::math::Vector;
use hashbrown::{HashMap, HashSet};

/// An element: its nodes (unused ones repeat the last) and their number, 2 to 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SheetFacet {
    /// Nodes.
    pub nodes: [u32; 4],
    /// Number of nodes.
    pub count: usize,
}

impl SheetFacet {
    /// The facet of 2 (segment), 3 (triangle) or 4 (quadrilateral) nodes.
    pub fn new(nodes: &[u32]) -> Self {
        let last = nodes.len().min(4) - 1;
        Self { nodes: std::array::from_fn(|k| nodes[k.min(last)]), count: last + 1 }
    }

    /// Nodes of the facet.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.count]
    }

    /// Node values at the facet's corners.
    pub fn corners<const D: usize>(&self, values: &[Vector<D>]) -> [Vector<D>; 4] {
        self.nodes.map(|k| values[k as usize])
    }

    /// The vector area [m²] (2D: length [m]): ½ r₃₁ × r₄₂, ½ r₂₁ × r₃₁, or the segment's tangent × z.
    pub fn area<const D: usize>(&self, position: &[Vector<D>]) -> Vector<D> {
        let x = self.corners(position);
        match self.count {
            2 => {
                let t = x[1] - x[0];
                Vector::from_fn(|i| if i == 0 { t[1] } else { -t[0] })
            }
            3 => half_cross(x[1] - x[0], x[2] - x[0]),
            _ => half_cross(x[2] - x[0], x[3] - x[1]),
        }
    }

    /// Longest side of the facet [m].
    pub fn size<const D: usize>(&self, position: &[Vector<D>]) -> f64 {
        let next = |k: usize| if k + 1 < self.count { k + 1 } else { 0 };
        let side = |k: usize| (position[self.nodes[k] as usize] - position[self.nodes[next(k)] as usize]).norm();
        (0..self.count).map(side).fold(0.0, f64::max)
    }
}

fn half_cross<const D: usize>(a: Vector<D>, b: Vector<D>) -> Vector<D> {
    Vector::from3(Vector(a.to3()).cross(Vector(b.to3())).0) * 0.5
}

/// The free edges: those that belong to one facet only.
pub fn free_edges(facets: &[SheetFacet]) -> HashSet<[u32; 2]> {
    let mut count: HashMap<[u32; 2], u32> = HashMap::new();
    for edge in facets.iter().flat_map(edges) {
        *count.entry(edge).or_insert(0) += 1;
    }
    count.into_iter().filter(|&(_, n)| n == 1).map(|(edge, _)| edge).collect()
}

/// Edges of a facet with their nodes ascending; the ends of a segment count as edges of one node.
fn edges(facet: &SheetFacet) -> impl Iterator<Item = [u32; 2]> {
    let nodes = facet.nodes().to_vec();
    let segment = nodes.len() == 2;
    (0..nodes.len()).map(move |k| {
        let (a, b) = (nodes[k], if segment { nodes[k] } else { nodes[(k + 1) % nodes.len()] });
        [a.min(b), a.max(b)]
    })
}
