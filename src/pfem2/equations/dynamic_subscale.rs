//! Subscales that keep their velocity from step to step (Codina, Principe, Guasch & Badia 2007; theory F.7.4).
//!
//! ```text
//! ũ̂ = m (ũⁿ + Δt (β₁ ãⁿ + β₂ ãⁿ⁻¹)),   m = 1/(1 + 2 |v| Δt/h)
//! (ũ − ũ̂)/(c Δ) + 4 μ/(ρ h²) ũ = −(∇p/ρ + (v − v̂)/Δ − b − f)          ã = (ũ − ũ̂)/Δ
//! ∫q ∇·v − ∫∇q·ũ = 0
//! ```

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::element::Stabilisation;

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

    /// Finds ũ̂ of a step of length `dt` [s] in a flow with these nodal velocities [m/s], in which the accelerations at
    /// its start and of the step before have these weights; `size`: of the elements [m].
    pub(super) fn carry<const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        size: &[f64],
        velocity: &[Vector<D>],
        dt: f64,
        weights: [f64; 2],
    ) {
        let [last, earlier] = weights.map(|weight| weight * dt);
        self.convected = parallel::collect(self.velocity.len(), 256, |e| {
            let nodes = mesh.elements()[e];
            let speed = nodes.iter().map(|&i| velocity[i as usize]).sum::<Vector<D>>().norm() / N as f64;
            let kept = self.velocity[e] + self.acceleration[e] * last + self.acceleration_previous[e] * earlier;
            kept / (1.0 + 2.0 * speed * dt / size[e])
        });
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

impl Stabilisation {
    /// c; one where subscales follow at once.
    pub(super) fn subscale_inertia(self) -> f64 {
        if self == Self::Dynamic { INERTIA } else { 1.0 }
    }
}
