//! Points of facets for integrals over the surface.

use super::{NearestPoint, NodeWeights, SolidSurface, weights};
use crate::math::Vector;

/// A point of a facet.
pub(in crate::pfem2::solid) struct FacetPoint<const D: usize> {
    /// [m].
    pub position: Vector<D>,
    /// n dA [m²], away from the solid.
    pub area: Vector<D>,
    /// Coordinates of the point, in −1..=1.
    pub local: [f64; 2],
    /// Weight of the point, 2 per axis in sum.
    pub quadrature_weight: f64,
    /// Shape functions of the global nodes.
    pub weights: NodeWeights,
}

impl<const D: usize> SolidSurface<D> {
    /// Positions of the nodes of a facet [m], the middle one first.
    pub(in crate::pfem2::solid) fn places(&self, facet: u32) -> impl Iterator<Item = Vector<D>> {
        let nodes = &self.facets[facet as usize].nodes;
        let middle = nodes[nodes.len() / 2];
        std::iter::once(middle).chain(nodes.iter().copied()).map(|node| self.positions[node as usize])
    }

    /// Global nodes of a facet.
    pub(in crate::pfem2::solid) fn nodes_of(&self, facet: u32) -> &[u32] {
        &self.facets[facet as usize].nodes
    }

    /// Calls `visit` with points of a facet: three Gauss points per axis between each two of these ascending
    /// coordinates, −1 and 1 among them.
    pub(in crate::pfem2::solid) fn visit_points(
        &self,
        facet: u32,
        breaks: &[f64],
        mut visit: impl FnMut(FacetPoint<D>),
    ) {
        let own = &self.facets[facet as usize];
        let points: Vec<(f64, f64)> = breaks.windows(2).flat_map(|ends| gauss_between([ends[0], ends[1]])).collect();
        let across = if D == 3 { &points[..] } else { &[(0.0, 1.0)] };
        for &(t, second) in across {
            for &(s, first) in &points {
                let (local, quadrature_weight) = ([s, t], first * second);
                let [along, across] = own.tangents(local).map(|tangent| Vector(tangent.to3()));
                let across = if D == 3 { across } else { Vector::unit(2) };
                visit(FacetPoint {
                    position: own.position(local),
                    area: Vector::from3(along.cross(across).0) * quadrature_weight,
                    local,
                    quadrature_weight,
                    weights: weights(&own.nodes, &local[..D - 1]),
                });
            }
        }
    }

    /// The point of a facet at a foot that stands for an area n dA [m²].
    pub(in crate::pfem2::solid) fn point_at(&self, foot: &NearestPoint<D>, area: Vector<D>) -> FacetPoint<D> {
        let &NearestPoint { facet, local, position, .. } = foot;
        let own = &self.facets[facet as usize];
        let [along, across] = own.tangents(local).map(|tangent| Vector(tangent.to3()));
        let across = if D == 3 { across } else { Vector::unit(2) };
        let per_weight = Vector::<D>::from3(along.cross(across).0);
        let quadrature_weight = area.dot(per_weight) / per_weight.norm_squared().max(f64::MIN_POSITIVE);
        FacetPoint { position, area, local, quadrature_weight, weights: weights(&own.nodes, &local[..D - 1]) }
    }

    /// The facet that is nearest to a place, and the coordinates of its nearest point.
    pub(in crate::pfem2::solid) fn facet_at(&self, x: Vector<D>) -> Option<(u32, [f64; 2])> {
        self.foot(x).map(|foot| (foot.facet, foot.local))
    }
}

/// The three Gauss points of an interval, with their weights.
fn gauss_between([start, end]: [f64; 2]) -> [(f64, f64); 3] {
    let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
    let outer = 0.6f64.sqrt();
    [(-outer, 5.0 / 9.0), (0.0, 8.0 / 9.0), (outer, 5.0 / 9.0)].map(|(x, weight)| (middle + half * x, half * weight))
}
