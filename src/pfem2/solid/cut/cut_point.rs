//! Points where edges of the mesh cross the surface of solids, and how they move (theory (J.6)–(J.6c)).
//!
//! ```text
//! x_c = x_i + t (x_j − x_i),  d(x_c) = 0,  t ∈ (0, 1)         c on the edge from i, outside, to j, inside
//! v_c = P_s Σ_a N_a(ξ_c) v_a + (1 − P_s) v_i                  P_s = 1 where the fluid sticks
//! ```

use super::super::setup::SurfaceCondition;
use super::super::surface::{NearestPoint, NodeWeights, SolidSurface};
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;

/// Cut points keep this fraction of their edge away from its end outside: slivers that are thinner cost the solver
/// digits, and tie nodes to solids.
pub(super) const LEAST_EDGE_FRACTION: f64 = 1e-4;

/// Cut points keep this fraction of their edge away from its end inside: fluid between two of them moves with
/// the solid.
pub(super) const LEAST_INNER_EDGE_FRACTION: f64 = 1e-6;

/// The same where the fluid glides: between two of them, beside a node inside, shear would tie the nodes outside
/// together.
pub(super) const LEAST_GLIDING_EDGE_FRACTION: f64 = 1e-3;

/// Films between two solids are as thick as this part of their edge at least; thinner ones between two sides of one
/// solid are left out.
pub(super) const LEAST_THICKNESS: f64 = 1e-3;

/// A point of the surface that is a corner of the fluid part of elements.
#[derive(Debug, Clone, PartialEq)]
pub struct CutPoint<const D: usize> {
    /// The node outside and the node inside of the edge of the mesh on which it lies. `None` on a corner or an edge
    /// of the solid, on an edge of the mesh that the solid crosses between two nodes outside, and in films.
    pub edge: Option<[u32; 2]>,
    /// The two nodes inside on whose edge of the mesh it bounds a film, that beside it first; `None` elsewhere.
    pub film_edge: Option<[u32; 2]>,
    /// The node outside that the fluid there follows in the directions in which it isn't bound to the solid.
    pub gliding_node: Option<u32>,
    /// Position [m]: on an edge of the mesh, on a face, or inside an element.
    pub position: Vector<D>,
    /// Shape functions of the solids' nodes at the nearest point of the surface, by global node.
    pub weights: NodeWeights,
    /// Outward unit normal of the surface there, on an edge of the mesh with a node outside; `None` elsewhere.
    pub normal: Option<Vector<D>>,
    /// P_s, the projection on the directions in which the fluid is bound to the solid, where it glides in others
    /// (theory (J.6a)–(J.6c)); `None` where it sticks.
    pub bound_directions: Option<Tensor<D>>,
}

/// Weights of the solid and of a node outside in the velocity of a cut point, v_c = P_s v_s + P_o v_o.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityWeights<const D: usize> {
    /// P_s.
    pub solid: Tensor<D>,
    /// P_o; `None` where the node has no weight.
    pub node: Option<Tensor<D>>,
}

impl<const D: usize> CutPoint<D> {
    /// The point at which a film meets a solid on an edge of the mesh whose node beside it comes first.
    pub(super) fn in_film(film_edge: [u32; 2], position: Vector<D>, weights: NodeWeights) -> Self {
        let (edge, gliding_node, normal, bound_directions) = (None, None, None, None);
        Self { edge, film_edge: Some(film_edge), gliding_node, position, weights, normal, bound_directions }
    }

    /// The weights in its velocity: the solid alone; where the fluid glides, the solid in the bound directions, P_s,
    /// and the gliding node in the others, P_o = 1 − P_s (theory (J.6a)–(J.6c)).
    pub fn velocity_weights(&self) -> VelocityWeights<D> {
        match self.bound_directions {
            Some(bound) => VelocityWeights { solid: bound, node: Some(Tensor::identity() - bound) },
            None => VelocityWeights { solid: Tensor::identity(), node: None },
        }
    }

    /// Its velocity, by those of nodes of the mesh and of solids [m/s].
    pub fn velocity(&self, of_node: &dyn Fn(usize) -> Vector<D>, of_solid: &dyn Fn(usize) -> Vector<D>) -> Vector<D> {
        let VelocityWeights { solid, node } = self.velocity_weights();
        let surface: Vector<D> = self.weights.iter().map(|&(a, w)| of_solid(a as usize) * w).sum();
        let gliding = node.zip(self.gliding_node).map_or(Vector::ZERO, |(p, i)| p.apply(of_node(i as usize)));
        solid.apply(surface) + gliding
    }
}

/// The cut point of an edge from the node outside to the node inside, which lies in this body:
/// a solid, or the first of those that are bonded.
pub(super) fn cut_point<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    surface: &SolidSurface<D>,
    conditions: &[SurfaceCondition],
    distance: &[f64],
    edge: [u32; 2],
    body: usize,
) -> CutPoint<D> {
    let [start, end] = edge.map(|node| mesh.nodes()[node as usize]);
    let at = |t: f64| start + (end - start) * t;
    let ends = edge.map(|node| distance[node as usize]);
    let (length, level) = ((end - start).norm(), level_of(mesh, surface, edge[1], ends[1]));
    let of_all = crossing(|x| surface.foot(x), at, ends, level, length);
    let is_other = of_all.1.is_some_and(|foot| surface.body(foot.solid) != body);
    let own = is_other.then(|| own_crossing(surface, at, body, length)).flatten();
    let (t, foot) = own.unwrap_or(of_all);
    let glides = |foot: &NearestPoint<D>| conditions.get(foot.solid) == Some(&SurfaceCondition::Slip);
    let last = if conditions.contains(&SurfaceCondition::Slip) {
        LEAST_GLIDING_EDGE_FRACTION
    } else {
        LEAST_INNER_EDGE_FRACTION
    };
    let kept = t.clamp(LEAST_EDGE_FRACTION, 1.0 - last);
    let foot = foot.filter(|_| kept == t).or_else(|| surface.foot(at(kept)));
    let normal = foot.and_then(|foot| surface.normal(&foot));
    let bound_directions = normal.filter(|_| foot.is_some_and(|foot| glides(&foot))).map(|n| Tensor::outer(n, n));
    let weights = foot.map_or_else(Vec::new, |foot| surface.weights(&foot));
    CutPoint {
        edge: Some(edge),
        film_edge: None,
        gliding_node: Some(edge[0]),
        position: at(kept),
        weights,
        normal,
        bound_directions,
    }
}

/// The place at which an edge of some length [m] leaves the body of its node inside; it meets another one farther on.
fn own_crossing<const D: usize>(
    surface: &SolidSurface<D>,
    at: impl Fn(f64) -> Vector<D>,
    body: usize,
    length: f64,
) -> Option<(f64, Option<NearestPoint<D>>)> {
    let of_body = |x| surface.foot_on_body(body, x);
    let ends = [of_body(at(0.0))?.distance, of_body(at(1.0))?.distance];
    (ends[0] > 0.0 && ends[1] < 0.0).then(|| crossing(of_body, at, ends, 0.0, length))
}

/// The distance at which an edge is cut that ends in a node inside [m]: zero, but where the node lies on the surface,
/// which the edge may meet before or follow, or outside of it: a little above that of the node.
fn level_of<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    surface: &SolidSurface<D>,
    node: u32,
    distance: f64,
) -> f64 {
    let margin = LEAST_INNER_EDGE_FRACTION * smallest_element(mesh, node as usize);
    if distance < -margin { 0.0 } else { surface.distance(mesh.nodes()[node as usize]) + margin }
}

/// Point where the signed distance has a `level` [m] on an edge of some length [m], as a fraction of it, given
/// the `nearest` point of the surface to a place, and the distances at its ends, of which the first is above the level
/// and the second is not; the nearest point there, if the crossing was found.
pub(super) fn crossing<const D: usize>(
    nearest: impl Fn(Vector<D>) -> Option<NearestPoint<D>>,
    at: impl Fn(f64) -> Vector<D>,
    [outside, inside]: [f64; 2],
    level: f64,
    length: f64,
) -> (f64, Option<NearestPoint<D>>) {
    const PASSES: usize = 40;
    /// Distance from the surface, relative to the edge.
    const TOLERANCE: f64 = 1e-7;
    let edge = at(1.0) - at(0.0);
    let mut t = (outside - level) / (outside - inside);
    let mut bracket = [0.0, 1.0];
    for _ in 0..PASSES {
        let Some(foot) = nearest(at(t)) else { break };
        let beyond = foot.distance - level;
        if beyond.abs() <= TOLERANCE * length {
            return (t, Some(foot));
        }
        bracket[usize::from(beyond < 0.0)] = t;
        // ∇d is the direction to the nearest point, backwards outside.
        let gradient = (at(t) - foot.position) / foot.distance;
        let next = t - beyond / gradient.dot(edge);
        t = if bracket[0] < next && next < bracket[1] { next } else { 0.5 * (bracket[0] + bracket[1]) };
    }
    (t, None)
}

/// Size of the smallest element around a node [m].
pub(super) fn smallest_element<const D: usize, const N: usize>(mesh: &Mesh<D, N>, node: usize) -> f64 {
    let volumes = mesh.elements_around(node).iter().map(|&e| mesh.simplex(e as usize).volume);
    volumes.fold(f64::INFINITY, f64::min).powf(1.0 / D as f64)
}
