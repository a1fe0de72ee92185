//! The state of a rigid solid and its prediction at the end of a step (theory J.11).

use super::freedom::{Freedom, RigidRates};
use crate::math::{Tensor, Vector};
use crate::simulation::Record;
use bytemuck::{Pod, Zeroable};

/// Motion of a rigid solid and of the steps before, a record of checkpoints.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RigidState {
    /// Displacement of the centre of mass [m].
    pub displacement: Vector<3>,
    /// R.
    pub rotation: Tensor<3>,
    /// V at the end of the last steps, the newest first [m/s].
    pub velocity: [Vector<3>; 3],
    /// ω at the end of the last steps [1/s].
    pub spin: [Vector<3>; 3],
    /// Acceleration of the centre of mass at the end of the last steps [m/s²].
    pub acceleration: [Vector<3>; 2],
    /// L about the centre of mass [kg m²/s].
    pub momentum: Vector<3>,
    /// Rate of the angular momentum at the end of the last steps [N m].
    pub torque: [Vector<3>; 2],
}

impl Record for RigidState {
    type Number = f64;
}

/// Prediction of a rigid solid at the end of a step.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidPrediction {
    /// ĉ [m].
    pub(super) displacement_hat: Vector<3>,
    /// V̂ [m/s].
    pub(super) velocity_hat: Vector<3>,
    /// L̂ [kg m²/s].
    pub(super) momentum_hat: Vector<3>,
    /// Δt (β₁ ωⁿ + β₂ ωⁿ⁻¹).
    pub(super) turned: Vector<3>,
    /// c* [m].
    pub displacement: Vector<3>,
    /// R*.
    pub rotation: Tensor<3>,
    /// J* [kg m²].
    pub(super) inertia: Tensor<3>,
    /// Motions that supports leave free about the prediction.
    pub freedom: Freedom,
    /// The first of its independent velocities.
    pub first: u32,
    /// Displacement along an axis that supports give nodes at the end of the step [m].
    pub(super) supported: Vec<(usize, usize, f64)>,
}

impl RigidPrediction {
    /// V and ω, of the independent velocities of all solids.
    pub fn rates(&self, w: &[f64]) -> RigidRates {
        self.freedom.rates(&w[self.first as usize..][..self.freedom.free.len()])
    }
}

impl RigidState {
    /// A solid at rest in the reference state but for these rates, with the moments of inertia J₀ [kg m²].
    pub fn new(rates: RigidRates, inertia: &Tensor<3>) -> Self {
        Self {
            displacement: Vector::ZERO,
            rotation: Tensor::identity(),
            velocity: [rates.velocity; 3],
            spin: [rates.spin; 3],
            acceleration: [Vector::ZERO; 2],
            momentum: inertia.apply(rates.spin),
            torque: [Vector::ZERO; 2],
        }
    }

    /// V and ω.
    pub fn rates(&self) -> RigidRates {
        RigidRates { velocity: self.velocity[0], spin: self.spin[0] }
    }

    /// Stops it where it is.
    pub fn rest(&mut self) {
        (self.velocity[0], self.spin[0], self.momentum) = (Vector::ZERO, Vector::ZERO, Vector::ZERO);
    }

    /// Forgets the steps before.
    pub fn clear_history(&mut self) {
        (self.velocity, self.spin) = ([self.velocity[0]; 3], [self.spin[0]; 3]);
        (self.acceleration, self.torque) = ([Vector::ZERO; 2], [Vector::ZERO; 2]);
    }

    /// Begins anew with the velocity that it has, and the forces of the step before.
    pub fn begin_anew(&mut self) {
        (self.velocity, self.spin) = ([self.velocity[0]; 3], [self.spin[0]; 3]);
        (self.acceleration, self.torque) = ([self.acceleration[1]; 2], [self.torque[1]; 2]);
    }

    /// Takes the steps before from the end of a predicted first step: a⁰ = a¹, v⁻¹ = 2 v⁰ − v¹ (theory H.9).
    pub fn begin(&mut self, end: &Self) {
        let backwards = |start: Vector<3>, end: Vector<3>| [start, start * 2.0 - end, start * 3.0 - end * 2.0];
        self.velocity = backwards(self.velocity[0], end.velocity[0]);
        self.spin = backwards(self.spin[0], end.spin[0]);
        (self.acceleration, self.torque) = ([end.acceleration[0]; 2], [end.torque[0]; 2]);
    }
}
