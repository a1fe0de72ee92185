//! Elements with 27 nodes from hexahedra with eight corners: nodes in the middle of edges and sides on the boundary lie
//! on the surface, those of sides and elements inside where what is around them leads (transfinite interpolation, Gordon
//! & Hall 1973), those of edges inside in their middle.
//!
//! ```text
//! side: x = ½ Σ x_edge − ¼ Σ x_corner         element: x = ½ Σ x_side − ¼ Σ x_edge + ⅛ Σ x_corner
//! ```
//!
//! Edges inside of elements that fold follow those of the boundary (as with the meshes of Persson & Peraire 2009, DOI
//! 10.2514/6.2009-949, by Laplace's equation instead of an elastic one). Elements that fold still are bent less, and
//! nodes of their sides stay off the surface.

use super::features::Features;
use super::hexes::Hexes;
use super::holds::Hold;
use crate::math::Vector;
use crate::mesh::QuadraticMesh;
use std::collections::{BTreeMap, BTreeSet};

/// Elements whose least determinant is below this part of their largest one are bent less.
const LEAST_DETERMINANT: f64 = 0.03;

/// How far edges and sides are bent, over the whole way: less from round to round.
const BENDS: [f64; 4] = [1.0, 0.5, 0.25, 0.0];

/// Rounds in which elements are bent less.
const ROUNDS: usize = 16;

/// Sweeps in which the bend of edges is spread inside.
const SWEEPS: usize = 30;

/// The ends of an edge, ascending.
type EdgeEnds = [u32; 2];

/// Midside nodes of edges, sides and elements, each known by the corners around it, ascending.
struct MidsideNodes<'a> {
    mesh: &'a Hexes,
    features: &'a Features,
    /// Constraint of the middle of each edge and side on the boundary.
    holds: BTreeMap<Vec<u32>, Hold>,
    numbers: BTreeMap<Vec<u32>, u32>,
    elements: Vec<Vec<u32>>,
}

/// The mesh with nodes of second order. Edges inside are straight, unless elements would fold by it.
pub fn raise(mesh: &Hexes, holds: &[Hold], features: &Features) -> QuadraticMesh {
    let midside = MidsideNodes::new(mesh, holds, features);
    let mut bends = vec![0; mesh.nodes.len() + midside.numbers.len()];
    let made = midside.made(&bends, &BTreeMap::new());
    if made.flat().is_empty() {
        return made;
    }
    let inner = midside.inner();
    let mut made = midside.made(&bends, &inner);
    for _ in 0..ROUNDS {
        let less = |node: &u32| bends[*node as usize] + 1 < BENDS.len();
        let nodes: BTreeSet<u32> = made.flat().into_iter().flatten().copied().filter(less).collect();
        if nodes.is_empty() {
            break;
        }
        nodes.into_iter().for_each(|node| bends[node as usize] += 1);
        made = midside.made(&bends, &inner);
    }
    made
}

impl<'a> MidsideNodes<'a> {
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
        let mut midside = Self {
            mesh,
            features,
            holds: on,
            numbers: BTreeMap::new(),
            elements: Vec::with_capacity(mesh.hexes.len()),
        };
        for hex in &mesh.hexes {
            let own = (0..27).map(|local| midside.number(hex, local)).collect();
            midside.elements.push(own);
        }
        midside
    }

    fn number(&mut self, hex: &[u32; 8], local: usize) -> u32 {
        let corners = corners(hex, local);
        if let [corner] = corners[..] {
            return corner;
        }
        let next = (self.mesh.nodes.len() + self.numbers.len()) as u32;
        *self.numbers.entry(corners).or_insert(next)
    }

    /// Edges inside, each with those opposite to it in the sides around it.
    fn inner(&self) -> BTreeMap<EdgeEnds, BTreeSet<EdgeEnds>> {
        let mut found: BTreeMap<EdgeEnds, BTreeSet<EdgeEnds>> = BTreeMap::new();
        for hex in &self.mesh.hexes {
            for (k, a) in (0..3).flat_map(|k| (0..8).filter(move |a| a >> k & 1 == 0).map(move |a| (k, a))) {
                let edge = |a: usize| {
                    let (p, q) = (hex[a], hex[a | 1 << k]);
                    [p.min(q), p.max(q)]
                };
                if !self.holds.contains_key(&edge(a)[..]) {
                    let opposite = [(k + 1) % 3, (k + 2) % 3].map(|other| edge(a ^ 1 << other));
                    found.entry(edge(a)).or_default().extend(opposite);
                }
            }
        }
        found
    }

    /// The mesh, in which nodes are bent by what is listed, and edges inside follow those opposite to them.
    fn made(&self, bends: &[usize], inner: &BTreeMap<EdgeEnds, BTreeSet<EdgeEnds>>) -> QuadraticMesh {
        let mut places = self.mesh.nodes.clone();
        places.resize(places.len() + self.numbers.len(), Vector::ZERO);
        let of_size = |size: usize| self.numbers.iter().filter(move |(corners, _)| corners.len() == size);
        for size in [2, 4, 8] {
            for (corners, &node) in of_size(size) {
                let middle = match size {
                    2 => corners.iter().map(|&n| places[n as usize]).sum::<Vector<3>>() * 0.5,
                    _ => self.between(corners, &places),
                };
                let way = BENDS[bends[node as usize]];
                let held = self.holds.get(corners).map(|hold| hold.place(self.features, middle).0);
                places[node as usize] = match held {
                    Some(place) if way == 1.0 => place,
                    Some(place) => middle + (place - middle) * way,
                    None => middle,
                };
            }
            if size == 2 {
                self.spread(bends, inner, &mut places);
            }
        }
        QuadraticMesh {
            dimension: 3,
            nodes: places.into_iter().map(|x| x.0).collect(),
            elements: self.elements.clone(),
            sets: BTreeMap::new(),
        }
    }

    /// Bends edges inside as the mean of those opposite to them, which solves Laplace's equation by Gauss & Seidel's
    /// sweeps: an element beneath a curved side is curved on its other side, too, and doesn't fold.
    fn spread(&self, bends: &[usize], inner: &BTreeMap<EdgeEnds, BTreeSet<EdgeEnds>>, places: &mut [Vector<3>]) {
        let number = |edge: &EdgeEnds| self.numbers[&edge[..]] as usize;
        let straight = |edge: &EdgeEnds| (self.mesh.nodes[edge[0] as usize] + self.mesh.nodes[edge[1] as usize]) * 0.5;
        let bent = |edge: &[u32; 2], places: &[Vector<3>]| places[number(edge)] - straight(edge);
        for _ in 0..SWEEPS {
            for (edge, opposite) in inner {
                let mean = opposite.iter().map(|other| bent(other, places)).sum::<Vector<3>>() / opposite.len() as f64;
                places[number(edge)] = straight(edge) + mean * BENDS[bends[number(edge)]];
            }
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
    /// Nodes of each element that is folded, or nearly.
    fn flat(&self) -> Vec<&[u32]> {
        let is_flat = |element: &usize| self.least_determinant(*element) < LEAST_DETERMINANT;
        (0..self.elements.len()).filter(is_flat).map(|element| &self.elements[element][..]).collect()
    }

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
