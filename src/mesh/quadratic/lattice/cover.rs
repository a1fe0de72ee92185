//! The surface as a whole: its pieces, its holes, and how far the boundary of a mesh stays away from it.

use super::features::find;
use super::hexes::Hexes;
use crate::geometry::{IndexedTriangle, Triangles};
use crate::math::Vector;
use rstar::{PointDistance, RTree};
use std::collections::BTreeMap;

/// Places in a triangle along each of its sides, at most.
const MOST_PLACES: usize = 40;

/// The place of the surface that is farthest from the boundary of the mesh, and its distance [m]; places are half a cell
/// apart.
pub fn farthest(surface: &Triangles, mesh: &Hexes, cell: f64) -> (Vector<3>, f64) {
    let corner = |node: u32| mesh.nodes[node as usize];
    let halves = mesh.quads.iter().enumerate().flat_map(|(index, quad)| {
        let [a, b, c, d] = quad.nodes.map(corner);
        [[a, b, c], [a, c, d]].map(|corners| IndexedTriangle { index, corners })
    });
    let boundary = RTree::bulk_load(halves.collect());
    let mut most = (Vector::ZERO, 0.0);
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|v| Vector(surface.vertices[v as usize]));
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let count = ((longest / (0.5 * cell)).ceil() as usize).clamp(1, MOST_PLACES);
        for (i, j) in (0..=count).flat_map(|i| (0..=count - i).map(move |j| (i, j))) {
            let x = a + (b - a) * (i as f64 / count as f64) + (c - a) * (j as f64 / count as f64);
            let away = boundary.nearest_neighbor(x.0).map_or(f64::INFINITY, |near| near.distance_2(&x.0).sqrt());
            if away > most.1 {
                most = (x, away);
            }
        }
    }
    most
}

/// Characteristic of a closed surface: vertices − edges + faces.
pub fn characteristic(surface: &Triangles) -> isize {
    let mut used: Vec<u32> = surface.triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    used.len() as isize - (surface.triangles.len() / 2) as isize
}

/// Number of pieces of a closed surface that enclose something; others are around hollows.
pub fn pieces(surface: &Triangles) -> usize {
    let mut root: Vec<usize> = (0..surface.vertices.len()).collect();
    for &[a, b, c] in &surface.triangles {
        for [a, b] in [[a, b], [b, c]] {
            let (a, b) = (find(&mut root, a as usize), find(&mut root, b as usize));
            root[a.max(b)] = a.min(b);
        }
    }
    let mut volumes: BTreeMap<usize, f64> = BTreeMap::new();
    for triangle in &surface.triangles {
        let piece = find(&mut root, triangle[0] as usize);
        let [a, b, c] = triangle.map(|v| Vector(surface.vertices[v as usize]) - Vector(surface.vertices[piece]));
        *volumes.entry(piece).or_default() += a.dot(b.cross(c));
    }
    volumes.into_values().filter(|&volume| volume > 0.0).count()
}
