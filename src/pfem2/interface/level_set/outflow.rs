//! Volume of the fluid inside that leaves through open boundaries in a step (theory G.6).
//!
//! ```text
//! V(t + Δt) = V(t) − ∫₀^Δt ∮_{φ<0} v*·n dA dτ
//! φ(x, τ)   = φⁿ at the foot of the streamline of v* that reaches x after τ; at an inlet, what comes in
//! ```
//!
//! The particles that carry the interface move along the streamlines of v*, frozen over the step, so that this is the
//! volume that their motion takes away; counting particles would know it to one particle only. A facet and a part of
//! the step make a prism in space and time, divided into simplices like those of a cut element: with φ and v*·n linear
//! in each, a plane front that leaves at constant speed counts exactly wherever in the step it meets the facet.
//!
//! Over all open facets ∫v*·n dA vanishes, as the equation of continuity adds up to it: what one fluid loses the other
//! gains, and nothing is counted that doesn't cross the boundary.

use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::parallel;
use crate::pfem2::cut_element::{is_cut, split};
use crate::pfem2::particles::convect::MeshPoint;

/// Parts of a step: φ is a distance up to five elements from the interface, and a step may carry it that far.
const PARTS: usize = 8;

/// A facet that admits flow, also an inlet, with the level set of what comes in.
#[derive(Debug, Clone, Copy)]
pub struct OpenFacet<const D: usize> {
    /// The facet.
    pub facet: Facet,
    /// φ of what comes in at its corners [m].
    pub inflow_level: [f64; D],
}

/// Volume that leaves through open facets in `dt` [s]: of the fluid where φ < 0, and of both [m³]; negative where it
/// comes in.
///
/// `velocity` is v* at the nodes [m/s]; `phi` gives φ at a place of the boundary and a time after the start of the
/// step [s].
pub fn outflow<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    open_facets: &[OpenFacet<D>],
    velocity: &[Vector<D>],
    dt: f64,
    phi: impl Fn(&MeshPoint<N>, f64) -> f64 + Sync,
) -> [f64; 2] {
    let through = |n: usize| {
        let opening = &open_facets[n];
        let rates = rates(mesh, opening.facet, velocity);
        let all = dt * rates.iter().sum::<f64>() / D as f64;
        let level = &opening.inflow_level;
        let comes_in = || dt * prism::<D, N>(level, level, &rates);
        [if all < 0.0 { comes_in() } else { inside(opening.facet, rates, dt, &phi) }, all]
    };
    let each: Vec<[f64; 2]> = parallel::collect(open_facets.len(), 16, through);
    each.iter().fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
}

/// The fraction of a facet that is inside, with φ at its corners [m].
pub fn fraction_inside<const D: usize, const N: usize>(level: &[f64; D]) -> f64 {
    prism::<D, N>(level, level, &[1.0; D])
}

/// v*·n A at the corners of a facet [m³/s].
fn rates<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facet: Facet, velocity: &[Vector<D>]) -> [f64; D] {
    let (area, nodes) = (mesh.facet_area(facet), mesh.facet_nodes(facet));
    std::array::from_fn(|j| velocity[nodes[j] as usize].dot(area))
}

/// Volume of the fluid inside that leaves through a facet [m³].
fn inside<const D: usize, const N: usize>(
    facet: Facet,
    rates: [f64; D],
    dt: f64,
    phi: &impl Fn(&MeshPoint<N>, f64) -> f64,
) -> f64 {
    let (element, opposite) = (facet.element as usize, facet.opposite as usize);
    let local: [usize; D] = std::array::from_fn(|j| j + usize::from(j >= opposite));
    let level = |time: f64| {
        local.map(|k| {
            let shape = std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
            phi(&MeshPoint { element, shape }, time)
        })
    };
    let part = dt / PARTS as f64;
    let mut before = level(0.0);
    let mut sum = 0.0;
    for k in 1..=PARTS {
        let after = level(k as f64 * part);
        sum += part * prism::<D, N>(&before, &after, &rates);
        before = after;
    }
    sum
}

/// Mean over a prism in space and time of v*·n A where φ < 0, with φ at the corners `before` and `after`.
fn prism<const D: usize, const N: usize>(before: &[f64; D], after: &[f64; D], rates: &[f64; D]) -> f64 {
    let simplex = |k: usize| {
        let pick = |lower: &[f64; D], upper: &[f64; D]| -> [f64; N] {
            std::array::from_fn(|i| if i <= k { lower[i] } else { upper[i - 1] })
        };
        let (level, rate) = (pick(before, after), pick(rates, rates));
        if !is_cut(&level) {
            let negative = level.iter().sum::<f64>() < 0.0;
            return if negative { rate.iter().sum::<f64>() / N as f64 } else { 0.0 };
        }
        let parts = split(&level);
        let mean = |center: &[f64; N]| center.iter().zip(&rate).map(|(n, q)| n * q).sum::<f64>();
        parts.iter().filter(|part| part.negative).map(|part| part.volume_fraction * mean(&part.center)).sum()
    };
    (0..D).map(simplex).sum::<f64>() / D as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume behind a tilted plane that moves with a uniform flow, as it leaves through the side x = 1 of a block.
    fn leaves<const D: usize, const N: usize>(mesh: &Mesh<D, N>, offset: f64, dt: f64) -> [f64; 2] {
        let speed = Vector::from_fn(|axis| [1.5, -0.2, 0.3][axis]);
        let out = |facet: &&Facet| mesh.facet_nodes(**facet).iter().all(|&i| mesh.nodes()[i as usize][0] == 1.0);
        let open_facets: Vec<OpenFacet<D>> =
            mesh.boundary().iter().filter(out).map(|&facet| OpenFacet { facet, inflow_level: [1.0; D] }).collect();
        let normal = Vector::from_fn(|axis| [0.8, 0.6, 0.0][axis]);
        let phi = |place: &MeshPoint<N>, time: f64| (place.position(mesh) - speed * time).dot(normal) - offset;
        outflow(mesh, &open_facets, &vec![speed; mesh.nodes().len()], dt, phi)
    }

    /// The fluid where 0.8 x + 0.6 y < `offset` moves with (1.5, −0.2): what lies beyond x = 1 after Δt with y in 0..1
    /// at the time when it crossed is ∫dτ ∫dy [0.8 + 0.6 y − 1.08 τ < offset] 1.5.
    fn exact(offset: f64, dt: f64) -> f64 {
        const POINTS: usize = 20_000;
        let height = |tau: f64| ((offset - 0.8 + 1.08 * tau) / 0.6).clamp(0.0, 1.0);
        (0..POINTS).map(|k| height((k as f64 + 0.5) / POINTS as f64 * dt)).sum::<f64>() / POINTS as f64 * dt * 1.5
    }

    #[test]
    fn a_tilted_plane_leaves_as_fast_as_it_moves() {
        let flat = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [5; 2]).unwrap();
        let full = Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [3; 3]).unwrap();
        for (offset, dt) in [(0.5, 0.2), (0.7, 0.3), (1.1, 0.05), (2.0, 0.4), (0.0, 0.01)] {
            let exact = exact(offset, dt);
            for [inside, all] in [leaves(&flat, offset, dt), leaves(&full, offset, dt)] {
                assert!((inside - exact).abs() < 1e-8, "{offset} {dt}: {inside} {exact}");
                assert!((all - 1.5 * dt).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn inflow_counts_with_the_level_set_that_the_opening_brings() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [2; 2]).unwrap();
        let left = |facet: &&Facet| mesh.facet_nodes(**facet).iter().all(|&i| mesh.nodes()[i as usize][0] == 0.0);
        let flow = vec![Vector([2.0, 0.0]); mesh.nodes().len()];
        for (inflow_level, inside) in [([-1.0; 2], -0.2), ([1.0; 2], 0.0), ([-1.0, 3.0], -0.05)] {
            let open_facets: Vec<OpenFacet<2>> =
                mesh.boundary().iter().filter(left).map(|&facet| OpenFacet { facet, inflow_level }).collect();
            let [found, all] = outflow(&mesh, &open_facets, &flow, 0.1, |_, _| 1.0);
            assert!((found - inside).abs() < 1e-15 && (all + 0.2).abs() < 1e-15);
        }
    }
}
