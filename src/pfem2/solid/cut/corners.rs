//! Corners of solids inside elements, in two dimensions (theory J.2).
//!
//! ```text
//! corner c in an element that is cut       fluid part: the polygon of nodes outside, cut points, and c between these
//! corner c in another element              see `corners_beyond_nodes`
//! ```
//!
//! Without them the chord between cut points would cut the corner off, and with it buoyancy.

use super::corners_beyond_nodes::CornersBeyondNodes;
use super::cut_point::{LEAST_EDGE_FRACTION, LEAST_GLIDING_EDGE_FRACTION};
use super::polygon::{PolygonCorner, triangulated};
use super::{CutBySolid, CutPoint, ElementState, SolidCut, Vertex, body_of, parts};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::solid::surface::{SolidSurface, SurfaceCorner};
use std::collections::BTreeMap;

/// Least shape function of a corner inside of an element: nearer to its sides it is moved there, as cut points are kept
/// away from nodes.
const LEAST_SHAPE_FUNCTION: f64 = LEAST_EDGE_FRACTION;

/// Shape function below zero that is rounding.
const ROUNDING: f64 = 1e-9;

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Makes corners of the solids corners of the fluid part of the elements that hold them.
    pub(super) fn keep_corners(&mut self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>) {
        if D != 2 {
            return;
        }
        let mut held: BTreeMap<usize, Vec<SurfaceCorner<D>>> = BTreeMap::new();
        for corner in surface.corners() {
            if self.stick_at(mesh, corner.position) {
                continue;
            }
            if let Some((element, position)) = self.holder(mesh, &corner) {
                held.entry(element).or_default().push(SurfaceCorner { position, ..corner });
            }
        }
        for (&element, corners) in &held {
            let kept = match (self.state[element], &corners[..]) {
                (ElementState::Cut(place), _) => {
                    let own: Vec<_> =
                        corners.iter().filter(|corner| self.is_cut_by(surface, place, corner.node)).copied().collect();
                    let kept = self.keep_inside(mesh, place as usize, &own);
                    kept.filter(|()| own.len() == corners.len())
                }
                (ElementState::Fluid, _) => {
                    let is_plain = |behind| !held.contains_key(&behind);
                    let beyond = CornersBeyondNodes::new(mesh, self, element, corners, is_plain);
                    beyond.and_then(|beyond| self.keep_corners_beyond_nodes(mesh, surface, &beyond))
                }
                (ElementState::Solid, _) => None,
            };
            if kept.is_none() {
                self.stick_around(mesh, element);
            }
        }
    }

    /// Makes the fluid stick at cut points that are no farther from a corner than they are kept away from nodes:
    /// gliding along one of its sides they would let the fluid through the other. False if there are none.
    fn stick_at(&mut self, mesh: &Mesh<D, N>, corner: Vector<D>) -> bool {
        let mut any = false;
        for point in self.points.iter_mut().filter(|point| point.bound_directions.is_some()) {
            let Some([start, end]) = point.edge.map(|edge| edge.map(|node| mesh.nodes()[node as usize])) else {
                continue;
            };
            if (point.position - corner).norm() <= 2.0 * LEAST_GLIDING_EDGE_FRACTION * (end - start).norm() {
                point.bound_directions = None;
                any = true;
            }
        }
        any
    }

    /// Makes the fluid stick at the cut points of an element and its neighbours, which cut a corner off: where it
    /// glides along one side of the solid at one end of a chord and along the other at the other end, it flows through
    /// the chord.
    fn stick_around(&mut self, mesh: &Mesh<D, N>, element: usize) {
        let neighbours = (0..N).filter_map(|k| mesh.neighbour(element, k));
        for e in std::iter::once(element).chain(neighbours) {
            let ElementState::Cut(place) = self.state[e] else { continue };
            for &point in &self.elements[place as usize].points {
                self.points[point as usize].bound_directions = None;
            }
        }
    }

    /// True if a cut point of an element lies on the solid of a global node.
    fn is_cut_by(&self, surface: &SolidSurface<D>, place: u32, node: u32) -> bool {
        let body_at = |point: u32| body_of(surface, &self.points[point as usize].weights);
        self.elements[place as usize].points.iter().any(|&point| body_at(point) == Some(surface.body_of(node)))
    }

    /// The element near solids that holds a corner, and its place there, no nearer to the sides of the element than it
    /// may be [m]. Of two elements on whose common side it lies that into which the solid goes on from it.
    fn holder(&self, mesh: &Mesh<D, N>, corner: &SurfaceCorner<D>) -> Option<(usize, Vector<D>)> {
        let holds = |e: usize| {
            let inwards = corner.normal * -(LEAST_SHAPE_FUNCTION * mesh.simplex(e).volume.powf(1.0 / D as f64));
            if mesh.shape_functions(e, corner.position + inwards).iter().any(|&n| n < -ROUNDING) {
                return None;
            }
            let kept = mesh.shape_functions(e, corner.position).map(|n| n.max(LEAST_SHAPE_FUNCTION));
            let sum: f64 = kept.iter().sum();
            Some((e, mesh.corners(e).into_iter().zip(kept).map(|(x, n)| x * (n / sum)).sum()))
        };
        let cut = || self.elements.iter().map(|cut| cut.element as usize);
        let beside = || cut().flat_map(|e| (0..N).filter_map(move |k| mesh.neighbour(e, k)));
        let around = |e: usize| mesh.elements()[e].iter().flat_map(|&i| mesh.elements_around(i as usize));
        let farther = || beside().flat_map(around).map(|&e| e as usize);
        cut().chain(beside()).find_map(holds).or_else(|| farther().find_map(holds))
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

    pub(super) fn add_point(&mut self, position: Vector<D>, weights: Vec<(u32, f64)>) -> u32 {
        self.points.push(CutPoint {
            edge: None,
            film_edge: None,
            gliding_node: None,
            position,
            weights,
            normal: None,
            bound_directions: None,
        });
        self.points.len() as u32 - 1
    }

    /// Nodes outside and cut points of an element in order around it, from the cut point at which the surface leaves it
    /// to that at which it comes.
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
