//! The particles of a run with the rules that move, add and correct them, and counts of what happened to them (theory
//! F.2).

use super::interface::InterfaceTracking;
use crate::math::Vector;
use crate::pfem2::ThetaStep;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::history::TimeHistory;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::convect::{ConvectionCounts, Projectiles};
use crate::pfem2::particles::correct::{self, Correction, ProjectileCorrection};
use crate::pfem2::particles::project::AveragingKernel;
use crate::pfem2::particles::project::ConvectedVelocity;
use crate::pfem2::particles::reseed::{self, ParticleCounts, Reseeded};
use bytemuck::{Pod, Zeroable};

/// Treatment of velocities of particles that the mesh can't resolve (see `unresolved`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unresolved {
    /// Velocities are kept.
    Kept,
    /// The velocity of a particle relative to the mesh is bounded by the differences between neighbouring nodes.
    #[default]
    Bounded,
}

/// Rules that stay the same during a run.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct ParticleRules {
    /// Averages at the nodes.
    pub kernel: AveragingKernel,
    /// Numbers of particles to be held in elements and sub-cells.
    pub target: ParticleCounts,
    /// Fluids that follow their side of the interface (Becker (36)).
    pub is_projectile: Vec<bool>,
    /// Time in which particles take over the velocity of the mesh [s].
    pub relaxation: f64,
    /// Treatment of velocities that the mesh can't resolve.
    pub unresolved: Unresolved,
}

impl ParticleRules {
    /// True if some fluid follows its side of the interface.
    pub fn has_projectiles(&self) -> bool {
        self.is_projectile.contains(&true)
    }

    /// The rule for these fluids, if there are some.
    pub fn projectiles<'a, const D: usize, const N: usize>(
        &'a self,
        system: &'a VelocityPressureSystem<D, N>,
        interface: &'a InterfaceTracking<D>,
    ) -> Option<Projectiles<'a, D>> {
        let rule = Projectiles { fluids: &self.is_projectile, level: &interface.level, body_force: &system.force };
        self.has_projectiles().then_some(rule)
    }
}

/// Events since the start, for histories.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(in crate::pfem2) struct ParticleEvents {
    /// Particles that left through open boundaries.
    pub left: u64,
    /// Particles that crossed too many elements and stopped on their way.
    pub stuck: u64,
    /// Particles added where there were none.
    pub added: u64,
    /// Added particles that came in through an open boundary.
    pub inflow: u64,
    /// Particles merged where there were too many.
    pub merged: u64,
    /// Particles that joined the other fluid, deep inside of it.
    pub joined: u64,
    /// Elements found empty.
    pub empty: u64,
}

impl ParticleEvents {
    /// Adds those of the motion of a step.
    pub fn add_motion(&mut self, moved: &ConvectionCounts) {
        self.left += moved.left as u64;
        self.stuck += moved.stuck as u64;
    }

    /// Adds those of the reseeding of a step.
    pub fn add_reseeding(&mut self, reseeded: &Reseeded) {
        self.added += reseeded.added as u64;
        self.inflow += reseeded.inflow as u64;
        self.merged += reseeded.merged as u64;
        self.empty += reseeded.empty as u64;
    }
}

/// The particles of a run.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct ParticleTracking<const D: usize> {
    /// Columns of the particles.
    pub columns: Particles<D>,
    /// Rules of the particles.
    pub rules: ParticleRules,
    /// Events since the start.
    pub events: ParticleEvents,
    /// Energy that the bound of velocities relative to the mesh has taken since the start [J].
    pub unresolved_energy: f64,
}

impl<const D: usize> ParticleTracking<D> {
    /// Particles at the start.
    pub fn new(columns: Particles<D>, rules: ParticleRules) -> Self {
        Self { columns, rules, events: ParticleEvents::default(), unresolved_energy: 0.0 }
    }

    /// Volume of a particle: its part of its element [m³], or per depth [m²].
    pub fn volume<const N: usize>(&self, system: &VelocityPressureSystem<D, N>, particle: usize) -> f64 {
        let element = self.columns.element[particle] as usize;
        system.fluid_volume(element) / self.columns.of(element).len() as f64
    }

    /// Adds the explicit part of the acceleration, Δt (β₁ aⁿ + β₂ aⁿ⁻¹), to the velocities (theory (F.3)).
    pub fn accelerate<const N: usize>(
        &mut self,
        step: ThetaStep,
        history: &TimeHistory<D>,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
    ) {
        let [last, earlier] = history.explicit_weights(step);
        if last + earlier != 0.0 {
            let increment = history.explicit_increment(step);
            let each = vec![&increment[..]; interface.list.count()];
            self.add_increment(&each, (last + earlier) * step.dt, 0.0, system, interface);
        }
    }

    /// Corrects the velocities with the increment of the mesh, v − v̂ (Becker (40); theory F.11), and keeps the
    /// particles fit for the next step.
    ///
    /// The increment counts from the average of the particles, also at nodes with a prescribed velocity: that average
    /// enters no equation there, and would drift away from the boundary's velocity.
    pub fn correct<const N: usize>(
        &mut self,
        step: ThetaStep,
        averaged: &ConvectedVelocity<D>,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
    ) {
        let increment = averaged.increments(&system.velocity, interface.list.count());
        let increment: Vec<&[Vector<D>]> = increment.iter().map(|own| &own[..]).collect();
        let filter = correct::filter(step.dt, self.rules.relaxation);
        self.add_increment(&increment, step.delta(), filter, system, interface);
        self.bound_unresolved(system, interface.list.density());
        if interface.list.reseeds_by_elements() {
            let phases = interface.phases();
            let added = reseed::refill(&mut self.columns, &system.mesh, &system.velocity, &phases);
            self.events.added += added as u64;
        }
        self.join_surrounding_fluid(system, interface);
    }

    /// Adds nodal increments for each fluid [m/s], which took the time `dt` [s], with the fraction `filter` of the mesh
    /// velocity.
    fn add_increment<const N: usize>(
        &mut self,
        increment: &[&[Vector<D>]],
        dt: f64,
        filter: f64,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
    ) {
        let (heavy, light) = extremes(interface.list.density());
        let fall_time = dt * (1.0 - light / heavy);
        let projectiles =
            self.rules.projectiles(system, interface).map(|rule| ProjectileCorrection { rule, fall_time });
        let correction = Correction { increment, velocity: &system.velocity, filter, projectiles };
        self.columns.correct(&system.mesh, &correction);
    }
}

/// The largest and the smallest density [kg/m³].
fn extremes(density: &[f64]) -> (f64, f64) {
    let largest = density.iter().copied().fold(0.0, f64::max);
    (largest, density.iter().copied().fold(f64::INFINITY, f64::min))
}
