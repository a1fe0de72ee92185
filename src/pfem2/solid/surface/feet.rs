//! The points of the facets around a place that are nearest to it, facet by facet: where solids may meet.

use super::{NearestPoint, NodeWeights, SolidSurface, weights};
use crate::math::Vector;
use rstar::AABB;

/// The point of one facet that is nearest to a place.
#[derive(Debug, Clone, Copy)]
pub(in crate::pfem2::solid) struct FacetFoot<const D: usize> {
    facet: u32,
    local: [f64; 2],
    /// Position [m].
    pub position: Vector<D>,
    /// Distance of the place [m].
    pub distance: f64,
}

impl<const D: usize> FacetFoot<D> {
    /// True for a point inside of its facet, not at an edge.
    pub(in crate::pfem2::solid) fn is_inside(&self) -> bool {
        self.local[..D - 1].iter().all(|s| s.abs() < 1.0)
    }
}

impl<const D: usize> SolidSurface<D> {
    /// The nearest points of the facets of a solid within `reach` [m] of `x`, the nearest first.
    pub(in crate::pfem2::solid) fn feet(&self, solid: usize, x: Vector<D>, reach: f64) -> Vec<FacetFoot<D>> {
        let own = &self.solids[solid];
        if !x.is_finite() || own.gap_squared(x) > reach * reach {
            return Vec::new();
        }
        let around = AABB::from_corners((x - Vector::splat(reach)).0, (x + Vector::splat(reach)).0);
        let mut facets: Vec<u32> = own.boxes.locate_in_envelope_intersecting(around).map(|entry| entry.data).collect();
        facets.sort_unstable();
        let foot = |facet: u32| {
            let of = &self.facets[facet as usize];
            let local = of.nearest(x, reach * reach)?.local;
            let position = of.position(local);
            Some(FacetFoot { facet, local, position, distance: (x - position).norm() })
        };
        let mut feet: Vec<_> = facets.into_iter().filter_map(foot).filter(|foot| foot.distance < reach).collect();
        feet.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.facet.cmp(&b.facet)));
        feet
    }

    /// Signed distance of `x` from a foot [m], by the normals of all facets that meet there.
    pub(in crate::pfem2::solid) fn signed_distance(&self, x: Vector<D>, foot: &FacetFoot<D>) -> f64 {
        self.signed(x, foot.facet, foot.local, foot.position)
    }

    /// Outward unit normal at a foot.
    pub(in crate::pfem2::solid) fn normal_at(&self, foot: &FacetFoot<D>) -> Vector<D> {
        self.normals.at(&self.facets, foot.facet, foot.local).normalized().unwrap_or_default()
    }

    /// Shape functions of the global nodes at a foot.
    pub(in crate::pfem2::solid) fn weights_at(&self, foot: &FacetFoot<D>) -> NodeWeights {
        weights(&self.facets[foot.facet as usize].nodes, &foot.local[..D - 1])
    }

    /// True if a node belongs to the facet of a foot.
    pub(in crate::pfem2::solid) fn holds(&self, foot: &FacetFoot<D>, node: u32) -> bool {
        self.facets[foot.facet as usize].nodes.contains(&node)
    }

    /// Unit normals at all nodes of the surface, in the mean over their facets; zero elsewhere.
    pub(in crate::pfem2::solid) fn nodal_normals(&self) -> Vec<Vector<D>> {
        let mut sum = vec![Vector::ZERO; self.positions.len()];
        for facet in &self.facets {
            for (a, &node) in facet.nodes.iter().enumerate() {
                let along = [a % 3, a / 3].map(|k| k as f64 - 1.0);
                sum[node as usize] += facet.normal(if D == 3 { along } else { [along[0], 0.0] });
            }
        }
        sum.into_iter().map(|sum| sum.normalized().unwrap_or_default()).collect()
    }

    /// The nearest point of a solid's surface, and the size of its facet [m].
    pub(in crate::pfem2::solid) fn foot_and_size(&self, solid: usize, x: Vector<D>) -> Option<(NearestPoint<D>, f64)> {
        let foot = self.foot_on(solid, x)?;
        Some((foot, self.facets[foot.facet as usize].size()))
    }
}
