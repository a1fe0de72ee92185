//! The part of a cut element outside of solids as simplices (theory J.2).
//!
//! One node outside leaves a corner, all but one, and two of a tetrahedron, a prism between edges (a quadrilateral in
//! 2D). The global numbers of nodes choose the diagonals of its sides, the same in the element behind them.

use crate::math::Tensor;

/// A corner of a sub-simplex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Vertex {
    /// A local node of the element.
    Node(u8),
    /// A cut point, by its place in the element's list.
    Point(u8),
}

/// A simplex of the part of an element outside of solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FluidSimplex<const N: usize> {
    /// Its corners, in an order of positive volume.
    pub vertices: [Vertex; N],
}

/// Edges between a local node outside and one inside, in this order, by ascending lower and then higher node.
pub fn cut_edges<const N: usize>(inside: [bool; N]) -> Vec<[usize; 2]> {
    let edges = (0..N).flat_map(|i| (i + 1..N).map(move |j| [i, j]));
    let is_cut = |[i, j]: &[usize; 2]| inside[*i] != inside[*j];
    edges.filter(is_cut).map(|[i, j]| if inside[i] { [j, i] } else { [i, j] }).collect()
}

/// The simplices of the part outside, given the element's nodes and which of them are inside.
pub fn outside<const N: usize>(nodes: &[u32; N], inside: [bool; N]) -> Vec<FluidSimplex<N>> {
    let edges = cut_edges(inside);
    let (mut own, mut other): (Vec<usize>, Vec<usize>) = (0..N).partition(|&k| !inside[k]);
    own.sort_unstable_by_key(|&k| nodes[k]);
    other.sort_unstable_by_key(|&k| nodes[k]);
    let node = |k: usize| Vertex::Node(k as u8);
    let point =
        |i: usize, j: usize| Vertex::Point(edges.iter().position(|edge| *edge == [i, j]).unwrap_or_default() as u8);
    let parts = match (&own[..], &other[..]) {
        (&[a], rest) => vec![std::array::from_fn(|k| if k == 0 { node(a) } else { point(a, rest[k - 1]) })],
        (rest, &[a]) => {
            let lower: Vec<Vertex> = rest.iter().map(|&i| point(i, a)).collect();
            let upper: Vec<Vertex> = rest.iter().map(|&i| node(i)).collect();
            prism(&lower, &upper)
        }
        // Diagonals run from the cut point at the lower number to the node with the higher one, as above.
        (&[b, a], &[c, d]) => prism(&[node(a), point(a, c), point(a, d)], &[node(b), point(b, c), point(b, d)]),
        _ => Vec::new(),
    };
    parts.into_iter().map(|vertices| oriented(vertices, &edges)).collect()
}

/// A prism between two facets with corresponding corners, as simplices: {(p,b,c,d), (p,q,c,d), (p,q,r,d)}.
fn prism<const N: usize>(lower: &[Vertex], upper: &[Vertex]) -> Vec<[Vertex; N]> {
    let simplex = |k: usize| std::array::from_fn(|i| if i <= k { lower[i] } else { upper[i - 1] });
    (0..lower.len()).map(simplex).collect()
}

/// The simplex with its corners in an order of positive volume. That order is the same wherever the points lie on their
/// edges.
fn oriented<const N: usize>(mut vertices: [Vertex; N], edges: &[[usize; 2]]) -> FluidSimplex<N> {
    let barycentric = |vertex: Vertex| -> [f64; N] {
        let nodes = match vertex {
            Vertex::Node(k) => [usize::from(k); 2],
            Vertex::Point(k) => edges[usize::from(k)],
        };
        std::array::from_fn(|k| nodes.iter().filter(|node| **node == k).count() as f64 * 0.5)
    };
    let corners = vertices.map(barycentric);
    let sides = Tensor::<3>::from_fn(|i, j| match (i + 1 < N, j + 1 < N) {
        (true, true) => corners[i + 1][j + 1] - corners[0][j + 1],
        (false, false) => 1.0,
        _ => 0.0,
    });
    if sides.determinant() < 0.0 {
        vertices.swap(N - 2, N - 1);
    }
    FluidSimplex { vertices }
}
