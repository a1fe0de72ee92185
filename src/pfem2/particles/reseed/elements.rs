//! Reseeding by elements, as the source and its program do (theory G.12).
//!
//! ```text
//!                            triangles                            tetrahedra
//! surplus above 8 D          dropped                              dropped
//! before the projection      below D: 3 at (½, ¼, ¼)              4 at (0.4, 0.2, 0.2, 0.2)
//! at the end of the step     below 2 D: 7 at (0.76, 0.12, 0.12),  9 at (0.7, 0.1, 0.1, 0.1),
//!                            ⅓, (0.44, 0.44, 0.12)                ¼, (0.3, 0.3, 0.3, 0.1)
//! ```
//!
//! The former are traced back, as those of `SubCells`. The latter take the new velocity of the mesh; their fluid is
//! that of φ in cut elements, and where all nodes are light, ⌊1.01 n (½ − φ̄/2)⌋ of them are still heavy.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::interpolate_nodal;
use crate::pfem2::phases::Phases;
use crate::pfem2::phases::phase_list::Reseeding;

/// Most particles in an element.
pub(super) const fn most<const D: usize>() -> usize {
    8 * D
}

/// Elements with fewer particles are filled before the projection.
pub(super) const fn least<const D: usize>() -> usize {
    D
}

/// Points of an element for new particles before the projection.
pub(super) fn before<const N: usize>() -> Vec<[f64; N]> {
    if N == 3 { corners(0.5, 0.25) } else { corners(0.4, 0.2) }
}

/// Points of an element for new particles at the end of the step.
fn after<const N: usize>() -> Vec<[f64; N]> {
    let (near, far) = if N == 3 { ((0.76, 0.12), (0.12, 0.44)) } else { ((0.7, 0.1), (0.1, 0.3)) };
    let mut places = corners(near.0, near.1);
    places.push([1.0 / N as f64; N]);
    places.extend(corners(far.0, far.1));
    places
}

/// One place per node: `own` at the node, `other` at the rest.
fn corners<const N: usize>(own: f64, other: f64) -> Vec<[f64; N]> {
    (0..N).map(|k| std::array::from_fn(|i| if i == k { own } else { other })).collect()
}

/// Fills elements with few particles at the end of a step; returns how many particles were added.
pub fn refill<const D: usize, const N: usize>(
    particles: &mut Particles<D>,
    mesh: &Mesh<D, N>,
    velocity: &[Vector<D>],
    phases: &Phases,
) -> usize {
    let places = after::<N>();
    let by_elements = |e: usize| {
        let own = particles.of(e);
        particles.reseeding_of(phases.list, own.clone()) == Reseeding::Elements && own.len() < 2 * D
    };
    let is_poor = |e: usize| by_elements(e).then_some(e);
    let poor = parallel::collect_some(mesh.elements().len(), parallel::CHUNK, is_poor);
    let mut added = 0;
    for &e in &poor {
        let (nodes, corners) = (&mesh.elements()[e], mesh.corners(e));
        let fills_empty = |fluid: u8| phases.list.reseeding(usize::from(fluid)) == Reseeding::EmptyElements;
        let all = places.iter().zip(fluids(&places, nodes, phases));
        for (place, fluid) in all.filter(|(_, fluid)| !fills_empty(*fluid)) {
            added += 1;
            let position = crate::pfem2::particles::interpolate(place, &corners);
            particles.push(position, interpolate_nodal(place, nodes, velocity), fluid, e as u32);
        }
    }
    if !poor.is_empty() {
        particles.sort();
    }
    added
}

/// The fluids of new particles at these places of an element.
fn fluids<const N: usize>(places: &[[f64; N]], nodes: &[u32; N], phases: &Phases) -> Vec<u8> {
    let mut fluids: Vec<u8> = places.iter().map(|shape| phases.at_place(nodes, shape) as u8).collect();
    let level = || nodes.iter().map(|&node| phases.level[node as usize]);
    let Some([negative, _]) = phases.list.sides() else { return fluids };
    if level().any(|phi| phi < 0.0) {
        return fluids;
    }
    let mean = level().sum::<f64>() / N as f64;
    let heavy = (1.01 * places.len() as f64 * (0.5 - 0.5 * mean)).max(0.0) as usize;
    let phi = |k: usize| places[k].iter().zip(level()).map(|(n, phi)| n * phi).sum::<f64>();
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| phi(a).total_cmp(&phi(b)));
    order.into_iter().take(heavy).for_each(|k| fluids[k] = negative as u8);
    fluids
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pfem2::phases::phase_list::PhaseList;

    #[test]
    fn places_lie_inside_and_are_as_many_as_in_the_source() {
        fn check<const N: usize>(counts: [usize; 2]) {
            assert_eq!([before::<N>().len(), after::<N>().len()], counts);
            for place in before::<N>().into_iter().chain(after()) {
                assert!((place.iter().sum::<f64>() - 1.0).abs() < 1e-14 && place.iter().all(|n| *n > 0.0));
            }
        }
        check::<3>([3, 7]);
        check::<4>([4, 9]);
    }

    #[test]
    fn new_particles_keep_the_fraction_of_the_heavy_fluid() {
        let places = after::<3>();
        let heavy = |level: [f64; 3]| {
            let phases = Phases { list: &PhaseList::fluids(&[1.0, 3.0]), fraction: &[], level: &level };
            fluids(&places, &[0, 1, 2], &phases).iter().filter(|&&fluid| fluid == 1).count()
        };
        assert_eq!(heavy([-1.0; 3]), 7);
        assert_eq!(heavy([1.0; 3]), 0);
        // φ̄ = 0.4: 1.01 · 7 · 0.3 = 2.1.
        assert_eq!(heavy([0.2, 0.4, 0.6]), 2);
        assert_eq!(heavy([-0.5, 1.0, 1.0]), 1);
    }
}
