//! Films between an interface and the surface of a solid that no node outside of the solid sees (theory G.5).
//!
//! φ goes on inside of solids, so that an interface that comes near their surface leaves a film of the other fluid in
//! the elements that they cut. Where all nodes of a film lie inside, their pressures act on it alone, and the thinner
//! it is the larger they must be to move the fluid beside it, which shares its elements: they grew from step to step,
//! and pushed a disc that sank in water to pieces. Such nodes take the side of the fluid around the film; its particles
//! stay, and it shows itself again where a node outside sees them or it is thicker.

use crate::mesh::Mesh;
use crate::pfem2::phases::FluidRegion;
use std::collections::{BTreeMap, BTreeSet};

/// Part of the fluid in the elements of its nodes below which a film is none.
const THIN: f64 = 0.05;

/// Gives the nodes of thin films that no node outside of solids sees the mean φ of the nodes outside around them;
/// returns their number.
pub fn absorb_unresolved_films<const D: usize, const N: usize>(region: &FluidRegion<D, N>, level: &mut [f64]) -> usize {
    let (mut rest, mut absorbed) = (region.covered_beside_fluid(), 0);
    while let Some(first) = rest.pop_first() {
        let negative = level[first] < 0.0;
        let own = |node: usize| (level[node] < 0.0) == negative;
        let (mut piece, mut is_seen) = (vec![first], false);
        let mut next = 0;
        while next < piece.len() {
            for other in neighbours_in_fluid(region, piece[next]).filter(|&other| own(other)) {
                is_seen |= !region.is_covered(other);
                if rest.remove(&other) {
                    piece.push(other);
                }
            }
            next += 1;
        }
        if !is_seen && is_thin(region, &piece, level, negative) {
            absorbed += piece.len();
            let found: BTreeMap<usize, f64> =
                piece.iter().filter_map(|&n| Some((n, around(region, n, level)?))).collect();
            let mean = found.values().sum::<f64>() / found.len().max(1) as f64;
            piece.iter().for_each(|node| level[*node] = found.get(node).copied().unwrap_or(mean));
        }
    }
    absorbed
}

/// True if nodes have hardly any fluid of their side in the elements around them.
fn is_thin<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    piece: &[usize],
    level: &[f64],
    negative: bool,
) -> bool {
    let elements: BTreeSet<usize> = piece.iter().flat_map(|&node| elements_around(region.mesh, node)).collect();
    let [own, all] = elements.into_iter().fold([0.0; 2], |[own, all], e| {
        let volume = region.volume(e);
        let inside = region.negative_volume(e, &region.mesh.elements()[e].map(|node| level[node as usize]));
        [own + if negative { inside } else { volume - inside }, all + volume]
    });
    own < THIN * all
}

/// The mean φ of the nodes outside of solids around a node.
fn around<const D: usize, const N: usize>(region: &FluidRegion<D, N>, node: usize, level: &[f64]) -> Option<f64> {
    let outside = || neighbours_in_fluid(region, node).filter(|&other| !region.is_covered(other));
    let count = outside().count();
    (count > 0).then(|| outside().map(|other| level[other]).sum::<f64>() / count as f64)
}

/// The other nodes of the elements around a node that hold fluid, each once per element.
fn neighbours_in_fluid<'a, const D: usize, const N: usize>(
    region: &'a FluidRegion<'a, D, N>,
    node: usize,
) -> impl Iterator<Item = usize> + 'a {
    let elements = elements_around(region.mesh, node).filter(|&e| region.volume(e) > 0.0);
    elements.flat_map(|e| region.mesh.elements()[e]).map(|other| other as usize).filter(move |&other| other != node)
}

fn elements_around<const D: usize, const N: usize>(mesh: &Mesh<D, N>, node: usize) -> impl Iterator<Item = usize> + '_ {
    mesh.elements_around(node).iter().map(|&e| e as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::pfem2::solid::cut::SolidCut;
    use crate::pfem2::solid::mesh::SolidMesh;
    use crate::pfem2::solid::surface::SolidSurface;

    /// Number of nodes that change sides beside a block whose left side lies a third of an element behind the nodes at
    /// x = 0.4, where the other fluid is a circle of this radius around a place inside of the block, and the volume of
    /// that fluid before and afterwards.
    fn absorbed(radius: f64) -> (usize, [f64; 2]) {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [10; 2]).unwrap();
        let block = SolidMesh::block(Vector([0.434, 0.21]), Vector([0.83, 0.83]), [2; 2]).unwrap();
        let cut = SolidCut::new(&mesh, &SolidSurface::new(&[(&block, 0)], &block.nodes), &[]);
        let region = FluidRegion::new(&mesh, Some(&cut));
        let mut level: Vec<f64> = mesh.nodes().iter().map(|x| (*x - Vector([0.55, 0.5])).norm() - radius).collect();
        let volume = |level: &[f64]| -> f64 {
            let of = |e: usize| region.negative_volume(e, &mesh.elements()[e].map(|node| level[node as usize]));
            (0..mesh.elements().len()).map(of).sum()
        };
        let before = volume(&level);
        let count = absorb_unresolved_films(&region, &mut level);
        (count, [before, volume(&level)])
    }

    #[test]
    fn a_thin_film_that_no_node_outside_sees_goes_and_others_stay() {
        // From x = 0.433 on: nodes at (0.5, 0.4), (0.5, 0.5) and (0.5, 0.6).
        let (count, [before, after]) = absorbed(0.117);
        assert_eq!((count, after), (3, 0.0));
        assert!(before > 0.0, "{before}");
        // Thicker, or with the node at (0.4, 0.5).
        for radius in [0.135, 0.17] {
            let (count, [before, after]) = absorbed(radius);
            assert_eq!((count, before), (0, after));
            assert!(before > 0.0, "{before}");
        }
    }
}
