//! Constraints that keep the nodes of the boundary on the surface: on a patch, on a sharp edge, at a corner.

use super::features::Features;
use super::hexes::Hexes;
use crate::math::Vector;
use std::collections::{BTreeMap, BTreeSet};

/// A node farther from a sharp edge or a corner, in cells, is not meant for it.
const FARTHEST: f64 = 3.0;

/// The constraint of a node: the places that it may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hold {
    /// Anywhere: it lies inside.
    Free,
    /// On a patch.
    Patch(u32),
    /// On the sharp edge between two patches, the lower first.
    Edge([u32; 2]),
    /// At a corner [m].
    Corner([f64; 3]),
}

/// The directions in which a node may move: as many as there are.
pub struct Tangents {
    pub count: usize,
    pub directions: [Vector<3>; 3],
}

impl Hold {
    /// The place that is allowed nearest to `x` [m], and the directions in which it may move there.
    pub fn place(&self, features: &Features, x: Vector<3>) -> (Vector<3>, Tangents) {
        let fixed = Tangents { count: 0, directions: [0, 1, 2].map(Vector::unit) };
        match *self {
            Self::Free => (x, Tangents { count: 3, ..fixed }),
            Self::Corner(place) => (Vector(place), fixed),
            Self::Edge(patches) => match features.on_edge(patches, x) {
                Some((place, along)) => (place, Tangents { count: 1, directions: [along, along, along] }),
                None => (x, fixed),
            },
            Self::Patch(patch) => match features.on_patch(patch, x) {
                Some((place, normal)) => {
                    let least = (0..3).fold(0, |best, k| if normal[k].abs() < normal[best].abs() { k } else { best });
                    let first = normal.cross(Vector::unit(least)).normalized().unwrap_or(Vector::unit(0));
                    (place, Tangents { count: 2, directions: [first, normal.cross(first), normal] })
                }
                None => (x, fixed),
            },
        }
    }
}

/// The constraint of each node.
pub fn holds(mesh: &Hexes, features: &Features, cell: f64) -> Vec<Hold> {
    let mut holds = vec![Hold::Free; mesh.nodes.len()];
    let patches = mesh.patches();
    let corners = corners(mesh, features, &patches, cell);
    // Two sides of a quadrilateral on one sharp edge would meet at 180° in the node between them, where the Jacobian
    // vanishes: that node stays off the edge.
    let released = mesh.bends();
    for (&node, own) in &patches {
        let x = mesh.nodes[node as usize];
        let near = |pair: &[u32; 2]| {
            let away = features.on_edge(*pair, x).map(|(place, _)| (place - x).norm());
            away.filter(|&away| away < FARTHEST * cell)
        };
        let pairs = own.iter().enumerate().flat_map(|(i, &p)| own[i + 1..].iter().map(move |&q| [p, q]));
        let nearest = pairs.filter_map(|pair| Some((pair, near(&pair)?)));
        let nearest = nearest.reduce(|best, next| if next.1 < best.1 { next } else { best });
        holds[node as usize] = match (corners.get(&node), released.get(&node), nearest) {
            (Some(&corner), ..) => Hold::Corner(features.corners()[corner].place.0),
            (None, None, Some((pair, _))) => Hold::Edge(pair),
            (None, Some(&patch), _) if own.len() == 2 => Hold::Patch(patch),
            (None, Some(_), Some((pair, _))) => Hold::Edge(pair),
            _ => Hold::Patch(nearest_patch(features, own, x)),
        };
    }
    for apex in features.apexes() {
        let on = |node: &&u32| holds[**node as usize] == Hold::Patch(apex.patches[0]);
        let away = |node: &u32| (mesh.nodes[*node as usize] - apex.place).norm();
        let nearest = patches.keys().filter(on).min_by(|a, b| away(a).total_cmp(&away(b)));
        if let Some(&node) = nearest.filter(|node| away(node) < FARTHEST * cell) {
            holds[node as usize] = Hold::Corner(apex.place.0);
        }
    }
    holds
}

fn nearest_patch(features: &Features, patches: &[u32], x: Vector<3>) -> u32 {
    let away = |patch: u32| features.on_patch(patch, x).map_or(f64::INFINITY, |(place, _)| (place - x).norm());
    patches.iter().copied().reduce(|best, next| if away(next) < away(best) { next } else { best }).unwrap_or(0)
}

/// A node with a corner of the surface that it may take.
struct CornerCandidate {
    /// Distance of the corner from the node [m].
    distance: f64,
    node: u32,
    /// Place among the corners of the surface.
    corner: usize,
}

/// The corner of the surface that each node with three patches or more takes: the nearest one where these meet, each
/// corner once.
fn corners(mesh: &Hexes, features: &Features, patches: &BTreeMap<u32, Vec<u32>>, cell: f64) -> BTreeMap<u32, usize> {
    let mut candidates: Vec<CornerCandidate> = Vec::new();
    for (&node, own) in patches.iter().filter(|(_, own)| own.len() > 2) {
        for (index, corner) in features.corners().iter().enumerate() {
            let distance = (corner.place - mesh.nodes[node as usize]).norm();
            if distance < FARTHEST * cell && own.iter().all(|patch| corner.patches.contains(patch)) {
                candidates.push(CornerCandidate { distance, node, corner: index });
            }
        }
    }
    candidates.sort_by(|a, b| a.distance.total_cmp(&b.distance).then((a.node, a.corner).cmp(&(b.node, b.corner))));
    let (mut taken, mut found) = (BTreeSet::new(), BTreeMap::new());
    for CornerCandidate { node, corner, .. } in candidates {
        if !found.contains_key(&node) && taken.insert(corner) {
            found.insert(node, corner);
        }
    }
    found
}
