//! Nodes that have one fluid for themselves.
//!
//! A node whose neighbours all lie on the other side stands for a drop smaller than its elements. No element ties its
//! pressure to that of another node (beyond the interface every element has a pressure of its own), so the stabilised
//! continuity equation says nothing about it, and the system is singular up to round-off. Such a node takes the side of
//! its neighbours; the particles of the drop stay, and show themselves again where two nodes see them.

use crate::mesh::Mesh;
use rayon::prelude::*;

/// What a node that changes sides takes of the mean φ of its neighbours: it isn't to change back for a little shift.
const TAKEN: f64 = 1e-3;

/// Gives lone nodes the side of their neighbours; returns how many there were.
pub fn absorb_lone_nodes<const D: usize, const N: usize>(mesh: &Mesh<D, N>, level: &mut [f64]) -> usize {
    let absorbed = |node: usize| {
        let own = level[node] < 0.0;
        let around = mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]);
        let others = || around.clone().map(|other| other as usize).filter(|&other| other != node);
        let alone = others().all(|other| (level[other] < 0.0) != own);
        let mean = || others().map(|other| level[other]).sum::<f64>() / others().count() as f64;
        alone.then(|| (node, TAKEN * mean()))
    };
    let lone: Vec<(usize, f64)> = (0..level.len()).into_par_iter().filter_map(absorbed).collect();
    lone.iter().for_each(|&(node, phi)| level[node] = phi);
    lone.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;

    #[test]
    fn a_node_alone_joins_its_neighbours_and_a_pair_stays() {
        let mesh = Mesh::<2, 3>::block(Vector([0.0; 2]), Vector([8.0; 2]), [8, 8]).unwrap();
        let at = |x: f64, y: f64| mesh.nodes().iter().position(|n| (*n - Vector([x, y])).norm() < 1e-9).unwrap();
        for sign in [1.0, -1.0] {
            let mut level = vec![sign; mesh.nodes().len()];
            let (lone, pair) = (at(2.0, 2.0), [at(5.0, 5.0), at(6.0, 5.0)]);
            [lone, pair[0], pair[1]].into_iter().for_each(|node| level[node] = -0.4 * sign);
            assert_eq!(absorb_lone_nodes(&mesh, &mut level), 1);
            assert!((level[lone] < 0.0) == (sign < 0.0) && level[lone].abs() <= 1e-3);
            assert_eq!(pair.map(|node| level[node]), [-0.4 * sign; 2]);
        }
    }
}
