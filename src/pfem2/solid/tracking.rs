//! The solids of a run in the steps of the fluid: their prediction cuts the mesh, and they take the velocity of the system (theory J.1).

use super::bodies::quadrilaterals;
use super::contact::Contact;
use super::contact_step::DEPTH;
use super::cut::SolidCut;
use super::equations::SolidEquations;
use super::immersed::Immersed;
use super::outline::SolidOutline;
use super::setup::SurfaceCondition;
use super::structure::{Prediction, SolidState, Structure};
use super::surface::SolidSurface;
use super::touching::SolidContacts;
use super::trace::SurfaceTrace;
use super::unilateral::PushSearch;
use super::walls::WallContacts;
use super::wetted::FluidPressure;
use crate::error::StepError;
use crate::linalg::SparseMatrix;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::boundary::Boundary;
use crate::pfem2::equations::system::{TimeStep, VelocityPressureSystem};
use crate::pfem2::report::moments::{self, ForcedPart, MomentPoint, Moments};
use crate::pfem2::report::solids::SolidEnergies;
use crate::pfem2::time::history::{StepShares, TimeHistory};

/// A step whose end is farther than this from the prediction of a surface, in elements of the mesh, is solved anew about the end that was found...
const FAR: f64 = 0.1;

/// ... until a solution moves the surface by less than this. Steps that resolve the motion of a solid are off by less than a hundredth.
const SETTLED: f64 = 0.02;

/// A step is solved anew at most this often, and so where elastic solids touch something.
const REPETITIONS: usize = 6;
const REPETITIONS_IN_CONTACT: usize = 30;

/// Steps by backward Euler from an impact on that a step doesn't resolve: its impulse is in the accelerations of two that follow.
const BACKWARD_STEPS: usize = 3;

/// The solids of a run.
#[derive(Debug)]
pub(in crate::pfem2) struct SolidTracking<const D: usize> {
    /// Their meshes, laws and state.
    pub structure: Structure<D>,
    /// The elements of each as simple ones, for pictures.
    pub quadrilaterals: Vec<Vec<[u32; 4]>>,
    /// The surface of each, for outputs.
    pub outlines: Vec<SolidOutline>,
    /// Points about which the forces on them have moments [m].
    pub about: Vec<Option<Vector<D>>>,
    /// Contact with walls.
    pub(super) walls: WallContacts<D>,
    /// Contact with each other and with themselves.
    pub(super) touching: SolidContacts<D>,
    /// K_p of the pressure of the fluid in it.
    pressure_stiffness: Option<SparseMatrix>,
    /// Prediction of the step that is being made.
    prediction: Option<Prediction<D>>,
    /// The first prediction u* of a step that is solved anew [m].
    pub(super) first: Option<Vec<Vector<D>>>,
    /// Its contacts with walls, and among solids.
    pub(super) contacts: [Vec<Contact<D>>; 2],
    /// Which of them push.
    pub(super) search: PushSearch,
    /// Numbers of linear forces in the equations of the step besides contacts.
    pub(super) without_contacts: [usize; 2],
    /// Results of the last step.
    pub last: SolidStep<D>,
}

/// Results of a step.
#[derive(Debug, Clone, Default)]
pub(in crate::pfem2) struct SolidStep<const D: usize> {
    /// Last predicted displacement u* [m]: the surface that cut the mesh.
    pub predicted: Vec<Vector<D>>,
    /// Forces of the fluid on each node of the solids at its end [N].
    pub nodal: Vec<Vector<D>>,
    /// Moments of the forces of the fluid on each solid, about their points.
    pub moments: Moments,
    /// Forces of the fluid on each solid at its end [N].
    pub forces: Vec<Vector<D>>,
    /// The same at the end of the step before [N].
    pub forces_earlier: Vec<Vector<D>>,
    /// Means over the step, with the shares that it takes of each [N].
    pub forces_mean: Vec<Vector<D>>,
    /// Normal force of walls on each node, and then between the nodes of each facet, at its end [N].
    pub contact: Vec<Vector<D>>,
    /// Normal force of solids on each point of their surfaces that may touch [N].
    pub touch: Vec<Vector<D>>,
    /// Energies at its end, and powers from outside.
    pub energies: SolidEnergies,
    /// Force that quasi-static solids were off balance by at its end, over the largest.
    pub imbalance: f64,
    /// Distance of the surface from where it was first predicted, in elements.
    pub off: f64,
    /// How often it was solved (theory (J.3a)).
    pub solutions: usize,
    /// By how much the last solution of a step moved elastic solids, in elements, if that is too much; else zero.
    pub unsettled: f64,
    /// True if contacts of elastic solids pulled, or lacked, when it was solved for the last time.
    pub has_wrong_contacts: bool,
    /// Steps that solids make by backward Euler from now on (theory J.8).
    pub backward_steps: usize,
}

/// State of solids at the start of a step.
pub(in crate::pfem2) struct SolidStart<const D: usize> {
    state: SolidState<D>,
    last: SolidStep<D>,
}

impl<const D: usize> SolidTracking<D> {
    /// Solids at the start, in a mesh with walls.
    pub fn new<const N: usize>(structure: Structure<D>, mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Self {
        let none = vec![Vector::ZERO; structure.setups().len()];
        let touching = SolidContacts::new(&structure, mesh);
        let last = SolidStep {
            predicted: structure.state.displacement.clone(),
            nodal: vec![Vector::ZERO; structure.node_count()],
            moments: Moments::none(none.len()),
            forces: none.clone(),
            forces_earlier: none.clone(),
            forces_mean: none,
            contact: vec![Vector::ZERO; structure.node_count() + structure.facet_count()],
            touch: vec![Vector::ZERO; touching.count()],
            // Elements that are turned inside out are found by the first step.
            energies: energies(&structure, [0.0; 2]).unwrap_or_default(),
            imbalance: 0.0,
            off: 0.0,
            solutions: 0,
            unsettled: 0.0,
            has_wrong_contacts: false,
            backward_steps: 0,
        };
        let setups = structure.setups().iter();
        let (quadrilaterals, outlines) =
            setups.map(|setup| (quadrilaterals(&setup.mesh), SolidOutline::new(&setup.name, &setup.mesh))).unzip();
        let (walls, about) = (WallContacts::new(&structure, mesh, boundary), vec![None; structure.setups().len()]);
        let contacts = [Vec::new(), Vec::new()];
        Self {
            structure,
            quadrilaterals,
            outlines,
            about,
            walls,
            touching,
            pressure_stiffness: None,
            prediction: None,
            first: None,
            contacts,
            search: PushSearch::default(),
            without_contacts: [0; 2],
            last,
        }
    }

    /// With points about which the forces on solids have moments.
    #[must_use]
    pub fn with_moments(mut self, moments: &[MomentPoint<D>]) -> Self {
        self.about = moments::points(moments, self.about.len(), ForcedPart::Solid);
        self
    }

    /// Moments of nodal forces [N] on each solid, which act where the mesh was cut [N m].
    fn moments(&self, nodal: &[Vector<D>]) -> Vec<Vector<3>> {
        let places = self.structure.positions(&self.last.predicted);
        let of = |(solid, about): (usize, &Option<Vector<D>>)| {
            let about = about.unwrap_or_default();
            self.structure.nodes_of(solid).map(|a| moments::moment(places[a] - about, nodal[a])).sum()
        };
        self.about.iter().enumerate().map(of).collect()
    }

    /// Cuts the mesh at the surface that the solids had in the last step, and gives the nodes inside their velocity.
    pub fn immerse<const N: usize>(&self, system: &mut VelocityPressureSystem<D, N>) {
        let velocity = &self.structure.state.velocity;
        let immersed = Immersed::new(self.cut(&system.mesh, &self.surface()), velocity, velocity.clone(), None);
        immersed.extend(|node| velocity[node], &mut system.velocity);
        system.immerse(immersed);
    }

    /// The predicted surface.
    fn surface(&self) -> SolidSurface<D> {
        SolidSurface::new(&self.structure.meshes(), &self.structure.positions(&self.last.predicted))
    }

    /// The mesh cut at a surface, and the points of that.
    fn cut<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        surface: &SolidSurface<D>,
    ) -> (SolidCut<D, N>, SurfaceTrace<D, N>) {
        let conditions: Vec<SurfaceCondition> = self.structure.setups().iter().map(|setup| setup.surface).collect();
        let cut = SolidCut::new(mesh, surface, &conditions);
        let is_elastic = |node: u32| self.structure.is_elastic(node);
        let trace = SurfaceTrace::new(mesh, &self.touching.locator, surface, &cut, is_elastic);
        (cut, trace)
    }

    /// Predicts the displacement u* at the end of a step, makes the equations of the solids about it, and cuts the mesh at their surface
    /// (theory J.1, J.2).
    ///
    /// # Errors
    /// An element of a solid turns inside out; supports that a rigid solid can't follow; solids go through each other.
    pub fn predict<const N: usize>(
        &mut self,
        step: TimeStep,
        history: &TimeHistory<D>,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<(), StepError> {
        let (shares, weights) = match self.last.backward_steps {
            0 => (history.shares(step), history.convecting_weights(step)),
            _ => (StepShares::backward_euler(step.dt), [1.0, 0.0, 0.0]),
        };
        let prediction = self.structure.predict(step.end(), shares, weights)?;
        (self.last.solutions, self.first) = (1, None);
        self.linearise(self.own(step), prediction, system)
    }

    /// The step as solids make it.
    fn own(&self, step: TimeStep) -> TimeStep {
        if self.last.backward_steps > 0 { TimeStep { theta: 1.0, ..step } } else { step }
    }

    /// True if a step is to be solved anew after the solution that the system has found: with other contacts, or about the displacement to which
    /// its velocities lead, where that is far from u*, or nearer to something than the gap, or where an impact is to be made by backward Euler
    /// (theory (J.3a), J.8).
    ///
    /// # Errors
    /// As [`SolidTracking::predict`].
    pub fn predict_again<const N: usize>(
        &mut self,
        step: TimeStep,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<bool, StepError> {
        let (Some(immersed), Some(prediction)) = (&system.immersed, &self.prediction) else { return Ok(false) };
        let independent = immersed.independent.clone();
        let velocity = prediction.velocities.nodal_vectors(&independent);
        let most = if self.touches() { REPETITIONS_IN_CONTACT } else { REPETITIONS };
        let is_last = self.last.solutions > most;
        let again = self.corrects_contacts((&velocity, &independent), is_last, system)
            || self.corrects_prediction(step, (&velocity, &independent), is_last, system)?;
        self.last.solutions += usize::from(again);
        Ok(again)
    }

    /// Lets other contacts act in the equations of the step where some pull or lack in a solution with these velocities of nodes [m/s].
    fn corrects_contacts<const N: usize>(
        &mut self,
        (velocity, independent): (&[Vector<D>], &[f64]),
        is_last: bool,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> bool {
        self.last.has_wrong_contacts = self.has_wrong_contacts(velocity);
        if is_last || !self.last.has_wrong_contacts {
            return false;
        }
        let equations = system.immersed.as_mut().and_then(|immersed| immersed.equations.as_mut());
        equations.is_some_and(|equations| self.change_contacts((velocity, independent), equations))
    }

    /// Takes the displacement to which the velocities of nodes lead, the independent ones beside them [m/s], as prediction, where that is to be.
    ///
    /// # Errors
    /// As [`SolidTracking::predict`].
    fn corrects_prediction<const N: usize>(
        &mut self,
        step: TimeStep,
        (velocity, independent): (&[Vector<D>], &[f64]),
        is_last: bool,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<bool, StepError> {
        let Some(prediction) = &self.prediction else { return Ok(false) };
        let own = self.own(step);
        let mut found = self.structure.corrected(own.delta(), prediction, independent);
        let places = [&found, prediction].map(|end| self.structure.positions(&end.displacement));
        let off = self.touching.largest_error(&system.mesh, [&places[0], &places[1]]);
        let is_near = off <= if self.first.is_none() { FAR } else { SETTLED };
        let keeps_gap = !self.touches() || self.depth_without_contact(&places[0], &system.mesh)? <= DEPTH;
        let is_impact = own.theta < 1.0 && self.is_unresolved_impact(own, velocity);
        self.last.unsettled = if is_near { 0.0 } else { off };
        if is_last || is_near && keeps_gap && !is_impact {
            return Ok(false);
        }
        if is_impact {
            self.last.backward_steps = BACKWARD_STEPS;
            let Prediction { displacement, found: correction, .. } = found;
            let hats = self.structure.predict(step.end(), StepShares::backward_euler(step.dt), [1.0, 0.0, 0.0])?;
            found = Prediction { displacement, found: correction, ..hats };
        }
        self.first.get_or_insert_with(|| prediction.displacement.clone());
        self.linearise(self.own(step), found, system)?;
        Ok(true)
    }

    /// Makes the equations of the solids about a prediction, and cuts the mesh at their surface.
    ///
    /// # Errors
    /// As [`SolidTracking::predict`].
    fn linearise<const N: usize>(
        &mut self,
        step: TimeStep,
        prediction: Prediction<D>,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<(), StepError> {
        let gravity = |x: Vector<D>| Vector::from_fn(|i| system.physics.gravity[i].value(x.to3(), step.end()));
        let mut equations = self.structure.equations(step.end(), step.delta(), &prediction, gravity)?;
        self.last.predicted.clone_from(&prediction.displacement);
        let surface = self.surface();
        self.touch(step, &prediction, (&system.mesh, &surface), &mut equations)?;
        let is_held = |node: usize| (node * D..(node + 1) * D).any(|k| equations.velocities.is_prescribed(k));
        let held: Vec<bool> = (0..self.structure.node_count()).map(is_held).collect();
        let (cut, trace) = self.cut(&system.mesh, &surface);
        self.follow_pressure((step, &prediction), (&surface, &cut, &trace), system, &mut equations);
        let hat = prediction.velocity_hat.clone();
        system.immersed = Some(Immersed::new((cut, trace), &self.structure.state.velocity, hat, Some(equations)));
        check_boundary(system, &held)?;
        self.prediction = Some(prediction);
        Ok(())
    }

    /// Adds the change of the forces of the fluid as the surface moves on from u* under the pressure of the last step (theory (J.9b)).
    fn follow_pressure<const N: usize>(
        &mut self,
        (step, prediction): (TimeStep, &Prediction<D>),
        (surface, cut, trace): (&SolidSurface<D>, &SolidCut<D, N>, &SurfaceTrace<D, N>),
        system: &VelocityPressureSystem<D, N>,
        equations: &mut SolidEquations,
    ) {
        let Some(immersed) = &system.immersed else { return };
        let pressure = FluidPressure::new(&system.mesh, immersed, &system.pressure);
        let places = self.structure.positions(&prediction.displacement);
        let mut stiffness = self.structure.zero_matrix();
        pressure.stiffness((cut, trace), (surface, &places), |nodes, slope| {
            self.structure.add_block(&mut stiffness, nodes, &slope);
        });
        let rest = self.structure.way(prediction, |a| prediction.displacement_hat[a]);
        let forces = self.structure.product(&stiffness, &rest);
        equations.rhs.iter_mut().zip(forces.iter().flat_map(|force| force.0)).for_each(|(rhs, force)| *rhs += force);
        let all = equations.matrix.values.iter_mut().zip(&stiffness.values);
        all.for_each(|(value, slope)| *value -= step.delta() * slope);
        self.pressure_stiffness = Some(stiffness);
    }

    /// Takes the velocity that the system has found for the end of the step.
    ///
    /// # Errors
    /// An element of a solid is turned inside out.
    pub fn advance<const N: usize>(
        &mut self,
        step: TimeStep,
        shares: StepShares,
        system: &VelocityPressureSystem<D, N>,
    ) -> Result<(), StepError> {
        let (Some(immersed), Some(prediction)) = (&system.immersed, self.prediction.take()) else { return Ok(()) };
        let step = self.own(step);
        self.last.backward_steps = self.last.backward_steps.saturating_sub(1);
        self.structure.advance(step.delta(), &prediction, &immersed.independent);
        let mut nodal = immersed.forces(&system.mesh, &system.unknowns);
        let [gravity, supports] = self.structure.powers(step, &prediction, immersed, &nodal, &system.physics.gravity);
        if let Some(stiffness) = self.pressure_stiffness.take() {
            let way = self.structure.way(&prediction, |a| self.structure.state.displacement[a]);
            let more = self.structure.product(&stiffness, &way);
            nodal.iter_mut().zip(more).for_each(|(force, more)| *force += more);
        }
        let imbalance = self.structure.linearisation_error(step, &prediction)?;
        self.keep_contacts();
        let powers = [gravity, supports + self.end_impulses(step, &prediction)];
        self.last.energies = energies(&self.structure, powers)?;
        self.last.imbalance = imbalance;
        let first = self.first.as_ref().unwrap_or(&self.last.predicted);
        let places = [&self.structure.state.displacement, first].map(|u| self.structure.positions(u));
        self.last.off = self.touching.largest_error(&system.mesh, [&places[0], &places[1]]);
        self.last.add_forces(self.structure.sums(&nodal), shares);
        self.last.moments.update(self.moments(&nodal), shares);
        self.last.nodal = nodal;
        Ok(())
    }

    /// State at the start of a step.
    pub fn start(&self) -> SolidStart<D> {
        SolidStart { state: self.structure.state.clone(), last: self.last.clone() }
    }

    /// Takes the state at the start of a predicted first step, and the step before it from its end: a⁰ = a¹, v⁻¹ = 2 v⁰ − v¹
    /// (theory H.9).
    pub fn restart(&mut self, SolidStart { mut state, last }: SolidStart<D>) {
        state.begin(&self.structure.state);
        let forces = std::mem::take(&mut self.last.forces);
        let [contact, touch, nodal] =
            [&mut self.last.contact, &mut self.last.touch, &mut self.last.nodal].map(std::mem::take);
        let mut moments = last.moments;
        moments.begin(std::mem::take(&mut self.last.moments.last));
        self.last = SolidStep { forces_earlier: forces.clone(), forces, moments, contact, touch, nodal, ..last };
        self.structure.state = state;
    }

    /// Energies with which a run begins in the present state [J].
    ///
    /// # Errors
    /// An element is turned inside out.
    pub fn open_energies(&mut self) -> Result<SolidEnergies, StepError> {
        let none = vec![Vector::ZERO; self.last.forces.len()];
        let SolidStep { predicted, contact, touch, mut nodal, .. } = std::mem::take(&mut self.last);
        nodal.fill(Vector::ZERO);
        let energies = energies(&self.structure, [0.0; 2])?;
        let (forces_earlier, forces_mean) = (none.clone(), none.clone());
        self.last = SolidStep {
            predicted,
            nodal,
            moments: Moments::none(none.len()),
            contact,
            touch,
            energies,
            forces: none,
            forces_earlier,
            forces_mean,
            imbalance: 0.0,
            off: 0.0,
            solutions: 0,
            unsettled: 0.0,
            has_wrong_contacts: false,
            backward_steps: 0,
        };
        Ok(energies)
    }

    /// Forgets the steps before.
    pub fn clear_history(&mut self) {
        self.structure.state.clear_history();
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

/// Energies of a structure [J], with these powers of gravity and of supports [W].
///
/// # Errors
/// An element is turned inside out.
fn energies<const D: usize>(structure: &Structure<D>, powers: [f64; 2]) -> Result<SolidEnergies, StepError> {
    let [gravity, supports] = powers;
    let (kinetic, strain) = (structure.kinetic_energy(), structure.strain_energy()?);
    Ok(SolidEnergies { kinetic, strain, gravity, supports })
}

impl<const D: usize> SolidStep<D> {
    fn add_forces(&mut self, now: Vec<Vector<D>>, shares: StepShares) {
        let all = self.forces_earlier.iter().zip(&self.forces).zip(&now);
        let mean = |((f0, f1), f2): ((&Vector<D>, &Vector<D>), &Vector<D>)| {
            *f0 * shares.earlier + *f1 * shares.start + *f2 * shares.end
        };
        self.forces_mean = all.map(mean).collect();
        self.forces_earlier = std::mem::replace(&mut self.forces, now);
    }
}
