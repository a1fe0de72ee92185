//! The convective part of a step: particles move along the streamlines of a frozen flow, empty places are filled with
//! what the flow brings there, and nodal values of the last step go along.
//!
//! ```text
//! v*     convecting velocity, frozen over the step: vⁿ in the paper's scheme; theory F.5
//! x_p ← x_p + ∫ v*(x_p) dτ                                                                Becker (34), (35)
//! new particles, and aⁿ⁻¹ at the nodes: the state at the foot of the streamline that ends there
//! ```

use super::interface::InterfaceTracking;
use super::particles::ParticleTracking;
use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::parallel;
use crate::pfem2::ThetaStep;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::history::TimeHistory;
use crate::pfem2::interface::level_set::InflowDepth;
use crate::pfem2::particles::convect::{Flow, MeshPoint, Rates, Streamlines, Walk};
use crate::pfem2::particles::interpolate_nodal;
use crate::pfem2::particles::reseed::{NewParticle, ParticleSource};
use crate::pfem2::solid::coupling::immersed::Immersed;

/// The flow of a step, frozen, and the state at its start.
pub(in crate::pfem2) struct FrozenFlow<const D: usize> {
    step: ThetaStep,
    /// v* at the nodes [m/s].
    pub velocity: Vec<Vector<D>>,
    /// Velocity at the nodes at the start of the step, with its explicit part [m/s].
    start: Vec<Vector<D>>,
    /// The elements, prepared for streamlines of v*.
    rates: Rates,
    /// Distances from the interface at the start, which give inflow its depth; with a sharp level set and open
    /// boundaries.
    inflow_depth: Option<InflowDepth>,
}

impl<const D: usize> ParticleTracking<D> {
    /// Moves the particles along the streamlines of v* (Becker (34)–(36); theory F.4).
    /// [`ParticleTracking::reseed`] has to follow, which sorts them.
    pub fn convect<const N: usize>(
        &mut self,
        step: ThetaStep,
        history: &TimeHistory<D>,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
    ) -> FrozenFlow<D> {
        let (velocity, increment) =
            (history.convecting_velocity(step, &system.velocity), history.explicit_increment(step));
        let start = system.velocity.iter().zip(&increment).map(|(v, increment)| *v + *increment).collect();
        let projectiles = self.rules.projectiles(system, interface);
        let (mesh, boundary) = (&system.mesh, &system.boundary.kinds[..]);
        let lines = Streamlines::new(mesh, &Flow { velocity: &velocity, boundary, projectiles });
        let inflow_depth = interface.inflow_depth(&system.fluid_region(), &velocity, &mut self.columns);
        self.events.add_motion(&self.columns.carry(&lines, step.dt));
        let rates = lines.into_rates();
        FrozenFlow { step, velocity, start, rates, inflow_depth }
    }

    /// Adds particles where there are too few and merges them where there are too many, before the projection
    /// (theory G.12).
    pub fn reseed<const N: usize>(
        &mut self,
        flow: &FrozenFlow<D>,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
    ) {
        let target = self.rules.target;
        let columns = &mut self.columns;
        if let Some(immersed) = &system.immersed {
            columns.leave_solids(&system.mesh, immersed);
        }
        let reseeded =
            flow.with_source(system, interface, |source| columns.reseed(&system.mesh, &interface.list, target, source));
        self.events.add_reseeding(&reseeded);
    }
}

impl<const D: usize> FrozenFlow<D> {
    fn streamlines<'a, const N: usize>(&'a self, system: &'a VelocityPressureSystem<D, N>) -> Streamlines<'a, D, N> {
        let flow = Flow { velocity: &self.velocity, boundary: &system.boundary.kinds, projectiles: None };
        Streamlines::with_rates(&system.mesh, &flow, &self.rates)
    }

    /// Calls `take` with the state at the start of the step, from which places take their values after it.
    pub fn with_source<const N: usize, R>(
        &self,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
        take: impl FnOnce(&ParticleSource<D, N>) -> R,
    ) -> R {
        let VelocityPressureSystem { mesh, boundary, .. } = system;
        let lines = self.streamlines(system);
        let phases = interface.phases();
        let sharp = interface.sharp.as_ref();
        let fluid = |place: &MeshPoint<N>| match sharp {
            Some(set) => set.at(mesh, place),
            None => (phases.at_place(&mesh.elements()[place.element], &place.shape) as u8, f64::INFINITY),
        };
        let inflow = |place: &MeshPoint<N>, opposite: usize, after: f64| {
            let (element, x) = (place.element, place.position(mesh));
            let facet = Facet { element: element as u32, opposite: opposite as u32 };
            let inflow = boundary.inflow(mesh, facet, x, self.step.t + after.max(0.0))?;
            let here = || interpolate_nodal(&place.shape, &mesh.elements()[element], &self.start);
            let velocity = inflow.velocity.unwrap_or_else(here);
            let sharp = sharp.zip(self.inflow_depth.as_ref());
            let (fluid, depth) = interface.inflow.brought(mesh, sharp, place, &inflow, velocity * after);
            Some(NewParticle { velocity, fluid, depth })
        };
        let (dt, velocity) = (self.step.dt, &self.start[..]);
        let is_fluid = |place: &MeshPoint<N>| {
            let of = |immersed: &Immersed<D, N>| immersed.is_fluid(mesh, place.element, &place.shape);
            system.immersed.as_ref().is_none_or(of)
        };
        take(&ParticleSource { lines: &lines, dt, velocity, fluid: &fluid, inflow: &inflow, is_fluid: &is_fluid })
    }

    /// The feet of the nodes' streamlines at the start of the step.
    pub fn feet<const N: usize>(&self, system: &VelocityPressureSystem<D, N>) -> Feet<N> {
        let mesh = &system.mesh;
        let place = |node: usize| {
            let element = mesh.elements_around(node).first().map_or(0, |&e| e as usize);
            MeshPoint::of(mesh, element, mesh.nodes()[node])
        };
        let places = parallel::collect(mesh.nodes().len(), 256, place);
        Feet(self.streamlines(system).trace_all(&places, self.step.dt, -1.0))
    }
}

/// The foot of each node's streamline.
pub(in crate::pfem2) struct Feet<const N: usize>(Vec<Walk<N>>);

impl<const N: usize> Feet<N> {
    /// Nodal values that go along with the flow: each node takes that at the foot of its streamline.
    pub fn carried<const D: usize>(&self, mesh: &Mesh<D, N>, values: &[Vector<D>]) -> Vec<Vector<D>> {
        let there =
            |MeshPoint { element, shape }: &MeshPoint<N>| interpolate_nodal(shape, &mesh.elements()[*element], values);
        parallel::collect(self.0.len(), parallel::CHUNK, |node| there(&self.0[node].place))
    }
}
