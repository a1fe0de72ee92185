//! Nodes inside of solids so thin that they have fluid on both sides (theory J.2b).

use super::{CutBySolid, ElementState, PIECE, SolidCut};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::solid::surface::SolidSurface;

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Marks the nodes inside with fluid on several sides in the elements that have nodes outside, too.
    pub(super) fn mark_two_sided(&mut self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>) {
        let is_two_sided = |k: usize| {
            let node = self.inside[k].node;
            (self.sides_of(mesh, node) > 1 && self.is_thin_at(mesh, surface, node)).then_some(node)
        };
        let two_sided = parallel::collect_some(self.inside.len(), PIECE, is_two_sided);
        let distance = &self.distance;
        for element in &mut self.elements {
            element.outside = element.nodes.map(|node| distance[node as usize] > 0.0);
            element.two_sided = element.nodes.map(|node| two_sided.binary_search(&node).is_ok());
        }
    }

    /// True if the solid around a node inside ends within two elements behind the nearest place of its surface. (Where
    /// something comes near a thick one, its nodes see fluid here and there, on the same side.)
    fn is_thin_at(&self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>, node: u32) -> bool {
        const ELEMENTS: f64 = 2.0;
        const TRIALS: u32 = 16;
        let x = mesh.nodes()[node as usize];
        let corners = mesh.elements_around(node as usize).iter().flat_map(|&e| mesh.elements()[e as usize]);
        let size = corners.fold(0.0, |most: f64, other| most.max((mesh.nodes()[other as usize] - x).norm()));
        let is_outside = |body: usize, place| surface.foot_on_body(body, place).is_some_and(|foot| foot.distance > 0.0);
        let behind = || {
            let (foot, body) = (surface.foot(x)?, self.body_at(surface, node)?);
            let way = surface.normal(&foot)? * (-ELEMENTS * size / f64::from(TRIALS));
            Some((1..=TRIALS).any(|k| is_outside(body, foot.position + way * f64::from(k))))
        };
        behind().unwrap_or(true)
    }

    /// Number of sides on which a node inside has fluid: elements around it are on one side if they share a node outside
    /// or an edge that a film crosses.
    fn sides_of(&self, mesh: &Mesh<D, N>, node: u32) -> usize {
        let mut sides: Vec<Vec<[u32; 2]>> = Vec::new();
        for &element in mesh.elements_around(node as usize) {
            let mut side = self.passages(mesh, element);
            if side.is_empty() {
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

    /// Where fluid passes from an element to others: its nodes outside, each twice, and the edges that films cross, the
    /// lower node of each first.
    fn passages(&self, mesh: &Mesh<D, N>, element: u32) -> Vec<[u32; 2]> {
        let ElementState::Cut(place) = self.state[element as usize] else {
            let is_fluid = self.state[element as usize] == ElementState::Fluid;
            return mesh.elements()[element as usize].into_iter().filter(|_| is_fluid).map(|node| [node; 2]).collect();
        };
        let CutBySolid { nodes, points, .. } = &self.elements[place as usize];
        let outside = nodes.iter().filter(|&&node| !self.is_inside(node)).map(|&node| [node; 2]);
        let films = points.iter().filter_map(|&point| self.points[point as usize].film_edge);
        outside.chain(films.map(|[i, j]| [i.min(j), i.max(j)])).collect()
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
