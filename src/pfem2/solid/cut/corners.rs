//! Corners of solids inside cut elements, in two dimensions (theory J.2).
//!
//! ```text
//! fluid part of e   polygon: nodes outside, cut points, and the corners c of the solid in e, along its surface
//! ear clipping      triangles of its corners; of all ears the one of the best shape first
//! ```
//!
//! Without them the chord between the two cut points would cut the corner off, and with it buoyancy.

use super::{CutBySolid, CutPoint, FluidSimplex, SolidCut, Vertex, parts};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::solid::surface::SolidSurface;
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
        let mut held: BTreeMap<usize, Vec<CutPoint<D>>> = BTreeMap::new();
        for (position, node) in surface.corners() {
            let holds =
                |cut: &CutBySolid<N>| mesh.shape_functions(cut.element as usize, position).iter().all(|&n| n > INSIDE);
            if let Some(place) = self.elements.iter().position(holds) {
                let point = CutPoint { edge: None, position, weights: vec![(node, 1.0)], glides_across: None };
                held.entry(place).or_default().push(point);
            }
        }
        for (place, corners) in held {
            let Some(parts) = self.parts_beside(mesh, place, &corners) else { continue };
            let points = self.points.len() as u32..;
            self.elements[place].points.extend(points.take(corners.len()));
            self.elements[place].parts = parts;
            self.points.extend(corners);
        }
    }

    /// The fluid part of an element that holds these corners; `None` if the polygon crosses itself.
    fn parts_beside(&self, mesh: &Mesh<D, N>, place: usize, corners: &[CutPoint<D>]) -> Option<Vec<FluidSimplex<N>>> {
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
        let triangles = triangulated(polygon)?;
        Some(
            triangles
                .into_iter()
                .map(|corners| FluidSimplex { vertices: std::array::from_fn(|k| corners[k]) })
                .collect(),
        )
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

/// A polygon, counter-clockwise, as triangles; `None` if it crosses itself.
fn triangulated<const D: usize>(mut polygon: Vec<PolygonCorner<D>>) -> Option<Vec<[Vertex; 3]>> {
    let mut triangles = Vec::new();
    while polygon.len() > 2 {
        let count = polygon.len();
        let ear = |i: usize| [(i + count - 1) % count, i, (i + 1) % count];
        let shape = |i: usize| {
            let corners = ear(i).map(|k| polygon[k].1);
            let others = (0..count).filter(|k| !ear(i).contains(k)).map(|k| polygon[k].1);
            let is_free = others.into_iter().all(|x| !contains(&corners, x));
            if is_free { quality(&corners) } else { 0.0 }
        };
        let best = (0..count).map(|i| (i, shape(i))).max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
        if best.1 <= 0.0 {
            return None;
        }
        triangles.push(ear(best.0).map(|k| polygon[k].0));
        polygon.remove(best.0);
    }
    Some(triangles)
}

/// Twice the area of a triangle [m²], positive where its corners run counter-clockwise.
fn area<const D: usize>([a, b, c]: &[Vector<D>; 3]) -> f64 {
    let (u, v) = (*b - *a, *c - *a);
    u[0] * v[1] - u[1] * v[0]
}

/// Area of a triangle over the square of its longest side, at most 0.87.
fn quality<const D: usize>(corners: &[Vector<D>; 3]) -> f64 {
    let [a, b, c] = *corners;
    let longest = [b - a, c - b, a - c].iter().map(|side| side.norm_squared()).fold(0.0, f64::max);
    if longest > 0.0 { area(corners) / longest } else { 0.0 }
}

/// True if a triangle holds a place.
fn contains<const D: usize>([a, b, c]: &[Vector<D>; 3], x: Vector<D>) -> bool {
    [[*a, *b, x], [*b, *c, x], [*c, *a, x]].iter().all(|triangle| area(triangle) >= 0.0)
}
