//! Neighbours of elements.

use crate::parallel::Groups;

/// No element behind a facet.
const NONE: u32 = u32::MAX;

/// A facet: an element and the local node opposite to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facet {
    /// The element.
    pub element: u32,
    /// The local node opposite to the facet.
    pub opposite: u32,
}

/// Neighbours of elements, elements around nodes, boundary.
#[derive(Debug, Clone)]
pub(super) struct Topology<const N: usize> {
    neighbours: Vec<[u32; N]>,
    boundary: Vec<Facet>,
    /// Elements around each node, ascending.
    around: Groups,
}

impl<const N: usize> Topology<N> {
    pub fn new(elements: &[[u32; N]], nodes: usize, number: &dyn Fn(usize) -> i64) -> Result<Self, String> {
        let mut facets: Vec<([u32; 3], Facet)> = Vec::with_capacity(elements.len() * N);
        for (element, nodes) in (0u32..).zip(elements) {
            facets.extend((0..N).map(|k| (facet_key(nodes, k), Facet { element, opposite: k as u32 })));
        }
        facets.sort_unstable();
        let mut neighbours = vec![[NONE; N]; elements.len()];
        let mut boundary = Vec::new();
        for same in facets.chunk_by(|a, b| a.0 == b.0) {
            match same {
                [(_, facet)] => boundary.push(*facet),
                [(_, a), (_, b)] => {
                    if is_even(elements, *a) == is_even(elements, *b) {
                        let [a, b] = [a, b].map(|facet| number(facet.element as usize));
                        return Err(format!(
                            "elements {a} and {b} overlap: they lie on one side of the facet that they share"
                        ));
                    }
                    neighbours[a.element as usize][a.opposite as usize] = b.element;
                    neighbours[b.element as usize][b.opposite as usize] = a.element;
                }
                more => {
                    let first = number(more[0].1.element as usize);
                    return Err(format!("{} elements share a facet of element {first}", more.len()));
                }
            }
        }
        boundary.sort_unstable();
        let by_node = (0u32..).zip(elements).flat_map(|(element, nodes)| nodes.map(|node| (node, element)));
        Ok(Self { neighbours, boundary, around: Groups::from_pairs(nodes, by_node) })
    }

    pub fn neighbour(&self, element: usize, k: usize) -> Option<usize> {
        let neighbour = self.neighbours[element][k];
        (neighbour != NONE).then_some(neighbour as usize)
    }

    pub fn boundary(&self) -> &[Facet] {
        &self.boundary
    }

    pub fn around(&self, node: usize) -> &[u32] {
        self.around.of(node)
    }
}

/// Nodes of the facet opposite local node `k`.
pub(super) fn facet_nodes<const N: usize>(nodes: &[u32; N], k: usize) -> Vec<u32> {
    (0..N).filter(|&i| i != k).map(|i| nodes[i]).collect()
}

/// The nodes of a facet in ascending order; the same from both sides. In 2D the last is unused.
fn facet_key<const N: usize>(nodes: &[u32; N], k: usize) -> [u32; 3] {
    let mut key = [NONE; 3];
    let others = (0..N).filter(|&i| i != k);
    key.iter_mut().zip(others).for_each(|(slot, i)| *slot = nodes[i]);
    key.sort_unstable();
    key
}

/// True if the nodes of a facet, as they run around its element, are an even permutation of their ascending order. Of
/// two elements of positive volume on either side of a facet this is true for one.
fn is_even<const N: usize>(elements: &[[u32; N]], facet: Facet) -> bool {
    let nodes = facet_nodes(&elements[facet.element as usize], facet.opposite as usize);
    let swaps = (0..nodes.len()).flat_map(|i| (i + 1..nodes.len()).map(move |j| (i, j)));
    let swaps = swaps.filter(|&(i, j)| nodes[i] > nodes[j]).count();
    (swaps + facet.opposite as usize).is_multiple_of(2)
}
