//! Impacts of elastic solids that the next step would begin, and the step that resolves them (theory J.8).
//!
//! ```text
//! x' = x + 2 Δt v:   places after the longest step that may follow
//! τ = (d − g)/v_n,   d = d' + v_n 2 Δt,   v_n = −n·Σ c_i v_i:   a place that touches nothing is at the gap then
//! V_n = −n·Σ c_i V_i > v_n/2,   V_i: velocity of the centre of mass of the solid of node i:   they come as a whole
//! (J.12a)  Δt ≤ max(τ, h/4c_s),   c_s = (G/ρ)^½,   h: size of the smallest facet of the solid
//! ```

use super::force::{ContactCandidate, relative};
use super::places::node_areas;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::solid::setup::{Inertia, SolidSetup};
use crate::pfem2::solid::structure::Structure;

/// Steps in which a shear wave crosses an element of a solid that meets something.
const STEPS_PER_ELEMENT: f64 = 4.0;

/// Part of the velocity of a place that comes near which the centres of mass have, where solids meet as a whole.
const AS_A_WHOLE: f64 = 0.5;

/// Part of the largest kinetic energy of solids so far that an impact has which steps are to resolve; others land.
const STRONG: f64 = 0.01;

/// A solid as it meets something.
#[derive(Debug, Clone, Copy)]
struct MeetingSolid<const D: usize> {
    mass: f64,
    /// Velocity of the centre of mass [m/s].
    velocity: Vector<D>,
}

/// The steps that resolve impacts of solids.
#[derive(Debug)]
pub(super) struct ResolvingSteps {
    /// h/4c_s of each solid [s]; `None` where something holds it, and of those that are rigid or quasi-static.
    steps: Vec<Option<f64>>,
}

impl ResolvingSteps {
    pub fn new<const D: usize>(structure: &Structure<D>) -> Self {
        let of = |(solid, setup): (usize, &SolidSetup<D>)| {
            let is_free = setup.held.iter().all(|held| held.nodes.is_empty()) && !structure.ties.is_bonded(solid);
            let law = setup.law.elastic_law().ok().filter(|_| is_free && setup.inertia == Inertia::Dynamic)?;
            let speed = (law.moduli().shear / law.reference_density()).sqrt();
            let smallest = node_areas(setup).iter().map(|node| node.size).reduce(f64::min)?;
            Some(smallest / (STEPS_PER_ELEMENT * speed))
        };
        Self { steps: structure.setups().iter().enumerate().map(of).collect() }
    }

    /// The shortest of them [s]; `None` where there are none.
    pub fn shortest(&self) -> Option<f64> {
        self.steps.iter().flatten().copied().reduce(f64::min)
    }

    /// The longest next step (J.12a), of places found about where the solids are after the time `ahead` [s] with the
    /// velocity that they have; `peak` is the largest kinetic energy of the solids so far [J]. Infinite where nothing that
    /// counts comes near.
    pub fn longest<const D: usize>(
        &self,
        structure: &Structure<D>,
        near: &[ContactCandidate<D>],
        ahead: f64,
        peak: f64,
    ) -> f64 {
        let (velocity, solids) = (&structure.state.velocity, meeting_solids(structure));
        let longest = |place: &ContactCandidate<D>| {
            let speed = -relative(&place.coefficients, |node| velocity[node]).dot(place.normal);
            let way = place.distance + speed * ahead - place.gap;
            let mut own: Vec<usize> =
                place.coefficients.iter().map(|&(node, _)| structure.solid_of(node as usize)).collect();
            own.dedup();
            let resolving = own.iter().filter_map(|&solid| self.steps[solid]).reduce(f64::max)?;
            let together =
                -relative(&place.coefficients, |node| solids[structure.solid_of(node)].velocity).dot(place.normal);
            let mass = own.iter().map(|&solid| solids[solid].mass.recip()).sum::<f64>().recip();
            let is_strong = together > AS_A_WHOLE * speed && 0.5 * mass * together.powi(2) > STRONG * peak;
            (way > 0.0 && speed > 0.0 && is_strong).then(|| (way / speed).max(resolving))
        };
        near.iter().filter_map(longest).fold(f64::INFINITY, f64::min)
    }
}

/// The solids as they meet something.
fn meeting_solids<const D: usize>(structure: &Structure<D>) -> Vec<MeetingSolid<D>> {
    let momentum = structure.weighted_by_mass(&structure.state.velocity);
    let (nodal, _) = momentum.as_chunks::<D>();
    let of = |solid: usize| {
        let (mass, own) = (structure.mass_of(solid), &nodal[structure.nodes_of(solid)]);
        MeetingSolid { mass, velocity: parallel::sum(own.len(), |node| Vector(own[node])) / mass }
    };
    (0..structure.setups().len()).map(of).collect()
}
