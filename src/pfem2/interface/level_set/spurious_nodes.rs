//! Spurious changes of side: pieces of a fluid without an origin (theory G.5).
//!
//! A fluid gets to a node from a node beside it, with particles, or through an open boundary. A group of nodes that
//! changes sides without any of these shows only that depths were continued too far; it stays on the side on which it
//! was.

use super::OpenFacet;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::particles::Particles;
use crate::pfem2::phases::FluidRegion;
use std::collections::BTreeSet;

/// Part of φ, with the other sign, that a reverted node keeps: small enough not to move the interface, large enough
/// that a small shift of φ doesn't flip the node again.
const KEPT: f64 = 1e-3;

/// The level set before a step, and all that could bring nodes to its other side.
pub struct Origins<'a, const D: usize> {
    /// φ before the step [m].
    pub before: &'a [f64],
    /// The fluid where φ is negative.
    pub inside: u8,
    /// The particles after the step.
    pub particles: &'a Particles<D>,
    /// Open facets with the level set of their inflow.
    pub open_facets: &'a [OpenFacet<D>],
}

/// Reverts nodes of pieces without an origin to the side on which they were; returns their number. Nodes inside
/// of solids are left as they were continued.
pub fn revert_spurious_nodes<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    origins: &Origins<D>,
    level: &mut [f64],
) -> usize {
    let mesh = region.mesh;
    let changed = |node: usize| (level[node] < 0.0) != (origins.before[node] < 0.0) && !region.is_covered(node);
    let alone = |node: usize| !origins.explain(mesh, node, level[node] < 0.0);
    let of_these = |node: usize| (changed(node) && alone(node)).then_some(node);
    let mut without_origin = BTreeSet::from_iter(parallel::collect_some(level.len(), parallel::CHUNK, of_these));
    if without_origin.is_empty() {
        return 0;
    }
    for opening in origins.open_facets {
        for (node, brought) in mesh.facet_nodes(opening.facet).into_iter().zip(opening.inflow_level) {
            if (brought < 0.0) == (level[node as usize] < 0.0) {
                without_origin.remove(&(node as usize));
            }
        }
    }
    // A piece that reaches a node with an origin has that origin.
    loop {
        let joins = |&node: &usize| {
            let around = mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]);
            let mut same = around.map(|other| other as usize).filter(|&k| (level[k] < 0.0) == (level[node] < 0.0));
            same.any(|other| !without_origin.contains(&other) && !region.is_covered(other))
        };
        let joined: Vec<usize> = without_origin.iter().copied().filter(joins).collect();
        if joined.is_empty() {
            break;
        }
        without_origin.retain(|node| !joined.contains(node));
    }
    without_origin.iter().for_each(|&node| level[node] *= -KEPT);
    without_origin.len()
}

impl<const D: usize> Origins<'_, D> {
    /// True if a node beside this one was on its new side, or a particle of that side is near.
    fn explain<const N: usize>(&self, mesh: &Mesh<D, N>, node: usize, negative: bool) -> bool {
        let own = |fluid: &u8| (*fluid == self.inside) == negative;
        mesh.elements_around(node).iter().any(|&e| {
            let was = |&other: &u32| (self.before[other as usize] < 0.0) == negative;
            mesh.elements()[e as usize].iter().any(was)
                || self.particles.phase[self.particles.of(e as usize)].iter().any(own)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;

    /// Two nodes in the middle of a block of air change sides; `water` is where particles of the other fluid are.
    fn put_back(water: Option<Vector<2>>, top_inflow_level: f64) -> (usize, Vec<f64>) {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(8.0), [8; 2]).unwrap();
        let near = |x: Vector<2>| water.is_some_and(|place| (x - place).norm() < 0.5);
        let particles = Particles::seed(&mesh, 3, |x| Some(u8::from(!near(x))), |_| Vector::ZERO);
        let top =
            |facet: &&crate::mesh::Facet| mesh.facet_nodes(**facet).iter().all(|&i| mesh.nodes()[i as usize][1] == 8.0);
        let open_facets: Vec<OpenFacet<2>> = mesh
            .boundary()
            .iter()
            .filter(top)
            .map(|&facet| OpenFacet { facet, inflow_level: [top_inflow_level; 2] })
            .collect();
        let before = vec![2.0; mesh.nodes().len()];
        let piece = [Vector([4.0, 8.0]), Vector([4.0, 7.0])];
        let mut level: Vec<f64> = mesh
            .nodes()
            .iter()
            .map(|x| if piece.iter().any(|p| (*p - *x).norm() < 0.1) { -0.5 } else { 2.0 })
            .collect();
        let origins = Origins { before: &before, inside: 0, particles: &particles, open_facets: &open_facets };
        (revert_spurious_nodes(&FluidRegion::whole(&mesh), &origins, &mut level), level)
    }

    #[test]
    fn a_piece_without_an_origin_is_reverted() {
        let (count, level) = put_back(None, 1.0);
        assert_eq!(count, 2);
        assert!(level.iter().all(|phi| *phi > 0.0));
    }

    #[test]
    fn a_piece_with_particles_or_from_an_opening_stays() {
        for (water, inflow_level) in [(Some(Vector([4.0, 7.0])), 1.0), (None, -1.0)] {
            let (count, level) = put_back(water, inflow_level);
            assert_eq!((count, level.iter().filter(|phi| **phi < 0.0).count()), (0, 2), "{water:?}");
        }
        // Particles elsewhere are no origin.
        assert_eq!(put_back(Some(Vector([1.0, 1.0])), 1.0).0, 2);
    }
}
