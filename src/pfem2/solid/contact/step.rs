//! Contacts of the solids in a step: those that push at its end, and impacts that it doesn't resolve (theory J.8, J.9,
//! J.11).

use super::arrivals::ResolvingSteps;
use super::between_solids::{SearchContext, SolidContacts};
use super::force::{Contact, ContactCandidate, ContactStep, LeastDistances};
use super::impulses::{RigidEquations, pushing};
use super::places::ContactPlaces;
use super::unilateral::{PushSearch, is_settled};
use super::walls::WallContacts;
use crate::error::StepError;
use crate::linalg::SparseFactor;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::ThetaStep;
use crate::pfem2::boundary::Boundary;
use crate::pfem2::history::LARGEST_CHANGE;
use crate::pfem2::solid::equations::SolidEquations;
use crate::pfem2::solid::equations::independent::SolutionVelocities;
use crate::pfem2::solid::setup::Inertia;
use crate::pfem2::solid::structure::{Prediction, SolidState, Structure};
use crate::pfem2::solid::surface::SolidSurface;

/// A step is solved anew where an elastic solid comes nearer than the gap by this part of it, and no contact acts.
pub(in crate::pfem2) const DEPTH: f64 = 0.01;

/// Most searches in a step with the forces of the fluid frozen. After these, the contacts that act follow from the
/// coupled solutions of the step alone (theory J.8).
const SEARCHES: usize = 8;

/// Solutions of the equations of solids in one search.
const SOLUTIONS_WITHOUT_FLUID: usize = 300;

/// Arrivals more slowly than by this part of the largest speed in a solid are no collisions: they may be rounding.
const SLOW: f64 = 1e-3;

/// A step that stops more than this part of the mass of an elastic solid doesn't resolve its impact.
const STOPPED: f64 = 0.1;

/// Contact of the solids of a run, with the contacts of the present step.
#[derive(Debug)]
pub(in crate::pfem2) struct StepContacts<const D: usize> {
    /// Contact with walls.
    walls: WallContacts<D>,
    /// Contact of solids with each other and with themselves.
    pub solids: SolidContacts<D>,
    /// Contacts of the step.
    contacts: ContactLists<D>,
    /// Search for those that push.
    search: PushSearch,
    /// Numbers of linear forces in the equations of the step besides contacts.
    without_contacts: [usize; 2],
    /// The steps that resolve impacts.
    resolving: ResolvingSteps,
}

/// Contacts of a step.
#[derive(Debug, Default)]
struct ContactLists<const D: usize> {
    /// Contacts with walls.
    walls: Vec<Contact<D>>,
    /// Contacts among solids.
    solids: Vec<Contact<D>>,
}

/// Normal forces of contacts at the end of a step [N].
#[derive(Debug, Clone, Default)]
pub(in crate::pfem2) struct ContactForces<const D: usize> {
    /// Force of walls on each node, and then between the nodes of each facet.
    pub walls: Vec<Vector<D>>,
    /// Force of solids on each point of their surfaces that may touch.
    pub solids: Vec<Vector<D>>,
}

/// The prediction about which contacts are looked for.
pub(in crate::pfem2) struct ContactPrediction<'a, const D: usize> {
    /// The prediction.
    pub prediction: &'a Prediction<D>,
    /// The surface there.
    pub surface: &'a SolidSurface<D>,
    /// Forces of contacts at the end of the last step.
    pub last: &'a ContactForces<D>,
    /// True where the step is solved anew: then d* alone says what touches.
    pub anew: bool,
}

impl<const D: usize> ContactLists<D> {
    fn iter(&self) -> impl Iterator<Item = &Contact<D>> {
        self.walls.iter().chain(&self.solids)
    }

    fn iter_mut(&mut self) -> impl Iterator<Item = &mut Contact<D>> {
        self.walls.iter_mut().chain(&mut self.solids)
    }

    /// Contacts with a force.
    fn acting(&self) -> impl Iterator<Item = &Contact<D>> {
        self.iter().filter(|contact| contact.is_active)
    }

    /// All of them.
    fn all(&mut self) -> Vec<&mut Contact<D>> {
        self.iter_mut().collect()
    }
}

impl<const D: usize> ContactForces<D> {
    /// No forces.
    pub(in crate::pfem2) fn none(structure: &Structure<D>, contacts: &StepContacts<D>) -> Self {
        Self {
            walls: vec![Vector::ZERO; structure.node_count() + structure.facet_count()],
            solids: vec![Vector::ZERO; contacts.solids.count()],
        }
    }
}

impl<const D: usize> StepContacts<D> {
    /// Contact of solids in their reference state, in a mesh with walls.
    pub fn new<const N: usize>(structure: &Structure<D>, mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Self {
        Self {
            walls: WallContacts::new(structure, mesh, boundary),
            solids: SolidContacts::new(structure, mesh),
            contacts: ContactLists { walls: Vec::new(), solids: Vec::new() },
            search: PushSearch::default(),
            without_contacts: [0; 2],
            resolving: ResolvingSteps::new(structure),
        }
    }

    /// Finds the contacts of a step, and adds them to its equations (theory J.8, J.9).
    ///
    /// # Errors
    /// Solids go through each other.
    pub fn find<const N: usize>(
        &mut self,
        step: ThetaStep,
        structure: &Structure<D>,
        mesh: &Mesh<D, N>,
        predicted_step: &ContactPrediction<'_, D>,
        equations: &mut SolidEquations,
    ) -> Result<(), StepError> {
        let &ContactPrediction { prediction, surface, last, anew } = predicted_step;
        let Prediction { displacement_hat, displacement, .. } = prediction;
        let SolidState { velocity, velocity_previous, acceleration, .. } = &structure.state;
        let [start, predicted] = [&structure.state.displacement, displacement].map(|u| structure.positions(u));
        let contact_step = ContactStep {
            anew,
            dt: step.dt,
            delta: step.delta(),
            displacement_offset: &|a| displacement_hat[a] - displacement[a],
            predicted_increment: &|a| displacement[a] - structure.state.displacement[a],
            velocity: &|a| velocity[a],
            velocity_increment: &|a| velocity[a] - velocity_previous[a],
            acceleration: &|a| acceleration[a],
        };
        let places = ContactPlaces { start: &start, predicted: &predicted, surface };
        let with_walls = self.walls.candidates(&places);
        let among_solids = self.solids.candidates(&SearchContext { structure, mesh, places })?;
        let made = |candidates: Vec<ContactCandidate<D>>, last: &[Vector<D>]| -> Vec<Contact<D>> {
            let least = structure.least_distances(&candidates, &contact_step);
            let contact = |(candidate, least): (ContactCandidate<D>, LeastDistances)| {
                Contact::new(last[candidate.point], candidate, least, &contact_step)
            };
            candidates.into_iter().zip(least).map(contact).collect()
        };
        let forces = structure.rigid_forces(prediction);
        let rigid = RigidEquations { inertia: &equations.inertia, forces: &forces, velocities: &equations.velocities };
        let [walls, solids] = pushing([made(with_walls, &last.walls), made(among_solids, &last.solids)], &rigid);
        self.contacts = ContactLists { walls, solids };
        (self.search, self.without_contacts) = (PushSearch::default(), equations.linear.counts());
        self.contacts.acting().for_each(|contact| contact.add(&mut equations.linear));
        Ok(())
    }

    /// All places that may touch something.
    ///
    /// # Errors
    /// Solids go through each other.
    fn candidates<const N: usize>(
        &self,
        structure: &Structure<D>,
        mesh: &Mesh<D, N>,
        places: ContactPlaces<'_, D>,
    ) -> Result<Vec<ContactCandidate<D>>, StepError> {
        let mut all = self.walls.candidates(&places);
        all.extend(self.solids.candidates(&SearchContext { structure, mesh, places })?);
        Ok(all)
    }

    /// The longest step after one of `dt` [s] that resolves what it lets meet [s] (theory J.8); `peak` is the largest
    /// kinetic energy of the solids so far [J]. Infinite where nothing that counts comes near.
    pub fn longest_before_impact<const N: usize>(
        &self,
        structure: &Structure<D>,
        mesh: &Mesh<D, N>,
        dt: f64,
        peak: f64,
    ) -> f64 {
        let Some(shortest) = self.resolving.shortest() else { return f64::INFINITY };
        let ahead = LARGEST_CHANGE * dt;
        let start = structure.positions(&structure.state.displacement);
        let predicted: Vec<Vector<D>> =
            start.iter().zip(&structure.state.velocity).map(|(x, v)| *x + *v * ahead).collect();
        let surface = SolidSurface::new(&structure.meshes(), &predicted);
        let places = ContactPlaces { start: &start, predicted: &predicted, surface: &surface };
        // Solids that would go through each other are told apart in shorter steps.
        let near = self.candidates(structure, mesh, places);
        near.map_or(shortest, |near| self.resolving.longest(structure, &near, ahead, peak))
    }

    /// True if a contact acts in the step, or a place of an elastic solid is near something.
    pub fn any(&self) -> bool {
        self.contacts.iter().any(|contact| contact.is_active || contact.impulse().is_none())
    }

    /// True if contacts pull at the velocities that a solution has found [m/s], or if some lack.
    pub fn are_wrong(&mut self, velocity: &[Vector<D>]) -> bool {
        !is_settled(&self.contacts.all(), velocity)
    }

    /// Lets other contacts act in these equations of the step than in a solution; returns false if
    /// there are none.
    pub fn change(&mut self, solution: &SolutionVelocities<D>, equations: &mut SolidEquations) -> bool {
        let before = self.active();
        // The next iterate of the search by coupled solutions. It goes on with each of them, used or not.
        self.search.take_solution(&mut self.contacts.all(), &solution.nodal);
        let coupled = self.active();
        if self.search.solutions() <= SEARCHES {
            // The solids alone find their contacts, from those that acted in the solution on; the coupled search
            // decides only where they have no solution without the fluid.
            self.set_active(&before);
            if self.search_without_fluid(solution, equations).is_none() {
                self.set_active(&coupled);
            }
        }
        self.replace(equations);
        self.active() != before
    }

    /// True for each contact that acts.
    fn active(&self) -> Vec<bool> {
        self.contacts.iter().map(|contact| contact.is_active).collect()
    }

    fn set_active(&mut self, active: &[bool]) {
        self.contacts.iter_mut().zip(active).for_each(|(contact, active)| contact.is_active = *active);
    }

    /// Lets those contacts act that push if the fluid goes on to push as in a solution; `None` where the solids have no
    /// solution without it, as where nothing holds one without inertia.
    fn search_without_fluid(&mut self, solution: &SolutionVelocities<D>, equations: &mut SolidEquations) -> Option<()> {
        let none = vec![0.0; equations.rhs.len()];
        let (matrix, rhs) = equations.independent(&[], &none);
        let mut fluid = vec![0.0; rhs.len()];
        matrix.multiply(&solution.independent, &mut fluid);
        fluid.iter_mut().zip(&rhs).for_each(|(fluid, rhs)| *fluid -= rhs);
        let SolutionVelocities { nodal: mut velocity, independent: mut found } = solution.clone();
        let (mut search, mut factor) = (PushSearch::default(), None::<SparseFactor>);
        for _ in 0..SOLUTIONS_WITHOUT_FLUID {
            if !search.take_solution(&mut self.contacts.all(), &velocity) {
                break;
            }
            self.replace(equations);
            let (matrix, mut rhs) = equations.independent(&[], &none);
            rhs.iter_mut().zip(&fluid).for_each(|(rhs, fluid)| *rhs += fluid);
            let renewed = match factor.take() {
                Some(factor) => factor.renewed(&matrix),
                None => SparseFactor::new(&matrix),
            };
            factor.insert(renewed?).solve(&rhs, &mut found);
            found.iter().all(|w| w.is_finite()).then_some(())?;
            velocity = equations.velocities.nodal_vectors(&found);
            if is_settled(&self.contacts.all(), &velocity) {
                break;
            }
        }
        Some(())
    }

    /// Takes the contacts that act into the equations, in place of those that did.
    fn replace(&self, equations: &mut SolidEquations) {
        equations.linear.truncate(self.without_contacts);
        self.contacts.acting().for_each(|contact| contact.add(&mut equations.linear));
    }

    /// Takes the impulses of contacts out of the accelerations at the end of a step, and lets solids that collided
    /// begin anew: they take no part in later steps (theory (J.16a)). Returns their change of the power of supports
    /// [W].
    pub fn end_impulses(&self, step: ThetaStep, structure: &mut Structure<D>, prediction: &Prediction<D>) -> f64 {
        let all = || self.contacts.acting();
        let velocity = |a: usize| structure.state.velocity[a];
        let excess = all().map(|contact| contact.excess_power(step.theta, velocity)).sum();
        let impulses = self.impulses(velocity);
        let colliding: Vec<usize> = all().flat_map(Contact::colliding).collect();
        structure.take_out_impulses(step.delta(), prediction, &impulses);
        structure.begin_anew(&colliding);
        excess
    }

    /// Writes the normal forces of contacts at the end of a step, at the velocities of nodes there [m/s].
    pub fn write_forces(&self, velocity: &[Vector<D>], forces: &mut ContactForces<D>) {
        let ContactLists { walls, solids } = &self.contacts;
        for (contacts, forces) in [(walls, &mut forces.walls), (solids, &mut forces.solids)] {
            forces.fill(Vector::ZERO);
            for contact in contacts.iter().filter(|contact| contact.is_active) {
                forces[contact.point] += contact.normal_force(|node| velocity[node]);
            }
        }
    }

    /// Forces of contacts on nodes but for impulses [N], from the velocities of nodes at the end of a step [m/s].
    pub fn forces(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vec<(usize, Vector<D>)> {
        let lasting = self.contacts.acting().filter(|contact| contact.impulse().is_none());
        lasting.flat_map(|contact| contact.nodal_forces(&velocity)).collect()
    }

    /// Impulses of contacts on nodes, as forces that act for Δ [N], from the velocities of nodes at the end of a step
    /// [m/s].
    pub fn impulses(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vec<(usize, Vector<D>)> {
        let impulses = self.contacts.acting().filter(|contact| contact.impulse().is_some());
        impulses.flat_map(|contact| contact.nodal_forces(&velocity)).collect()
    }

    /// The largest depth in the gap of places of elastic solids where no contact acts, over the gap, with the nodes at
    /// `end` [m].
    ///
    /// # Errors
    /// Solids go through each other.
    pub fn depth_without_contact<const N: usize>(
        &self,
        structure: &Structure<D>,
        mesh: &Mesh<D, N>,
        end: &[Vector<D>],
    ) -> Result<f64, StepError> {
        let start = structure.positions(&structure.state.displacement);
        let surface = SolidSurface::new(&structure.meshes(), end);
        let places = ContactPlaces { start: &start, predicted: end, surface: &surface };
        let with_walls = self.walls.candidates(&places);
        let among_solids = self.solids.candidates(&SearchContext { structure, mesh, places })?;
        let largest = |candidates: &[ContactCandidate<D>], contacts: &[Contact<D>]| {
            let free = candidates.iter().filter(|place| !contacts.iter().any(|contact| contact.is_at(place)));
            free.map(ContactCandidate::depth).fold(0.0, f64::max)
        };
        let ContactLists { walls, solids } = &self.contacts;
        Ok(f64::max(largest(&with_walls, walls), largest(&among_solids, solids)))
    }

    /// True if contacts that begin in a step carry most of what presses on a solid, and stop more of it than the step
    /// resolves: with forces in part those of its start, a solid at the gap at its end would have a velocity away from
    /// it that nothing gave it (theory J.8).
    pub fn has_unresolved_impact(&self, step: ThetaStep, structure: &Structure<D>, velocity: &[Vector<D>]) -> bool {
        let mut solids = vec![Impact::default(); structure.setups().len()];
        let fastest =
            |solid: usize| velocity[structure.nodes_of(solid)].iter().fold(0.0, |most: f64, v| most.max(v.norm()));
        let slow: Vec<f64> = (0..solids.len()).map(|solid| SLOW * fastest(solid)).collect();
        for contact in self.contacts.acting().filter(|contact| contact.impulse().is_none()) {
            let push = contact.push(|node| velocity[node]).max(0.0);
            let mut touching: Vec<usize> = contact.nodes().map(|node| structure.solid_of(node)).collect();
            touching.dedup();
            for solid in touching {
                solids[solid].add(push, contact.arrival.map(|speed| speed.max(slow[solid])));
            }
        }
        solids.iter().enumerate().any(|(solid, impact)| {
            let mass = structure.mass_of(solid);
            structure.setups()[solid].inertia == Inertia::Dynamic && impact.is_unresolved(step.delta(), mass)
        })
    }
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

    /// True for a solid with this `mass` [kg] in a step with the implicit part `delta` [s].
    fn is_unresolved(&self, delta: f64, mass: f64) -> bool {
        self.new > 0.5 * self.all && self.resistance * delta > STOPPED * mass
    }
}
