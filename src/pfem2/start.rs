//! The start: what the first step of second order would take from the one before it.
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
//! paper's PSPG (theory 5.4), and the pressure half of what it is.

use super::Pfem2;
use super::element::Stabilisation;
use super::implicit::{Implicit, Step};
use super::phases::Phases;
use crate::error::StepError;
use crate::math::Vector;

/// Solutions of the rehearsed step: with τ ≈ Δt each halves what π lacks of the pressure gradient.
const SOLUTIONS: usize = 8;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Prepares a first step of second order.
    ///
    /// # Errors
    /// As [`super::implicit::Implicit::solve`].
    pub(super) fn rehearse(&mut self, step: Step) -> Result<(), StepError> {
        let particles = self.particles.clone();
        let (sharp, level, fraction) = (self.sharp.clone(), self.level.clone(), self.fraction.clone());
        let (counts, outflow, shift) = (self.counts, self.outflow, self.shift);
        let start = self.implicit.velocity.clone();
        self.convect(step);
        self.follow_interface();
        let mut convected = self.project().mean;
        self.implicit.boundary.impose(&self.implicit.mesh, [step.t, step.dt, 1.0], &mut convected);
        let solutions = if self.implicit.physics.stabilisation == Stabilisation::Oss { SOLUTIONS } else { 1 };
        for _ in 0..solutions {
            let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
            self.implicit.solve(step, &phases, &convected)?;
        }
        self.implicit.subscales.settle();
        self.remember(step, &convected);
        self.carried.copy_from_slice(&self.acceleration);
        let outside = self.push(step, &convected);
        self.books.begin(&outside);
        self.friction.begin(&self.implicit);
        self.earlier_forces.clone_from(&self.forces);
        let end = std::mem::replace(&mut self.implicit.velocity, start);
        self.before = self.implicit.velocity.iter().zip(end).map(|(start, end)| *start * 2.0 - end).collect();
        self.dt_before = step.dt;
        (self.particles, self.sharp, self.level, self.fraction) = (particles, sharp, level, fraction);
        (self.counts, self.outflow, self.shift) = (counts, outflow, shift);
        Ok(())
    }

    /// What walls and inlets give at once, when the run begins, to the nodes that they hold [J].
    pub(super) fn jolt(&self) -> f64 {
        let Implicit { mesh, boundary, contents, velocity, .. } = &self.implicit;
        let mass = |node: usize| -> f64 {
            let around = mesh.elements_around(node).iter().map(|&e| e as usize);
            let own = |e: usize| {
                (0..N).filter(move |&k| mesh.elements()[e][k] as usize == node).map(move |k| contents[e].mass[k])
            };
            around.flat_map(own).sum()
        };
        let gain =
            |(node, held): (usize, Vector<D>)| 0.5 * mass(node) * (held.norm_squared() - velocity[node].norm_squared());
        boundary.held(mesh, 0.0).into_iter().map(gain).sum()
    }
}
