//! The patch of the surface to which each quadrilateral of the boundary belongs.
//!
//! ```text
//! E = Σ_q (d(x_q, P)/h + w (1 − n_q·n_P) + [n_q·n_P < −0.1] 10) + γ #{neighbours q, r: P_q ≠ P_r}
//! ```
//!
//! is lowered one quadrilateral at a time (iterated conditional modes, Besag 1986). Then the quadrilaterals of a patch
//! are made one piece, that touches itself nowhere.

use super::features::Features;
use super::hexes::Hexes;
use crate::math::Vector;
use std::collections::BTreeMap;

/// w: weight of the direction.
const DIRECTION: f64 = 2.0;

/// γ: weight of a change between neighbours.
const CHANGE: f64 = 0.4;

/// Cost of a normal that points away from that of the patch.
const AWAY: f64 = 10.0;

/// Cosine of the angle between two normals below which they point away from each other.
const AWAY_COSINE: f64 = -0.1;

/// Rounds in which quadrilaterals are looked at again.
const ROUNDS: usize = 30;

/// Distance [cells] beyond the nearest patch in which other patches are tried.
const REACH: f64 = 2.5;

/// A patch, and what it costs a quadrilateral to belong to it.
#[derive(Clone, Copy)]
struct PatchCost {
    patch: u32,
    cost: f64,
}

/// Quadrilaterals, their neighbours, and the cost of each patch for them.
struct Labelling {
    labels: Vec<u32>,
    /// Neighbours across the four edges.
    neighbours: Vec<[usize; 4]>,
    /// Costs of the patches near each quadrilateral.
    costs: Vec<Vec<PatchCost>>,
    /// Quadrilaterals around each node, in their order around it.
    rings: Vec<Vec<usize>>,
}

/// Gives each quadrilateral a patch; patches that none belongs to are merged into their neighbours.
pub fn label(mesh: &mut Hexes, features: &mut Features, cell: f64) {
    let mut labelling = Labelling::new(mesh, features, cell);
    labelling.relax();
    for _ in 0..ROUNDS {
        while labelling.join_parts() {}
        if !labelling.part_pinches() {
            break;
        }
    }
    mesh.quads.iter_mut().zip(&labelling.labels).for_each(|(quad, &label)| quad.patch = label);
    let mut used = vec![false; features.patch_count()];
    labelling.labels.iter().for_each(|&label| used[label as usize] = true);
    features.merge_unmarked(&used);
}

impl Labelling {
    fn new(mesh: &Hexes, features: &Features, cell: f64) -> Self {
        let neighbours = mesh.neighbours();
        let costs: Vec<_> =
            mesh.quads.iter().map(|quad| costs(quad.nodes.map(|n| mesh.nodes[n as usize]), features, cell)).collect();
        let labels = costs.iter().map(|own| cheapest(own)).collect();
        let rings = rings(mesh, &neighbours);
        Self { labels, neighbours, costs, rings }
    }

    fn relax(&mut self) {
        for _ in 0..ROUNDS {
            let mut changed = false;
            for q in 0..self.labels.len() {
                let total = |&PatchCost { patch, cost }: &PatchCost| {
                    let others = self.neighbours[q].iter().filter(|&&r| self.labels[r] != patch).count();
                    PatchCost { patch, cost: cost + CHANGE * others as f64 }
                };
                let best = cheapest(&self.costs[q].iter().map(total).collect::<Vec<_>>());
                changed |= best != self.labels[q];
                self.labels[q] = best;
            }
            if !changed {
                break;
            }
        }
    }

    /// Gives the smaller pieces of each patch to the neighbours that they share most edges with. True if there were any.
    fn join_parts(&mut self) -> bool {
        let mut part = vec![usize::MAX; self.labels.len()];
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for start in 0..part.len() {
            if part[start] != usize::MAX {
                continue;
            }
            let (number, mut members, mut next) = (parts.len(), vec![start], 0);
            part[start] = number;
            while let Some(&q) = members.get(next) {
                next += 1;
                for r in self.neighbours[q] {
                    if part[r] == usize::MAX && self.labels[r] == self.labels[q] {
                        part[r] = number;
                        members.push(r);
                    }
                }
            }
            parts.push(members);
        }
        let mut largest: BTreeMap<u32, usize> = BTreeMap::new();
        for (number, members) in parts.iter().enumerate() {
            let best = largest.entry(self.labels[members[0]]).or_insert(number);
            if members.len() > parts[*best].len() {
                *best = number;
            }
        }
        let stray = |number: &usize| largest[&self.labels[parts[*number][0]]] != *number;
        let Some(smallest) = (0..parts.len()).filter(stray).min_by_key(|&number| parts[number].len()) else {
            return false;
        };
        let beyond = parts[smallest].iter().flat_map(|&q| self.neighbours[q]).filter(|&r| part[r] != smallest);
        let label = most(beyond.map(|r| self.labels[r]));
        parts[smallest].iter().for_each(|&q| self.labels[q] = label);
        true
    }

    /// Parts patches that touch themselves in a node: the fewest quadrilaterals between are given to a patch beside
    /// them. True if there were any.
    fn part_pinches(&mut self) -> bool {
        let mut changed = false;
        for ring in &self.rings {
            // Quadrilaterals with the same patch that follow each other.
            let starts: Vec<usize> = (0..ring.len())
                .filter(|&i| self.labels[ring[i]] != self.labels[ring[(i + ring.len() - 1) % ring.len()]])
                .collect();
            let label = |start: &usize| self.labels[ring[*start]];
            let doubled = starts.iter().any(|a| starts.iter().filter(|b| label(b) == label(a)).count() > 1);
            if !doubled {
                continue;
            }
            let length = |i: &usize| (starts[(i + 1) % starts.len()] + ring.len() - starts[*i] - 1) % ring.len() + 1;
            let Some(shortest) = (0..starts.len()).min_by_key(length) else { continue };
            let previous = self.labels[ring[(starts[shortest] + ring.len() - 1) % ring.len()]];
            for k in 0..length(&shortest) {
                self.labels[ring[(starts[shortest] + k) % ring.len()]] = previous;
            }
            changed = true;
        }
        changed
    }
}

/// The cost of each patch near a quadrilateral.
fn costs(corners: [Vector<3>; 4], features: &Features, cell: f64) -> Vec<PatchCost> {
    let centre = corners.into_iter().sum::<Vector<3>>() * 0.25;
    let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalized().unwrap_or(Vector::unit(0));
    let all = |reach: f64| {
        let near = features.patches_near(centre, reach);
        near.filter_map(|patch| features.on_patch(patch, centre).map(|(x, n)| (patch, (x - centre).norm(), n)))
            .collect::<Vec<_>>()
    };
    let mut near = Vec::new();
    let mut reach = REACH * cell;
    while near.is_empty() && reach.is_finite() {
        near = all(reach);
        reach *= 2.0;
    }
    let least = near.iter().map(|(_, distance, _)| *distance).fold(f64::INFINITY, f64::min);
    let cost = |(patch, distance, n): (u32, f64, Vector<3>)| {
        let cosine = n.dot(normal);
        let away = if cosine < AWAY_COSINE { AWAY } else { 0.0 };
        PatchCost { patch, cost: distance / cell + DIRECTION * (1.0 - cosine) + away }
    };
    near.into_iter().filter(|(_, distance, _)| *distance < least + REACH * cell).map(cost).collect()
}

/// The cheapest patch; the first of several.
fn cheapest(costs: &[PatchCost]) -> u32 {
    costs.iter().reduce(|best, next| if next.cost < best.cost { next } else { best }).map_or(0, |best| best.patch)
}

/// The most frequent one; the lowest of several.
fn most(labels: impl Iterator<Item = u32>) -> u32 {
    let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
    labels.for_each(|label| *counts.entry(label).or_default() += 1);
    counts.into_iter().reduce(|best, next| if next.1 > best.1 { next } else { best }).map_or(0, |(label, _)| label)
}

/// Quadrilaterals around each node of the boundary, in their order around it.
fn rings(mesh: &Hexes, neighbours: &[[usize; 4]]) -> Vec<Vec<usize>> {
    let mut first: BTreeMap<u32, usize> = BTreeMap::new();
    for (q, quad) in mesh.quads.iter().enumerate() {
        quad.nodes.iter().for_each(|&node| _ = first.entry(node).or_insert(q));
    }
    let ring = |(node, start): (u32, usize)| {
        let mut ring = vec![start];
        loop {
            let last = ring[ring.len() - 1];
            // Across the edge that ends in the node.
            let Some(k) = mesh.quads[last].edges().iter().position(|edge| edge[1] == node) else { return ring };
            let next = neighbours[last][k];
            if next == start || ring.len() > mesh.quads.len() {
                return ring;
            }
            ring.push(next);
        }
    };
    first.into_iter().map(ring).collect()
}
