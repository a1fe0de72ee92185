//! Subscales that keep their velocity from step to step (Codina, Principe, Guasch & Badia 2007; theory F.7.4).
//!
//! ```text
//! ũ̂ = m (ũⁿ + Δt (β₁ ãⁿ + β₂ ãⁿ⁻¹)),   m = 1/(1 + 2 |v| Δt/h)
//! (ũ − ũ̂)/(c Δ) + 4 μ/(ρ h²) ũ = −(∇p/ρ + (v − v̂)/Δ − b − f)          ã = (ũ − ũ̂)/Δ
//! ∫q ∇·v − ∫∇q·ũ = 0
//! ```

use super::element::Stabilisation;
use super::system::{TimeStep, VelocityPressureSystem};
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::solid::cut::ElementState;
use crate::pfem2::time::history::StepShares;

/// Velocity and acceleration of the subscales, by element; without entries for stabilisations that have none.
#[derive(Debug, Clone, Default)]
pub struct DynamicSubscales<const D: usize> {
    /// ũ [m/s].
    pub velocity: Vec<Vector<D>>,
    /// ũ̂ of the step [m/s].
    pub convected: Vec<Vector<D>>,
    /// ã [m/s²].
    pub acceleration: Vec<Vector<D>>,
    /// ã of the step before [m/s²].
    pub acceleration_previous: Vec<Vector<D>>,
}

impl<const D: usize> DynamicSubscales<D> {
    /// The subscales of fluids at rest.
    pub fn at_rest(elements: usize) -> Self {
        let zero = vec![Vector::ZERO; elements];
        Self {
            velocity: zero.clone(),
            convected: zero.clone(),
            acceleration: zero.clone(),
            acceleration_previous: zero,
        }
    }

    /// Keeps the accelerations ã ← (ũ − ũ̂)/Δ at the end of a step with the implicit part Δ = `delta` [s] for the next
    /// one. Elements that have no subscale any more forget that they had one.
    pub fn keep_acceleration(&mut self, delta: f64) {
        std::mem::swap(&mut self.acceleration_previous, &mut self.acceleration);
        let Self { velocity, convected, acceleration, acceleration_previous } = self;
        for e in 0..velocity.len() {
            if velocity[e] == Vector::ZERO {
                (acceleration[e], acceleration_previous[e]) = (Vector::ZERO, Vector::ZERO);
            } else {
                acceleration[e] = (velocity[e] - convected[e]) / delta;
            }
        }
    }

    /// Takes the accelerations of the predicted step for those at the start and of the step before, and lets the run
    /// begin without subscales, ũ = 0 (theory H.9).
    pub fn begin(&mut self) {
        self.velocity.fill(Vector::ZERO);
        self.acceleration_previous.clone_from(&self.acceleration);
    }
}

/// c: the velocity that a residual gives a subscale in a step is this part of what it would give the fluid.
const INERTIA: f64 = 0.5;

impl<const D: usize, const N: usize> VelocityPressureSystem<D, N> {
    /// Finds ũ̂ of a step, in which accelerations have these shares.
    pub(in crate::pfem2) fn carry_subscales(&mut self, step: TimeStep, shares: StepShares) {
        let dynamic = &self.subscales.dynamic;
        let [last, earlier] = [shares.start, shares.earlier].map(|share| share * step.dt);
        let convected = parallel::collect(dynamic.velocity.len(), 256, |e| {
            let nodes = self.mesh.elements()[e];
            let speed = nodes.iter().map(|&i| self.velocity[i as usize]).sum::<Vector<D>>().norm() / N as f64;
            let kept =
                dynamic.velocity[e] + dynamic.acceleration[e] * last + dynamic.acceleration_previous[e] * earlier;
            kept / (1.0 + 2.0 * speed * step.dt / self.size[e])
        });
        self.subscales.dynamic.convected = convected;
    }

    /// Finds the velocity ũ of the subscales that belongs to the solution.
    pub(super) fn find_subscales(&mut self, convected: &[Vector<D>]) {
        let count = self.subscales.dynamic.velocity.len();
        self.subscales.dynamic.velocity = parallel::collect(count, 256, |e| self.subscale_velocity(e, convected));
    }

    /// ũ of an element [m/s]; zero where there is no fluid, or several.
    fn subscale_velocity(&self, e: usize, convected: &[Vector<D>]) -> Vector<D> {
        let (content, volume) = (&self.contents[e], self.fluid_volume(e));
        let nodes = &self.mesh.elements()[e];
        if !self.pure[e] || content.volume_over_density == 0.0 || volume == 0.0 {
            return Vector::ZERO;
        }
        let slope =
            (0..N).map(|k| self.mesh.simplex(e).gradient[k] * self.pressure[nodes[k] as usize]).sum::<Vector<D>>();
        let force = self.elements(convected).drive(e, false).forces_of(&self.equations, [true; N]);
        let inertia = self.mean_acceleration(e, convected);
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
}

impl Stabilisation {
    /// c; one where subscales follow at once.
    pub(super) fn subscale_inertia(self) -> f64 {
        if self == Self::Dynamic { INERTIA } else { 1.0 }
    }
}
