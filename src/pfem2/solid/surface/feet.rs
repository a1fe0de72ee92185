//! The points of the facets around a place that are nearest to it, facet by facet: where solids may meet (theory J.9).

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

    /// Outward unit normal at a foot, the mean of the facets that meet there.
    pub(in crate::pfem2::solid) fn normal_at(&self, foot: &FacetFoot<D>) -> Vector<D> {
        self.normals.at(&self.facets, foot.facet, foot.local).normalized().unwrap_or_default()
    }

    /// Outward unit normal of the facet of a foot there, that of the facet alone also at edges.
    pub(in crate::pfem2::solid) fn facet_normal_at(&self, foot: &FacetFoot<D>) -> Vector<D> {
        self.facets[foot.facet as usize].normal(foot.local)
    }

    /// Shape functions of the global nodes at a foot.
    pub(in crate::pfem2::solid) fn weights_at(&self, foot: &FacetFoot<D>) -> NodeWeights {
        weights(&self.facets[foot.facet as usize].nodes, &foot.local[..D - 1])
    }

    /// True if a node belongs to the facet of a foot.
    pub(in crate::pfem2::solid) fn holds(&self, foot: &FacetFoot<D>, node: u32) -> bool {
        self.facets[foot.facet as usize].nodes.contains(&node)
    }

    /// True for nodes at edges and corners of the surface, where the normals of facets differ by more than some 50°.
    pub(in crate::pfem2::solid) fn sharp_nodes(&self) -> Vec<bool> {
        /// Length of the mean of unit normals below which they differ.
        const DIFFERENT: f64 = 0.9;
        let mean = |own: &Vec<Vector<D>>| own.iter().copied().sum::<Vector<D>>() / own.len().max(1) as f64;
        self.normals_at_nodes().iter().map(|own| mean(own).norm() < DIFFERENT).collect()
    }

    /// Unit normals of all facets that meet at each node; none inside.
    pub(in crate::pfem2::solid) fn normals_at_nodes(&self) -> Vec<Vec<Vector<D>>> {
        let mut normals = vec![Vec::new(); self.positions.len()];
        for facet in &self.facets {
            for (a, &node) in facet.nodes.iter().enumerate() {
                let along = [a % 3, a / 3].map(|k| k as f64 - 1.0);
                normals[node as usize].push(facet.normal(if D == 3 { along } else { [along[0], 0.0] }));
            }
        }
        normals
    }

    /// The point of a facet that is farthest against a unit vector, where the facet is round and it lies clearly beyond
    /// all nodes; and the shape functions of the global nodes there.
    pub(in crate::pfem2::solid) fn lowest(&self, facet: u32, up: Vector<D>) -> Option<(Vector<D>, NodeWeights)> {
        /// Beyond the nodes by less than this part of the facet's size, these tell enough.
        const CLEAR: f64 = 1e-6;
        /// Distance of the place that sees the facet from below, over its size.
        const DISTANCE_BELOW: f64 = 1e3;
        let own = &self.facets[facet as usize];
        let below = self.positions[own.nodes[0] as usize] - up * (DISTANCE_BELOW * own.size());
        let local = own.nearest(below, f64::INFINITY)?.local;
        let x = own.position(local);
        let nodes = own.nodes.iter().map(|&node| self.positions[node as usize].dot(up));
        let beyond = nodes.fold(f64::INFINITY, f64::min) - x.dot(up);
        (beyond > CLEAR * own.size()).then(|| (x, weights(&own.nodes, &local[..D - 1])))
    }

    /// The first facet of a solid among those of all.
    pub(in crate::pfem2::solid) fn first_facet(&self, solid: usize) -> u32 {
        self.solids[solid].first
    }

    /// Number of facets of all solids.
    pub(in crate::pfem2::solid) fn facet_count(&self) -> usize {
        self.facets.len()
    }

    /// Length of the diagonal of a facet's box [m], and its middle node.
    pub(in crate::pfem2::solid) fn size_and_middle(&self, facet: u32) -> (f64, u32) {
        let own = &self.facets[facet as usize];
        (own.size(), own.nodes[own.nodes.len() / 2])
    }

    /// The nearest point of a solid's surface, and the size of its facet [m].
    pub(in crate::pfem2::solid) fn foot_and_size(&self, solid: usize, x: Vector<D>) -> Option<(NearestPoint<D>, f64)> {
        let foot = self.foot_on(solid, x)?;
        Some((foot, self.facets[foot.facet as usize].size()))
    }
}
