//! Particles at solids (theory J.5).
//!
//! Particles move along the streamlines of the mesh, whose nodes inside a solid have its velocity: they follow its
//! surface up to the error of a step. One that is inside of it at the end of the step leaves; reseeding fills what is
//! empty.

use super::{GONE, Particles};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::solid::coupling::immersed::Immersed;
use crate::pfem2::solid::cut::ElementState;

impl<const D: usize> Particles<D> {
    /// Takes out the particles inside solids.
    pub fn leave_solids<const N: usize>(&mut self, mesh: &Mesh<D, N>, immersed: &Immersed<D, N>) {
        let Self { position, element, .. } = self;
        parallel::change(element, parallel::CHUNK, |p, element| {
            let e = *element as usize;
            if *element == GONE || immersed.cut.state[e] == ElementState::Fluid {
                return;
            }
            if !immersed.is_fluid(mesh, e, &mesh.shape_functions(e, position[p])) {
                *element = GONE;
            }
        });
    }
}
