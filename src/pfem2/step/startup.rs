//! The start: what the first step of second order would take from the one before it, and the pressure that is shown
//! (theory H.9).
//!
//! ```text
//! predictor   a step of backward Euler over the first step gives v¹, p¹, a¹; the particles go back to where they were
//! a⁰ ← a¹,  v⁻¹ ← 2 v⁰ − v¹,  π⁰ ← π¹         at the nodes, so that v* = ½ (v⁰ + v¹)
//! ```
//!
//! All three, and the forces that the first step's explicit part is booked with, are known up to O(Δt) at a fixed
//! place, which leaves an error of O(Δt²) in the first step; in a steady flow they are exact. Backward Euler instead
//! would turn vortices by an angle φ per step and take the part φ² of their energy at once. The projected pressure
//! gradient π of the stabilisation counts as much: with π⁰ = 0, fluid that accelerates would be as compressible in
//! the first step as with the paper's PSPG (theory F.7.1), and the pressure half of what it is.

use crate::error::StepError;
use crate::linalg::SolverState;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::Pfem2;
use crate::pfem2::ThetaStep;
use crate::pfem2::balance::forces::BoundaryForces;
use crate::pfem2::balance::ledger::EnergyLedger;
use crate::pfem2::checks::notices::Notices;
use crate::pfem2::element::Stabilisation;
use crate::pfem2::equations::subscale::Subscales;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::theta_step::Scheme;
use crate::pfem2::tracking::interface::InterfaceTracking;
use crate::pfem2::tracking::particles::ParticleTracking;
use crate::pfem2::tracking::solid_start::SolidStart;
use crate::pfem2::tracking::solids::SolidTracking;

/// Solutions of the predicted step: with τ ≈ Δt each halves what π lacks of the pressure gradient.
const SOLUTIONS: usize = 8;

/// The state at the start of a step: all that a step moves, and the notices, as a prediction tells the user nothing.
struct StartOfStep<const D: usize> {
    particles: ParticleTracking<D>,
    interface: InterfaceTracking<D>,
    solids: Option<SolidStart<D>>,
    /// Velocity at the nodes [m/s].
    velocity: Vec<Vector<D>>,
    /// Body force at the nodes [m/s²].
    force: Vec<Vector<D>>,
    notices: Notices,
}

impl<const D: usize> StartOfStep<D> {
    fn of<const N: usize>(pfem: &Pfem2<D, N>) -> Self {
        Self {
            particles: pfem.particles.clone(),
            interface: pfem.interface.clone(),
            solids: pfem.solids.as_ref().map(SolidTracking::start),
            velocity: pfem.system.velocity.clone(),
            force: pfem.system.force.clone(),
            notices: pfem.notices.clone(),
        }
    }

    /// Puts the state back; returns the velocity at the end of the step [m/s].
    fn restore<const N: usize>(self, pfem: &mut Pfem2<D, N>) -> Vec<Vector<D>> {
        (pfem.particles, pfem.interface) = (self.particles, self.interface);
        (pfem.system.force, pfem.notices) = (self.force, self.notices);
        let end = std::mem::replace(&mut pfem.system.velocity, self.velocity);
        if let (Some(solids), Some(start)) = (&mut pfem.solids, self.solids) {
            solids.restart(start);
            solids.immerse(&mut pfem.system);
        }
        end
    }
}

/// All but the pressure that a prediction leaves, of which a scheme of first order takes nothing.
struct BeforePrediction<const D: usize> {
    subscales: Subscales<D>,
    ledger: EnergyLedger,
    forces: BoundaryForces<D>,
    solver: SolverState,
    preconditioners: u64,
}

impl<const D: usize> BeforePrediction<D> {
    fn of<const N: usize>(pfem: &Pfem2<D, N>) -> Self {
        Self {
            subscales: pfem.system.subscales.clone(),
            ledger: pfem.balance.ledger,
            forces: pfem.forces.clone(),
            solver: pfem.system.linear.solver_state(),
            preconditioners: pfem.system.linear.preconditioners,
        }
    }

    fn restore<const N: usize>(self, pfem: &mut Pfem2<D, N>) {
        (pfem.system.subscales, pfem.system.linear.preconditioners) = (self.subscales, self.preconditioners);
        (pfem.balance.ledger, pfem.forces) = (self.ledger, self.forces);
        pfem.system.restore_solver(&self.solver);
    }
}

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Finds the pressure at the start, which is shown with it, by a prediction of the first step. A prediction that
    /// fails leaves the start as it is: the first step tells why.
    pub(in crate::pfem2) fn predict_start(&mut self, step: ThetaStep) {
        if self.history.scheme != Scheme::BackwardEuler {
            if self.predict_first_step(step).is_ok() {
                self.update_contents();
            }
            return;
        }
        // A step of first order takes nothing of it but the pressure, to begin its iterations with.
        let before = BeforePrediction::of(self);
        let _ = self.predict_first_step(step);
        self.clear_history();
        before.restore(self);
        self.update_contents();
    }

    /// Clears the step before the first.
    fn clear_history(&mut self) {
        self.history.clear(&self.system.velocity);
        if let Some(solids) = &mut self.solids {
            solids.clear_history();
        }
        self.system.subscales = Subscales::at_rest(&self.system.mesh, self.system.physics.stabilisation);
    }

    /// Predicts the first step, from which a step of second order takes the one before it. After an error the state is
    /// that before.
    ///
    /// # Errors
    /// As [`VelocityPressureSystem::solve`].
    pub(in crate::pfem2) fn predict_first_step(&mut self, step: ThetaStep) -> Result<(), StepError> {
        self.clear_history();
        let start = StartOfStep::of(self);
        let outcome = self.predictor_step(step);
        let end = start.restore(self);
        if let Err(error) = outcome {
            self.clear_history();
            self.system.pressure.fill(0.0);
            return Err(error);
        }
        self.history.extrapolate_backwards(step.dt, &self.system.velocity, &end);
        Ok(())
    }

    /// The stages of a step before its projection.
    pub(super) fn transport(&mut self, step: ThetaStep) {
        let flow = self.particles.convect(step, &self.history, &self.system, &self.interface);
        self.particles.reseed(&flow, &self.system, &self.interface);
        self.carry_along(&flow, step);
        self.interface.follow(&self.system, &mut self.particles.columns, &mut self.notices);
    }

    /// A step of backward Euler.
    fn predictor_step(&mut self, step: ThetaStep) -> Result<(), StepError> {
        self.predict_solids(step)?;
        self.transport(step);
        let solutions = if self.system.physics.stabilisation == Stabilisation::Oss { SOLUTIONS } else { 1 };
        let (_, convected) = self.find_velocity(step, solutions)?;
        self.advance_solids(step)?;
        self.system.subscales.dynamic.keep_acceleration(step.delta());
        self.system.subscales.begin_average();
        self.history.keep_acceleration(step, &self.system.velocity, &convected);
        self.history.acceleration_previous.copy_from_slice(&self.history.acceleration);
        let action = self.forces.begin(&self.system, step, &convected);
        self.balance.begin(&self.system, &self.interface, action);
        if let (Some(energy), Some(solids)) = (&mut self.balance.solids, &self.solids) {
            energy.begin(solids.last.energies);
        }
        Ok(())
    }
}

/// Kinetic energy of an impulsive start: what walls and inlets add to the nodes that they hold when the run begins [J].
pub(in crate::pfem2) fn impulsive_energy<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>) -> f64 {
    let VelocityPressureSystem { mesh, boundary, velocity, .. } = system;
    let mass = |node: usize| system.nodal_mass(node);
    let gain =
        |(node, held): (usize, Vector<D>)| 0.5 * mass(node) * (held.norm_squared() - velocity[node].norm_squared());
    let held = boundary.held(mesh, 0.0);
    parallel::sum(held.len(), |n| gain(held[n]))
}
