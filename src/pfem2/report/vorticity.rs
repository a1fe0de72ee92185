//! Vorticity at the nodes, for outputs.
//!
//! \\[ \omega_i = \frac{\sum_e V_e\,(\nabla\times v)_e}{\sum_e V_e} \\]
//!
//! over the elements e around node i: the velocity is linear in each of them.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;

/// Elements or nodes per piece of a parallel loop.
const BATCH: usize = 256;

/// Curl of a velocity that is linear in each element, averaged at the nodes by volume [1/s]; in 2D along z.
pub fn at_nodes<const D: usize, const N: usize>(mesh: &Mesh<D, N>, velocity: &[Vector<D>]) -> Vec<Vector<3>> {
    let weighted_curl = |element: usize| {
        let simplex = mesh.simplex(element);
        let nodes = mesh.elements()[element].iter().zip(&simplex.gradient);
        let curls = nodes.map(|(&node, slope)| Vector(slope.to3()).cross(Vector(velocity[node as usize].to3())));
        (curls.sum::<Vector<3>>() * simplex.volume, simplex.volume)
    };
    let curls = parallel::collect(mesh.elements().len(), BATCH, weighted_curl);
    parallel::collect(velocity.len(), BATCH, |node| {
        let around = mesh.elements_around(node).iter().map(|&element| curls[element as usize]);
        let (sum, volume) = around.fold((Vector::ZERO, 0.0), |(sum, all), (curl, volume)| (sum + curl, all + volume));
        // Nodes of a file that no element uses have no volume.
        if volume > 0.0 { sum / volume } else { Vector::ZERO }
    })
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
