//! The stages of a step that solids on particles have beside those of fluids (theory K.3).

use super::columns;
use super::stress::{self, SolvedFlow};
use crate::error::{Place, StepError};
use crate::math::{Tensor, Vector};
use crate::parallel;
use crate::pfem2::Pfem2;
use crate::pfem2::equations::system::TimeStep;
use crate::pfem2::particles::convect::Continued;
use crate::pfem2::particles::project::ConvectedVelocity;

/// Part of its volume that an element of a solid keeps in a step, at least.
const LEAST_VOLUME: f64 = 0.1;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Turns the stresses of the particles with the spin of vⁿ, before they move: Becker (16), theory (K.3).
    pub(in crate::pfem2) fn rotate_stresses(&mut self, step: TimeStep) {
        let Some(solids) = &self.system.particle_solids else { return };
        solids.rotate(&mut self.particles.columns, &self.system.mesh, &self.system.velocity, step.dt);
    }

    /// Averages pressures and accelerations of the particles at the nodes, and stresses in the elements: theory (K.4), (K.5).
    pub(in crate::pfem2) fn gather_particle_solids(&mut self) {
        let Some(mut solids) = self.system.particle_solids.take() else { return };
        let (mesh, columns) = (&self.system.mesh, &mut self.particles.columns);
        columns::admit(columns, mesh, solids.first);
        solids.gather(columns, mesh, &self.interface.phases(), &self.system.pressure);
        self.system.particle_solids = Some(solids);
    }

    /// Gives the particles their increments of stress and pressure, and keeps their accelerations: Becker (15), theory (K.2), (K.6), (K.7).
    ///
    /// # Errors
    /// An element of a solid loses most of its volume in the step.
    pub(in crate::pfem2) fn update_particle_solids(
        &mut self,
        step: TimeStep,
        averaged: &ConvectedVelocity<D>,
    ) -> Result<(), StepError> {
        self.check_solids(step)?;
        let Some(solids) = &self.system.particle_solids else { return Ok(()) };
        let (mesh, columns) = (&self.system.mesh, &mut self.particles.columns);
        let solved = SolvedFlow { dt: step.dt, velocity: &self.system.velocity, pressure: &self.system.pressure };
        solids.update(columns, mesh, &solved);
        let mut gained = averaged.increments(&self.system.velocity, self.interface.list.count());
        let projectiles =
            self.particles.rules.is_projectile.iter().zip(&mut gained).filter(|(is_projectile, _)| **is_projectile);
        projectiles.for_each(|(_, own)| *own = Continued::new(mesh, own, &self.interface.level).values);
        solids.keep_acceleration(columns, mesh, &gained, step.dt);
        Ok(())
    }

    /// No element of a solid turns inside out.
    fn check_solids(&self, step: TimeStep) -> Result<(), StepError> {
        let Some(solids) = &self.system.particle_solids else { return Ok(()) };
        let (mesh, velocity) = (&self.system.mesh, &self.system.velocity);
        let ratio = |place: usize| {
            let gradient = stress::gradient(mesh, solids.elements[place].element as usize, velocity);
            (Tensor::<3>::identity() + gradient.embed(0.0) * step.dt).determinant()
        };
        let kept = |place: usize| {
            let own = &solids.elements[place];
            own.split.is_some() || own.part.volume == 0.0 || ratio(place) > LEAST_VOLUME
        };
        let Some(bad) = parallel::first(solids.elements.len(), |place| !kept(place)) else { return Ok(()) };
        let element = solids.elements[bad].element as usize;
        let at = Place::Element {
            body: solids.setups[solids.elements[bad].solid].name.clone(),
            index: element,
            position: mesh.center(element).to3(),
        };
        let advice = "take a shorter step (`time.step`), and look at supports and loads: the solid is deformed by its own size in one step";
        Err(StepError::new(at, "a solid is turned inside out", "volume ratio", ratio(bad), advice))
    }

    /// Forces of the fluid on the solids, their strain energy and the work of their supports, and the watch over their volume: theory K.6.
    pub(in crate::pfem2) fn account_for_particle_solids(&mut self, step: TimeStep, convected: &[Vector<D>]) {
        let Some(mut solids) = self.system.particle_solids.take() else { return };
        let system = &self.system;
        let elements = system.elements(convected);
        let solution = |e: usize| {
            let nodes = system.mesh.elements()[e].map(|node| node as usize);
            (nodes.map(|i| system.velocity[i]), nodes.map(|i| system.pressure[i]), elements.drive(e, false))
        };
        solids.find_forces(&system.mesh, solution, step.dt, |node, axis| system.is_free(node, axis));
        self.notices.solid_volume(system.contents.volumes[solids.first..].iter().sum(), solids.start_volume);
        self.system.particle_solids = Some(solids);
        let supports = step.dt * self.power_of_supports(step, convected);
        if let (Some(now), Some(strain)) = (self.strain_energy(), &mut self.balance.strain) {
            strain.add(now, supports);
        }
    }

    /// Power of supports that move [W].
    fn power_of_supports(&self, step: TimeStep, convected: &[Vector<D>]) -> f64 {
        let Some(solids) = &self.system.particle_solids else { return 0.0 };
        let elements = self.system.elements(convected);
        let driven = solids.driven(&self.system.mesh, step.end(), self.system.boundary_mask());
        let power = |(node, axis, velocity): (usize, usize, f64)| {
            -elements.nodal_force(node, |i| self.system.linear.unknowns[i])[axis] * velocity
        };
        driven.into_iter().map(power).sum()
    }

    /// Strain energy of the solids on particles [J]: Σ V_p (σ':σ'/4μ + p²/2κ) (theory (K.14)).
    pub(in crate::pfem2) fn strain_energy(&self) -> Option<f64> {
        let solids = self.system.particle_solids.as_ref()?;
        let particles = &self.particles.columns;
        let (stress, pressure, _) = columns::state(particles);
        Some(parallel::sum(particles.len(), |p| {
            let Some(law) = solids.law_of(particles.phase[p]) else { return 0.0 };
            let density = stress[p].contract(&stress[p]) / (4.0 * law.shear) + pressure[p].powi(2) / (2.0 * law.bulk);
            self.particles.volume(&self.system, p) * density
        }))
    }
}
