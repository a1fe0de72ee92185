//! Time integration: the scheme, and the time of a step.

/// A step of the θ-scheme: its time, its length and its implicit weight (theory F.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThetaStep {
    /// Time at its start [s].
    pub t: f64,
    /// Length of the step [s].
    pub dt: f64,
    /// Implicit weight θ; 1: backward Euler.
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

/// Time integration (theory F.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scheme {
    /// The paper's: streamlines of vⁿ, backward Euler; first order.
    BackwardEuler,
    /// Streamlines of the velocity extrapolated to the middle of the step; forces at its end with the weight θ, at its
    /// start with 3/2 − 2θ and one step before with θ − ½; second order. θ = ½ is the trapezoidal rule, which never
    /// forgets noise; more damps what the step doesn't resolve.
    SecondOrder {
        /// Implicit weight θ, in ½..=1.
        theta: f64,
    },
}

impl Default for Scheme {
    fn default() -> Self {
        Self::SecondOrder { theta: 0.6 }
    }
}
