//! Distances of nodes from the polygons where φ vanishes (theory G.3).
//!
//! A node of a cut element knows the polygons of the elements around it. Then the nearest polygon is handed on from
//! node to node until the band is filled; every node measures its distance to the polygons that its neighbours found
//! nearest. The order of the nodes plays no role.
//!
//! Polygons end where the mesh ends. Where they meet a wall obliquely, a node near the wall may be nearest to that end,
//! farther than from the interface as it would go on behind the wall. It takes the distance from the polygon's plane,
//!
//! ```text
//! |(x − p)·n|   if the foot of x lies beyond the end p at the wall, and x itself before the wall, (x − p)·n_wall ≤ 0
//! ```
//!
//! which is exact for a plane and of second order for a curve; the last condition keeps planes that go on behind a
//! re-entrant corner or an obstacle out of the fluid on the other side. Inside of solids the
//! interface goes on as it meets their surface (see `solids`).

use super::solids::continue_interface;
use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::parallel;
use crate::pfem2::cut_element::{facets, is_cut};
use crate::pfem2::interface::outline::size;
use crate::pfem2::particles::interpolate;
use crate::pfem2::phases::FluidRegion;

/// Relative differences of lengths that are rounding.
const ROUNDING: f64 = 1e-9;

/// Part of the largest |φ| around a node below which φ vanishes at the node, for all elements around it: decided in each
/// element by itself, one polygon would be missing beside another, and depths grow with the gap.
const ON_NODE: f64 = 1e-9;

/// No polygon yet.
const NONE: u32 = u32::MAX;

/// The zero line or surface of a nodal level set, as segments (2D) or triangles (3D).
#[derive(Debug, Clone)]
pub struct InterfacePolygons<const D: usize> {
    facets: Vec<InterfacePiece<D>>,
    /// The element of each facet, ascending.
    element: Vec<u32>,
    longest_edge: f64,
}

/// A segment or triangle.
#[derive(Debug, Clone, Copy)]
struct InterfacePiece<const D: usize> {
    corners: [Vector<D>; D],
    /// Unit normal: that of φ, since the corners of a tiny polygon hardly tell it.
    normal: Vector<D>,
    /// The outward normal of the boundary of the mesh if the end opposite to each corner lies on it: the other corner
    /// of a segment, the opposite edge of a triangle.
    wall: [Option<Vector<D>>; D],
    /// True for a facet of an element, false inside of one.
    bounds: bool,
}

/// A polygon seen from a node.
#[derive(Debug, Clone, Copy)]
struct Sight {
    /// Distance from the polygon [m].
    nearest: f64,
    /// Distance from the interface, which goes on behind walls [m].
    away: f64,
    facet: u32,
}

impl Sight {
    const NOTHING: Self = Self { nearest: f64::INFINITY, away: f64::INFINITY, facet: NONE };

    /// Orders by distance, then by number, so that equal distances leave no choice.
    fn closer(&self, other: &Self) -> std::cmp::Ordering {
        let distances = self.nearest.total_cmp(&other.nearest).then(self.away.total_cmp(&other.away));
        distances.then(self.facet.cmp(&other.facet))
    }
}

impl<const D: usize> InterfacePolygons<D> {
    /// The zero of the linear interpolant of `level`, and how it goes on inside of solids.
    pub fn new<const N: usize>(region: &FluidRegion<D, N>, level: &[f64]) -> Self {
        let mesh = region.mesh;
        let mut interface = Self { facets: Vec::new(), element: Vec::new(), longest_edge: 0.0 };
        let level = without_rounding(mesh, level);
        let inside = continue_interface(region, &level);
        for (e, nodes) in (0u32..).zip(mesh.elements()) {
            let own = nodes.map(|node| match region.volume(e as usize) > 0.0 {
                true => Some(level[node as usize]),
                false => inside[node as usize],
            });
            if own.iter().any(Option::is_none) {
                continue;
            }
            let own = own.map(Option::unwrap_or_default);
            let facets = facets::<D, N>(&own);
            if facets.is_empty() {
                continue;
            }
            let x = mesh.corners(e as usize);
            let slope: Vector<D> = mesh.simplex(e as usize).gradient.iter().zip(own).map(|(&g, phi)| g * phi).sum();
            for facet in facets {
                let corners = facet.map(|shape| interpolate(&shape, &x));
                let wall = std::array::from_fn(|k| wall(mesh, e as usize, &facet, k));
                let bounds = !is_cut(&own);
                interface.facets.push(InterfacePiece { corners, normal: slope / slope.norm(), wall, bounds });
                interface.element.push(e);
            }
            interface.longest_edge = interface.longest_edge.max(longest_edge(&x));
        }
        interface
    }

    /// Facets of the boundary of a mesh, as an interface that is about to leave them.
    pub fn of_facets<const N: usize>(mesh: &Mesh<D, N>, facets: &[Facet]) -> Self {
        let mut facets = facets.to_vec();
        facets.sort_unstable();
        let polygon = |facet: &Facet| {
            let nodes = mesh.facet_nodes(*facet);
            let corners = std::array::from_fn(|k| mesh.nodes()[nodes[k] as usize]);
            let normal = mesh.facet_area(*facet).normalized().unwrap_or_default();
            InterfacePiece { corners, normal, wall: [None; D], bounds: true }
        };
        let edges = facets.iter().map(|facet| longest_edge(&mesh.corners(facet.element as usize)));
        Self {
            longest_edge: edges.fold(0.0, f64::max),
            facets: facets.iter().map(polygon).collect(),
            element: facets.iter().map(|facet| facet.element).collect(),
        }
    }

    /// The polygons of both.
    pub fn union(self, other: Self) -> Self {
        let longest_edge = self.longest_edge.max(other.longest_edge);
        let own = self.element.into_iter().zip(self.facets);
        let mut all: Vec<(u32, InterfacePiece<D>)> = own.chain(other.element.into_iter().zip(other.facets)).collect();
        all.sort_by_key(|(element, _)| *element);
        let (element, facets) = all.into_iter().unzip();
        Self { facets, element, longest_edge }
    }

    /// True if there is no interface.
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// Longest edge of the elements that it cuts or bounds [m].
    pub fn longest_edge(&self) -> f64 {
        self.longest_edge
    }

    /// Length [m], or area in 3D [m²].
    pub fn area(&self) -> f64 {
        parallel::sum(self.facets.len(), |n| size(&self.facets[n].corners))
    }

    /// Distance of each node [m], up to `band`; nodes farther away have `band`.
    pub fn distances<const N: usize>(&self, mesh: &Mesh<D, N>, band: f64) -> Vec<f64> {
        let mut nearest = vec![Sight::NOTHING; mesh.nodes().len()];
        for (facet, &e) in (0u32..).zip(&self.element) {
            for &node in &mesh.elements()[e as usize] {
                let found = self.seen(facet, mesh.nodes()[node as usize]);
                let own = &mut nearest[node as usize];
                if found.closer(own).is_lt() {
                    *own = found;
                }
            }
        }
        let mut front: Vec<u32> = (0..).zip(&nearest).filter(|(_, n)| n.facet != NONE).map(|(node, _)| node).collect();
        while !front.is_empty() {
            let beside = neighbours(mesh, &front);
            let found = parallel::collect_some(beside.len(), 64, |n| {
                let found = self.nearer(mesh, beside[n], &nearest).filter(|found| found.away < band)?;
                Some((beside[n], found))
            });
            found.iter().for_each(|&(node, found)| nearest[node as usize] = found);
            front = found.into_iter().map(|(node, _)| node).collect();
        }
        nearest.into_iter().map(|sight| sight.away.min(band)).collect()
    }

    fn seen(&self, facet: u32, x: Vector<D>) -> Sight {
        let [nearest, away] = self.facets[facet as usize].distances(x);
        Sight { nearest, away, facet }
    }

    /// A facet nearer than the node's own, among those of its neighbours.
    fn nearer<const N: usize>(&self, mesh: &Mesh<D, N>, node: u32, nearest: &[Sight]) -> Option<Sight> {
        let own = nearest[node as usize];
        let around = mesh.elements_around(node as usize).iter().flat_map(|&e| mesh.elements()[e as usize]);
        let facets =
            around.map(|other| nearest[other as usize].facet).filter(|&facet| facet != NONE && facet != own.facet);
        let x = mesh.nodes()[node as usize];
        facets
            .map(|facet| self.descend(mesh, facet, x))
            .min_by(Sight::closer)
            .filter(|found| found.nearest < own.nearest)
    }

    /// Goes from facet to facet, through neighbouring elements, as long as they come nearer to `x`: the nearest
    /// facet of a neighbour is close to that of the node, but need not be it.
    fn descend<const N: usize>(&self, mesh: &Mesh<D, N>, start: u32, x: Vector<D>) -> Sight {
        let mut best = self.seen(start, x);
        loop {
            let element = self.element[best.facet as usize];
            let around = self.around(mesh, element as usize).flat_map(|e| self.of(e));
            match around.map(|facet| self.seen(facet, x)).min_by(Sight::closer) {
                Some(next) if next.nearest < best.nearest => best = next,
                _ => return best,
            }
        }
    }

    /// Elements that may hold facets next to those of an element.
    fn around<const N: usize>(&self, mesh: &Mesh<D, N>, element: usize) -> impl Iterator<Item = u32> {
        let behind = (0..N).filter_map(move |k| mesh.neighbour(element, k)).map(|e| e as u32);
        // A facet that bounds the element meets the next one at a node.
        let bounds = self.of(element as u32).all(|facet| self.facets[facet as usize].bounds);
        let nodes = mesh.elements()[element].into_iter().take(if bounds { N } else { 0 });
        behind.chain(nodes.flat_map(move |node| mesh.elements_around(node as usize).iter().copied()))
    }

    /// The facets of an element.
    fn of(&self, element: u32) -> std::ops::Range<u32> {
        let start = self.element.partition_point(|&e| e < element);
        let count = self.element[start..].iter().take_while(|&&e| e == element).count();
        start as u32..(start + count) as u32
    }
}

/// φ at the nodes, zero where it is but rounding.
fn without_rounding<const D: usize, const N: usize>(mesh: &Mesh<D, N>, level: &[f64]) -> Vec<f64> {
    parallel::collect(level.len(), 256, |node| {
        let around = mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]);
        let largest = around.map(|other| level[other as usize].abs()).fold(0.0, f64::max);
        if level[node].abs() <= ON_NODE * largest { 0.0 } else { level[node] }
    })
}

/// Longest edge of an element with these corners [m].
pub(super) fn longest_edge<const D: usize, const N: usize>(corners: &[Vector<D>; N]) -> f64 {
    let edges = (0..N).flat_map(|i| (0..i).map(move |j| (i, j)));
    edges.map(|(i, j)| (corners[i] - corners[j]).norm()).fold(0.0, f64::max)
}

/// The outward normal of the boundary of the mesh where the end of a facet opposite to its corner `k` lies on it.
fn wall<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    element: usize,
    facet: &[[f64; N]; D],
    k: usize,
) -> Option<Vector<D>> {
    let on = |j: &usize| (0..D).all(|i| i == k || facet[i][*j] == 0.0) && mesh.neighbour(element, *j).is_none();
    (0..N).find(on).map(|j| mesh.simplex(element).facet_area(j))
}

/// The nodes of the elements around these nodes, ascending.
fn neighbours<const D: usize, const N: usize>(mesh: &Mesh<D, N>, front: &[u32]) -> Vec<u32> {
    let around = front.iter().flat_map(|&node| mesh.elements_around(node as usize));
    let mut nodes: Vec<u32> = around.flat_map(|&e| mesh.elements()[e as usize]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

impl<const D: usize> InterfacePiece<D> {
    /// Distances of a point from the polygon, and from where it goes on behind walls [m].
    fn distances(&self, x: Vector<D>) -> [f64; 2] {
        if D == 3 && over_triangle(&self.corners, x) {
            return [self.distance_to_plane(x); 2];
        }
        let ends: [(f64, bool); D] = std::array::from_fn(|k| self.end(k, x));
        let nearest = ends.iter().map(|end| end.0).fold(f64::INFINITY, f64::min);
        let behind = (0..D).any(|k| ends[k].1 && ends[k].0 <= nearest * (1.0 + ROUNDING) && self.is_before_wall(k, x));
        [nearest, if behind { self.distance_to_plane(x).min(nearest) } else { nearest }]
    }

    /// Distance from the end opposite to corner `k`; true if the foot of the point lies at that end or beyond it.
    fn end(&self, k: usize, x: Vector<D>) -> (f64, bool) {
        let [a, b] = [self.corners[(k + 1) % D], self.corners[(k + 2) % D]];
        let (along, away) = (b - a, x - a);
        let length = along.norm_squared();
        let t = if length > 0.0 { (away.dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        // In 2D a is the end and b the corner opposite to it.
        ((away - along * t).norm(), D == 3 || t == 0.0)
    }

    fn distance_to_plane(&self, x: Vector<D>) -> f64 {
        (x - self.corners[0]).dot(self.normal).abs()
    }

    /// Points on the wall count as before it.
    fn is_before_wall(&self, k: usize, x: Vector<D>) -> bool {
        let from = x - self.corners[(k + 1) % D];
        self.wall[k].is_some_and(|outward| from.dot(outward) <= ROUNDING * from.norm() * outward.norm())
    }
}

/// True if the foot of the perpendicular lies in the triangle.
fn over_triangle<const D: usize>(corners: &[Vector<D>; D], x: Vector<D>) -> bool {
    let (u, v, w) = (corners[1] - corners[0], corners[2] - corners[0], x - corners[0]);
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let size = uu * vv - uv * uv;
    let (s, t) = ((vv * wu - uv * wv) / size, (uu * wv - uv * wu) / size);
    s >= 0.0 && t >= 0.0 && s + t <= 1.0
}
