//! The fluid part of an element that surfaces of a solid cut which meet at an edge, in three dimensions (theory J.2).
//!
//! ```text
//! groups               nodes outside that edges of the mesh join which no surface crosses
//! face of an element   a triangle or quadrilateral for each group; around the point e in which the edge of the solid
//!                      passes it a fan: triangles (side, e)
//! element              with the apex m on the edge of the solid a cone over the fluid part of its faces: tetrahedra
//!                      (triangle, m); else a tetrahedron or prism for each group
//! ```
//!
//! A convex element without a wedge that has its edge through m is seen from m as a whole, and so is the wedge:
//! the parts are exact where sides of solids are plane.

use super::{FluidSimplex, Vertex, parts};

/// An element with the points where surfaces cross its edges, each by a number.
pub struct CrossedElement<const N: usize> {
    /// The element.
    pub element: usize,
    /// Its nodes.
    pub nodes: [u32; N],
    /// True for nodes inside.
    pub inside: [bool; N],
    /// The point on the edge from a node outside, the first, next to that node.
    pub crossings: Vec<([usize; 2], u32)>,
}

/// Corners of a triangle on a face, and of the parts: nodes, and points by their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corner {
    /// A local node.
    Node(usize),
    /// A point.
    Point(u32),
}

impl<const N: usize> CrossedElement<N> {
    fn crossing(&self, from: usize, towards: usize) -> Option<u32> {
        self.crossings.iter().find(|(edge, _)| *edge == [from, towards]).map(|(_, number)| *number)
    }

    /// True if nodes are outside and no surface is between them.
    fn are_joined(&self, i: usize, j: usize) -> bool {
        !self.inside[i] && !self.inside[j] && self.crossing(i, j).is_none()
    }

    /// Edges between nodes outside that a solid crosses.
    fn crossed_twice(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.crossings.iter().map(|(edge, _)| *edge).filter(|[i, j]| i < j && !self.inside[*j])
    }

    /// True if a solid crosses an edge between nodes outside.
    pub fn has_crossed_twice(&self) -> bool {
        self.crossed_twice().next().is_some()
    }

    /// The groups of nodes outside among some of its nodes, each by ascending number.
    fn groups(&self, among: &[usize]) -> Vec<Vec<usize>> {
        let mut rest: Vec<usize> = among.iter().copied().filter(|&k| !self.inside[k]).collect();
        let mut groups = Vec::new();
        while let Some(first) = rest.pop() {
            let mut group = vec![first];
            while let Some(next) = rest.iter().position(|&k| group.iter().any(|&own| self.are_joined(own, k))) {
                group.push(rest.swap_remove(next));
            }
            group.sort_unstable_by_key(|&k| self.nodes[k]);
            groups.push(group);
        }
        groups.sort_unstable_by_key(|group| self.nodes[group[0]]);
        groups
    }

    /// True if all edges with both nodes outside that a solid crosses are between groups.
    pub fn is_divided(&self) -> bool {
        let all: Vec<usize> = (0..N).collect();
        let is_within = |group: &Vec<usize>| self.crossed_twice().any(|edge| edge.iter().all(|k| group.contains(k)));
        !self.groups(&all).iter().any(is_within)
    }

    /// Nodes of the face opposite to one of its nodes.
    fn of_face(&self, opposite: usize) -> Vec<usize> {
        (0..N).filter(|&k| k != opposite).collect()
    }

    /// True if surfaces cross edges of a face.
    pub fn crosses_face(&self, opposite: usize) -> bool {
        self.crossings.iter().any(|(edge, _)| !edge.contains(&opposite))
    }

    /// The fluid part of a face as triangles, given the number of the point in it.
    fn fluid_of_face(&self, opposite: usize, middle: Option<u32>) -> Vec<[Corner; 3]> {
        let nodes = self.of_face(opposite);
        let pairs = || nodes.iter().enumerate().flat_map(|(n, &i)| nodes[n + 1..].iter().map(move |&j| (i, j)));
        if let Some(middle) = middle {
            let middle = Corner::Point(middle);
            let plain = pairs().filter(|&(i, j)| self.are_joined(i, j));
            let plain = plain.map(|(i, j)| [Corner::Node(i), Corner::Node(j), middle]);
            let ends = pairs().flat_map(|(i, j)| [(i, j), (j, i)]);
            let cut = ends.filter_map(|(i, j)| Some([Corner::Node(i), Corner::Point(self.crossing(i, j)?), middle]));
            return plain.chain(cut).collect();
        }
        let of_group = |group: Vec<usize>| {
            let rest: Vec<usize> = nodes.iter().copied().filter(|k| !group.contains(k)).collect();
            let point = |i: usize, j: usize| self.crossing(i, j).map(Corner::Point);
            let node = Corner::Node;
            match (&group[..], &rest[..]) {
                (&[i], &[a, b]) => point(i, a).zip(point(i, b)).map_or(Vec::new(), |(a, b)| vec![[node(i), a, b]]),
                // The diagonal runs from the cut point at the lower number to the node with the higher one.
                (&[i, j], &[a]) => point(i, a)
                    .zip(point(j, a))
                    .map_or(Vec::new(), |(low, high)| vec![[node(i), node(j), low], [node(j), high, low]]),
                (all, _) => self.uncut(all),
            }
        };
        self.groups(&nodes).into_iter().flat_map(of_group).collect()
    }

    /// A face with all nodes outside and joined. Where a solid crosses one of its sides without reaching into it,
    /// the crossings are corners of its triangles.
    fn uncut(&self, face: &[usize]) -> Vec<[Corner; 3]> {
        let &[i, j, k] = face else { return Vec::new() };
        let node = Corner::Node;
        let crossed = [(i, j, k), (j, k, i), (k, i, j)].into_iter().find_map(|(i, j, k)| {
            let ends = [self.crossing(i, j)?, self.crossing(j, i)?];
            Some((i, j, k, ends.map(Corner::Point)))
        });
        let Some((i, j, k, [p, q])) = crossed else { return vec![[node(i), node(j), node(k)]] };
        vec![[node(i), p, node(k)], [p, q, node(k)], [q, node(j), node(k)]]
    }

    /// The parts of the cone with an apex, given the points in its faces.
    pub fn cone(&self, on_faces: [Option<u32>; N], apex: u32) -> Vec<[Corner; N]> {
        let triangles = (0..N).flat_map(|k| self.fluid_of_face(k, on_faces[k]));
        triangles.map(|side| std::array::from_fn(|k| side.get(k).copied().unwrap_or(Corner::Point(apex)))).collect()
    }

    /// The parts of the tetrahedra and prisms of its groups.
    pub fn prisms(&self) -> Vec<[Corner; N]> {
        let all: Vec<usize> = (0..N).collect();
        let of_group = |group: Vec<usize>| {
            let others: [bool; N] = std::array::from_fn(|k| !group.contains(&k));
            let edges = parts::cut_edges(others);
            let corner = |vertex: Vertex| match vertex {
                Vertex::Node(k) => Some(Corner::Node(usize::from(k))),
                Vertex::Point(k) => {
                    edges.get(usize::from(k)).and_then(|&[i, j]| self.crossing(i, j)).map(Corner::Point)
                }
            };
            let part = |FluidSimplex { vertices }: FluidSimplex<N>| {
                let corners: Vec<Corner> = vertices.into_iter().filter_map(corner).collect();
                <[Corner; N]>::try_from(corners).ok()
            };
            parts::outside(&self.nodes, others).into_iter().filter_map(part).collect::<Vec<_>>()
        };
        self.groups(&all).into_iter().flat_map(of_group).collect()
    }
}
