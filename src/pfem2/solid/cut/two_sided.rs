//! Nodes inside of solids so thin that they have fluid on both sides (theory J.2b).

use super::{CutBySolid, ElementState, PIECE, SolidCut};
use crate::mesh::Mesh;
use crate::parallel;

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Marks the nodes inside with fluid on several sides in the elements that have nodes outside, too.
    pub(super) fn mark_two_sided(&mut self, mesh: &Mesh<D, N>) {
        let is_two_sided = |k: usize| {
            let node = self.inside[k].node;
            (self.sides_of(mesh, node) > 1).then_some(node)
        };
        let two_sided = parallel::collect_some(self.inside.len(), PIECE, is_two_sided);
        let distance = &self.distance;
        for element in &mut self.elements {
            element.outside = element.nodes.map(|node| distance[node as usize] > 0.0);
            element.two_sided = element.nodes.map(|node| two_sided.binary_search(&node).is_ok());
        }
    }

    /// Number of sides on which a node inside has fluid: elements around it are on one side if they share a node outside.
    fn sides_of(&self, mesh: &Mesh<D, N>, node: u32) -> usize {
        let mut sides: Vec<Vec<u32>> = Vec::new();
        for &element in mesh.elements_around(node as usize) {
            let nodes = mesh.elements()[element as usize];
            let mut side: Vec<u32> = nodes.into_iter().filter(|&other| !self.is_inside(other)).collect();
            if side.is_empty() || self.state[element as usize] == ElementState::Solid {
                continue;
            }
            sides.retain(|known| {
                let is_apart = !known.iter().any(|other| side.contains(other));
                if !is_apart {
                    side.extend(known);
                }
                is_apart
            });
            sides.push(side);
        }
        sides.len()
    }
}

impl<const N: usize> CutBySolid<N> {
    /// The level set of fluids at its nodes, with that of nodes outside at the nodes that have fluid on several sides: an
    /// interface inside of a thin wall is no interface beside it.
    pub fn level_on_its_side(&self, mut level: [f64; N]) -> [f64; N] {
        let outside: Vec<f64> = (0..N).filter(|&k| self.outside[k]).map(|k| level[k]).collect();
        if !outside.is_empty() {
            let mean = outside.iter().sum::<f64>() / outside.len() as f64;
            self.nodes_of_two_sides().for_each(|k| level[k] = mean);
        }
        level
    }

    /// Local nodes inside whose pressure on this side follows that of the nodes outside.
    pub fn nodes_of_two_sides(&self) -> impl Iterator<Item = usize> + '_ {
        (0..N).filter(|&k| self.two_sided[k])
    }
}
