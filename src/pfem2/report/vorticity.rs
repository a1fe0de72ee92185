//! Vorticity at the nodes, for outputs.
//!
//! \\[ \omega_i = \frac{\sum_e V_e\,(\nabla\times v)_e}{\sum_e V_e} \\]
//!
//! over the elements e around node i: the velocity is linear in each of them.

use crate::math::Vector;
use crate::mesh::Mesh;

/// Curl of a velocity that is linear in each element, averaged at the nodes by volume [1/s]; in 2D along z.
pub fn at_nodes<const D: usize, const N: usize>(mesh: &Mesh<D, N>, velocity: &[Vector<D>]) -> Vec<Vector<3>> {
    let mut sums = vec![(Vector::ZERO, 0.0); velocity.len()];
    for (element, nodes) in mesh.elements().iter().enumerate() {
        let simplex = mesh.simplex(element);
        let curls = nodes
            .iter()
            .zip(&simplex.gradient)
            .map(|(&node, gradient)| Vector(gradient.to3()).cross(Vector(velocity[node as usize].to3())));
        let curl = curls.sum::<Vector<3>>();
        for &node in nodes {
            let (sum, volume) = &mut sums[node as usize];
            *sum += curl * simplex.volume;
            *volume += simplex.volume;
        }
    }
    // Nodes of a file that no element uses have no volume.
    sums.into_iter().map(|(sum, volume)| if volume > 0.0 { sum / volume } else { Vector::ZERO }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fluid_that_turns_has_twice_its_spin() {
        let spin = Vector([0.3, -0.7, 1.1]);
        let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0, 2.0, 0.5]), [3, 2, 2]).unwrap();
        let velocity: Vec<_> = mesh.nodes().iter().map(|&x| Vector([5.0, 0.0, 1.0]) + spin.cross(x)).collect();
        for found in at_nodes(&mesh, &velocity) {
            assert!((found - spin * 2.0).norm() < 1e-13, "{found:?}");
        }
    }

    #[test]
    fn a_plane_shear_flow_has_minus_its_rate() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 2.0]), [4, 3]).unwrap();
        let velocity: Vec<_> = mesh.nodes().iter().map(|x| Vector([2.5 * x[1], 0.0])).collect();
        for found in at_nodes(&mesh, &velocity) {
            assert!((found - Vector([0.0, 0.0, -2.5])).norm() < 1e-13, "{found:?}");
        }
    }
}
