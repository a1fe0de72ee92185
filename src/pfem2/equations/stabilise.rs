//! Subscales of a step: carried along with the flow, found with the solution, and projected for the next step
//! (theory F.7).

use super::subscale;
use super::system::VelocityPressureSystem;
use super::viscous::ViscousFlow;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::ThetaStep;
use crate::pfem2::element::Stabilisation;
use crate::pfem2::history::StepWeights;
use crate::pfem2::solid::cut::ElementState;

impl<const D: usize, const N: usize> VelocityPressureSystem<D, N> {
    /// Finds ũ̂ of a step, in which accelerations have these `step_weights`.
    pub(in crate::pfem2) fn carry_subscales(&mut self, step: ThetaStep, step_weights: StepWeights) {
        let weights = [step_weights.start, step_weights.earlier];
        self.subscales.dynamic.carry(&self.mesh, &self.mesh_data.size, &self.velocity, step.dt, weights);
    }

    /// Finds the velocity ũ of the subscales that belongs to the solution: of those that keep it, and of others where
    /// the energy balance asks for it, beside solids.
    pub(super) fn find_subscales(&mut self, convected: &[Vector<D>]) {
        let is_dynamic = self.physics.stabilisation == Stabilisation::Dynamic;
        if !is_dynamic && self.immersed.is_none() {
            return;
        }
        let count = self.mesh.elements().len();
        let velocity = parallel::collect(count, 256, |e| self.subscale_velocity(e, convected));
        if is_dynamic {
            self.subscales.dynamic.velocity = velocity;
        } else {
            self.subscales.momentary = velocity;
        }
    }

    /// ũ of an element [m/s]; zero where there is no fluid, or several.
    fn subscale_velocity(&self, e: usize, convected: &[Vector<D>]) -> Vector<D> {
        let (content, volume) = (&self.contents.elements[e], self.fluid_volume(e));
        let nodes = &self.mesh.elements()[e];
        if !self.contents.pure[e] || content.volume_over_density == 0.0 || volume == 0.0 {
            return Vector::ZERO;
        }
        let nodal = nodes.map(|node| self.pressure[node as usize]);
        let pressure = self.immersed.as_ref().map_or(nodal, |immersed| immersed.pressures(e, nodal));
        let slope = (0..N).map(|k| self.mesh.simplex(e).gradient[k] * pressure[k]).sum::<Vector<D>>();
        let force = self.elements(convected).drive(e, false).forces_of(&self.equations, [true; N]);
        let inertia = match self.physics.stabilisation {
            Stabilisation::ConsistentPspg | Stabilisation::Dynamic => self.mean_acceleration(e, convected),
            Stabilisation::Pspg | Stabilisation::Oss => Vector::ZERO,
        };
        (force - slope * (content.volume_over_density / volume) - inertia) * content.tau
    }

    /// (v − v̂)/Δ in the mean over the fluid of an element [m/s²].
    fn mean_acceleration(&self, e: usize, convected: &[Vector<D>]) -> Vector<D> {
        let gained = |i: usize| self.velocity[i] - convected[i];
        let mean = match &self.immersed {
            Some(immersed) if immersed.cut.state[e] != ElementState::Fluid => immersed.mean_of_fluid(e, &gained),
            _ => self.mesh.elements()[e].iter().map(|&i| gained(i as usize)).sum::<Vector<D>>() / N as f64,
        };
        mean / self.equations.delta
    }

    /// Projects on the nodes what the next step is stabilised against.
    pub(super) fn project_subscales(&mut self) {
        let Self { mesh, mesh_data, contents, velocity, immersed, subscales, .. } = self;
        let (pure, pressure) = (|e: usize| contents.pure[e], |node: usize| self.pressure[node]);
        match self.physics.stabilisation {
            Stabilisation::Pspg => {}
            Stabilisation::ConsistentPspg | Stabilisation::Dynamic => {
                let flow = ViscousFlow { mesh, contents: &contents.elements, velocity, immersed: immersed.as_ref() };
                subscales.projected = flow.accelerations(pure, |node| mesh_data.on_boundary[node]);
            }
            Stabilisation::Oss => {
                subscale::project(mesh, &contents.elements, pure, pressure, &self.force, &mut subscales.projected);
                subscales.average();
            }
        }
    }
}
