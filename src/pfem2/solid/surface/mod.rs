//! The surface of solids in a configuration: nearest points, signed distance, places inside (theory J.2).
//!
//! ```text
//! d(x) = ± min |x − x_Γ(ξ)|   over the quadratic facets of a solid, negative inside;   the least of several solids
//! x = Σ_a N_a(ξ) x_a          weights N_a of the nodes at a point of a facet or of an element
//! ```
//!
//! Boxes around facets and elements are kept in trees. The sign is that of (x − x_Γ)·n with the normal n of all facets
//! which meet at x_Γ, so that it holds at corners, too.

mod edges;
mod facet;
mod feet;
mod normals;
mod points;
mod quadratic;
#[cfg(test)]
pub(in crate::pfem2) mod tests;

use super::mesh::{SolidMesh, element_nodes};
use crate::math::Vector;
use crate::parallel;
pub use edges::{EDGE_COSINE_SQUARED, EdgePiece};
use facet::SurfaceFacet;
pub(super) use feet::FacetFoot;
use normals::Normals;
pub(super) use points::FacetPoint;
use quadratic::{bounds, coordinates, shape_functions};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Nearer than this fraction of a facet a place lies on the surface.
const ROUND_OFF: f64 = 1e-12;

/// Facets per piece of a parallel loop.
const PIECE: usize = 64;

/// Boxes with numbers.
type Boxes<const D: usize> = RTree<GeomWithData<Rectangle<[f64; D]>, u32>>;

/// Weights of global nodes.
pub type NodeWeights = Vec<(u32, f64)>;

/// The surface of the solids of a run in one configuration.
#[derive(Debug, Clone)]
pub struct SolidSurface<const D: usize> {
    /// Facets of all solids, one solid after the other.
    facets: Vec<SurfaceFacet<D>>,
    normals: Normals<D>,
    solids: Vec<SolidFacets<D>>,
    /// Global nodes of all elements, 3ᴰ each.
    elements: Vec<u32>,
    element_boxes: Boxes<D>,
    positions: Vec<Vector<D>>,
    /// The first global node of each solid, ascending.
    first_nodes: Vec<u32>,
    /// For each solid the first of those that it is bonded with, or itself: no fluid is between them.
    bonded_to: Vec<usize>,
    /// True for rigid solids.
    is_rigid: Vec<bool>,
}

/// The facets of a solid.
#[derive(Debug, Clone)]
struct SolidFacets<const D: usize> {
    /// Number of its first facet.
    first: u32,
    boxes: Boxes<D>,
    lower: Vector<D>,
    upper: Vector<D>,
    /// True without elements inside.
    is_hollow: bool,
}

/// The point of the surface that is nearest to a place.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosestPoint<const D: usize> {
    /// The solid, in the order of [`SolidSurface::new`].
    pub solid: u32,
    /// The facet, in [`SolidMesh::facets`].
    pub facet: u32,
    /// Coordinates on the facet, in −1..=1; in 2D the second is zero.
    pub local: [f64; 2],
    /// Position [m].
    pub position: Vector<D>,
    /// Outward unit normal; at an edge or corner the mean of those of all facets which meet there.
    pub normal: Vector<D>,
    /// Signed distance of the place [m]: positive outside, negative inside.
    pub distance: f64,
    /// Shape functions of the global nodes at it; their sum is one.
    pub weights: NodeWeights,
}

/// A corner of a solid in two dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceCorner<const D: usize> {
    /// Position [m].
    pub position: Vector<D>,
    /// Its global node.
    pub node: u32,
    /// Outward unit normal: the mean of those of the two facets.
    pub normal: Vector<D>,
}

/// The nearest point of one solid or of all.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearestPoint<const D: usize> {
    /// The solid, in the order of [`SolidSurface::new`].
    pub solid: usize,
    /// The facet, among those of all solids.
    pub facet: u32,
    local: [f64; 2],
    /// Position [m].
    pub position: Vector<D>,
    /// Signed distance of the place from it [m].
    pub distance: f64,
}

impl<const D: usize> SolidSurface<D> {
    /// The surface of the meshes of the solids, each with its first global node, and the positions of all global nodes
    /// [m]. Facets and elements with a position that is not finite are left out.
    pub fn new(solids: &[(&SolidMesh<D>, u32)], positions: &[Vector<D>]) -> Self {
        let of = |(mesh, first): (&SolidMesh<D>, u32)| {
            let facet = |f: usize| {
                let nodes = mesh.facets[f].nodes.iter().map(|node| node + first).collect();
                SurfaceFacet::new(nodes, positions)
            };
            parallel::collect(mesh.facets.len(), PIECE, facet)
        };
        let (mut facets, mut outlines) = (Vec::new(), Vec::new());
        for &solid in solids {
            let start = facets.len() as u32;
            facets.extend(of(solid));
            outlines.push(SolidFacets::new(start, &facets[start as usize..], solid.0.elements.is_empty()));
        }
        let shifted = |(mesh, first): &(&SolidMesh<D>, u32)| {
            let first = *first;
            mesh.elements.iter().flatten().map(move |node| node + first).collect::<Vec<u32>>()
        };
        let elements: Vec<u32> = solids.iter().flat_map(shifted).collect();
        let hull = |e: usize| {
            let nodes = &elements[e * element_nodes::<D>()..][..element_nodes::<D>()];
            bounds(&nodes.iter().map(|&node| positions[node as usize]).collect::<Vec<_>>())
        };
        let hulls = parallel::collect(elements.len() / element_nodes::<D>(), PIECE, hull);
        let normals = Normals::new(&facets, positions.len());
        let positions = positions.to_vec();
        let element_boxes = boxes(0, hulls.into_iter());
        let (first_nodes, bonded_to) = (solids.iter().map(|(_, first)| *first).collect(), (0..solids.len()).collect());
        let is_rigid = vec![false; solids.len()];
        Self { facets, normals, solids: outlines, elements, element_boxes, positions, first_nodes, bonded_to, is_rigid }
    }

    /// The surface, with the first of the solids that each is bonded with, or itself.
    pub fn with_bonds(self, bonded_to: Vec<usize>) -> Self {
        Self { bonded_to, ..self }
    }

    /// The surface, with those of its solids that are rigid.
    pub fn with_rigid(self, is_rigid: Vec<bool>) -> Self {
        Self { is_rigid, ..self }
    }

    /// True if some solids are rigid.
    pub(super) fn has_rigid(&self) -> bool {
        self.is_rigid.contains(&true)
    }

    /// True for a solid that is rigid.
    pub(super) fn is_rigid(&self, solid: usize) -> bool {
        self.is_rigid.get(solid).copied().unwrap_or(false)
    }

    /// The solid of a global node, or the first of those that it is bonded with.
    pub(super) fn body_of(&self, node: u32) -> usize {
        self.body(self.first_nodes.partition_point(|&first| first <= node).saturating_sub(1))
    }

    /// The first of the solids that a solid is bonded with, or itself.
    pub(super) fn body(&self, solid: usize) -> usize {
        self.bonded_to.get(solid).copied().unwrap_or(solid)
    }

    /// The nearest point of the surface to `x` [m], that of the solid with the least signed distance; `None` without
    /// solids.
    pub fn nearest(&self, x: Vector<D>) -> Option<ClosestPoint<D>> {
        let foot = self.foot(x)?;
        let NearestPoint { facet, local, position, distance, .. } = foot;
        let away = (x - position) * distance.signum();
        let normal = self.normals.at(&self.facets, facet, local).normalized().or(away.normalized());
        Some(ClosestPoint {
            solid: foot.solid as u32,
            facet: facet - self.solids[foot.solid].first,
            local,
            position,
            normal: normal.unwrap_or_default(),
            distance,
            weights: self.weights(&foot),
        })
    }

    /// Signed distance of `x` [m]: positive outside, negative inside, infinite without solids.
    pub fn distance(&self, x: Vector<D>) -> f64 {
        self.foot(x).map_or(f64::INFINITY, |foot| foot.distance)
    }

    /// Shape functions of the global nodes at `x` [m] in the element that holds it; `None` outside of all elements.
    pub fn locate_inside(&self, x: Vector<D>) -> Option<NodeWeights> {
        let (e, local) = self.element_at(x)?;
        Some(weights(self.element(e), &local.0))
    }

    /// Shape functions of the global nodes at `x` [m], near the surface, continued from the element that holds the
    /// nearest place of the surface: Σ N_a x_a = x. `None` of a solid without elements.
    pub(super) fn weights_beyond(&self, x: Vector<D>, foot: &NearestPoint<D>) -> Option<NodeWeights> {
        /// From the nearest place on, over the distance from it, a place is inside.
        const WAY_INSIDE: f64 = 1e-3;
        let inside = foot.position + (foot.position - x) * WAY_INSIDE;
        let (e, _) = self.element_at(x).or_else(|| self.element_at(inside))?;
        Some(weights(self.element(e), &coordinates(&self.places_of(self.element(e)), x)?.0))
    }

    /// The element that holds `x` [m], with the coordinates there.
    fn element_at(&self, x: Vector<D>) -> Option<(u32, Vector<D>)> {
        /// Beyond its sides an element holds what rounding puts there.
        const BEYOND: f64 = 1e-9;
        let at = self.element_boxes.locate_in_envelope_intersecting(AABB::from_point(x.0));
        let mut candidates: Vec<u32> = at.map(|entry| entry.data).collect();
        candidates.sort_unstable();
        let mut best: Option<(f64, u32, Vector<D>)> = None;
        for e in candidates {
            let Some(local) = coordinates(&self.places_of(self.element(e)), x) else { continue };
            let beyond = local.0.iter().fold(0.0, |most: f64, s| most.max(s.abs() - 1.0));
            if best.is_none_or(|(least, ..)| beyond < least) {
                best = Some((beyond, e, local));
            }
        }
        let (beyond, e, local) = best?;
        (beyond <= BEYOND).then_some((e, local))
    }

    /// Places of global nodes [m].
    fn places_of(&self, nodes: &[u32]) -> Vec<Vector<D>> {
        nodes.iter().map(|&node| self.positions[node as usize]).collect()
    }

    /// True if the box around an element, or that around a solid without elements, widened by a `margin` [m], holds `x`
    /// [m]: elsewhere `x` is outside.
    pub fn is_near(&self, x: Vector<D>, margin: f64) -> bool {
        let around = || AABB::from_corners((x - Vector::splat(margin)).0, (x + Vector::splat(margin)).0);
        let is_near = |solid: &&SolidFacets<D>| solid.gap_squared(x) <= margin * margin * D as f64;
        let mut near = self.solids.iter().filter(is_near).peekable();
        x.is_finite()
            && near.peek().is_some()
            && (near.any(|solid| solid.is_hollow)
                || self.element_boxes.locate_in_envelope_intersecting(around()).next().is_some())
    }

    /// Positions of the nodes of the facets [m], facet by facet; shared ones repeat.
    pub fn facet_nodes(&self) -> impl Iterator<Item = Vector<D>> {
        self.facets.iter().flat_map(|facet| facet.nodes.iter().map(|&node| self.positions[node as usize]))
    }

    /// Corners of the solids in two dimensions, where facets meet at an angle, by ascending nodes.
    pub fn corners(&self) -> Vec<SurfaceCorner<D>> {
        /// Cosine of the angle between the normals of facets from which on they make a corner.
        const FLAT: f64 = 0.97;
        let ends = |facet: &SurfaceFacet<D>| {
            let [first, second] = [[-1.0, 0.0], [1.0, 0.0]].map(|local| facet.normal(local).normalized());
            [(facet.nodes[0], first), (facet.nodes[2], second)]
        };
        let mut ends: Vec<(u32, Option<Vector<D>>)> = self.facets.iter().flat_map(ends).collect();
        ends.sort_by_key(|(node, _)| *node);
        let corner = |group: &[(u32, Option<Vector<D>>)]| {
            let &[(node, Some(first)), (_, Some(second))] = group else { return None };
            let position = self.positions[node as usize];
            let normal = (first + second).normalized().filter(|_| first.dot(second) < FLAT && position.is_finite())?;
            Some(SurfaceCorner { position, node, normal })
        };
        ends.chunk_by(|a, b| a.0 == b.0).filter_map(corner).collect()
    }

    fn element(&self, e: u32) -> &[u32] {
        &self.elements[e as usize * element_nodes::<D>()..][..element_nodes::<D>()]
    }

    /// Shape functions of the global nodes at a nearest point.
    pub(super) fn weights(&self, foot: &NearestPoint<D>) -> NodeWeights {
        weights(&self.facets[foot.facet as usize].nodes, &foot.local[..D - 1])
    }

    /// Outward unit normal at a nearest point.
    pub(super) fn normal(&self, foot: &NearestPoint<D>) -> Option<Vector<D>> {
        self.normals.at(&self.facets, foot.facet, foot.local).normalized()
    }

    /// The nearest point of the solid with the least signed distance.
    pub(super) fn foot(&self, x: Vector<D>) -> Option<NearestPoint<D>> {
        self.foot_on_some(x, |_| true)
    }

    /// The same of the solids that are bonded with one another, of which this is the first.
    pub(super) fn foot_on_body(&self, body: usize, x: Vector<D>) -> Option<NearestPoint<D>> {
        self.foot_on_some(x, |solid| self.body(solid) == body)
    }

    fn foot_on_some(&self, x: Vector<D>, counts: impl Fn(usize) -> bool) -> Option<NearestPoint<D>> {
        if !x.is_finite() {
            return None;
        }
        let mut best: Option<NearestPoint<D>> = None;
        for (s, solid) in self.solids.iter().enumerate().filter(|(s, _)| counts(*s)) {
            let may_be_nearer = |best: &NearestPoint<D>| {
                let gap = solid.gap_squared(x);
                gap == 0.0 || best.distance > 0.0 && gap < best.distance.powi(2)
            };
            if best.as_ref().is_none_or(may_be_nearer) {
                let foot = self.foot_on(s, x);
                best = best.into_iter().chain(foot).reduce(|a, b| if b.distance < a.distance { b } else { a });
            }
        }
        best
    }

    /// The nearest point of a solid's surface.
    fn foot_on(&self, solid: usize, x: Vector<D>) -> Option<NearestPoint<D>> {
        let mut best: Option<(u32, facet::Projection)> = None;
        for (entry, gap) in self.solids[solid].boxes.nearest_neighbor_iter_with_distance_2(x.0) {
            if best.is_some_and(|(_, best)| gap > best.squared) {
                break;
            }
            let limit = best.map_or(f64::INFINITY, |(_, best)| best.squared);
            let Some(next) = self.facets[entry.data as usize].nearest(x, limit) else { continue };
            let is_nearer = |(facet, best): (u32, facet::Projection)| {
                next.squared < best.squared || next.squared == best.squared && entry.data < facet
            };
            if best.is_none_or(is_nearer) {
                best = Some((entry.data, next));
            }
        }
        let (facet, projection) = best?;
        let local = projection.local;
        let position = self.facets[facet as usize].position(local);
        Some(NearestPoint { solid, facet, local, position, distance: self.signed(x, facet, local, position) })
    }

    fn signed(&self, x: Vector<D>, facet: u32, local: [f64; 2], position: Vector<D>) -> f64 {
        /// Sine of the angle between the way to the surface and the tangent plane, below which it doesn't tell
        /// the side.
        const UNCLEAR: f64 = 1e-8;
        let away = x - position;
        let distance = away.norm();
        if distance <= ROUND_OFF * self.facets[facet as usize].size() {
            return 0.0;
        }
        let normal = self.normals.at(&self.facets, facet, local).normalized().unwrap_or_default();
        let side = away.dot(normal);
        let outside = if side.abs() > UNCLEAR * distance { side > 0.0 } else { self.locate_inside(x).is_none() };
        if outside { distance } else { -distance }
    }
}

impl<const D: usize> SolidFacets<D> {
    fn new(first: u32, facets: &[SurfaceFacet<D>], is_hollow: bool) -> Self {
        let corner = |side: usize, pick: fn(f64, f64) -> f64, start: f64| {
            let corners = facets.iter().map(|facet| facet.bounds[side]);
            corners.fold(Vector::splat(start), |a, b| Vector::from_fn(|i| pick(a[i], b[i])))
        };
        let boxes = boxes(first, facets.iter().map(|facet| facet.bounds));
        let [lower, upper] = [corner(0, f64::min, f64::INFINITY), corner(1, f64::max, f64::NEG_INFINITY)];
        Self { first, boxes, lower, upper, is_hollow }
    }

    /// Square of the distance from the box around it [m²].
    fn gap_squared(&self, x: Vector<D>) -> f64 {
        Vector::<D>::from_fn(|i| (self.lower[i] - x[i]).max(x[i] - self.upper[i]).max(0.0)).norm_squared()
    }
}

/// A tree of boxes, numbered from `first`; those that are not finite are left out.
fn boxes<const D: usize>(first: u32, corners: impl Iterator<Item = [Vector<D>; 2]>) -> Boxes<D> {
    let finite = (first..).zip(corners).filter(|(_, [lower, upper])| lower.is_finite() && upper.is_finite());
    let entry =
        |(n, [lower, upper]): (u32, [Vector<D>; 2])| GeomWithData::new(Rectangle::from_corners(lower.0, upper.0), n);
    RTree::bulk_load(finite.map(entry).collect())
}

/// Shape functions of nodes that are not zero.
fn weights(nodes: &[u32], local: &[f64]) -> NodeWeights {
    nodes.iter().copied().zip(shape_functions(local)).filter(|(_, weight)| *weight != 0.0).collect()
}
