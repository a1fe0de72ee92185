//! Distances of nodes from the polygons where φ vanishes.
//!
//! A node of a cut element knows the polygons of the elements around it. Then the nearest polygon is handed on from
//! node to node until the band is filled; every node measures its distance to the polygons that its neighbours found
//! nearest. The order of the nodes plays no role.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::interface::{facets, is_cut};
use crate::pfem2::outline::size;
use crate::pfem2::particles::interpolate;
use rayon::prelude::*;

/// No polygon yet.
const NONE: u32 = u32::MAX;

/// The zero line or surface of a nodal level set, as segments (2D) or triangles (3D).
#[derive(Debug, Clone)]
pub struct Interface<const D: usize> {
    facets: Vec<[Vector<D>; D]>,
    /// The cut element of each facet, ascending.
    element: Vec<u32>,
    longest_edge: f64,
}

impl<const D: usize> Interface<D> {
    /// Where the linear interpolant of `level` vanishes.
    pub fn new<const N: usize>(mesh: &Mesh<D, N>, level: &[f64]) -> Self {
        let mut interface = Self { facets: Vec::new(), element: Vec::new(), longest_edge: 0.0 };
        for (e, nodes) in (0u32..).zip(mesh.elements()) {
            let own = nodes.map(|node| level[node as usize]);
            if !is_cut(&own) {
                continue;
            }
            let x = mesh.corners(e as usize);
            for facet in facets::<D, N>(&own) {
                interface.facets.push(facet.map(|shape| interpolate(&shape, &x)));
                interface.element.push(e);
            }
            let edges = (0..N).flat_map(|i| (0..i).map(move |j| (i, j)));
            interface.longest_edge = edges.map(|(i, j)| (x[i] - x[j]).norm()).fold(interface.longest_edge, f64::max);
        }
        interface
    }

    /// True if there is no interface.
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// Longest edge of the elements that it cuts [m].
    pub fn longest_edge(&self) -> f64 {
        self.longest_edge
    }

    /// Length [m], or area in 3D [m²].
    pub fn area(&self) -> f64 {
        self.facets.iter().map(size).sum()
    }

    /// Distance of each node [m], up to `band`; nodes farther away have `band`.
    pub fn distances<const N: usize>(&self, mesh: &Mesh<D, N>, band: f64) -> Vec<f64> {
        let mut nearest = vec![(band, NONE); mesh.nodes().len()];
        for (facet, &e) in (0u32..).zip(&self.element) {
            for &node in &mesh.elements()[e as usize] {
                let found = (distance(&self.facets[facet as usize], mesh.nodes()[node as usize]), facet);
                let own = &mut nearest[node as usize];
                if found.0 < own.0 || own.1 == NONE {
                    *own = found;
                }
            }
        }
        let mut front: Vec<u32> = (0..).zip(&nearest).filter(|(_, n)| n.1 != NONE).map(|(node, _)| node).collect();
        while !front.is_empty() {
            let found: Vec<(u32, (f64, u32))> = neighbours(mesh, &front)
                .into_par_iter()
                .filter_map(|node| self.nearer(mesh, node, &nearest).map(|found| (node, found)))
                .collect();
            found.iter().for_each(|&(node, found)| nearest[node as usize] = found);
            front = found.into_iter().map(|(node, _)| node).collect();
        }
        nearest.into_iter().map(|(distance, _)| distance).collect()
    }

    /// A facet nearer than the node's own, among those of its neighbours.
    fn nearer<const N: usize>(&self, mesh: &Mesh<D, N>, node: u32, nearest: &[(f64, u32)]) -> Option<(f64, u32)> {
        let own = nearest[node as usize];
        let around = mesh.elements_around(node as usize).iter().flat_map(|&e| mesh.elements()[e as usize]);
        let facets = around.map(|other| nearest[other as usize].1).filter(|&facet| facet != NONE && facet != own.1);
        let x = mesh.nodes()[node as usize];
        facets.map(|facet| self.descend(mesh, facet, x)).min_by(closer).filter(|found| found.0 < own.0)
    }

    /// Goes from facet to facet, through neighbouring elements, as long as they come nearer to `x`: the nearest
    /// facet of a neighbour is close to the own one, but need not be it.
    fn descend<const N: usize>(&self, mesh: &Mesh<D, N>, start: u32, x: Vector<D>) -> (f64, u32) {
        let measured = |facet: u32| (distance(&self.facets[facet as usize], x), facet);
        let mut best = measured(start);
        loop {
            let element = self.element[best.1 as usize] as usize;
            let around = (0..N).filter_map(|k| mesh.neighbour(element, k)).flat_map(|e| self.of(e as u32));
            match around.map(measured).min_by(closer) {
                Some(next) if next.0 < best.0 => best = next,
                _ => return best,
            }
        }
    }

    /// The facets of an element.
    fn of(&self, element: u32) -> std::ops::Range<u32> {
        let start = self.element.partition_point(|&e| e < element);
        let count = self.element[start..].iter().take_while(|&&e| e == element).count();
        start as u32..(start + count) as u32
    }
}

/// Orders by distance, then by number, so that equal distances leave no choice.
fn closer(a: &(f64, u32), b: &(f64, u32)) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

/// The nodes of the elements around these nodes, ascending.
fn neighbours<const D: usize, const N: usize>(mesh: &Mesh<D, N>, front: &[u32]) -> Vec<u32> {
    let around = front.iter().flat_map(|&node| mesh.elements_around(node as usize));
    let mut nodes: Vec<u32> = around.flat_map(|&e| mesh.elements()[e as usize]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Distance of a point from a segment or triangle [m].
fn distance<const D: usize>(facet: &[Vector<D>; D], x: Vector<D>) -> f64 {
    let to_edge = |a: usize, b: usize| {
        let (along, away) = (facet[b] - facet[a], x - facet[a]);
        let length = along.norm_squared();
        let t = if length > 0.0 { (away.dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        (away - along * t).norm()
    };
    if D == 2 {
        return to_edge(0, 1);
    }
    over_triangle(facet, x).unwrap_or_else(|| to_edge(0, 1).min(to_edge(1, 2)).min(to_edge(2, 0)))
}

/// Distance from a triangle's plane if the foot of the perpendicular lies in the triangle.
fn over_triangle<const D: usize>(facet: &[Vector<D>; D], x: Vector<D>) -> Option<f64> {
    let (u, v, w) = (facet[1] - facet[0], facet[2] - facet[0], x - facet[0]);
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let size = uu * vv - uv * uv;
    let (s, t) = ((vv * wu - uv * wv) / size, (uu * wv - uv * wu) / size);
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| (w - u * s - v * t).norm())
}
