//! The unknowns that the boundary, supports and immersed solids prescribe in a step.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::boundary::{Boundary, Constraints};
use crate::pfem2::particle_solids::solids::ParticleSolids;
use crate::pfem2::solid::coupling::immersed::Immersed;

/// Prescribed unknowns of the nodes, with their values in the last step.
#[derive(Debug)]
pub struct PrescribedUnknowns<const D: usize, const N: usize> {
    /// All of them.
    pub constraints: Constraints<D, N>,
    /// Those of the boundary alone: bits as in [`Constraints::mask`].
    pub boundary_mask: Vec<u8>,
}

impl<const D: usize, const N: usize> PrescribedUnknowns<D, N> {
    /// Those of the boundary of a mesh with so many nodes.
    pub fn new(boundary: &Boundary<D>, nodes: usize) -> Self {
        let constraints = boundary.constraints(nodes);
        Self { boundary_mask: constraints.mask.clone(), constraints }
    }

    /// Takes the unknowns that solids leave to the fluid, and the values at time `t` [s].
    pub(super) fn update(
        &mut self,
        mesh: &Mesh<D, N>,
        t: f64,
        boundary: &Boundary<D>,
        immersed: Option<&Immersed<D, N>>,
        particle_solids: Option<&ParticleSolids<D, N>>,
    ) {
        if let Some(immersed) = immersed {
            immersed.constrain(mesh, &self.boundary_mask, &mut self.constraints);
        }
        boundary.prescribe(mesh, t, &mut self.constraints);
        if let Some(solids) = particle_solids {
            solids.prescribe(mesh, t, &self.boundary_mask, &mut self.constraints);
        }
    }

    /// True for a component of a node that neither the boundary nor a support holds.
    pub fn is_free(&self, node: usize, axis: usize) -> bool {
        self.constraints.mask[node] >> axis & 1 == 0
    }

    /// Unknowns of a node with this velocity [m/s] and pressure [Pa], in its frame, and with what is prescribed.
    pub(super) fn unknowns(&self, node: usize, velocity: Vector<D>, pressure: f64) -> [f64; N] {
        let Constraints { mask, value, .. } = &self.constraints;
        let mut x = [pressure; N];
        x[..D].copy_from_slice(&self.constraints.into_frame(node, velocity).0);
        (0..N).filter(|r| mask[node] >> r & 1 == 1).for_each(|r| x[r] = value[node][r]);
        x
    }
}
