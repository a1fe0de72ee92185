//! The step: particles carry what moves, the fixed mesh solves the rest, all fluids in one system
//! (Becker, Idelsohn & Oñate 2015; theory F.2).
//!
//! ```text
//! paper         x_p along vⁿ for Δt                          M (vⁿ⁺¹ − v̂)/Δt = forces(vⁿ⁺¹, pⁿ⁺¹)
//! second order  v_p += Δt (β₁ aⁿ + β₂ aⁿ⁻¹)                  explicit part, before the particle moves
//!               x_p along v* = vⁿ + ½Δt (vⁿ − vⁿ⁻¹)/Δtⁿ      the velocity at the middle of the step
//!               M (vⁿ⁺¹ − v̂)/(θΔt) = forces(vⁿ⁺¹, pⁿ⁺¹)      implicit part, aⁿ⁺¹ = (vⁿ⁺¹ − v̂)/(θΔt)
//!               β₂ = (θ − ½) Δt/Δtⁿ,   β₁ = 1 − θ − β₂
//! ```
//!
//! The second integrates forces along the paths of the particles: each acceleration is taken where the particle is at
//! its time, and vⁿ⁺¹ is free of divergence at the time and place at which it is shown. aⁿ⁻¹ is carried to where the
//! particles are now by tracing the nodes back. At θ = ½ these are the trapezoidal rule (theory F.2); with it, what
//! the nodes take from the particles comes back with the opposite sign, and noise never dies. θ = 9/16 are the weights
//! of Ascher, Ruuth & Wetton (1995); all θ ≥ ½ are A-stable and of second order. The first step is predicted (see
//! `startup.rs`). All of it is linear: convection and geometry come from the particles.

mod equilibrium;
mod startup;

use crate::error::StepError;
use crate::linalg::SolverState;
use crate::math::Vector;
use crate::pfem2::balance::forces::BoundaryForces;
use crate::pfem2::balance::strain::StrainEnergy;
use crate::pfem2::balance::{EnergyBalance, SolidsAtStart};
use crate::pfem2::boundary::Boundary;
use crate::pfem2::checks::health;
use crate::pfem2::checks::notices::Notices;
use crate::pfem2::equations::system::{Physics, VelocityPressureSystem};
use crate::pfem2::history::TimeHistory;
use crate::pfem2::particles::project::ConvectedVelocity;
use crate::pfem2::phases::phase_list::PhaseList;
use crate::pfem2::setup::{InitialState, Setup};
use crate::pfem2::theta_step::ThetaStep;
use crate::pfem2::time::step_bounds::StepLimits;
use crate::pfem2::tracking::interface::InterfaceTracking;
use crate::pfem2::tracking::particles::ParticleTracking;
use crate::pfem2::tracking::solids::SolidTracking;
use crate::pfem2::tracking::transport::FrozenFlow;
use crate::simulation::Timer;
use crate::timed;
use startup::impulsive_energy;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// PFEM-2 in `D` dimensions on simplices with `N` = `D` + 1 nodes.
pub struct Pfem2<const D: usize, const N: usize> {
    /// Velocity and pressure on the mesh.
    pub(super) system: VelocityPressureSystem<D, N>,
    /// Particles that carry velocity and fluid.
    pub(super) particles: ParticleTracking<D>,
    /// Interfaces between the fluids.
    pub(super) interface: InterfaceTracking<D>,
    /// Solids in the fluid.
    pub(super) solids: Option<SolidTracking<D>>,
    /// State with which the run begins.
    pub(super) start: InitialState,
    /// Velocities and accelerations of the steps before.
    pub(super) history: TimeHistory<D>,
    /// Forces of the fluid on the boundary.
    pub(super) forces: BoundaryForces<D>,
    /// Energy, and the checks against it.
    pub(super) balance: EnergyBalance<D>,
    /// Bounds of the length of steps.
    pub(super) limits: StepLimits,
    /// Notices for the user.
    pub(super) notices: Notices,
    /// Places of the nodes, for outputs [m].
    pub(super) places: Vec<[f64; 3]>,
    /// Steps since the start.
    pub(super) steps: u64,
    /// State of the linear solver, while a checkpoint is written or read.
    pub(super) solver_state: SolverState,
    pub(super) timer: Timer,
    /// True once the run is asked to stop.
    pub(super) stop: Arc<AtomicBool>,
}

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// The state at the start.
    pub fn new(setup: Setup<D, N>) -> Self {
        let volume = setup.volume;
        let mut pfem = Self::unopened(setup);
        if let Some(solids) = &pfem.solids {
            solids.immerse(&mut pfem.system);
        }
        pfem.interface.project(&pfem.system, &pfem.particles.columns, pfem.particles.rules.kernel);
        pfem.update_contents();
        pfem.notices = Notices::of_the_start(&pfem.system, &pfem.particles.columns, &pfem.interface.fraction);
        pfem.interface.begin_inflow(&pfem.system);
        pfem.interface.keep_volumes(&pfem.system, volume);
        pfem.begin_interface();
        let solids = pfem
            .solids
            .as_ref()
            .map(|solids| SolidsAtStart { energies: solids.last.energies, mass: solids.structure.mass() });
        pfem.balance.open(&pfem.system, impulsive_energy(&pfem.system), solids);
        pfem.balance.strain = pfem.particles.strain_energy(&pfem.system).map(StrainEnergy::open);
        if let Some(solids) = &mut pfem.system.particle_solids {
            solids.start_volume = pfem.system.contents.volumes[solids.first..].iter().sum();
        }
        pfem
    }

    /// The parts of the solver, before anything is averaged or counted.
    fn unopened(setup: Setup<D, N>) -> Self {
        let (rules, phases) = (setup.particle_rules(), setup.phases());
        let Setup { mesh, boundaries, fluids, tension, gravity, velocity, moments, .. } = setup;
        let (stabilisation, mass, enrichment) = (setup.stabilisation, setup.mass, setup.enrichment);
        let down = Vector::from_fn(|i| gravity[i].value([0.0; 3], 0.0));
        let boundary = Boundary::new(&mesh, boundaries, down).pinned(&mesh, setup.pin.as_ref());
        let physics = Physics { fluids, tension, gravity, mass, stabilisation, enrichment };
        let places: Vec<[f64; 3]> = mesh.nodes().iter().map(|x| x.to3()).collect();
        let system = VelocityPressureSystem::new(mesh, boundary, physics, velocity, setup.linear)
            .with_particle_solids(setup.particle_solids);
        let tracked = |solids| SolidTracking::new(solids, &system.mesh, &system.boundary).with_moments(&moments);
        Self {
            particles: ParticleTracking::new(system.with_columns(setup.particles), rules),
            interface: InterfaceTracking::new(PhaseList::new(phases), setup.level_set),
            solids: setup.solids.map(tracked),
            start: setup.start,
            history: TimeHistory::new(setup.scheme, &system.velocity),
            forces: BoundaryForces::new(&system, &moments),
            balance: EnergyBalance::new(places.len()),
            limits: StepLimits::new(setup.scheme, setup.courant, setup.step_tolerance),
            notices: Notices::default(),
            places,
            steps: 0,
            solver_state: SolverState::default(),
            timer: Timer::default(),
            stop: Arc::default(),
            system,
        }
    }

    /// Shows a sharp interface as the particles show it, from the start on: averages round the corners of a shape, and
    /// the volume that this takes comes back elsewhere. In the first step that would be energy from nothing.
    fn begin_interface(&mut self) {
        if self.interface.sharp.is_some() {
            self.interface.follow(&self.system, &mut self.particles.columns, &mut self.notices);
            self.interface.project(&self.system, &self.particles.columns, self.particles.rules.kernel);
            self.update_contents();
        }
    }

    /// The step of the method.
    pub(super) fn advance(&mut self, step: ThetaStep) -> Result<(), StepError> {
        // Turn the stresses of solids on particles: Becker (16), theory (K.3).
        timed!(self.timer, "solids", self.particles.rotate_stresses(step, &self.system));
        // Predict u* of solids, and cut the mesh at their surface: theory J.1, J.2.
        timed!(self.timer, "solids", self.predict_solids(step)?);
        // v_p += Δt (β₁ aⁿ + β₂ aⁿ⁻¹), the explicit part: theory (F.3).
        let (history, system, interface) = (&self.history, &self.system, &self.interface);
        timed!(self.timer, "explicit", self.particles.accelerate(step, history, system, interface));
        // Convect, along the streamlines of v*: Becker (34)–(36), theory (F.4).
        let flow = timed!(self.timer, "convect", self.particles.convect(step, history, system, interface));
        // Reseed: theory G.12.
        timed!(self.timer, "convect", self.particles.reseed(&flow, system, interface));
        // Volumes that leave, aⁿ⁻¹, vⁿ and viscous forces go along with the flow: theory G.6, F.2, F.7.2.
        timed!(self.timer, "convect", self.carry_along(&flow, step));
        // φ follows the particles and keeps its volume: theory G.2–G.6.
        let (system, particles) = (&self.system, &mut self.particles);
        timed!(self.timer, "interface", self.interface.follow(system, &mut particles.columns, &mut self.notices));
        self.history.keep_velocity(&self.system.velocity);
        // Project v̂ and φ: Becker (37)–(39), theory G.11. Solve for v and p, enriched pressures condensed:
        // Becker (20), (29)–(33), theory F.6, G.8.
        let (averaged, convected) = self.find_velocity(step, 1)?;
        // Keep the accelerations of the subscales, ã ← (ũ − ũ̂)/Δ, for the next step: theory F.7.4.
        self.system.subscales.dynamic.keep_acceleration(step.delta());
        // Solids take their velocity: u, a and the forces on them, theory J.1.
        timed!(self.timer, "solids", self.advance_solids(step)?);
        // Particles of solids take the increments of stress and pressure: Becker (15), theory (K.2).
        let (system, interface) = (&self.system, &self.interface);
        timed!(self.timer, "solids", self.particles.update_stresses(step, &averaged, system, interface)?);
        // Correct, v_p += Σ N_i (v_i − v̂_i): Becker (40), theory F.11.
        timed!(self.timer, "correct", self.particles.correct(step, &averaged, system, interface));
        self.history.keep_acceleration(step, &self.system.velocity, &convected);
        timed!(self.timer, "account", self.account(step, &convected));
        // Forces on solids on particles, their strain energy and the work of their supports: theory K.6.
        timed!(self.timer, "account", self.account_for_particle_solids(step, &convected));
        health::check_particles(&self.particles.columns)?;
        health::check_nodes(&self.system)
    }

    /// Projects, and solves the system as often as given: velocity and pressure at the end of a step, with the solids.
    /// All of it anew about where the solids come to, where that is far from u* (theory (J.3a)). Returns the averages
    /// of the particles at the nodes, and v̂ [m/s].
    ///
    /// # Errors
    /// The linear solver doesn't converge; an element of a solid turns inside out.
    pub(super) fn find_velocity(
        &mut self,
        step: ThetaStep,
        solutions: usize,
    ) -> Result<(ConvectedVelocity<D>, Vec<Vector<D>>), StepError> {
        let (start, subscales) = (self.system.velocity.clone(), self.system.subscales.clone());
        let mut iterations = 0;
        let found = loop {
            let (system, particles) = (&self.system, &self.particles);
            let averaged = timed!(
                self.timer,
                "project",
                self.interface.project(system, &particles.columns, particles.rules.kernel)
            );
            timed!(self.timer, "project", self.average_particle_solids());
            let convected = self.system.imposed(step, &averaged.mean);
            for _ in 0..solutions {
                timed!(self.timer, "solve", self.system.solve(step, &self.interface.phases(), &convected)?);
                iterations += self.system.linear.outcome.iterations;
            }
            if !timed!(self.timer, "solids", self.predict_again(step)?) {
                break (averaged, convected);
            }
            self.system.restart(&start, &subscales);
        };
        self.system.linear.outcome.iterations = iterations;
        Ok(found)
    }

    /// Predicts the solids and cuts the mesh at their surface.
    ///
    /// # Errors
    /// An element of a solid turns inside out.
    pub(super) fn predict_solids(&mut self, step: ThetaStep) -> Result<(), StepError> {
        let Some(solids) = &mut self.solids else { return Ok(()) };
        solids.predict(step, &self.history, &mut self.system)
    }

    /// Cuts the mesh where the velocity that the system has found leads the solids, if that is far from their
    /// prediction; returns true if it is.
    ///
    /// # Errors
    /// As [`Self::predict_solids`].
    fn predict_again(&mut self, step: ThetaStep) -> Result<bool, StepError> {
        let Some(solids) = &mut self.solids else { return Ok(false) };
        solids.predict_again(step, &mut self.system)
    }

    /// Gives the solids the velocity that the system has found.
    ///
    /// # Errors
    /// An element of a solid is turned inside out.
    pub(super) fn advance_solids(&mut self, step: ThetaStep) -> Result<(), StepError> {
        let step_weights = self.history.step_weights(step);
        let Some(solids) = &mut self.solids else { return Ok(()) };
        solids.advance(step, step_weights, &self.system)
    }

    /// Counts what leaves with the flow, and takes the nodal values of the last step to where their fluid is now.
    pub(super) fn carry_along(&mut self, flow: &FrozenFlow<D>, step: ThetaStep) {
        self.interface.count_outflow(flow, &self.system);
        self.system.carry_subscales(step, self.history.step_weights(step));
        let feet = flow.feet(&self.system);
        let mesh = &self.system.mesh;
        self.history.acceleration_previous = feet.carried(mesh, &self.history.acceleration);
        // Before the first step walls and inlets take hold of their nodes.
        let start = (self.steps == 0).then(|| self.system.held_velocity(step.t));
        self.balance.dissipation.start = feet.carried(mesh, start.as_ref().unwrap_or(&self.system.velocity));
        if self.system.physics.stabilisation.has_inertia() {
            let carried = feet.carried(mesh, &self.system.subscales.projected);
            self.system.subscales.projected = carried;
        }
    }

    /// Forces on the boundary, and the energy balance.
    fn account(&mut self, step: ThetaStep, convected: &[Vector<D>]) {
        let Self { system, interface, forces, balance, .. } = self;
        let step_weights = self.history.step_weights(step);
        let action = forces.update(system, step, convected, step_weights);
        interface.trace(system);
        if let (Some(energy), Some(solids)) = (&mut balance.solids, &self.solids) {
            energy.add(step_weights, solids.last.energies);
        }
        balance.add(step_weights, self.steps == 0, system, interface, action);
    }

    /// Forces of the fluid on solids on particles, the watch over their volume, and their energy.
    fn account_for_particle_solids(&mut self, step: ThetaStep, convected: &[Vector<D>]) {
        self.system.find_forces_on_particle_solids(step, convected);
        let volumes = self.system.particle_solid_volumes();
        volumes.iter().for_each(|&[now, start]| self.notices.solid_volume(now, start));
        let supports = step.dt * self.system.power_of_supports(step, convected);
        if let (Some(now), Some(strain)) = (self.particles.strain_energy(&self.system), &mut self.balance.strain) {
            strain.add(now, supports);
        }
    }

    /// Averages of solids on particles at the nodes and in the elements, those of new particles included.
    fn average_particle_solids(&mut self) {
        self.particles.admit_to_solids(&self.system);
        self.system.gather_particle_solids(&self.particles.columns, &self.interface.phases());
    }

    /// Updates what follows from the columns: contents of the elements, sums over the mesh, the interfaces as surfaces.
    pub(super) fn update_contents(&mut self) {
        self.average_particle_solids();
        self.system.fill(&self.interface.phases(), &self.history.velocity_previous);
        self.balance.sum(&self.system);
        self.interface.trace(&self.system);
    }
}
