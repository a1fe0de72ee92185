//! The start: what the first step of second order would take from the one before it, and the pressure that is shown (theory H.9).
//!
//! ```text
//! rehearsal   a step of backward Euler over the first step gives v¹, p¹, a¹; the particles go back to where they were
//! a⁰ ← a¹,  v⁻¹ ← 2 v⁰ − v¹,  π⁰ ← π¹         at the nodes, so that v* = ½ (v⁰ + v¹)
//! ```
//!
//! All three, and the forces that the first step's explicit share is booked with, are known up to O(Δt) at a fixed
//! place, which leaves an error of O(Δt²) in the first step; in a steady flow they are exact. Backward Euler instead would
//! turn vortices by an angle φ per step and take the part φ² of their energy at once. The projected pressure gradient π of
//! the stabilisation counts as much: with π⁰ = 0, fluid that accelerates would be as compressible in the first step as with the
//! paper's PSPG (theory F.7.1), and the pressure half of what it is.

use crate::error::StepError;
use crate::math::Vector;
use crate::pfem2::Pfem2;
use crate::pfem2::equations::element::Stabilisation;
use crate::pfem2::equations::subscale::Subscales;
use crate::pfem2::equations::system::{TimeStep, VelocityPressureSystem};
use crate::pfem2::interface::phases::Phases;
use crate::pfem2::setup::Scheme;

/// Solutions of the rehearsed step: with τ ≈ Δt each halves what π lacks of the pressure gradient.
const SOLUTIONS: usize = 8;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Finds the pressure at the start, which is shown with it, by a rehearsal of the first step. What can't be found is left: the
    /// first step tells why.
    pub(in crate::pfem2) fn show_pressure(&mut self, step: TimeStep) {
        if self.scheme != Scheme::BackwardEuler {
            if self.rehearse(step).is_ok() {
                self.settle();
            }
            return;
        }
        // A step of first order takes nothing of it but the pressure, to begin its iterations with.
        let (subscales, books) = (self.system.subscales.clone(), self.books.clone());
        let (forces, memory) = ([self.forces.clone(), self.earlier_forces.clone()], self.system.memory());
        let preconditioners = self.system.preconditioners;
        let _ = self.rehearse(step);
        self.forget();
        (self.system.subscales, self.books, self.system.preconditioners) = (subscales, books, preconditioners);
        [self.forces, self.earlier_forces] = forces;
        self.system.recall(&memory);
        self.settle();
    }

    /// Forgets the step before the first.
    fn forget(&mut self) {
        let nodes = self.system.velocity.len();
        (self.acceleration, self.carried) = (vec![Vector::ZERO; nodes], vec![Vector::ZERO; nodes]);
        self.before.clone_from(&self.system.velocity);
        self.earlier.clone_from(&self.system.velocity);
        self.system.subscales = Subscales::at_rest(nodes);
        (self.dt_before, self.dt_earlier) = (0.0, 0.0);
    }

    /// Prepares a first step of second order. After an error the state is that before.
    ///
    /// # Errors
    /// As [`crate::pfem2::equations::system::VelocityPressureSystem::solve`].
    pub(in crate::pfem2) fn rehearse(&mut self, step: TimeStep) -> Result<(), StepError> {
        self.forget();
        let particles = self.particles.clone();
        let (sharp, level, fraction) = (self.sharp.clone(), self.level.clone(), self.fraction.clone());
        let (counts, outflow, shift, weight) = (self.counts, self.outflow, self.shift, self.weight);
        let (start, force) = (self.system.velocity.clone(), self.system.force.clone());
        let outcome = self.try_step(step);
        let end = std::mem::replace(&mut self.system.velocity, start);
        (self.particles, self.sharp, self.level, self.fraction) = (particles, sharp, level, fraction);
        (self.counts, self.outflow, self.shift, self.weight) = (counts, outflow, shift, weight);
        self.system.force = force;
        if let Err(error) = outcome {
            self.forget();
            self.system.pressure.fill(0.0);
            return Err(error);
        }
        let both = || self.system.velocity.iter().zip(&end);
        self.before = both().map(|(start, end)| *start * 2.0 - *end).collect();
        self.earlier = both().map(|(start, end)| *start * 3.0 - *end * 2.0).collect();
        (self.dt_before, self.dt_earlier) = (step.dt, step.dt);
        Ok(())
    }

    /// A step of backward Euler.
    fn try_step(&mut self, step: TimeStep) -> Result<(), StepError> {
        self.convect(step);
        self.follow_interface();
        let mut convected = self.project().mean;
        self.system.boundary.impose(&self.system.mesh, [step.t, step.dt, 1.0], &mut convected);
        let solutions = if self.system.physics.stabilisation == Stabilisation::Oss { SOLUTIONS } else { 1 };
        for _ in 0..solutions {
            let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
            self.system.solve(step, &phases, &convected)?;
        }
        self.system.subscales.settle();
        self.remember(step, &convected);
        self.carried.copy_from_slice(&self.acceleration);
        let outside = self.push(step, &convected);
        self.books.begin(&outside);
        self.friction.begin(&self.system);
        self.earlier_forces.clone_from(&self.forces);
        Ok(())
    }

    /// What walls and inlets give at once, when the run begins, to the nodes that they hold [J].
    pub(in crate::pfem2) fn jolt(&self) -> f64 {
        let VelocityPressureSystem { mesh, boundary, velocity, .. } = &self.system;
        let mass = |node: usize| self.system.nodal_mass(node);
        let gain =
            |(node, held): (usize, Vector<D>)| 0.5 * mass(node) * (held.norm_squared() - velocity[node].norm_squared());
        boundary.held(mesh, 0.0).into_iter().map(gain).sum()
    }
}
