//! Corners of solids inside elements, in two dimensions (theory J.2).
//!
//! ```text
//! corner c in an element that is cut       fluid part: the polygon of nodes outside, cut points, and c between these
//! corner c in an element without a node    c with the points p and q where the surface crosses the edge behind c: the polygon of all nodes,
//! inside                                   p, c, q; in the element behind that edge a triangle at each of its ends
//! ear clipping                             triangles of the corners of a polygon; of all ears the one of the best shape first
//! ```
//!
//! Without them the chord between cut points would cut the corner off, and with it buoyancy.

use super::{CutBySolid, CutPoint, ElementState, FluidSimplex, SolidCut, Vertex, crossing, parts};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::solid::surface::{SolidSurface, SurfaceCorner};
use std::collections::BTreeMap;

/// Least shape function of a corner that counts as inside of an element.
const INSIDE: f64 = 0.01;

/// A corner of the polygon that the fluid fills in an element.
type PolygonCorner<const D: usize> = (Vertex, Vector<D>);

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Makes corners of the solids corners of the fluid part of the elements that hold them.
    pub(super) fn keep_corners(&mut self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>) {
        if D != 2 {
            return;
        }
        let mut held: BTreeMap<usize, Vec<SurfaceCorner<D>>> = BTreeMap::new();
        for corner in surface.corners() {
            if let Some(element) = self.holder(mesh, corner.position) {
                held.entry(element).or_default().push(corner);
            }
        }
        for (&element, corners) in &held {
            match (self.state[element], &corners[..]) {
                (ElementState::Cut(place), _) => self.keep_inside(mesh, place as usize, corners),
                (ElementState::Fluid, [corner]) => self.keep_tip(mesh, surface, element, corner, &held),
                _ => None,
            };
        }
    }

    /// The element near solids that holds a place.
    fn holder(&self, mesh: &Mesh<D, N>, x: Vector<D>) -> Option<usize> {
        let holds = |e: &usize| mesh.shape_functions(*e, x).iter().all(|&n| n > INSIDE);
        let beside = |cut: &CutBySolid<N>| {
            let e = cut.element as usize;
            std::iter::once(e).chain((0..N).filter_map(move |k| mesh.neighbour(e, k)))
        };
        self.elements.iter().flat_map(beside).find(holds)
    }

    /// Keeps corners inside of a cut element; `None` if their polygon crosses itself.
    fn keep_inside(&mut self, mesh: &Mesh<D, N>, place: usize, corners: &[SurfaceCorner<D>]) -> Option<()> {
        let element = &self.elements[place];
        let nodes = element.nodes.map(|node| mesh.nodes()[node as usize]);
        let mut polygon = self.outline(element, &nodes)?;
        let (enter, leave) = (polygon.first()?.1, polygon.last()?.1);
        let first = element.points.len() as u8;
        let mut own: Vec<PolygonCorner<D>> =
            (first..).map(Vertex::Point).zip(corners.iter().map(|corner| corner.position)).collect();
        let along = |corner: &PolygonCorner<D>| (corner.1 - leave).dot(enter - leave);
        own.sort_by(|a, b| along(a).total_cmp(&along(b)));
        polygon.extend(own);
        self.elements[place].parts = triangulated(polygon)?;
        for corner in corners {
            let number = self.add_point(corner.position, vec![(corner.node, 1.0)]);
            self.elements[place].points.push(number);
        }
        Some(())
    }

    /// Keeps a corner that reaches through an edge into an element without a node inside; `None` where it is no plain tip.
    fn keep_tip(
        &mut self,
        mesh: &Mesh<D, N>,
        surface: &SolidSurface<D>,
        element: usize,
        corner: &SurfaceCorner<D>,
        held: &BTreeMap<usize, Vec<SurfaceCorner<D>>>,
    ) -> Option<()> {
        let nodes = mesh.elements()[element];
        let x = mesh.corners(element);
        let opposite = (0..N).find(|&k| {
            let behind = mesh.neighbour(element, k).filter(|behind| !held.contains_key(behind));
            behind.is_some_and(|behind| matches!(self.state[behind], ElementState::Cut(_)))
                && foot_on_edge(corner, x[(k + 1) % N], x[(k + 2) % N]).is_some()
        })?;
        let [i, j] = [(opposite + 1) % N, (opposite + 2) % N];
        let ElementState::Cut(behind) = self.state[mesh.neighbour(element, opposite)?] else { return None };
        let middle = x[i] + (x[j] - x[i]) * foot_on_edge(corner, x[i], x[j])?;
        let inside = surface.distance(middle);
        if inside >= 0.0 {
            return None;
        }
        let points = [i, j].map(|end| {
            let at = |t: f64| x[end] + (middle - x[end]) * t;
            let ends = [self.distance[nodes[end] as usize], inside];
            let (t, foot) = crossing(surface, at, ends, (middle - x[end]).norm());
            Some((at(t), surface.weights(&foot.or_else(|| surface.foot(at(t)))?)))
        });
        let [Some(first), Some(second)] = points else { return None };
        let polygon = [i, j, opposite].map(|k| (Vertex::Node(k as u8), x[k]));
        let tip =
            [first.0, corner.position, second.0].into_iter().enumerate().map(|(k, x)| (Vertex::Point(k as u8), x));
        let around = [polygon[0]].into_iter().chain(tip).chain([polygon[1], polygon[2]]).collect();
        let parts = triangulated(around)?;
        let beside = self.beside_tip([nodes[i], nodes[j]], behind as usize)?;
        let numbers = [first, (corner.position, vec![(corner.node, 1.0)]), second]
            .map(|(position, weights)| self.add_point(position, weights));
        self.state[element] = ElementState::Cut(self.elements.len() as u32);
        let (points, shapes) = (numbers.to_vec(), Vec::new());
        self.elements.push(CutBySolid { element: element as u32, nodes, points, parts, shapes, share: 1.0 });
        self.elements[behind as usize].parts = beside;
        self.elements[behind as usize].points.extend([numbers[0], numbers[2]]);
        Some(())
    }

    /// The triangles at the ends of an edge through which a tip reaches, in the cut element from which it comes; the points of the surface on
    /// the edge are its next two.
    fn beside_tip(&self, ends: [u32; 2], place: usize) -> Option<Vec<FluidSimplex<N>>> {
        let element = &self.elements[place];
        let inside = element.nodes.map(|node| self.is_inside(node));
        let edges = parts::cut_edges(inside);
        if edges.len() != 2 || element.points.len() != 2 || inside.iter().filter(|inside| **inside).count() != 1 {
            return None;
        }
        let triangle = |(side, end): (usize, u32)| {
            let node = element.nodes.iter().position(|&node| node == end)?;
            let own = edges.iter().position(|[outside, _]| *outside == node)?;
            let [node, own] = [Vertex::Node(node as u8), Vertex::Point(own as u8)];
            let next = Vertex::Point(2 + side as u8);
            // The element behind sees the edge the other way round.
            let corners = if side == 0 { [node, own, next] } else { [node, next, own] };
            Some(FluidSimplex { vertices: std::array::from_fn(|k| corners[k]) })
        };
        ends.into_iter().enumerate().map(triangle).collect()
    }

    fn add_point(&mut self, position: Vector<D>, weights: Vec<(u32, f64)>) -> u32 {
        self.points.push(CutPoint { edge: None, position, weights, glides_across: None });
        self.points.len() as u32 - 1
    }

    /// Nodes outside and cut points of an element in order around it, from the cut point at which the surface leaves it to that at which it comes.
    fn outline(&self, element: &CutBySolid<N>, nodes: &[Vector<D>; N]) -> Option<Vec<PolygonCorner<D>>> {
        let inside = element.nodes.map(|node| self.is_inside(node));
        let edges = parts::cut_edges(inside);
        let mut around = Vec::new();
        let mut start = None;
        for i in 0..N {
            let j = (i + 1) % N;
            if !inside[i] {
                around.push((Vertex::Node(i as u8), nodes[i]));
            }
            if inside[i] != inside[j] {
                let edge = if inside[i] { [j, i] } else { [i, j] };
                let k = edges.iter().position(|other| *other == edge)?;
                if inside[i] {
                    start = Some(around.len());
                }
                around.push((Vertex::Point(k as u8), self.points[element.points[k] as usize].position));
            }
        }
        around.rotate_left(start?);
        Some(around)
    }
}

/// Where the way from a corner into its solid crosses an edge, as a fraction of it.
fn foot_on_edge<const D: usize>(corner: &SurfaceCorner<D>, start: Vector<D>, end: Vector<D>) -> Option<f64> {
    let (edge, away) = (end - start, corner.position - start);
    let cross = |a: Vector<D>, b: Vector<D>| a[0] * b[1] - a[1] * b[0];
    let slope = cross(corner.normal, edge);
    let (way, t) = (cross(away, edge) / slope, cross(corner.normal, away) / slope);
    (way.is_finite() && way > 0.0 && t > 0.0 && t < 1.0).then_some(t)
}

/// A polygon, counter-clockwise, as triangles; `None` if it crosses itself.
fn triangulated<const D: usize, const N: usize>(mut polygon: Vec<PolygonCorner<D>>) -> Option<Vec<FluidSimplex<N>>> {
    let mut triangles = Vec::new();
    while polygon.len() > 2 {
        let count = polygon.len();
        let ear = |i: usize| [(i + count - 1) % count, i, (i + 1) % count];
        let shape = |i: usize| {
            let corners = ear(i).map(|k| polygon[k].1);
            let mut others = (0..count).filter(|k| !ear(i).contains(k)).map(|k| polygon[k].1);
            if others.any(|x| contains(&corners, x)) { 0.0 } else { quality(&corners) }
        };
        let best = (0..count).map(|i| (i, shape(i))).max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
        if best.1 <= 0.0 {
            return None;
        }
        let corners = ear(best.0).map(|k| polygon[k].0);
        triangles.push(FluidSimplex { vertices: std::array::from_fn(|k| corners[k]) });
        polygon.remove(best.0);
    }
    Some(triangles)
}

/// Twice the area of a triangle [m²], positive where its corners run counter-clockwise.
fn area<const D: usize>([a, b, c]: &[Vector<D>; 3]) -> f64 {
    let (u, v) = (*b - *a, *c - *a);
    u[0] * v[1] - u[1] * v[0]
}

/// Area of a triangle over the square of its longest side, twice.
fn quality<const D: usize>(corners: &[Vector<D>; 3]) -> f64 {
    let [a, b, c] = *corners;
    let longest = [b - a, c - b, a - c].iter().map(|side| side.norm_squared()).fold(0.0, f64::max);
    if longest > 0.0 { area(corners) / longest } else { 0.0 }
}

/// True if a triangle holds a place.
fn contains<const D: usize>([a, b, c]: &[Vector<D>; 3], x: Vector<D>) -> bool {
    [[*a, *b, x], [*b, *c, x], [*c, *a, x]].iter().all(|triangle| area(triangle) >= 0.0)
}
