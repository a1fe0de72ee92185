//! The complete, checked description that a run starts from, made by the case layer.

use crate::linalg;
use crate::math::{Signal, Vector};
use crate::mesh::Mesh;
use crate::pfem2::boundary::{BoundarySetup, PressurePin};
use crate::pfem2::cut_element::Enrichment;
use crate::pfem2::element::{Mass, Stabilisation};
use crate::pfem2::fluid::FluidSetup;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::moments::MomentPoint;
use crate::pfem2::particle_solids::setup::ParticleSolidSetup;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::project::AveragingKernel;
use crate::pfem2::particles::reseed::ParticleCounts;
use crate::pfem2::phases::phase_list::{Phase, Reseeding};
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::theta_step::Scheme;
use crate::pfem2::tracking::particles::ParticleRules;
use crate::pfem2::tracking::{Unresolved, VolumeCorrection};

/// Everything that a run of PFEM-2 starts from.
#[derive(Debug)]
pub struct Setup<const D: usize, const N: usize> {
    /// The fixed mesh.
    pub mesh: Mesh<D, N>,
    /// Conditions on sets of boundary facets; facets in no set are walls at rest.
    pub boundaries: Vec<BoundarySetup<D>>,
    /// The place at which the pressure of a closed box is held; else it is zero at the highest node of its boundary.
    pub pin: Option<PressurePin<D>>,
    /// The fluids.
    pub fluids: Vec<FluidSetup>,
    /// Solids; where they are there is no fluid.
    pub solids: Option<Structure<D>>,
    /// Solids on particles; their phases follow those of the fluids.
    pub particle_solids: Vec<ParticleSolidSetup<D>>,
    /// Points about which forces of the fluid have moments in the outputs.
    pub moments: Vec<MomentPoint<D>>,
    /// Surface tension of pairs of fluids [N/m].
    pub tension: Vec<([usize; 2], f64)>,
    /// Body force per unit mass, a formula per axis [m/s²].
    pub gravity: [Signal; D],
    /// Particles at the start, sorted.
    pub particles: Particles<D>,
    /// Sharp level set of two fluids, negative in the heavier; without one the pseudo level set of Becker (37).
    pub level_set: Option<LevelSet>,
    /// Treatment of the volume of each fluid.
    pub volume: VolumeCorrection,
    /// Velocity of the nodes at the start [m/s].
    pub velocity: Vec<Vector<D>>,
    /// Time integration.
    pub scheme: Scheme,
    /// Stabilisation of the pressure.
    pub stabilisation: Stabilisation,
    /// Mass matrix.
    pub mass: Mass,
    /// Enrichment of cut elements without surface tension.
    pub enrichment: Enrichment,
    /// Average of the particles at the nodes.
    pub kernel: AveragingKernel,
    /// Rule by which particles are added and merged.
    pub reseeding: Reseeding,
    /// Density ratio from which heavy fluids follow their side of the interface (Becker (36); theory G.13).
    pub projectile_ratio: f64,
    /// Time in which the part of particle velocities that the mesh can't resolve decays [s]; infinity: never.
    pub relaxation: f64,
    /// Treatment of velocities of particles that the mesh can't resolve.
    pub unresolved: Unresolved,
    /// Elements that a particle may cross in a step; infinity: no bound.
    pub courant: f64,
    /// The largest error of a step in time over that of the mesh; infinity: errors don't bound the step.
    pub step_tolerance: f64,
    /// State with which the run begins.
    pub start: InitialState,
    /// The linear solver.
    pub linear: linalg::SolverOptions,
}

impl<const D: usize, const N: usize> Setup<D, N> {
    /// The solids one by one.
    pub fn solid_setups(&self) -> &[SolidSetup<D>] {
        self.solids.as_ref().map_or(&[], |structure| structure.setups())
    }
}

/// State with which a run begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InitialState {
    /// As the case gives it.
    #[default]
    AsGiven,
    /// Solids in equilibrium with their loads at time 0, and all at rest (theory J.14).
    Equilibrium,
}

impl<const D: usize, const N: usize> Setup<D, N> {
    /// The phases: fluids, and then solids on particles.
    pub(super) fn phases(&self) -> Vec<Phase> {
        let fluids = self.fluids.iter().map(|fluid| Phase::fluid(fluid.density, self.reseeding));
        fluids.chain(self.particle_solids.iter().map(|solid| Phase::solid(solid.law.density))).collect()
    }

    /// The rules of the particles.
    pub(super) fn particle_rules(&self) -> ParticleRules {
        let solids = self.particle_solids.iter().map(|solid| solid.law.density);
        let density: Vec<f64> = self.fluids.iter().map(|fluid| fluid.density).chain(solids).collect();
        let lightest = density.iter().copied().fold(f64::INFINITY, f64::min);
        // The level set is negative in a solid, whatever its density.
        let negative = |phase: usize| self.particle_solids.is_empty() || phase >= self.fluids.len();
        let is_projectile = |(phase, rho): (usize, &f64)| {
            density.len() == 2 && negative(phase) && *rho >= self.projectile_ratio * lightest
        };
        ParticleRules {
            kernel: self.kernel,
            target: ParticleCounts::new::<D>(self.particles.len() / self.mesh.elements().len()),
            is_projectile: density.iter().enumerate().map(is_projectile).collect(),
            relaxation: self.relaxation,
            unresolved: self.unresolved,
        }
    }
}
