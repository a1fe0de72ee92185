//! The rate of strain of an element (theory K.1).

use crate::math::{SymTensor, Tensor, Vector};
use crate::mesh::Mesh;

/// Velocity gradient of an element, L_rs = Σ_i v_i,r g_i,s [1/s].
pub fn gradient<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    element: usize,
    velocity: &[Vector<D>],
) -> Tensor<D> {
    let mut sum = Tensor::ZERO;
    for (g, &node) in mesh.simplex(element).gradient.iter().zip(&mesh.elements()[element]) {
        sum += Tensor::outer(velocity[node as usize], *g);
    }
    sum
}

/// d' of an element, with d_zz = 0 in two dimensions [1/s].
pub fn deviatoric_rate<const D: usize>(gradient: &Tensor<D>) -> SymTensor {
    gradient.embed(0.0).symmetric().deviator()
}
