//! The solids of a structure one by one, for outputs and sums.

use super::immersed::Immersed;
use super::mesh::{SolidMesh, element_nodes};
use super::structure::{Prediction, Structure};
use crate::math::{Signal, Vector};
use crate::pfem2::equations::system::TimeStep;
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

impl<const D: usize> SolidBody<'_, D> {
    /// Places of its nodes [m].
    pub fn positions(&self) -> Vec<Vector<D>> {
        self.mesh.nodes.iter().zip(self.displacement).map(|(x, u)| *x + *u).collect()
    }
}

/// Quadrilaterals that show the elements of a mesh in 2D, four to each, and its surface in 3D, four to each facet.
pub fn quadrilaterals<const D: usize>(mesh: &SolidMesh<D>) -> Vec<[u32; 4]> {
    let four =
        |nodes: &[u32]| [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]].map(|quad| quad.map(|a| nodes[a]));
    match element_nodes::<D>() {
        9 => mesh.elements.iter().flat_map(|nodes| four(nodes)).collect(),
        _ => mesh.facets.iter().flat_map(|facet| four(&facet.nodes)).collect(),
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
    pub(super) fn solid_of(&self, node: usize) -> usize {
        self.meshes().iter().rposition(|&(_, first)| first as usize <= node).unwrap_or(0)
    }

    /// Sums over the nodes of each solid.
    pub fn sums(&self, nodal: &[Vector<D>]) -> Vec<Vector<D>> {
        (0..self.setups().len()).map(|solid| nodal[self.nodes_of(solid)].iter().copied().sum()).collect()
    }

    /// Powers at the end of a step [W]: of gravity, and of supports, contacts and loads. These give what the equations lack of the
    /// `nodal` forces of the fluid [N].
    pub(in crate::pfem2) fn powers<const N: usize>(
        &self,
        step: TimeStep,
        prediction: &Prediction<D>,
        immersed: &Immersed<D, N>,
        nodal: &[Vector<D>],
        gravity: &[Signal; D],
    ) -> [f64; 2] {
        let Some(equations) = &immersed.equations else { return [0.0; 2] };
        let at = |x: Vector<D>| Vector::from_fn(|i| gravity[i].value(x.to3(), step.end()));
        let forces = |gravity: &dyn Fn(Vector<D>) -> Vector<D>| {
            self.external_forces(step.end(), &prediction.displacement, gravity)
        };
        let (loads, all) = (forces(&|_| Vector::ZERO), forces(&at));
        let missing = equations.missing(&immersed.velocity);
        let velocity = |a: usize| Vector::from_fn(|axis| immersed.velocity[a * D + axis]);
        let way = self.way(prediction, |a| prediction.displacement_hat[a] + velocity(a) * step.delta());
        let followed = self.pressure_changes(step.end(), prediction, &way);
        let supports = |k: usize| missing[k] - nodal[k / D][k % D] + loads[k] + followed[k / D][k % D];
        let power =
            |force: &dyn Fn(usize) -> f64| (0..loads.len()).map(|k| force(k) * immersed.velocity[k]).sum::<f64>();
        let inertia = self.rigid_power(step.delta(), prediction, &immersed.independent);
        [power(&|k| all[k] - loads[k]), power(&supports) + inertia]
    }
}
