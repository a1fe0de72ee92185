//! Contacts of the solids in a step: which of them push at its end, and impacts that it doesn't resolve (theory J.8, J.9, J.11).

use super::contact::{Contact, ContactStep, Meeting};
use super::equations::SolidEquations;
use super::impulses::{RigidEquations, pushing};
use super::setup::Inertia;
use super::structure::{Prediction, SolidState};
use super::surface::SolidSurface;
use super::touching::ContactPlaces;
use super::tracking::SolidTracking;
use super::unilateral::{PushSearch, is_settled};
use crate::error::StepError;
use crate::linalg::SparseFactor;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::equations::system::TimeStep;

/// A step is solved anew where an elastic solid comes nearer than the gap by this part of it, and no contact acts.
pub(super) const DEPTH: f64 = 0.01;

/// After so many solutions of a step the fluid has a share in the search for contacts that push.
const SEARCHES: usize = 8;

/// Solutions of the equations of solids in one search.
const SOLUTIONS_WITHOUT_FLUID: usize = 300;

/// What arrives more slowly than by this part of the largest speed in a solid doesn't collide: it may be rounding.
const SLOW: f64 = 1e-3;

/// A step that stops more than this part of the mass of an elastic solid doesn't resolve its impact.
const STOPPED: f64 = 0.1;

impl<const D: usize> SolidTracking<D> {
    /// Adds the contacts of a step to its equations (theory J.8, J.9).
    ///
    /// # Errors
    /// Solids go through each other.
    pub(super) fn touch<const N: usize>(
        &mut self,
        step: TimeStep,
        prediction: &Prediction<D>,
        (mesh, surface): (&Mesh<D, N>, &SolidSurface<D>),
        equations: &mut SolidEquations,
    ) -> Result<(), StepError> {
        let Self { structure, walls, touching, last, first, .. } = self;
        let Prediction { displacement_hat, displacement, .. } = prediction;
        let SolidState { velocity, velocity_previous, acceleration, .. } = &structure.state;
        let [start, predicted] = [&structure.state.displacement, displacement].map(|u| structure.positions(u));
        let contact_step = ContactStep {
            anew: first.is_some(),
            dt: step.dt,
            delta: step.delta(),
            rest: &|a| displacement_hat[a] - displacement[a],
            way: &|a| displacement[a] - structure.state.displacement[a],
            velocity: &|a| velocity[a],
            gained: &|a| velocity[a] - velocity_previous[a],
            acceleration: &|a| acceleration[a],
        };
        let places = ContactPlaces { start: &start, predicted: &predicted, surface };
        let with_walls = walls.meetings(&places);
        let with_solids = touching.meetings(structure, mesh, &places)?;
        let made = |meetings: Vec<Meeting<D>>, last: &[Vector<D>]| -> Vec<Contact<D>> {
            let nearest = structure.nearest_places(&meetings, &contact_step);
            let contact = |(meeting, nearest): (Meeting<D>, [f64; 2])| {
                Contact::new(last[meeting.point], meeting, nearest, &contact_step)
            };
            meetings.into_iter().zip(nearest).map(contact).collect()
        };
        let forces = structure.rigid_forces(prediction);
        let SolidEquations { inertia, velocities, .. } = &*equations;
        let rigid = RigidEquations { inertia, forces: &forces, velocities };
        self.contacts = pushing([made(with_walls, &last.contact), made(with_solids, &last.touch)], &rigid);
        (self.search, self.without_contacts) = (PushSearch::default(), equations.linear.counts());
        acting(&self.contacts).for_each(|contact| contact.add(&mut equations.linear));
        Ok(())
    }

    /// True if a place of a solid is near something in the step.
    pub(super) fn touches(&self) -> bool {
        self.contacts.iter().any(|contacts| !contacts.is_empty())
    }

    /// True if contacts of elastic solids pull at the velocities that a solution has found [m/s], or if some lack.
    pub(super) fn has_wrong_contacts(&mut self, velocity: &[Vector<D>]) -> bool {
        !is_settled(&elastic(&mut self.contacts), velocity)
    }

    /// Lets other contacts of elastic solids act in these equations of the step than in a solution with these velocities of nodes, the
    /// independent ones beside them [m/s]; returns false if there are none.
    pub(super) fn change_contacts(
        &mut self,
        (velocity, independent): (&[Vector<D>], &[f64]),
        equations: &mut SolidEquations,
    ) -> bool {
        let before = self.acts();
        self.search.goes_on(&mut elastic(&mut self.contacts), velocity);
        let pushing = self.acts();
        if self.search.solutions() <= SEARCHES {
            self.let_act(&before);
            if self.search_without_fluid((velocity, independent), equations).is_none() {
                self.let_act(&pushing);
            }
        }
        self.replace_contacts(equations);
        self.acts() != before
    }

    /// Which contacts act.
    fn acts(&self) -> Vec<bool> {
        self.contacts.iter().flatten().map(|contact| contact.acts).collect()
    }

    fn let_act(&mut self, acts: &[bool]) {
        self.contacts.iter_mut().flatten().zip(acts).for_each(|(contact, acts)| contact.acts = *acts);
    }

    /// Lets those contacts act that push if the fluid goes on to push as in a solution; `None` where the solids have no solution of their own, as
    /// where nothing holds one without inertia.
    fn search_without_fluid(
        &mut self,
        (velocity, independent): (&[Vector<D>], &[f64]),
        equations: &mut SolidEquations,
    ) -> Option<()> {
        let none = vec![0.0; equations.rhs.len()];
        let (matrix, rhs) = equations.independent(Vec::new(), &none);
        let mut fluid = vec![0.0; rhs.len()];
        matrix.multiply(independent, &mut fluid);
        fluid.iter_mut().zip(&rhs).for_each(|(fluid, rhs)| *fluid -= rhs);
        let (mut search, mut velocity, mut found) = (PushSearch::default(), velocity.to_vec(), independent.to_vec());
        let mut factor: Option<SparseFactor> = None;
        for _ in 0..SOLUTIONS_WITHOUT_FLUID {
            if !search.goes_on(&mut elastic(&mut self.contacts), &velocity) {
                break;
            }
            self.replace_contacts(equations);
            let (matrix, mut rhs) = equations.independent(Vec::new(), &none);
            rhs.iter_mut().zip(&fluid).for_each(|(rhs, fluid)| *rhs += fluid);
            let renewed = match factor.take() {
                Some(factor) => factor.renewed(&matrix),
                None => SparseFactor::new(&matrix),
            };
            factor.insert(renewed?).solve(&rhs, &mut found);
            found.iter().all(|w| w.is_finite()).then_some(())?;
            velocity = equations.velocities.nodal_vectors(&found);
            if is_settled(&elastic(&mut self.contacts), &velocity) {
                break;
            }
        }
        Some(())
    }

    /// Takes those that act into the equations, in place of those that did.
    fn replace_contacts(&self, equations: &mut SolidEquations) {
        equations.linear.truncate(self.without_contacts);
        acting(&self.contacts).for_each(|contact| contact.add(&mut equations.linear));
    }

    /// Takes the impulses of contacts out of the accelerations at the end of a step, and what collided begins anew: they have no share in
    /// later steps (theory (J.16a)). Returns what they change of the power of supports [W].
    pub(super) fn end_impulses(&mut self, step: TimeStep, prediction: &Prediction<D>) -> f64 {
        let Self { contacts, structure, .. } = self;
        let all = || acting(contacts);
        let velocity = |a: usize| structure.state.velocity[a];
        let excess = all().map(|contact| contact.excess_power(step.theta, velocity)).sum();
        let impulses: Vec<(usize, Vector<D>)> = all().flat_map(|contact| contact.impulses(velocity)).collect();
        let colliding: Vec<usize> = all().flat_map(Contact::colliding).collect();
        structure.take_out_impulses(step.delta(), prediction, &impulses);
        structure.begin_anew(&colliding);
        excess
    }

    /// Keeps the normal forces of contacts at the end of a step.
    pub(super) fn keep_contacts(&mut self) {
        let velocity = &self.structure.state.velocity;
        for (contacts, last) in self.contacts.iter().zip([&mut self.last.contact, &mut self.last.touch]) {
            last.fill(Vector::ZERO);
            for contact in contacts.iter().filter(|contact| contact.acts) {
                last[contact.point] += contact.normal_force(|node| velocity[node]);
            }
        }
    }

    /// The largest depth in the gap of places of elastic solids where no contact acts, over the gap, where their nodes are [m].
    ///
    /// # Errors
    /// Solids go through each other.
    pub(super) fn depth_without_contact<const N: usize>(
        &self,
        end: &[Vector<D>],
        mesh: &Mesh<D, N>,
    ) -> Result<f64, StepError> {
        let start = self.structure.positions(&self.structure.state.displacement);
        let surface = SolidSurface::new(&self.structure.meshes(), end);
        let places = ContactPlaces { start: &start, predicted: end, surface: &surface };
        let meetings = [self.walls.meetings(&places), self.touching.meetings(&self.structure, mesh, &places)?];
        let depths = meetings.iter().zip(&self.contacts).flat_map(|(meetings, contacts)| {
            let free = meetings.iter().filter(|meeting| !contacts.iter().any(|contact| contact.is_at(meeting)));
            free.map(Meeting::depth)
        });
        Ok(depths.fold(0.0, f64::max))
    }

    /// True if contacts that begin in a step carry most of what presses on a solid, and stop more of it than the step resolves: with forces in
    /// part those of its start, what is at the gap at its end would have a velocity away from it that nothing gave it (theory J.8).
    pub(super) fn is_unresolved_impact(&self, step: TimeStep, velocity: &[Vector<D>]) -> bool {
        let structure = &self.structure;
        let mut solids = vec![Impact::default(); structure.setups().len()];
        let fastest =
            |solid: usize| velocity[structure.nodes_of(solid)].iter().fold(0.0, |most: f64, v| most.max(v.norm()));
        let slow: Vec<f64> = (0..solids.len()).map(|solid| SLOW * fastest(solid)).collect();
        for contact in acting(&self.contacts) {
            let push = contact.elastic_push(|node| velocity[node]).max(0.0);
            let mut own: Vec<usize> = contact.nodes().map(|node| structure.solid_of(node)).collect();
            own.dedup();
            own.into_iter()
                .for_each(|solid| solids[solid].add(push, contact.arrival.map(|speed| speed.max(slow[solid]))));
        }
        solids.iter().enumerate().any(|(solid, impact)| {
            let mass = structure.mass_of(solid);
            structure.setups()[solid].inertia == Inertia::Dynamic && impact.is_unresolved(step.delta(), mass)
        })
    }
}

/// Those of elastic solids.
fn elastic<const D: usize>(contacts: &mut [Vec<Contact<D>>; 2]) -> Vec<&mut Contact<D>> {
    contacts.iter_mut().flatten().filter(|contact| contact.impulse().is_none()).collect()
}

/// Those with a force.
fn acting<const D: usize>(contacts: &[Vec<Contact<D>>; 2]) -> impl Iterator<Item = &Contact<D>> {
    contacts.iter().flatten().filter(|contact| contact.acts)
}

/// Contacts of a solid.
#[derive(Debug, Clone, Copy, Default)]
struct Impact {
    /// Sum of all that push [N].
    all: f64,
    /// Sum of those that begin in the step [N].
    new: f64,
    /// Sum of the forces of these, over the speed with which they arrive [N s/m].
    resistance: f64,
}

impl Impact {
    fn add(&mut self, push: f64, arrival: Option<f64>) {
        self.all += push;
        if let Some(speed) = arrival {
            self.new += push;
            self.resistance += push / speed.max(f64::MIN_POSITIVE);
        }
    }

    /// In a step with the implicit part `delta` [s], for a solid with this `mass` [kg].
    fn is_unresolved(&self, delta: f64, mass: f64) -> bool {
        self.new > 0.5 * self.all && self.resistance * delta > STOPPED * mass
    }
}
