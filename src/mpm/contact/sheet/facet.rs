//! Elements of a sheet: areas, sizes, free edges and closest points.

use crate::math::Vector;
use hashbrown::{HashMap, HashSet};

/// An element: its nodes (unused ones repeat the last) and their number, 2 to 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facet {
    /// Nodes.
    pub nodes: [u32; 4],
    /// Number of nodes.
    pub count: usize,
}

impl Facet {
    /// From 2 (segment), 3 (triangle) or 4 (quadrilateral) nodes.
    pub fn new(nodes: &[u32]) -> Self {
        let last = nodes.len().min(4) - 1;
        Self { nodes: std::array::from_fn(|k| nodes[k.min(last)]), count: last + 1 }
    }

    /// Its nodes.
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

    /// Its longest side [m].
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
pub fn free_edges(facets: &[Facet]) -> HashSet<[u32; 2]> {
    let mut count: HashMap<[u32; 2], u32> = HashMap::new();
    for edge in facets.iter().flat_map(edges) {
        *count.entry(edge).or_insert(0) += 1;
    }
    count.into_iter().filter(|&(_, n)| n == 1).map(|(edge, _)| edge).collect()
}

/// Edges of a facet with their nodes ascending; the ends of a segment count as edges of one node.
fn edges(facet: &Facet) -> impl Iterator<Item = [u32; 2]> {
    let nodes = facet.nodes().to_vec();
    let segment = nodes.len() == 2;
    (0..nodes.len()).map(move |k| {
        let (a, b) = (nodes[k], if segment { nodes[k] } else { nodes[(k + 1) % nodes.len()] });
        [a.min(b), a.max(b)]
    })
}

/// Barycentric weights of the point of the triangle (or, with two equal corners, the segment) closest to `x`
/// (Ericson, Real-Time Collision Detection, 5.1.5). Weights are exactly 0 or 1 on edges and corners.
pub fn closest_on_triangle<const D: usize>([a, b, c]: [Vector<D>; 3], x: Vector<D>) -> [f64; 3] {
    let (ab, ac, ax) = (b - a, c - a, x - a);
    let (d1, d2) = (ab.dot(ax), ac.dot(ax));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bx = x - b;
    let (d3, d4) = (ab.dot(bx), ac.dot(bx));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cx = x - c;
    let (d5, d6) = (ab.dot(cx), ac.dot(cx));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let total = va + vb + vc;
    [1.0 - (vb + vc) / total, vb / total, vc / total]
}
