//! The solids of a run in the steps of the fluid: their prediction cuts the mesh, and they take the velocity of the system (theory J.1).

use super::bodies::quadrilaterals;
use super::cut::SolidCut;
use super::equations::SolidEquations;
use super::immersed::Immersed;
use super::setup::SurfaceCondition;
use super::structure::{Prediction, SolidState, Structure};
use super::surface::SolidSurface;
use super::walls::{WallContact, WallContacts};
use crate::error::StepError;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::boundary::Boundary;
use crate::pfem2::equations::system::{TimeStep, VelocityPressureSystem};
use crate::pfem2::report::solids::SolidEnergies;
use crate::pfem2::time::history::{StepShares, TimeHistory};

/// The solids of a run.
#[derive(Debug)]
pub(in crate::pfem2) struct SolidTracking<const D: usize> {
    /// Their meshes, laws and state.
    pub structure: Structure<D>,
    /// The elements of each as simple ones, for pictures.
    pub outlines: Vec<Vec<[u32; 4]>>,
    /// Contact with walls.
    walls: WallContacts<D>,
    /// Prediction of the step that is being made.
    prediction: Option<Prediction<D>>,
    /// Its contacts.
    contacts: Vec<WallContact<D>>,
    /// Results of the last step.
    pub last: SolidStep<D>,
}

/// Results of a step.
#[derive(Debug, Clone, Default)]
pub(in crate::pfem2) struct SolidStep<const D: usize> {
    /// Predicted displacement u* [m]: the surface that cut the mesh.
    pub predicted: Vec<Vector<D>>,
    /// Forces of the fluid on each solid at its end [N].
    pub forces: Vec<Vector<D>>,
    /// The same at the end of the step before [N].
    pub forces_earlier: Vec<Vector<D>>,
    /// Means over the step, with the shares that it takes of each [N].
    pub forces_mean: Vec<Vector<D>>,
    /// Normal force of walls on each node at its end [N].
    pub contact: Vec<f64>,
    /// Energies at its end, and powers from outside.
    pub energies: SolidEnergies,
    /// Force that quasi-static solids were off balance by at its end, over the largest.
    pub imbalance: f64,
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
        let last = SolidStep {
            predicted: structure.state.displacement.clone(),
            forces: none.clone(),
            forces_earlier: none.clone(),
            forces_mean: none,
            contact: vec![0.0; structure.node_count()],
            // Elements that are turned inside out are found by the first step.
            energies: energies(&structure, [0.0; 2]).unwrap_or_default(),
            imbalance: 0.0,
        };
        let outlines = structure.setups().iter().map(|setup| quadrilaterals(&setup.mesh)).collect();
        let walls = WallContacts::new(&structure, mesh, boundary);
        Self { structure, outlines, walls, prediction: None, contacts: Vec::new(), last }
    }

    /// Cuts the mesh at the surface that the solids had in the last step, and gives the nodes inside their velocity.
    pub fn immerse<const N: usize>(&self, system: &mut VelocityPressureSystem<D, N>) {
        self.cut(system, self.structure.state.velocity.clone(), None);
        if let Some(immersed) = &system.immersed {
            immersed.extend(|node| self.structure.state.velocity[node], &mut system.velocity);
        }
    }

    fn cut<const N: usize>(
        &self,
        system: &mut VelocityPressureSystem<D, N>,
        velocity_hat: Vec<Vector<D>>,
        equations: Option<SolidEquations>,
    ) {
        let positions = self.structure.positions(&self.last.predicted);
        let surface = SolidSurface::new(&self.structure.meshes(), &positions);
        let conditions: Vec<SurfaceCondition> = self.structure.setups().iter().map(|setup| setup.surface).collect();
        let cut = SolidCut::new(&system.mesh, &surface, &conditions);
        system.immersed = Some(Immersed::new(cut, &self.structure.state.velocity, velocity_hat, equations));
    }

    /// Predicts the displacement u* at the end of a step, makes the equations of the solids about it, and cuts the mesh at their surface
    /// (theory J.1, J.2).
    ///
    /// # Errors
    /// An element of a solid turns inside out.
    pub fn predict<const N: usize>(
        &mut self,
        step: TimeStep,
        history: &TimeHistory<D>,
        system: &mut VelocityPressureSystem<D, N>,
    ) -> Result<(), StepError> {
        let (shares, weights) = (history.shares(step), history.convecting_weights(step));
        let prediction = self.structure.predict(step.end(), shares, weights);
        let gravity = |x: Vector<D>| Vector::from_fn(|i| system.physics.gravity[i].value(x.to3(), step.end()));
        let mut equations = self.structure.equations(step.end(), step.delta(), &prediction, gravity)?;
        self.touch_walls(step, &prediction, &mut equations);
        self.last.predicted.clone_from(&prediction.displacement);
        let held: Vec<bool> = equations.held.chunks(D).map(|axes| axes.iter().any(Option::is_some)).collect();
        self.cut(system, prediction.velocity_hat.clone(), Some(equations));
        check_boundary(system, &held)?;
        self.prediction = Some(prediction);
        Ok(())
    }

    /// Adds the contacts of a step to its equations.
    fn touch_walls(&mut self, step: TimeStep, prediction: &Prediction<D>, equations: &mut SolidEquations) {
        let Self { structure, walls, last, .. } = self;
        let Prediction { displacement_hat, displacement, .. } = prediction;
        let [start, hat, predicted] = [&structure.state.displacement, displacement_hat, displacement]
            .map(|displacement| |a: usize| structure.place(a) + displacement[a]);
        let both = structure.state.velocity.iter().zip(&structure.state.velocity_previous);
        let velocity: Vec<Vector<D>> = both.map(|(now, before)| *now * 2.0 - *before).collect();
        self.contacts = walls.of_step([step.dt, step.delta()], [&start, &hat, &predicted], &velocity, &last.contact);
        for contact in &self.contacts {
            structure.add_block(&mut equations.matrix, (contact.node, contact.node), &contact.matrix());
            let rows = equations.rhs[contact.node as usize * D..].iter_mut();
            rows.zip(contact.load().0).for_each(|(row, load)| *row += load);
        }
    }

    /// Forces of the walls at the end of a step: keeps the normal ones, and returns their power [W].
    fn release_walls(&mut self) -> f64 {
        self.last.contact.fill(0.0);
        let mut power = 0.0;
        for contact in &self.contacts {
            let node = contact.node as usize;
            let velocity = self.structure.state.velocity[node];
            let (force, normal) = contact.force(velocity);
            self.last.contact[node] += normal;
            power += force.dot(velocity);
        }
        power
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
        let (Some(immersed), Some(prediction)) = (&system.immersed, &self.prediction) else { return Ok(()) };
        let nodes = self.structure.node_count();
        let velocity = (0..nodes).map(|a| immersed.velocity_of(a)).collect();
        self.structure.advance(step.delta(), prediction, velocity);
        let nodal = immersed.forces(&system.mesh, &system.unknowns);
        let [gravity, supports] = self.structure.powers(step, prediction, immersed, &nodal, &system.physics.gravity);
        let imbalance = self.structure.linearisation_error(prediction)?;
        let powers = [gravity, supports + self.release_walls()];
        self.last.energies = energies(&self.structure, powers)?;
        self.last.imbalance = imbalance;
        self.last.add_forces(self.structure.sums(&nodal), shares);
        Ok(())
    }

    /// State at the start of a step.
    pub fn start(&self) -> SolidStart<D> {
        SolidStart { state: self.structure.state.clone(), last: self.last.clone() }
    }

    /// Takes the state at the start of a predicted first step, and the step before it from its end: a⁰ = a¹, v⁻¹ = 2 v⁰ − v¹
    /// (theory H.9).
    pub fn restart(&mut self, SolidStart { mut state, last }: SolidStart<D>) {
        let end = &self.structure.state;
        let both = || state.velocity.iter().zip(&end.velocity);
        let previous = both().map(|(start, end)| *start * 2.0 - *end).collect();
        let earlier = both().map(|(start, end)| *start * 3.0 - *end * 2.0).collect();
        (state.velocity_previous, state.velocity_earlier) = (previous, earlier);
        state.acceleration.clone_from(&end.acceleration);
        state.acceleration_previous.clone_from(&end.acceleration);
        let forces = std::mem::take(&mut self.last.forces);
        let contact = std::mem::take(&mut self.last.contact);
        self.last = SolidStep { forces_earlier: forces.clone(), forces, contact, ..last };
        self.structure.state = state;
    }

    /// Brings the solids to rest where they are.
    pub fn rest(&mut self) {
        let displacement = self.structure.state.displacement.clone();
        let zero = vec![Vector::ZERO; displacement.len()];
        self.structure.state = SolidState { displacement, ..SolidState::new(zero) };
    }

    /// Energies with which a run begins in the present state [J].
    ///
    /// # Errors
    /// An element is turned inside out.
    pub fn open_energies(&mut self) -> Result<SolidEnergies, StepError> {
        let none = vec![Vector::ZERO; self.last.forces.len()];
        let SolidStep { predicted, contact, .. } = std::mem::take(&mut self.last);
        let energies = energies(&self.structure, [0.0; 2])?;
        let (forces_earlier, forces_mean) = (none.clone(), none.clone());
        self.last =
            SolidStep { predicted, contact, energies, forces: none, forces_earlier, forces_mean, imbalance: 0.0 };
        Ok(energies)
    }

    /// Forgets the steps before.
    pub fn clear_history(&mut self) {
        let SolidState { displacement, velocity, .. } = &self.structure.state;
        let displacement = displacement.clone();
        self.structure.state = SolidState { displacement, ..SolidState::new(velocity.clone()) };
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
