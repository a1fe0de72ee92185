//! Isolated nodes: all neighbours are on the other side of the interface (theory G.5).
//!
//! A node whose neighbours all lie on the other side stands for a drop smaller than its elements. No element ties its
//! pressure to that of another node (beyond the interface every element has a pressure of its own), so the stabilised
//! continuity equation says nothing about it, and the system is singular up to round-off. Such a node takes the side of
//! its neighbours; the particles of the drop stay, and show themselves again where two nodes see them.

use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::phases::Phases;
use crate::pfem2::phases::phase_list::PhaseList;

/// Part of the mean φ of its neighbours that a node takes when it changes sides: small enough not to move the
/// interface, large enough that a small shift of φ doesn't flip the node again.
const TAKEN: f64 = 1e-3;

/// Gives isolated nodes the side of their neighbours; returns their number.
pub fn absorb_isolated_nodes<const D: usize, const N: usize>(mesh: &Mesh<D, N>, level: &mut [f64]) -> usize {
    let absorbed = |node: usize| {
        let own = level[node] < 0.0;
        let others = || neighbours(mesh, node);
        let alone = others().all(|other| (level[other] < 0.0) != own);
        let mean = || others().map(|other| level[other]).sum::<f64>() / others().count() as f64;
        alone.then(|| (node, TAKEN * mean()))
    };
    let isolated: Vec<(usize, f64)> = parallel::collect_some(level.len(), 256, absorbed);
    isolated.iter().for_each(|&(node, phi)| level[node] = phi);
    isolated.len()
}

/// The same for three and more fluids, where the largest fraction makes the fluid of a node: an isolated node exchanges
/// it with that of the fluid of its neighbours, of several the one that occurs most. Returns their number.
pub fn absorb_isolated_fluids<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    list: &PhaseList,
    fraction: &mut [Vec<f64>],
) -> usize {
    let phases = Phases { list, fraction, level: &[] };
    let fluid: Vec<usize> = parallel::collect(mesh.nodes().len(), parallel::CHUNK, |node| phases.at(node));
    let absorbed = |node: usize| {
        let others = || neighbours(mesh, node);
        let alone = others().all(|other| fluid[other] != fluid[node]);
        let votes = |candidate: usize| others().filter(|&other| fluid[other] == candidate).count();
        alone.then(|| (0..list.count()).max_by_key(|&candidate| votes(candidate)).map(|winner| (node, winner)))?
    };
    let isolated: Vec<(usize, usize)> = parallel::collect_some(fluid.len(), 256, absorbed);
    for &(node, winner) in &isolated {
        let (own, other) = (fraction[fluid[node]][node], fraction[winner][node]);
        (fraction[fluid[node]][node], fraction[winner][node]) = (other, own);
    }
    isolated.len()
}

/// The other nodes of the elements around a node, each once per element.
fn neighbours<const D: usize, const N: usize>(mesh: &Mesh<D, N>, node: usize) -> impl Iterator<Item = usize> + '_ {
    let around = mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]);
    around.map(|other| other as usize).filter(move |&other| other != node)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;

    #[test]
    fn an_isolated_node_joins_its_neighbours_and_a_pair_stays() {
        let mesh = Mesh::<2, 3>::block(Vector([0.0; 2]), Vector([8.0; 2]), [8, 8]).unwrap();
        let at = |x: f64, y: f64| mesh.nodes().iter().position(|n| (*n - Vector([x, y])).norm() < 1e-9).unwrap();
        for sign in [1.0, -1.0] {
            let mut level = vec![sign; mesh.nodes().len()];
            let (isolated, pair) = (at(2.0, 2.0), [at(5.0, 5.0), at(6.0, 5.0)]);
            [isolated, pair[0], pair[1]].into_iter().for_each(|node| level[node] = -0.4 * sign);
            assert_eq!(absorb_isolated_nodes(&mesh, &mut level), 1);
            assert!((level[isolated] < 0.0) == (sign < 0.0) && level[isolated].abs() <= 1e-3);
            assert_eq!(pair.map(|node| level[node]), [-0.4 * sign; 2]);
        }
    }

    #[test]
    fn an_isolated_node_among_several_fluids_takes_that_of_most_neighbours() {
        let mesh = Mesh::<2, 3>::block(Vector([0.0; 2]), Vector([8.0; 2]), [8, 8]).unwrap();
        let at = |x: f64, y: f64| mesh.nodes().iter().position(|n| (*n - Vector([x, y])).norm() < 1e-9).unwrap();
        let density = [3.0, 2.0, 1.0];
        let mut fraction = vec![vec![0.1; 81], vec![0.2; 81], vec![0.7; 81]];
        let (isolated, pair) = (at(2.0, 2.0), [at(5.0, 5.0), at(6.0, 5.0)]);
        for node in [isolated, pair[0], pair[1]] {
            (fraction[0][node], fraction[2][node]) = (0.7, 0.1);
        }
        absorb_isolated_fluids(&mesh, &PhaseList::fluids(&density), &mut fraction);
        assert_eq!([0, 1, 2].map(|fluid: usize| fraction[fluid][isolated]), [0.1, 0.2, 0.7]);
        assert_eq!(pair.map(|node| fraction[0][node]), [0.7; 2]);
    }
}
