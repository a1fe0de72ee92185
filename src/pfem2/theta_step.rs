//! The time of a step.

/// A step of the θ-scheme: its time, its length and its implicit share (theory F.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThetaStep {
    /// Time at its start [s].
    pub t: f64,
    /// Length of the step [s].
    pub dt: f64,
    /// Implicit share θ; 1: backward Euler.
    pub theta: f64,
}

impl ThetaStep {
    /// Δ = θ Δt [s].
    pub fn delta(&self) -> f64 {
        self.theta * self.dt
    }

    /// Time at its end [s].
    pub fn end(&self) -> f64 {
        self.t + self.dt
    }
}
