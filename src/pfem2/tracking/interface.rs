//! The interfaces of a run: fractions and level set at the nodes, and the volumes on their sides.

use crate::math::Vector;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::interface::inflow::InflowComposition;
use crate::pfem2::interface::level_set::{self, InflowDepth, LevelSet, OpenFacet};
use crate::pfem2::interface::outline::Outline;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::project::{AveragingKernel, ConvectedVelocity, project};
use crate::pfem2::phases::FluidRegion;
use crate::pfem2::phases::Phases;
use crate::pfem2::phases::phase_list::PhaseList;

/// The interfaces of a run.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct InterfaceTracking<const D: usize> {
    /// The phases.
    pub list: PhaseList,
    /// Fraction of each fluid at the nodes, by fluid and node.
    pub fraction: Vec<Vec<f64>>,
    /// Level set at the nodes, negative in the first of the two sides of the phases.
    pub level: Vec<f64>,
    /// Source of `level`, if it is sharp.
    pub sharp: Option<LevelSet>,
    /// The last shift of the level set [m].
    pub shift: f64,
    /// The largest factor between the last weights of fractions.
    pub weight: f64,
    /// Volume of the fluid inside the level set at the start, if shifts keep it [m³].
    pub kept_volume: Option<f64>,
    /// Volume of each of several fluids at the start, if weights of their fractions keep them [m³].
    pub kept_volumes: Option<Vec<f64>>,
    /// Volume that has left through open boundaries, of the fluid inside the level set and of both [m³].
    pub outflow: [f64; 2],
    /// Facets through which it may leave.
    pub open_facets: Vec<OpenFacet<D>>,
    /// Fluids that come in through them.
    pub inflow: InflowComposition<D>,
    /// The interfaces as surfaces, after the last step.
    pub outline: Outline,
}

impl<const D: usize> InterfaceTracking<D> {
    /// The interfaces of these phases; with two, `level_set` may be sharp.
    pub fn new(list: PhaseList, level_set: Option<LevelSet>) -> Self {
        Self {
            sharp: level_set.filter(|_| list.sides().is_some()),
            list,
            fraction: Vec::new(),
            level: Vec::new(),
            shift: 0.0,
            weight: 1.0,
            kept_volume: None,
            kept_volumes: None,
            outflow: [0.0; 2],
            open_facets: Vec::new(),
            inflow: InflowComposition::default(),
            outline: Outline::default(),
        }
    }

    /// Phases at the nodes.
    pub fn phases(&self) -> Phases<'_> {
        Phases { list: &self.list, fraction: &self.fraction, level: &self.level }
    }

    /// Stage `project`: averages of the particles at the nodes. Fractions and level set stay here; returns the
    /// convected velocity v̂ [m/s] (Becker (37)–(39); theory G.2, G.11).
    pub fn project<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        particles: &Particles<D>,
        kernel: AveragingKernel,
    ) -> ConvectedVelocity<D> {
        let VelocityPressureSystem { mesh, velocity, .. } = system;
        let region = system.fluid_region();
        let volume = |e: usize| region.volume(e);
        let projected = project(mesh, particles, self.list.density(), kernel, velocity, &volume);
        self.fraction = projected.fraction;
        level_set::continue_fractions(&region, &mut self.fraction);
        self.level = match (&self.sharp, self.list.sides()) {
            (Some(sharp), _) => sharp.level.clone(),
            (None, Some([inside, _])) => {
                let mut level = level_set::pseudo(&self.fraction[inside]);
                level_set::absorb_isolated_nodes(mesh, &mut level);
                level
            }
            _ => Vec::new(),
        };
        if self.list.count() > 2 {
            self.weigh_fractions(&region);
        }
        projected.velocity
    }

    /// Finds the interfaces as surfaces.
    pub fn trace<const N: usize>(&mut self, system: &VelocityPressureSystem<D, N>) {
        self.outline = Outline::new(&system.fluid_region(), &self.phases(), &system.velocity);
    }

    /// Fluids that flow in, from the state at the start on.
    pub fn begin_inflow<const N: usize>(&mut self, system: &VelocityPressureSystem<D, N>) {
        let VelocityPressureSystem { mesh, boundary, .. } = system;
        self.inflow = InflowComposition::new(mesh, boundary, self.sharp.as_ref(), &self.phases());
    }

    /// Distances that give inflow its depth in a step of v* [m/s], with a sharp level set and open boundaries.
    /// Particles behind facets at which an interface begins take theirs at once.
    pub fn inflow_depth<const N: usize>(
        &self,
        region: &FluidRegion<D, N>,
        velocity: &[Vector<D>],
        particles: &mut Particles<D>,
    ) -> Option<InflowDepth> {
        let open_facets = &self.open_facets[..];
        let set = self.sharp.as_ref().filter(|_| !open_facets.is_empty())?;
        Some(InflowDepth::new(region, set, open_facets, velocity, particles))
    }

    /// Density of the fluid that a facet brings, by its place in [`Mesh::boundary`] [kg/m³], if a sharp level set tells
    /// it.
    pub fn inflow_density<const N: usize>(&self, place: usize) -> Option<f64> {
        let (level, set) = (self.inflow.level(place)?, self.sharp.as_ref()?);
        let fraction = level_set::fraction_inside::<D, N>(&level);
        let density = |phase: u8| self.list.density()[usize::from(phase)];
        Some(fraction * density(set.inside) + (1.0 - fraction) * density(set.outside()))
    }
}
