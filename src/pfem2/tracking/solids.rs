//! The solids of a run in the steps of the fluid: their prediction cuts the mesh, and they take the velocity
//! of the system (theory J.1).

use crate::error::StepError;
use crate::linalg::SparseMatrix;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::ThetaStep;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::history::{StepWeights, TimeHistory};
use crate::pfem2::moments;
use crate::pfem2::solid::contact::step::{ContactPrediction, DEPTH, StepContacts};
use crate::pfem2::solid::coupling::immersed::Immersed;
use crate::pfem2::solid::coupling::pressure_stiffness::FluidPressure;
use crate::pfem2::solid::coupling::trace::{CutMesh, SurfaceTrace};
use crate::pfem2::solid::cut::SolidCut;
use crate::pfem2::solid::equations::SolidEquations;
use crate::pfem2::solid::equations::independent::SolutionVelocities;
use crate::pfem2::solid::holding::{HeldStep, Holders, HoldingForces};
use crate::pfem2::solid::setup::SurfaceCondition;
use crate::pfem2::solid::step_results::{SolidStep, energies};
use crate::pfem2::solid::structure::bodies::{LinearCells, SolidPowers, SolvedStep};
use crate::pfem2::solid::structure::outline::SolidOutline;
use crate::pfem2::solid::structure::{Prediction, Structure};
use crate::pfem2::solid::surface::SolidSurface;

/// Distance of the surface of a solid at the end of a step from its prediction, in elements of the mesh, from which on
/// the step is solved anew about the end that was found.
const LARGEST_PREDICTION_ERROR: f64 = 0.1;

/// A step that is solved anew is done when a solution moves the surface by less than this, in elements of the mesh.
/// Steps that resolve the motion of a solid have a prediction error below a hundredth.
const SETTLED: f64 = 0.02;

/// Repeated solutions of a step stall, as where two shapes lead to each other by turns, if a correction is above this
/// part of the one before. The next prediction is half-way then, and an end that is not [`LARGEST_PREDICTION_ERROR`] is
/// taken.
const STALLED: f64 = 0.9;

/// Solutions of a step before they can count as stalled: corrections of the first ones may rise.
const SOLUTIONS_BEFORE_STALL: usize = 3;

/// Most repetitions of the solution of a step.
const REPETITIONS: usize = 6;

/// The same where something is near a solid, which may touch it.
const REPETITIONS_IN_CONTACT: usize = 30;

/// Number of backward-Euler steps at an impact that a step doesn't resolve: the step of the impact and the two after
/// it, whose predictions have its impulse through the velocities and accelerations of the steps before (theory J.8).
const BACKWARD_STEPS: usize = 3;

/// The solids of a run.
#[derive(Debug)]
pub(in crate::pfem2) struct SolidTracking<const D: usize> {
    /// Meshes, laws and state of the solids.
    pub structure: Structure<D>,
    /// The elements of each divided into linear ones, for outputs.
    pub cells: Vec<LinearCells>,
    /// The surface of each, for outputs.
    pub outlines: Vec<SolidOutline>,
    /// Points about which the forces on them have moments [m].
    pub moment_points: Vec<Option<Vector<D>>>,
    /// Supports, springs and contacts that hold the solids.
    pub holders: Holders,
    /// Contacts of the solids with walls, with each other and with themselves.
    pub(super) contacts: StepContacts<D>,
    /// K_p of the pressure of the fluid in the step that is being made (theory (J.9b)).
    pub(super) pressure_stiffness: Option<SparseMatrix>,
    /// Prediction of the step that is being made.
    pub(super) prediction: Option<Prediction<D>>,
    /// The first prediction u* of a step that is solved anew [m].
    pub(super) first: Option<Vec<Vector<D>>>,
    /// Results of the last step.
    pub last: SolidStep<D>,
}

impl<const D: usize> SolidTracking<D> {
    /// Moments of nodal forces [N] on each solid, which act where the mesh was cut [N m].
    fn moments(&self, nodal: &[Vector<D>]) -> Vec<Vector<3>> {
        let places = self.structure.positions(&self.last.predicted);
        let of = |(solid, point): (usize, &Option<Vector<D>>)| {
            let point = point.unwrap_or_default();
            self.structure.nodes_of(solid).map(|a| moments::moment(places[a] - point, nodal[a])).sum()
        };
        self.moment_points.iter().enumerate().map(of).collect()
    }

    /// Cuts the mesh at the surface that the solids had in the last step, and gives the nodes inside their velocity.
    pub fn immerse<const N: usize>(&self, system: &mut VelocityPressureSystem<D, N>) {
        let velocity = &self.structure.state.velocity;
        let (cut, density) = (self.cut(&system.mesh, &self.surface()), self.structure.largest_density());
        let immersed = Immersed::new(cut, velocity, velocity.clone(), None, density);
        immersed.extend(|node| velocity[node], &mut system.velocity);
        system.immerse(immersed);
    }

    /// The predicted surface.
    fn surface(&self) -> SolidSurface<D> {
        let meshes = self.structure.meshes();
        let bonded_to = self.structure.ties.bonded_to(meshes.len());
        let is_rigid = self.structure.setups().iter().map(|setup| setup.law.is_rigid()).collect();
        let surface = SolidSurface::new(&meshes, &self.structure.positions(&self.last.predicted));
        surface.with_bonds(bonded_to).with_rigid(is_rigid)
    }

    /// The mesh cut at a surface.
    fn cut<const N: usize>(&self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>) -> CutMesh<D, N> {
        let conditions: Vec<SurfaceCondition> = self.structure.setups().iter().map(|setup| setup.surface).collect();
        let cut = SolidCut::new(mesh, surface, &conditions);
        let is_elastic = |node: u32| self.structure.is_elastic(node);
        let trace = SurfaceTrace::new(mesh, &self.contacts.solids.locator, surface, &cut, is_elastic);
        CutMesh { cut, trace }
    }

    /// Predicts the displacement u* at the end of a step, makes the equations of the solids about it, and cuts the mesh
    /// at their surface (theory J.1, J.2).
    ///
    /// # Errors
    /// An element of a solid turns inside out; supports that a rigid solid can't follow; solids go through each other.
    pub fn predict<const N: usize>(
        &mut self,
        step: ThetaStep,
        history: &TimeHistory<D>,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<(), StepError> {
        let (step_weights, weights) = match self.last.backward_steps {
            0 => (history.step_weights(step), history.convecting_weights(step)),
            _ => (StepWeights::backward_euler(step.dt), [1.0, 0.0, 0.0]),
        };
        let prediction = self.structure.predict(step.end(), step_weights, weights)?;
        (self.last.solutions, self.first) = (1, None);
        self.linearise(self.solid_step(step), prediction, system)
    }

    /// The step as solids make it: some by backward Euler (theory J.8).
    fn solid_step(&self, step: ThetaStep) -> ThetaStep {
        if self.last.backward_steps > 0 { ThetaStep { theta: 1.0, ..step } } else { step }
    }

    /// True if a step is to be solved anew after the solution that the system has found: with other contacts, or about
    /// the displacement to which its velocities lead, where that is far from u*, or nearer to something than the gap,
    /// or where an impact is to be made by backward Euler (theory (J.3a), J.8).
    ///
    /// # Errors
    /// As [`SolidTracking::predict`].
    pub fn predict_again<const N: usize>(
        &mut self,
        step: ThetaStep,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<bool, StepError> {
        let (Some(immersed), Some(prediction)) = (&system.immersed, &self.prediction) else { return Ok(false) };
        let solution = prediction.velocities.solution(&immersed.independent);
        let most = if self.contacts.any() { REPETITIONS_IN_CONTACT } else { REPETITIONS };
        let is_last = self.last.solutions > most;
        let again = self.update_contacts(&solution, is_last, system)
            || self.update_prediction(step, &solution, is_last, system)?;
        self.last.solutions += usize::from(again);
        Ok(again)
    }

    /// Lets other contacts act in the equations of the step where some pull or lack in a solution; returns true if
    /// others act.
    fn update_contacts<const N: usize>(
        &mut self,
        solution: &SolutionVelocities<D>,
        is_last: bool,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> bool {
        self.last.has_wrong_contacts = self.contacts.are_wrong(&solution.nodal);
        if is_last || !self.last.has_wrong_contacts {
            return false;
        }
        let equations = system.immersed.as_mut().and_then(|immersed| immersed.equations.as_mut());
        equations.is_some_and(|equations| self.contacts.change(solution, equations))
    }

    /// Takes the displacement to which a solution leads as prediction, where the step is to be solved anew about it;
    /// returns true if it is.
    ///
    /// # Errors
    /// As [`SolidTracking::predict`].
    fn update_prediction<const N: usize>(
        &mut self,
        step: ThetaStep,
        solution: &SolutionVelocities<D>,
        is_last: bool,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<bool, StepError> {
        let Some(prediction) = &self.prediction else { return Ok(false) };
        let (own, mesh) = (self.solid_step(step), &system.mesh);
        let mut found = self.structure.corrected(own.delta(), prediction, &solution.independent);
        let places = [&found, prediction].map(|end| self.structure.positions(&end.displacement));
        let correction = self.contacts.solids.largest_error(mesh, [&places[0], &places[1]]);
        let stalls = self.last.solutions > SOLUTIONS_BEFORE_STALL && correction > STALLED * self.last.last_correction;
        let is_near = correction <= if self.first.is_none() || stalls { LARGEST_PREDICTION_ERROR } else { SETTLED };
        let keeps_gap =
            !self.contacts.any() || self.contacts.depth_without_contact(&self.structure, mesh, &places[0])? <= DEPTH;
        let is_impact = own.theta < 1.0 && self.contacts.has_unresolved_impact(own, &self.structure, &solution.nodal);
        self.last.last_correction = if is_near { 0.0 } else { correction };
        if is_last || is_near && keeps_gap && !is_impact {
            return Ok(false);
        }
        self.first.get_or_insert_with(|| prediction.displacement.clone());
        if is_impact {
            self.last.backward_steps = BACKWARD_STEPS;
            found = self.by_backward_euler(step, found)?;
        } else if stalls && !is_near {
            found = found.halfway_from(prediction);
        }
        self.linearise(self.solid_step(step), found, system)?;
        Ok(true)
    }

    /// The prediction of a step with the same displacement, whose end is found by backward Euler.
    ///
    /// # Errors
    /// As [`SolidTracking::predict`].
    fn by_backward_euler(&self, step: ThetaStep, prediction: Prediction<D>) -> Result<Prediction<D>, StepError> {
        let Prediction { displacement, found, .. } = prediction;
        let hats = self.structure.predict(step.end(), StepWeights::backward_euler(step.dt), [1.0, 0.0, 0.0])?;
        Ok(Prediction { displacement, found, ..hats })
    }

    /// Makes the equations of the solids about a prediction, and cuts the mesh at their surface.
    ///
    /// # Errors
    /// As [`SolidTracking::predict`].
    fn linearise<const N: usize>(
        &mut self,
        step: ThetaStep,
        prediction: Prediction<D>,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<(), StepError> {
        let gravity = |x: Vector<D>| Vector::from_fn(|i| system.physics.gravity[i].value(x.to3(), step.end()));
        let mut equations = self.structure.equations(step.end(), step.delta(), &prediction, gravity)?;
        self.last.predicted.clone_from(&prediction.displacement);
        let surface = self.surface();
        let (last, anew) = (&self.last.contact_forces, self.first.is_some());
        let predicted = ContactPrediction { prediction: &prediction, surface: &surface, last, anew };
        self.contacts.find(step, &self.structure, &system.mesh, &predicted, &mut equations)?;
        let is_held = |node: usize| (node * D..(node + 1) * D).any(|k| equations.velocities.is_prescribed(k));
        let held: Vec<bool> = (0..self.structure.node_count()).map(is_held).collect();
        let cut = self.cut(&system.mesh, &surface);
        if let Some(immersed) = &system.immersed {
            let pressure = FluidPressure::new(&system.mesh, immersed, &system.pressure);
            let places = self.structure.positions(&prediction.displacement);
            let mut stiffness = self.structure.zero_matrix();
            pressure.stiffness(&cut, &surface, &places, |nodes, slope| {
                self.structure.add_block(&mut stiffness, nodes, &slope);
            });
            self.add_pressure_stiffness(step, &prediction, &stiffness, &mut equations);
            self.pressure_stiffness = Some(stiffness);
        }
        let hat = prediction.surface_velocity_hat.clone();
        let density = self.structure.largest_density();
        system.immersed = Some(Immersed::new(cut, &self.structure.state.velocity, hat, Some(equations), density));
        check_boundary(system, &held)?;
        self.prediction = Some(prediction);
        Ok(())
    }

    /// Adds the change of the forces of the fluid as the surface moves on from u* under the pressure of the last step
    /// (theory (J.9b)).
    fn add_pressure_stiffness(
        &self,
        step: ThetaStep,
        prediction: &Prediction<D>,
        stiffness: &SparseMatrix,
        equations: &mut SolidEquations,
    ) {
        let offset = self.structure.increment_from_prediction(prediction, |a| prediction.displacement_hat[a]);
        let forces = self.structure.product(stiffness, &offset);
        equations.rhs.iter_mut().zip(forces.iter().flat_map(|force| force.0)).for_each(|(rhs, force)| *rhs += force);
        let all = equations.matrix.values.iter_mut().zip(&stiffness.values);
        all.for_each(|(value, slope)| *value -= step.delta() * slope);
    }

    /// Takes the velocity that the system has found for the end of the step.
    ///
    /// # Errors
    /// An element of a solid is turned inside out.
    pub fn advance<const N: usize>(
        &mut self,
        step: ThetaStep,
        step_weights: StepWeights,
        system: &VelocityPressureSystem<D, N>,
    ) -> Result<(), StepError> {
        let (Some(immersed), Some(prediction)) = (&system.immersed, self.prediction.take()) else { return Ok(()) };
        let step = self.solid_step(step);
        // After an impact the solids, and what holds them, have steps of backward Euler; the fluid has its own.
        let own_weights =
            if self.last.backward_steps > 0 { StepWeights::backward_euler(step.dt) } else { step_weights };
        self.last.backward_steps = self.last.backward_steps.saturating_sub(1);
        self.structure.advance(step.delta(), &prediction, &immersed.independent);

        // Work and forces of supports, from the equations as they were solved: these have the pressure stiffness in
        // their matrix, and the forces of the fluid on the surface at u*.
        let at_prediction = immersed.forces(&system.mesh, &system.linear.unknowns);
        let mut powers = SolidPowers::default();
        if let Some(equations) = &immersed.equations {
            let Immersed { velocity, independent, .. } = immersed;
            let solved = SolvedStep { equations, velocity, independent, fluid: &at_prediction };
            powers = self.structure.powers(step, &prediction, &solved, &system.physics.gravity);
            self.update_holding(step, own_weights, &prediction, &solved);
        }
        // The forces of the fluid on the surface at the end of the step, for outputs.
        let at_end = self.fluid_forces_at_end(at_prediction, &prediction);

        // Impulses of contacts leave the state once their forces are known.
        let imbalance = self.structure.linearisation_error(step, &prediction)?;
        self.contacts.write_forces(&self.structure.state.velocity, &mut self.last.contact_forces);
        powers.supports += self.contacts.end_impulses(step, &mut self.structure, &prediction);
        self.last.energies = energies(&self.structure, powers)?;
        self.last.imbalance = imbalance;
        self.last.prediction_error = self.prediction_error(&system.mesh);
        self.last.forces.update(self.structure.sums(&at_end), step_weights);
        self.last.moments.update(self.moments(&at_end), step_weights);
        self.last.nodal = at_end;
        Ok(())
    }

    /// Nodal forces of the fluid at the surface at u* [N], moved on to that at the end of the step (theory (J.9b)).
    fn fluid_forces_at_end(&mut self, mut nodal: Vec<Vector<D>>, prediction: &Prediction<D>) -> Vec<Vector<D>> {
        if let Some(stiffness) = self.pressure_stiffness.take() {
            let way = self.structure.increment_from_prediction(prediction, |a| self.structure.state.displacement[a]);
            let more = self.structure.product(&stiffness, &way);
            nodal.iter_mut().zip(more).for_each(|(force, more)| *force += more);
        }
        nodal
    }

    /// The longest step after one of `dt` [s] that resolves the impacts that it begins [s]; `peak` is the largest kinetic
    /// energy of the solids so far [J] (theory J.8).
    pub fn longest_before_impact<const N: usize>(&self, mesh: &Mesh<D, N>, dt: f64, peak: f64) -> f64 {
        self.contacts.longest_before_impact(&self.structure, mesh, dt, peak)
    }

    /// Distance of the surface at the end of a step from its first prediction, in elements of the mesh.
    fn prediction_error<const N: usize>(&self, mesh: &Mesh<D, N>) -> f64 {
        let first = self.first.as_ref().unwrap_or(&self.last.predicted);
        let places = [&self.structure.state.displacement, first].map(|u| self.structure.positions(u));
        self.contacts.solids.largest_error(mesh, [&places[0], &places[1]])
    }
}

impl<const D: usize> SolidTracking<D> {
    /// Takes the forces on supports and springs, and those of contacts, at the end of a step.
    fn update_holding(
        &mut self,
        step: ThetaStep,
        step_weights: StepWeights,
        prediction: &Prediction<D>,
        solved: &SolvedStep<'_, D>,
    ) {
        let (contacts, moment_points) = (&self.contacts, &self.moment_points[..]);
        let held = HeldStep { delta: step.delta(), prediction, solved, contacts, moment_points };
        let HoldingForces { lasting, impulses } = self.holders.measure(&self.structure, &held);
        self.last.holding.update(lasting.iter().map(|all| all.force).collect(), step_weights);
        self.last.holding_moments.update(lasting.iter().map(|all| all.moment).collect(), step_weights);
        let part = step.delta() / step.dt;
        self.last.holding.add_to_means(impulses.iter().map(|all| all.force * part));
        self.last.holding_moments.add_to_means(impulses.iter().map(|all| all.moment * part));
    }
}

/// No solid has reached the boundary of the mesh, but where its nodes are `held`.
///
/// # Errors
/// Names the first node of the boundary that is inside of one.
fn check_boundary<const D: usize, const N: usize>(
    system: &VelocityPressureSystem<D, N>,
    held: &[bool],
) -> Result<(), StepError> {
    let Some(immersed) = &system.immersed else { return Ok(()) };
    let reached = immersed.cut.inside.iter().find(|inside| {
        system.is_on_boundary(inside.node as usize)
            && !inside.weights.iter().any(|&(a, w)| held[a as usize] && w != 0.0)
    });
    let Some(inside) = reached else { return Ok(()) };
    let node = inside.node as usize;
    let advice = "solids stay half an element away from walls if they go less than that in a step: take shorter steps; they can't leave through \
                  an opening: put it farther away; support nodes that are to stay at the boundary";
    let what = "a solid has reached the boundary of the mesh";
    Err(StepError::new(system.place(node), what, "distance to its surface", -immersed.cut.distance[node], advice))
}
