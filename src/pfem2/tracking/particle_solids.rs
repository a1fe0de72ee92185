//! The stages of a step that solids on particles have beside those of fluids (theory K.3): of the particles, and of the
//! system.

use super::interface::InterfaceTracking;
use super::particles::ParticleTracking;
use crate::error::{Place, StepError};
use crate::math::{Tensor, Vector};
use crate::parallel;
use crate::pfem2::ThetaStep;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::particle_solids::columns;
use crate::pfem2::particle_solids::strain_rate::gradient;
use crate::pfem2::particle_solids::stress::SolvedFlow;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::convect::Continued;
use crate::pfem2::particles::project::ConvectedVelocity;
use crate::pfem2::phases::Phases;

/// Part of its volume that an element of a solid keeps in a step, at least.
const LEAST_VOLUME_RATIO: f64 = 0.1;

impl<const D: usize> ParticleTracking<D> {
    /// Turns the stresses of particles of solids with the spin of vⁿ, before they move (theory (K.3)).
    pub fn rotate_stresses<const N: usize>(&mut self, step: ThetaStep, system: &VelocityPressureSystem<D, N>) {
        let Some(solids) = &system.particle_solids else { return };
        // Becker (16).
        solids.rotate(&mut self.columns, &system.mesh, &system.velocity, step.dt);
    }

    /// Gives the particles of solids that came to fill empty elements a number and a state.
    pub fn admit_to_solids<const N: usize>(&mut self, system: &VelocityPressureSystem<D, N>) {
        let Some(solids) = &system.particle_solids else { return };
        columns::admit(&mut self.columns, &system.mesh, solids.first);
    }

    /// Gives the particles of solids their increments of stress and pressure, and keeps their accelerations (theory
    /// (K.2), (K.6), (K.7)).
    ///
    /// # Errors
    /// An element of a solid loses most of its volume in the step.
    pub fn update_stresses<const N: usize>(
        &mut self,
        step: ThetaStep,
        averaged: &ConvectedVelocity<D>,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
    ) -> Result<(), StepError> {
        let Some(solids) = &system.particle_solids else { return Ok(()) };
        system.check_particle_solids(step)?;
        let mesh = &system.mesh;
        let solved = SolvedFlow { dt: step.dt, velocity: &system.velocity, pressure: &system.pressure };
        // Becker (15).
        solids.update(&mut self.columns, mesh, &solved);
        let mut gained = averaged.increments(&system.velocity, interface.list.count());
        let projectiles = self.rules.is_projectile.iter().zip(&mut gained).filter(|(is_projectile, _)| **is_projectile);
        projectiles.for_each(|(_, own)| *own = Continued::new(mesh, own, &interface.level).values);
        solids.keep_acceleration(&mut self.columns, mesh, &gained, step.dt);
        Ok(())
    }

    /// Strain energy of the solids on particles [J]: Σ V_p (σ':σ'/4μ + p²/2κ) (theory (K.14)).
    pub fn strain_energy<const N: usize>(&self, system: &VelocityPressureSystem<D, N>) -> Option<f64> {
        let solids = system.particle_solids.as_ref()?;
        let particles = &self.columns;
        let (stress, pressure, _) = columns::state(particles);
        Some(parallel::sum(particles.len(), |p| {
            let Some(law) = solids.law_of(particles.phase[p]) else { return 0.0 };
            let density = stress[p].contract(&stress[p]) / (4.0 * law.shear) + pressure[p].powi(2) / (2.0 * law.bulk);
            self.volume(system, p) * density
        }))
    }
}

impl<const D: usize, const N: usize> VelocityPressureSystem<D, N> {
    /// Averages pressures and accelerations of the particles at the nodes, and stresses in the elements: theory (K.4),
    /// (K.5).
    pub(in crate::pfem2) fn gather_particle_solids(&mut self, particles: &Particles<D>, phases: &Phases) {
        let Self { mesh, pressure, particle_solids, .. } = self;
        let Some(solids) = particle_solids else { return };
        solids.gather(particles, mesh, phases, pressure);
    }

    /// No element of a solid turns inside out.
    fn check_particle_solids(&self, step: ThetaStep) -> Result<(), StepError> {
        let Some(solids) = &self.particle_solids else { return Ok(()) };
        let (mesh, velocity) = (&self.mesh, &self.velocity);
        let ratio = |place: usize| {
            let gradient = gradient(mesh, solids.elements[place].element as usize, velocity);
            (Tensor::<3>::identity() + gradient.embed(0.0) * step.dt).determinant()
        };
        let kept = |place: usize| {
            let own = &solids.elements[place];
            own.split.is_some() || own.part.volume == 0.0 || ratio(place) > LEAST_VOLUME_RATIO
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

    /// Finds the forces of the fluid on the solids on particles: theory K.6.
    pub(in crate::pfem2) fn find_forces_on_particle_solids(&mut self, step: ThetaStep, convected: &[Vector<D>]) {
        let Some(mut solids) = self.particle_solids.take() else { return };
        let elements = self.elements(convected);
        let solution = |e: usize| {
            let nodes = self.mesh.elements()[e].map(|node| node as usize);
            (nodes.map(|i| self.velocity[i]), nodes.map(|i| self.pressure[i]), elements.drive(e, false))
        };
        solids.find_forces(&self.mesh, solution, step.dt, |node, axis| self.is_free(node, axis));
        self.particle_solids = Some(solids);
    }

    /// Volumes of the solids on particles together, in the last step and at the start [m³].
    pub(in crate::pfem2) fn particle_solid_volumes(&self) -> Option<[f64; 2]> {
        let solids = self.particle_solids.as_ref()?;
        Some([self.contents.volumes[solids.first..].iter().sum(), solids.start_volume])
    }

    /// Power of moving supports of solids on particles [W].
    pub(in crate::pfem2) fn power_of_supports(&self, step: ThetaStep, convected: &[Vector<D>]) -> f64 {
        let Some(solids) = &self.particle_solids else { return 0.0 };
        let elements = self.elements(convected);
        let driven = solids.driven(&self.mesh, step.end(), self.boundary_mask());
        parallel::sum(driven.len(), |n| {
            let (node, axis, velocity) = driven[n];
            -elements.nodal_force(node, |i| self.linear.unknowns[i])[axis] * velocity
        })
    }
}
