//! One increment of one particle, as solid laws see it: the motion, the state before it, the stress after it.

use super::kinematics;
use crate::math::{SymTensor, Tensor};

/// Motion of one particle during one increment.
#[derive(Debug, Clone, Copy)]
pub struct Increment {
    /// Duration Δt [s].
    pub dt: f64,
    /// Velocity gradient L½ in the middle of the increment [1/s].
    pub gradient: Tensor<3>,
    /// Deviator of the strain increment, D' Δt.
    pub shear: SymTensor,
    /// Volume ratio J = V^{n+1}/V0 at the end.
    pub volume_ratio: f64,
}

impl Increment {
    /// The rotation of the increment (theory B.2).
    #[inline(always)]
    pub fn rotation(&self) -> Tensor<3> {
        kinematics::rotation(&self.gradient, self.dt)
    }
}

/// State of one particle that a law reads and writes.
#[derive(Debug)]
pub struct Point<'a> {
    /// Deviator sⁿ of the stress at the start [Pa].
    pub deviator: SymTensor,
    /// Deformation gradient F^{n+1} at the end, det F = J; the identity for laws that don't store it.
    pub deformation: Tensor<3>,
    /// History variables: at the start, to be left as at the end.
    pub history: &'a mut [f64],
}

/// Answer of a law.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    /// Cauchy stress σ^{n+1} [Pa], without artificial viscosity.
    pub stress: SymTensor,
    /// Modulus ρ c² of the fastest wave in the current state [Pa].
    pub modulus: f64,
}
