//! Points where a solid reaches through edges of the mesh with both nodes outside, at an edge of its own (theory J.2).

use super::CutPoint;
use super::cones::CrossedElement;
use super::cut_point::{LEAST_GLIDING_EDGE_FRACTION, LEAST_INNER_EDGE_FRACTION, crossing};
use super::edge_passages::{EdgePoint, LEAST_SHAPE_FUNCTION, moved_inside};
use super::solid_edges::{Crossings, Solids};
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;
use crate::pfem2::solid::setup::SurfaceCondition;
use crate::pfem2::solid::surface::NodeWeights;

/// Least distance of p and q from the place between them, over the length of their edge: the solid may do no more than
/// touch it.
const LEAST_EDGE_DISTANCE: f64 = LEAST_SHAPE_FUNCTION;

impl<const D: usize> Solids<'_, D> {
    /// The place of the surface amid these crossings of edges with both nodes outside.
    pub(super) fn amid<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        own: &CrossedElement<N>,
        twice: &Crossings<D>,
    ) -> Option<EdgePoint<D>> {
        let points: Vec<Vector<D>> = own
            .crossings
            .iter()
            .filter_map(|(edge, _)| Some(twice.get(&edge.map(|k| own.nodes[k]))?.position))
            .collect();
        let middle = points.iter().copied().sum::<Vector<D>>() / points.len() as f64;
        let weights = self.surface.weights(&self.surface.foot(middle)?);
        Some(EdgePoint { position: moved_inside(mesh, own.element, middle), weights, tangent: None })
    }

    /// Points where the solid crosses an edge of the mesh with both nodes outside at a piece of its own edge, seen from
    /// each node. The middle between is in the plane through that piece and its normal.
    pub(super) fn reach<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        nodes: [u32; 2],
        piece: usize,
    ) -> Option<[([u32; 2], CutPoint<D>); 2]> {
        let x = nodes.map(|node| mesh.nodes()[node as usize]);
        let own = &self.edges.pieces[piece];
        let across = Vector::<3>(own.tangent()?.to3()).cross(Vector(own.normal.to3()));
        let off = x.map(|x| Vector::<3>((x - own.ends[0].position).to3()).dot(across));
        let fraction = off[0] / (off[0] - off[1]);
        if !(fraction > 0.0 && fraction < 1.0) {
            return None;
        }
        let middle = x[0] + (x[1] - x[0]) * fraction;
        let inside = self.surface.distance(middle);
        let length = (x[1] - x[0]).norm();
        if inside > LEAST_INNER_EDGE_FRACTION * length {
            return None;
        }
        let seen = |end: usize| self.seen_from(nodes[end], [x[end], middle], inside, length);
        let [first, second] = [seen(0)?, seen(1)?];
        let reach = (second.position - first.position).dot(x[1] - x[0]);
        (reach > 0.0).then_some([(nodes, first), ([nodes[1], nodes[0]], second)])
    }

    /// The crossing of the solid on the way from a node outside to the place `middle` of its edge, which lies `inside`
    /// [m] (negative) of the solid; `length` of the edge [m].
    fn seen_from(&self, node: u32, [start, middle]: [Vector<D>; 2], inside: f64, length: f64) -> Option<CutPoint<D>> {
        let way = middle - start;
        let at = |t: f64| start + way * t;
        let part = way.norm() / length;
        let ends = [self.surface.distance(start), inside.min(0.0)];
        let (t, _) = crossing(|x| self.surface.foot(x), at, ends, 0.0, way.norm());
        let t = t.min(1.0 - LEAST_EDGE_DISTANCE / part).max(LEAST_GLIDING_EDGE_FRACTION / part);
        let foot = self.surface.foot(at(t))?;
        let glides = self.conditions.get(foot.solid) == Some(&SurfaceCondition::Slip);
        let normal = self.surface.normal(&foot).filter(|_| glides);
        let bound_directions = normal.map(|normal| Tensor::outer(normal, normal));
        let weights: NodeWeights = self.surface.weights(&foot);
        Some(CutPoint {
            edge: None,
            film_edge: None,
            gliding_node: Some(node),
            position: at(t),
            weights,
            normal: None,
            bound_directions,
        })
    }
}
