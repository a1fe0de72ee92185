//! The times of a step, and of the sub-steps that membranes take in it.

/// The times of one leapfrog step [s]: positions and stresses live at full steps, velocities between them (theory A.5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeapfrogStep {
    /// Start, tⁿ.
    pub t: f64,
    /// Positions move by dt^{n+½}.
    pub dt: f64,
    /// The step before, dt^{n−½}; 0 at the start.
    pub dt_previous: f64,
    /// Momentum advances by dtⁿ = ½(dt^{n−½} + dt^{n+½}).
    pub momentum_dt: f64,
}

impl LeapfrogStep {
    pub(super) fn new(t: f64, dt: f64, dt_previous: f64) -> Self {
        Self { t, dt, dt_previous, momentum_dt: 0.5 * (dt_previous + dt) }
    }

    /// The longer of its two increments, which has to be stable [s]: where a short step follows a long one,
    /// the momentum takes half of both.
    pub fn longer(&self) -> f64 {
        self.dt.max(self.momentum_dt)
    }

    /// The time at which the velocities before the step hold, t^{n−½} [s].
    pub fn before(&self) -> f64 {
        self.t - 0.5 * self.dt_previous
    }

    /// The time at which the velocities after the step hold, t^{n+½} [s].
    pub fn after(&self) -> f64 {
        self.t + 0.5 * self.dt
    }
}

/// A sub-step of the membranes within a step.
#[derive(Debug, Clone, Copy)]
pub struct SubStep<'a> {
    /// The step.
    pub step: &'a LeapfrogStep,
    /// Beginning of the sub-step after the start of the step, for positions [s].
    pub elapsed: f64,
    /// Length [s].
    pub dt: f64,
    /// End of the sub-step after the start of the step, for the momentum of bodies and sheets [s].
    pub momentum_end: f64,
    /// Length for the momentum [s].
    pub momentum_dt: f64,
}
