//! Elements with 27 nodes from hexahedra with eight corners: nodes in the middle of edges and sides on the boundary lie
//! on the surface, those inside where edges and sides around them lead (transfinite interpolation, Gordon & Hall 1973).
//!
//! ```text
//! side: x = ½ Σ x_edge − ¼ Σ x_corner         element: x = ½ Σ x_side − ¼ Σ x_edge + ⅛ Σ x_corner
//! ```

use super::features::Features;
use super::hexes::Hexes;
use super::holds::Hold;
use crate::math::Vector;
use crate::mesh::QuadraticMesh;
use std::collections::{BTreeMap, BTreeSet};

/// Elements whose least determinant is below this part of their largest one get straight edges.
const LEAST_DETERMINANT: f64 = 0.03;

/// Times that edges are made straight.
const ROUNDS: usize = 8;

/// Nodes between the corners: those of an edge or side by its corners, ascending.
struct Raised<'a> {
    mesh: &'a Hexes,
    features: &'a Features,
    /// What holds the middle of each edge and side on the boundary.
    holds: BTreeMap<Vec<u32>, Hold>,
    numbers: BTreeMap<Vec<u32>, u32>,
    elements: Vec<Vec<u32>>,
}

/// The mesh with nodes of second order.
pub fn raise(mesh: &Hexes, holds: &[Hold], features: &Features) -> QuadraticMesh {
    let mut raised = Raised::new(mesh, holds, features);
    let mut straight = BTreeSet::new();
    let mut made = raised.made(&straight);
    for _ in 0..ROUNDS {
        let before = straight.len();
        for (element, own) in made.elements.iter().enumerate() {
            if made.least_determinant(element) < LEAST_DETERMINANT {
                straight.extend(own.iter().copied());
            }
        }
        if straight.len() == before {
            break;
        }
        made = raised.made(&straight);
    }
    made
}

impl<'a> Raised<'a> {
    fn new(mesh: &'a Hexes, holds: &[Hold], features: &'a Features) -> Self {
        let mut on = BTreeMap::new();
        for quad in &mesh.quads {
            on.insert(sorted(&quad.nodes), Hold::Patch(quad.patch));
        }
        for (ends, quads) in mesh.edges() {
            let [p, q] = quads.map(|q| mesh.quads[q].patch);
            let pair = [p.min(q), p.max(q)];
            let at_ends = ends.map(|node| holds[node as usize]);
            let along = |hold: &Hold| matches!(hold, Hold::Corner(_)) || *hold == Hold::Edge(pair);
            let hold = if p == q {
                Hold::Patch(p)
            } else if at_ends.iter().all(along) {
                Hold::Edge(pair)
            } else if let Some(patch) =
                at_ends.iter().find_map(|hold| if let Hold::Patch(patch) = hold { Some(*patch) } else { None })
            {
                Hold::Patch(patch)
            } else {
                Hold::Free
            };
            on.insert(ends.to_vec(), hold);
        }
        let mut raised = Self {
            mesh,
            features,
            holds: on,
            numbers: BTreeMap::new(),
            elements: Vec::with_capacity(mesh.hexes.len()),
        };
        for hex in &mesh.hexes {
            let own = (0..27).map(|local| raised.number(hex, local)).collect();
            raised.elements.push(own);
        }
        raised
    }

    fn number(&mut self, hex: &[u32; 8], local: usize) -> u32 {
        let corners = corners(hex, local);
        if let [corner] = corners[..] {
            return corner;
        }
        let next = (self.mesh.nodes.len() + self.numbers.len()) as u32;
        *self.numbers.entry(corners).or_insert(next)
    }

    /// The mesh, in which the nodes that are listed lie where those around them lead.
    fn made(&mut self, straight: &BTreeSet<u32>) -> QuadraticMesh {
        let mut places = self.mesh.nodes.clone();
        places.resize(places.len() + self.numbers.len(), Vector::ZERO);
        let mut order: Vec<(&Vec<u32>, u32)> = self.numbers.iter().map(|(corners, &node)| (corners, node)).collect();
        order.sort_by_key(|(corners, _)| corners.len());
        for (corners, node) in order {
            let middle = match corners.len() {
                2 => corners.iter().map(|&n| places[n as usize]).sum::<Vector<3>>() * 0.5,
                _ => self.between(corners, &places),
            };
            let hold = self.holds.get(corners).filter(|_| !straight.contains(&node));
            places[node as usize] = hold.map_or(middle, |hold| hold.place(self.features, middle).0);
        }
        QuadraticMesh {
            dimension: 3,
            nodes: places.into_iter().map(|x| x.0).collect(),
            elements: self.elements.clone(),
            sets: BTreeMap::new(),
        }
    }

    /// The middle of a side or an element, from the nodes around it.
    fn between(&self, corners: &[u32], places: &[Vector<3>]) -> Vector<3> {
        let all = 1u32 << corners.len();
        let sum = |size: u32| {
            let parts = (0..all).filter(|part| part.count_ones() == size);
            let chosen =
                |part: u32| (0..corners.len()).filter(|i| part >> i & 1 == 1).map(|i| corners[i]).collect::<Vec<u32>>();
            parts.filter_map(|part| self.numbers.get(&chosen(part))).map(|&n| places[n as usize]).sum::<Vector<3>>()
        };
        let ends = corners.iter().map(|&n| places[n as usize]).sum::<Vector<3>>();
        if corners.len() == 4 { sum(2) * 0.5 - ends * 0.25 } else { sum(4) * 0.5 - sum(2) * 0.25 + ends * 0.125 }
    }
}

impl QuadraticMesh {
    /// The least determinant at the nodes of an element over the largest one.
    fn least_determinant(&self, element: usize) -> f64 {
        let places = (0..27).map(|a: usize| [a % 3, a / 3 % 3, a / 9].map(|i| i as f64 - 1.0));
        let all: Vec<f64> = places.map(|xi| self.jacobian(element, xi)).collect();
        all.iter().copied().fold(f64::INFINITY, f64::min) / all.iter().copied().fold(f64::MIN_POSITIVE, f64::max)
    }
}

/// Corners between which a local node lies, ascending.
fn corners(hex: &[u32; 8], local: usize) -> Vec<u32> {
    let at = [local % 3, local / 3 % 3, local / 9];
    let is_near = |a: &usize| (0..3).all(|k| at[k] == 1 || at[k] / 2 == a >> k & 1);
    sorted(&(0..8).filter(is_near).map(|a| hex[a]).collect::<Vec<_>>())
}

fn sorted(nodes: &[u32]) -> Vec<u32> {
    let mut own = nodes.to_vec();
    own.sort_unstable();
    own
}
