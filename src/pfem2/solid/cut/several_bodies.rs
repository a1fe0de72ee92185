//! Edges of solids near other solids, in three dimensions: elements that hold several bodies keep none (theory J.2a).

use super::cones::CrossedElement;
use super::edge_passages::Passage;
use super::films::Films;
use super::solid_edges::{Crossings, NearEdge, Solids, ascending};
use super::{SolidCut, body_of};
use crate::mesh::Mesh;
use std::collections::{BTreeMap, BTreeSet};

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// The elements of which an edge of a solid is part and that hold no other body and no film, with the crossings
    /// of edges of the mesh that are no edges of others.
    pub(super) fn near_edges_of_one_body(
        &self,
        mesh: &Mesh<D, N>,
        solids: &Solids<D>,
        passed: &[(usize, Vec<Passage>)],
        films: &Films<D>,
    ) -> (BTreeMap<usize, NearEdge<D, N>>, Crossings<D>) {
        let mut twice = self.crossed_twice(mesh, solids, passed);
        let mut left_out = films.elements.clone();
        loop {
            let edges = left_out.iter().flat_map(|&e| edges_of(mesh.elements()[e as usize]));
            let edges: BTreeSet<[u32; 2]> = edges.collect();
            twice.retain(|edge, _| !edges.contains(&ascending(*edge)));
            let mut near = self.near_edges(mesh, solids, &twice);
            let count = left_out.len();
            let of_several = near.iter().filter(|(_, own)| !self.is_of_one_body(solids, own, &twice));
            left_out.extend(of_several.map(|(&element, _)| element as u32));
            near.retain(|&element, _| !left_out.contains(&(element as u32)));
            if left_out.len() == count {
                return (near, twice);
            }
        }
    }

    /// True if the apex and the cut points of an element are of one body.
    fn is_of_one_body(&self, solids: &Solids<D>, own: &NearEdge<D, N>, twice: &Crossings<D>) -> bool {
        let CrossedElement { nodes, crossings, .. } = &own.crossed;
        let of_crossing = |(edge, number): &([usize; 2], u32)| {
            let point = self.points.get(*number as usize).or_else(|| twice.get(&edge.map(|k| nodes[k])))?;
            body_of(solids.surface, &point.weights)
        };
        // It may lie amid edges of several bodies.
        let apex = own.apex.iter().flat_map(|apex| &apex.weights).map(|(node, _)| Some(solids.surface.body_of(*node)));
        let bodies: BTreeSet<Option<usize>> = apex.chain(crossings.iter().map(of_crossing)).collect();
        bodies.len() < 2
    }
}

/// The edges of an element, the lower node of each first.
fn edges_of<const N: usize>(nodes: [u32; N]) -> impl Iterator<Item = [u32; 2]> {
    (0..N).flat_map(move |i| (i + 1..N).map(move |j| ascending([nodes[i], nodes[j]])))
}
