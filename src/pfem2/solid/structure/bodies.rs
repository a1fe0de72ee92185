//! The solids of a structure one by one, for outputs and sums.

use super::{Prediction, Structure};
use crate::math::{Signal, Vector};
use crate::parallel;
use crate::pfem2::ThetaStep;
use crate::pfem2::solid::equations::SolidEquations;
use crate::pfem2::solid::mesh::{SolidMesh, element_nodes};
use std::ops::Range;

/// A solid of a structure.
pub struct SolidBody<'a, const D: usize> {
    /// Name.
    pub name: &'a str,
    /// Mesh.
    pub mesh: &'a SolidMesh<D>,
    /// Displacement of its nodes [m].
    pub displacement: &'a [Vector<D>],
    /// Velocity of its nodes [m/s].
    pub velocity: &'a [Vector<D>],
}

/// Powers on solids [W].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::pfem2) struct SolidPowers {
    /// Power of gravity.
    pub gravity: f64,
    /// Power of supports, contacts and loads, less that of damping.
    pub supports: f64,
}

/// The solution of a step.
pub(in crate::pfem2) struct SolvedStep<'a, const D: usize> {
    /// Equations of the solids.
    pub equations: &'a SolidEquations,
    /// Velocities of all nodes, axis by axis [m/s].
    pub velocity: &'a [f64],
    /// The independent ones of these.
    pub independent: &'a [f64],
    /// Forces of the fluid on nodes [N].
    pub fluid: &'a [Vector<D>],
}

impl<const D: usize> SolidBody<'_, D> {
    /// Places of its nodes [m].
    pub fn positions(&self) -> Vec<Vector<D>> {
        self.mesh.nodes.iter().zip(self.displacement).map(|(x, u)| *x + *u).collect()
    }
}

/// Cells with nodes at their corners alone, which divide the elements of a solid or its facets.
#[derive(Debug, Clone)]
pub struct LinearCells {
    nodes: Vec<u32>,
    corners: usize,
}

impl LinearCells {
    /// Four quadrilaterals to each element in 2D, eight hexahedra in 3D; of a solid that is a surface without elements
    /// four quadrilaterals to each facet.
    pub fn new<const D: usize>(mesh: &SolidMesh<D>) -> Self {
        const QUADRILATERALS: [[usize; 4]; 4] = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]];
        let four = |nodes: &[u32]| QUADRILATERALS.as_flattened().iter().map(|&a| nodes[a]).collect::<Vec<_>>();
        let eight = |nodes: &[u32]| {
            let hexahedra = QUADRILATERALS.iter().flat_map(|lower| [0, 9].map(|layer| (lower, layer)));
            let corners = hexahedra.flat_map(|(lower, layer)| {
                [0, 9].into_iter().flat_map(move |above| lower.iter().map(move |a| a + layer + above))
            });
            corners.map(|a| nodes[a]).collect::<Vec<_>>()
        };
        match element_nodes::<D>() {
            9 => Self { nodes: mesh.elements.iter().flat_map(|nodes| four(nodes)).collect(), corners: 4 },
            _ if mesh.elements.is_empty() => {
                Self { nodes: mesh.facets.iter().flat_map(|facet| four(&facet.nodes)).collect(), corners: 4 }
            }
            _ => Self { nodes: mesh.elements.iter().flat_map(|nodes| eight(nodes)).collect(), corners: 8 },
        }
    }

    /// Nodes of each: four around a quadrilateral, or those of the lower side of a hexahedron and of the upper one.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.nodes.chunks_exact(self.corners)
    }

    /// True of hexahedra.
    pub fn are_volumes(&self) -> bool {
        self.corners == 8
    }
}

impl<const D: usize> Structure<D> {
    /// The solids.
    pub fn bodies(&self) -> impl Iterator<Item = SolidBody<'_, D>> {
        self.setups().iter().enumerate().map(|(solid, setup)| {
            let own = self.nodes_of(solid);
            SolidBody {
                name: &setup.name,
                mesh: &setup.mesh,
                displacement: &self.state.displacement[own.clone()],
                velocity: &self.state.velocity[own],
            }
        })
    }

    /// The nodes of a solid among those of all.
    pub(in crate::pfem2) fn nodes_of(&self, solid: usize) -> Range<usize> {
        let (mesh, first) = self.meshes()[solid];
        first as usize..first as usize + mesh.nodes.len()
    }

    /// The solid of a node.
    pub(in crate::pfem2::solid) fn solid_of(&self, node: usize) -> usize {
        self.meshes().iter().rposition(|&(_, first)| first as usize <= node).unwrap_or(0)
    }

    /// Sums over the nodes of each solid.
    pub fn sums(&self, nodal: &[Vector<D>]) -> Vec<Vector<D>> {
        let of_solid = |own: &[Vector<D>]| parallel::sum(own.len(), |node| own[node]);
        (0..self.setups().len()).map(|solid| of_solid(&nodal[self.nodes_of(solid)])).collect()
    }

    /// Powers at the end of a step. Supports, contacts and loads give what the equations lack of the forces
    /// of the fluid.
    pub(in crate::pfem2) fn powers(
        &self,
        step: ThetaStep,
        prediction: &Prediction<D>,
        solved: &SolvedStep<'_, D>,
        gravity: &[Signal; D],
    ) -> SolidPowers {
        let &SolvedStep { equations, velocity, independent, fluid } = solved;
        let at = |x: Vector<D>| Vector::from_fn(|i| gravity[i].value(x.to3(), step.end()));
        let forces = |gravity: &dyn Fn(Vector<D>) -> Vector<D>| {
            self.external_forces(step.end(), &prediction.displacement, gravity)
        };
        let (loads, all) = (forces(&|_| Vector::ZERO), forces(&at));
        let missing = equations.missing(velocity);
        let of_node = |a: usize| Vector::from_fn(|axis| velocity[a * D + axis]);
        let way =
            self.increment_from_prediction(prediction, |a| prediction.displacement_hat[a] + of_node(a) * step.delta());
        let followed = self.pressure_changes(step.end(), prediction, &way);
        let supports = |k: usize| missing[k] - fluid[k / D][k % D] + loads[k] + followed[k / D][k % D];
        let power = |force: &(dyn Fn(usize) -> f64 + Sync)| parallel::sum(loads.len(), |k| force(k) * velocity[k]);
        let inertia = self.rigid_power(step.delta(), prediction, independent);
        SolidPowers { gravity: power(&|k| all[k] - loads[k]), supports: power(&supports) + inertia }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Their volumes are positive, and fill the block.
    #[test]
    fn hexahedra_of_a_block_fill_it() {
        let mesh = SolidMesh::<3>::block(Vector([1.0, 2.0, -1.0]), Vector([4.0, 3.0, 1.0]), [3, 2, 1]).unwrap();
        let cells = LinearCells::new(&mesh);
        let volume = |nodes: &[u32]| {
            let side = |k: usize| mesh.nodes[nodes[k] as usize] - mesh.nodes[nodes[0] as usize];
            side(1).cross(side(3)).dot(side(4))
        };
        let volumes: Vec<f64> = cells.iter().map(volume).collect();
        assert!(cells.are_volumes() && volumes.len() == 48 && volumes.iter().all(|v| *v > 0.0), "{volumes:?}");
        assert!((volumes.iter().sum::<f64>() - 6.0).abs() < 1e-13);
    }
}
