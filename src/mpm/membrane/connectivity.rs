//! The nodes of each element, and the element corners at each node.

use super::lanes::LANES;
use crate::parallel::Groups;
use std::ops::Range;

/// Elements of a membrane in blocks of equal shape: quadrilaterals first, then triangles, then segments.
#[derive(Debug, Clone)]
pub struct MembraneElements {
    /// Start of each element in `nodes`; one more entry than elements.
    offset: Vec<u32>,
    /// Nodes, element by element: one entry per corner.
    nodes: Vec<u32>,
    /// Corners (indices into `nodes`) that meet at each node, ascending.
    corners: Groups,
    /// Numbers of elements with 4, 3 and 2 nodes.
    counts: [usize; 3],
    /// Quadrature points of a quadrilateral.
    points: usize,
}

impl MembraneElements {
    /// Sorts `elements` by shape (keeping the order within a shape) and links them to `nodes` nodes; quadrilaterals
    /// have `points` quadrature points.
    pub fn new(elements: &[Vec<u32>], node_count: usize, points: usize) -> Self {
        let of_size = |n: usize| elements.iter().filter(move |e| e.len() == n);
        let (mut offset, mut nodes) = (vec![0], Vec::new());
        for element in [4, 3, 2].into_iter().flat_map(of_size) {
            nodes.extend_from_slice(element);
            offset.push(nodes.len() as u32);
        }
        let corners = Groups::from_pairs(node_count, nodes.iter().copied().zip(0..));
        Self { offset, nodes, corners, counts: [4, 3, 2].map(|n| of_size(n).count()), points }
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.offset.len() - 1
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Nodes of element `e`.
    #[inline(always)]
    pub fn nodes(&self, e: usize) -> &[u32] {
        &self.nodes[self.offset[e] as usize..self.offset[e + 1] as usize]
    }

    /// The elements in order, each as its nodes.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|e| self.nodes(e))
    }

    /// Nodes of all elements in a row, element by element.
    pub(super) fn corner_nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Corners that meet at `node`, ascending.
    #[inline(always)]
    pub(super) fn corners(&self, node: usize) -> &[u32] {
        self.corners.of(node)
    }

    /// The element that a corner belongs to.
    #[inline(always)]
    pub(super) fn element_of(&self, corner: u32) -> usize {
        let ([quadrilaterals, triangles, _], corner) = (self.counts, corner as usize);
        if corner < 4 * quadrilaterals {
            corner / 4
        } else if corner < 4 * quadrilaterals + 3 * triangles {
            quadrilaterals + (corner - 4 * quadrilaterals) / 3
        } else {
            quadrilaterals + triangles + (corner - 4 * quadrilaterals - 3 * triangles) / 2
        }
    }

    /// The blocks of an element, one per quadrature point, and its lane there; every shape begins a new block.
    #[inline(always)]
    pub(super) fn blocks_and_lane(&self, element: usize) -> (Range<usize>, usize) {
        let (mut block, mut local) = (0, element);
        for (count, points) in self.counts.into_iter().zip(self.points()) {
            if local < count {
                let first = block + local / LANES * points;
                return (first..first + points, local % LANES);
            }
            (block, local) = (block + count.div_ceil(LANES) * points, local - count);
        }
        (block..block, local)
    }

    /// Number of blocks.
    pub(super) fn block_count(&self) -> usize {
        self.counts.iter().zip(self.points()).map(|(count, points)| count.div_ceil(LANES) * points).sum()
    }

    /// Quadrature points of quadrilaterals, triangles and segments.
    fn points(&self) -> [usize; 3] {
        [self.points, 1, 1]
    }

    /// Numbers of quadrilaterals, triangles and segments.
    pub(super) fn counts(&self) -> [usize; 3] {
        self.counts
    }
}
