//! The fluid part of an element that films cross, as simplices (theory J.2a).
//!
//! In the plane it is the polygon around the element, of nodes outside, cut points and corners of solids between these.
//! In space it is the polyhedron between such polygons on the sides of the element and one polygon on the surface of
//! each group of its nodes inside that no film parts. It is the fan of tetrahedra from its first corner to
//! the triangles of its facets, which are fans from their own first corners: from cut points in the order of their nodes
//! outside, as in elements without a film (`parts.rs`), then from those of films, then from nodes. So both elements
//! of a side divide it alike (Dompierre et al. 1999).

use super::polygon::{PolygonCorner, triangulated};
use super::{FluidSimplex, SolidCut, Vertex, body_of, parts};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::solid::surface::SolidSurface;
use std::collections::BTreeMap;

/// Shape function of a place on a side of an element, but for rounding.
const ON_SIDE: f64 = 1e-9;

/// Volume of a tetrahedron over that of its element below which it is flat.
const FLAT: f64 = 1e-12;

/// Edges of the mesh that films cross, the lower node of each first, with the numbers of their two cut points.
pub(super) type FilmNumbers = BTreeMap<[u32; 2], [u32; 2]>;

/// A corner of the fluid part of an element.
#[derive(Debug, Clone, Copy)]
struct PartCorner<const D: usize> {
    vertex: Vertex,
    position: Vector<D>,
    /// The local nodes of its edge of the element, that inside and beside it first; both the same at a node.
    edge: [usize; 2],
    /// The body on which it lies.
    body: Option<usize>,
    /// Its place in the order of corners, the same in all elements.
    order: (u8, u32, u32),
}

/// Cut points by the local nodes of their edge, that inside and beside it first.
type CutEdges<const D: usize> = BTreeMap<[usize; 2], PartCorner<D>>;

impl<const D: usize> PartCorner<D> {
    /// True for cut points of different edges.
    fn on_surface_with(&self, other: &Self) -> bool {
        let is_point = |corner: &Self| matches!(corner.vertex, Vertex::Point(_));
        let same_edge = self.edge == other.edge || self.edge == [other.edge[1], other.edge[0]];
        is_point(self) && is_point(other) && !same_edge
    }
}

/// An element that films cross.
pub(super) struct FilmElement<'a, const D: usize, const N: usize> {
    /// The mesh, cut.
    pub cut: &'a SolidCut<D, N>,
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// The surface of the solids.
    pub surface: &'a SolidSurface<D>,
    /// Number of the element.
    pub number: usize,
    /// Its cut points without the films.
    pub own: &'a [u32],
}

impl<const D: usize, const N: usize> FilmElement<'_, D, N> {
    /// Its cut points and the simplices of its fluid part with the films that cross its edges; `None` where the edges
    /// don't bound one.
    pub fn divided(&self, numbers: &FilmNumbers) -> Option<(Vec<u32>, Vec<FluidSimplex<N>>)> {
        let nodes = self.mesh.elements()[self.number];
        let inside = nodes.map(|node| self.cut.is_inside(node));
        let edges = parts::cut_edges(inside);
        let (corners, points) = self.cut_edges(&edges, numbers)?;
        let outline = |around: &[usize]| {
            let mut polygon = Vec::new();
            for (place, &i) in around.iter().enumerate() {
                let j = around[(place + 1) % around.len()];
                polygon.extend((!inside[i]).then(|| self.at_node(i)));
                polygon.extend([[i, j], [j, i]].iter().filter_map(|edge| corners.get(edge)));
            }
            polygon
        };
        let kept: Vec<u8> = (edges.len() as u8..self.own.len() as u8).collect();
        let parts = if D == 2 {
            triangulated(with_corners(self, outline(&[0, 1, 2]), &kept)?)?
        } else if kept.is_empty() {
            // Nodes of the side opposite to each, counter-clockwise seen from outside.
            let sides = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]].map(|side| outline(&side)).to_vec();
            polyhedron(sides, &groups(inside, &corners), self.mesh.simplex(self.number).volume)?
        } else {
            return None;
        };
        (!parts.is_empty()).then_some((points, parts))
    }

    /// The cut points of its edges, by the local nodes of each, that inside and beside the point first, and the numbers
    /// of all of its cut points.
    fn cut_edges(&self, edges: &[[usize; 2]], numbers: &FilmNumbers) -> Option<(CutEdges<D>, Vec<u32>)> {
        let nodes = self.mesh.elements()[self.number];
        let (mut corners, mut points) = (CutEdges::new(), self.own.to_vec());
        let mut add = |place: usize, number: u32, edge: [usize; 2], order: (u8, u32, u32)| {
            let point = &self.cut.points[number as usize];
            let (vertex, body) = (Vertex::Point(place as u8), body_of(self.surface, &point.weights));
            corners.insert(edge, PartCorner { vertex, position: point.position, edge, body, order });
        };
        for (place, &[outside, inside]) in edges.iter().enumerate() {
            add(place, *self.own.get(place)?, [inside, outside], (0, nodes[outside], nodes[inside]));
        }
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))).filter(|(i, j)| nodes[*i] < nodes[*j]) {
            let Some(film) = numbers.get(&[nodes[i], nodes[j]]) else { continue };
            for (&number, edge) in film.iter().zip([[i, j], [j, i]]) {
                add(points.len(), number, edge, (1, nodes[edge[0]], nodes[edge[1]]));
                points.push(number);
            }
        }
        Some((corners, points))
    }

    fn at_node(&self, k: usize) -> PartCorner<D> {
        let node = self.mesh.elements()[self.number][k];
        let (vertex, position) = (Vertex::Node(k as u8), self.mesh.nodes()[node as usize]);
        PartCorner { vertex, position, edge: [k; 2], body: None, order: (2, node, 0) }
    }
}

/// The polygon with the corners of solids that the element keeps, each on the side of its body that it lengthens
/// least; `None` with points on its sides.
fn with_corners<const D: usize, const N: usize>(
    element: &FilmElement<'_, D, N>,
    polygon: Vec<PartCorner<D>>,
    kept: &[u8],
) -> Option<Vec<PolygonCorner<D>>> {
    let FilmElement { cut, mesh, surface, number, own, .. } = *element;
    let is_surface = |k: usize| polygon[k].on_surface_with(&polygon[(k + 1) % polygon.len()]);
    // Each corner with the body of the side that begins there, if it is on one.
    let mut all: Vec<(PolygonCorner<D>, Option<usize>)> = (0..polygon.len())
        .map(|k| ((polygon[k].vertex, polygon[k].position), polygon[k].body.filter(|_| is_surface(k))))
        .collect();
    for &k in kept {
        let point = &cut.points[own[usize::from(k)] as usize];
        let (x, body) = (point.position, body_of(surface, &point.weights));
        if mesh.shape_functions(number, x).iter().any(|n| *n < ON_SIDE) {
            return None;
        }
        let longer = |side: usize| {
            let [p, q] = [all[side].0.1, all[(side + 1) % all.len()].0.1];
            (x - p).norm() + (q - x).norm() - (q - p).norm()
        };
        let sides = (0..all.len()).filter(|&side| body.is_some() && all[side].1 == body);
        let side = sides.min_by(|&a, &b| longer(a).total_cmp(&longer(b)))?;
        all.insert(side + 1, ((Vertex::Point(k), x), body));
    }
    Some(all.into_iter().map(|(corner, _)| corner).collect())
}

/// For each local node inside the first one of those that no film parts from it.
fn groups<const D: usize, const N: usize>(inside: [bool; N], corners: &CutEdges<D>) -> [usize; N] {
    let mut group: [usize; N] = std::array::from_fn(|k| k);
    for (i, j) in (0..N).flat_map(|i| (i + 1..N).map(move |j| (i, j))) {
        if inside[i] && inside[j] && !corners.contains_key(&[i, j]) {
            let [kept, gone] = [group[i].min(group[j]), group[i].max(group[j])];
            group.iter_mut().filter(|own| **own == gone).for_each(|own| *own = kept);
        }
    }
    group
}

/// The polyhedron between polygons on the sides of an element of some volume [m³] and on the surfaces of groups of its
/// nodes.
fn polyhedron<const D: usize, const N: usize>(
    mut facets: Vec<Vec<PartCorner<D>>>,
    group: &[usize; N],
    volume: f64,
) -> Option<Vec<FluidSimplex<N>>> {
    let mut segments: BTreeMap<usize, Vec<[PartCorner<D>; 2]>> = BTreeMap::new();
    for side in &facets {
        for k in 0..side.len() {
            let [start, end] = [side[k], side[(k + 1) % side.len()]];
            if start.on_surface_with(&end) {
                // The surface behind sees it the other way round.
                segments.entry(group[start.edge[0]]).or_default().push([end, start]);
            }
        }
    }
    for own in segments.into_values() {
        facets.push(ring(own)?);
    }
    let apex = *facets.iter().flatten().min_by_key(|corner| corner.order)?;
    let mut parts = Vec::new();
    for mut facet in facets {
        let Some(first) = (0..facet.len()).min_by_key(|&k| facet[k].order) else { continue };
        facet.rotate_left(first);
        if facet[0].vertex == apex.vertex {
            continue;
        }
        for pair in facet[1..].windows(2) {
            let mut corners = [apex, facet[0], pair[0], pair[1]];
            let [a, b, c] = [1, 2, 3].map(|k| Vector(corners[k].position.to3()) - Vector(apex.position.to3()));
            let size = a.cross(b).dot(c) / 6.0;
            if size.abs() < FLAT * volume {
                continue;
            }
            if size < 0.0 {
                corners.swap(2, 3);
            }
            parts.push(FluidSimplex { vertices: std::array::from_fn(|k| corners[k].vertex) });
        }
    }
    Some(parts)
}

/// Segments, each from its first corner to its second, as a closed polygon; `None` if they aren't one.
fn ring<const D: usize>(mut segments: Vec<[PartCorner<D>; 2]>) -> Option<Vec<PartCorner<D>>> {
    let [first, mut last] = segments.pop()?;
    let mut ring = vec![first];
    while last.vertex != first.vertex {
        ring.push(last);
        let next = segments.iter().position(|[start, _]| start.vertex == last.vertex)?;
        last = segments.swap_remove(next)[1];
    }
    segments.is_empty().then_some(ring)
}
