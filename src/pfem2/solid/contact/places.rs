//! Places of the nodes of solids in a step, and the parts of surfaces that may touch something (theory J.8).

use crate::math::Vector;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::support::facet_node_areas;
use crate::pfem2::solid::surface::SolidSurface;

/// Places of all nodes in a step [m].
pub(in crate::pfem2::solid) struct ContactPlaces<'a, const D: usize> {
    /// Places at its start.
    pub start: &'a [Vector<D>],
    /// Places as predicted for its end.
    pub predicted: &'a [Vector<D>],
    /// The surface at the predicted places.
    pub surface: &'a SolidSurface<D>,
}

/// A node on the surface of a solid.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeArea {
    /// Node of the solid's mesh.
    pub node: u32,
    /// A_a [m²].
    pub area: f64,
    /// Size of the largest facet there [m].
    pub size: f64,
}

/// Nodes on the surface of a solid, ascending.
pub(super) fn node_areas<const D: usize>(setup: &SolidSetup<D>) -> Vec<NodeArea> {
    let mut areas = vec![(0.0, 0.0f64); setup.mesh.nodes.len()];
    for facet in 0..setup.mesh.facets.len() {
        let of_facet = facet_node_areas(&setup.mesh, facet);
        let size = of_facet.iter().map(|(_, area)| area).sum::<f64>().powf(1.0 / (D - 1) as f64);
        for (node, area) in of_facet {
            let own = &mut areas[node as usize];
            *own = (own.0 + area, own.1.max(size));
        }
    }
    let on_surface = (0..).zip(areas).filter(|(_, (area, _))| *area > 0.0);
    on_surface.map(|(node, (area, size))| NodeArea { node, area, size }).collect()
}
