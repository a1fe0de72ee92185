//! Velocities and accelerations of earlier steps, which a step of second order extrapolates from (theory F.2, F.5).
//!
//! ```text
//! β₂ = (θ − ½) Δt/Δtⁿ,   β₁ = 1 − θ − β₂                        explicit weights of the accelerations; theory (F.8)
//! v* = vⁿ + ½Δt (vⁿ − vⁿ⁻¹)/Δtⁿ + c (vⁿ − 2vⁿ⁻¹ + vⁿ⁻²)     convecting velocity, c = 5/6 − θ (equal steps); theory F.5
//! ```
//!
//! vⁿ itself is the velocity of the system; the paper's scheme takes nothing from here.

use crate::math::Vector;
use crate::pfem2::ThetaStep;
use crate::pfem2::theta_step::Scheme;

/// A step may be as many times longer than the one before: twice as long, from two to one between outputs, at most.
pub(in crate::pfem2) const LARGEST_CHANGE: f64 = 2.0;

/// Room for rounding where times are compared.
const ROUNDING: f64 = 1.0 + 1e-9;

/// The weights with which forces and powers at three times act in a step (theory (F.8)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::pfem2) struct StepWeights {
    /// Length of the step [s].
    pub dt: f64,
    /// θ, of its end.
    pub end: f64,
    /// β₁, of its start.
    pub start: f64,
    /// β₂, of the start of the step before.
    pub earlier: f64,
}

impl StepWeights {
    /// Weights of backward Euler, for a step of `dt` [s].
    pub fn backward_euler(dt: f64) -> Self {
        Self { dt, end: 1.0, start: 0.0, earlier: 0.0 }
    }
}

/// The steps before, at the nodes.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct TimeHistory<const D: usize> {
    /// Time integration.
    pub scheme: Scheme,
    /// vⁿ⁻¹ [m/s].
    pub velocity_previous: Vec<Vector<D>>,
    /// vⁿ⁻² [m/s].
    pub velocity_earlier: Vec<Vector<D>>,
    /// aⁿ [m/s²].
    pub acceleration: Vec<Vector<D>>,
    /// aⁿ⁻¹ of the fluid that is at the nodes now [m/s²].
    pub acceleration_previous: Vec<Vector<D>>,
    /// The last step [s]; 0 before the first.
    pub dt_previous: f64,
    /// The step before it [s].
    pub dt_earlier: f64,
}

impl<const D: usize> TimeHistory<D> {
    /// The history of a fluid that starts with these nodal velocities [m/s].
    pub fn new(scheme: Scheme, velocity: &[Vector<D>]) -> Self {
        Self {
            scheme,
            velocity_previous: velocity.to_vec(),
            velocity_earlier: velocity.to_vec(),
            acceleration: vec![Vector::ZERO; velocity.len()],
            acceleration_previous: vec![Vector::ZERO; velocity.len()],
            dt_previous: 0.0,
            dt_earlier: 0.0,
        }
    }

    /// Forgets all steps: the fluid starts with these nodal velocities [m/s].
    pub fn clear(&mut self, velocity: &[Vector<D>]) {
        *self = Self::new(self.scheme, velocity);
    }

    /// Steps of `dt` [s] before the start, continued backwards from the velocities at the `start` and at the `end`
    /// of the first step [m/s]; the accelerations stay.
    pub fn extrapolate_backwards(&mut self, dt: f64, start: &[Vector<D>], end: &[Vector<D>]) {
        let both = || start.iter().zip(end);
        self.velocity_previous = both().map(|(start, end)| *start * 2.0 - *end).collect();
        self.velocity_earlier = both().map(|(start, end)| *start * 3.0 - *end * 2.0).collect();
        (self.dt_previous, self.dt_earlier) = (dt, dt);
    }

    /// The implicit weight θ of a step of `dt` [s].
    pub fn implicit_weight(&self, dt: f64) -> f64 {
        match self.scheme {
            Scheme::SecondOrder { theta } if self.extends_over(dt) => theta,
            _ => 1.0,
        }
    }

    /// β₁ and β₂ (theory (F.8)).
    pub fn explicit_weights(&self, step: ThetaStep) -> [f64; 2] {
        match self.scheme {
            Scheme::SecondOrder { theta } if self.extends_over(step.dt) => {
                let earlier = (theta - 0.5) * step.dt / self.dt_previous;
                [1.0 - theta - earlier, earlier]
            }
            _ => [0.0, 0.0],
        }
    }

    /// The weights of a step in forces and powers at three times.
    pub fn step_weights(&self, step: ThetaStep) -> StepWeights {
        let [start, earlier] = self.explicit_weights(step);
        StepWeights { dt: step.dt, end: step.theta, start, earlier }
    }

    /// The explicit part of the velocity increment at the nodes, Δt (β₁ aⁿ + β₂ aⁿ⁻¹) [m/s].
    pub fn explicit_increment(&self, step: ThetaStep) -> Vec<Vector<D>> {
        let [last, earlier] = self.explicit_weights(step).map(|weight| weight * step.dt);
        let both = self.acceleration.iter().zip(&self.acceleration_previous);
        both.map(|(a, previous)| *a * last + *previous * earlier).collect()
    }

    /// Weights of vⁿ, vⁿ⁻¹ and vⁿ⁻² in the convecting velocity v* (theory (F.15)).
    pub fn convecting_weights(&self, step: ThetaStep) -> [f64; 3] {
        match self.scheme {
            Scheme::SecondOrder { theta } if self.extends_over(step.dt) => {
                let part = if self.bends_over(step.dt) { second_difference_weight(theta) } else { 0.0 };
                convecting_weights(step.dt, [self.dt_previous, self.dt_earlier], part)
            }
            _ => [1.0, 0.0, 0.0],
        }
    }

    /// The convecting velocity v* at the nodes, where vⁿ is `velocity` [m/s].
    pub fn convecting_velocity(&self, step: ThetaStep, velocity: &[Vector<D>]) -> Vec<Vector<D>> {
        let weights = self.convecting_weights(step);
        if weights == [1.0, 0.0, 0.0] {
            return velocity.to_vec();
        }
        let all = velocity.iter().zip(&self.velocity_previous).zip(&self.velocity_earlier);
        all.map(|((v, previous), earlier)| *v * weights[0] + *previous * weights[1] + *earlier * weights[2]).collect()
    }

    /// True if the last step says how the flow changes over the next: after a much shorter one, as outputs may cut
    /// it, the extrapolation would multiply what is left of round-off, and the step starts anew with first order.
    fn extends_over(&self, dt: f64) -> bool {
        self.dt_previous > 0.0 && dt <= LARGEST_CHANGE * ROUNDING * self.dt_previous
    }

    /// True if the last two steps say how the change of the flow changes.
    fn bends_over(&self, dt: f64) -> bool {
        self.extends_over(dt)
            && self.dt_earlier > 0.0
            && self.dt_previous <= LARGEST_CHANGE * ROUNDING * self.dt_earlier
    }

    /// Keeps vⁿ [m/s] before the system of a step is solved.
    pub fn keep_velocity(&mut self, velocity: &[Vector<D>]) {
        std::mem::swap(&mut self.velocity_earlier, &mut self.velocity_previous);
        self.velocity_previous.copy_from_slice(velocity);
    }

    /// Keeps the acceleration (v − v̂)/(θ Δt) of a step for the next one, from the velocity at its end and
    /// the convected one [m/s].
    pub fn keep_acceleration(&mut self, step: ThetaStep, velocity: &[Vector<D>], convected: &[Vector<D>]) {
        self.acceleration.clear();
        let both = velocity.iter().zip(convected);
        self.acceleration.extend(both.map(|(v, hat)| (*v - *hat) / step.delta()));
    }

    /// Goes on to the next step after one of `dt` [s].
    pub fn advance(&mut self, dt: f64) {
        self.dt_earlier = self.dt_previous;
        self.dt_previous = dt;
    }
}

/// The weight of the second difference in v* with which errors of forces and of streamlines cancel in a wave:
/// both change its frequency, by parts θ − 5/12 and (1 − weight) 5/12 of (ωΔt)²/2. Theory (F.15)–(F.18).
fn second_difference_weight(theta: f64) -> f64 {
    (2.0 - 2.4 * theta).max(0.0)
}

/// Weights of vⁿ, vⁿ⁻¹ and vⁿ⁻² in v*, the mean over a step `dt` of the line through the first two, and of the part
/// `part` of what a parabola through all three adds; `last` and `earlier` are the steps between them [s]. Theory
/// (F.15).
fn convecting_weights(dt: f64, [last, earlier]: [f64; 2], part: f64) -> [f64; 3] {
    let slope = 0.5 * dt / last;
    // ∫ s (s + Δtⁿ) ds/Δt over the step, divided as the divided difference is
    let curve = part * dt * (dt / 3.0 + 0.5 * last) / (last + earlier);
    let [near, far] = if part > 0.0 { [curve / last, curve / earlier] } else { [0.0; 2] };
    [1.0 + slope + near, -slope - near - far, far]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over the step of what is known at three times is exact for parabolas, whatever the steps.
    #[test]
    fn the_whole_second_difference_makes_the_mean_of_a_parabola_exact() {
        let (dt, last, earlier) = (0.3, 0.2, 0.15);
        let v = |t: f64| 2.0 - 3.0 * t + 5.0 * t * t;
        let weights = convecting_weights(dt, [last, earlier], 1.0);
        let mean = weights[0] * v(0.0) + weights[1] * v(-last) + weights[2] * v(-last - earlier);
        let exact = 2.0 - 3.0 * dt / 2.0 + 5.0 * dt * dt / 3.0;
        assert!((mean - exact).abs() < 1e-14, "{mean} {exact}");
        let line = convecting_weights(dt, [last, earlier], 0.0);
        assert!((line[0] * 1.0 + line[1] * (1.0 - last) - (1.0 + 0.5 * dt)).abs() < 1e-15 && line[2] == 0.0);
    }

    /// η' = w along v*, w' = −ω² η with the weights of the scheme: amplitude and phase after ten periods.
    fn wave(theta: f64, part: f64, steps: usize) -> (f64, f64) {
        let dt = std::f64::consts::TAU / steps as f64;
        let [w0, w1, w2] = convecting_weights(dt, [dt, dt], part);
        let (b1, b2) = (1.5 - 2.0 * theta, theta - 0.5);
        let at = |n: f64| (n * dt).cos();
        let (mut eta, mut v, mut a) = (1.0, [0.0, (dt).sin(), (2.0 * dt).sin()], [-1.0, -at(-1.0)]);
        for _ in 0..10 * steps {
            eta += dt * (w0 * v[0] + w1 * v[1] + w2 * v[2]);
            let now = -eta;
            let next = v[0] + dt * (theta * now + b1 * a[0] + b2 * a[1]);
            (v, a) = ([next, v[0], v[1]], [now, a[0]]);
        }
        (eta.hypot(v[0]), (-v[0]).atan2(eta))
    }

    /// With c = 5/6 − θ the frequency of a wave is exact to fourth order, and none grows; without, phase is of second
    /// order and waves grow.
    #[test]
    fn waves_keep_their_frequency_and_never_grow() {
        let (amplitude, phase) = wave(0.6, second_difference_weight(0.6), 20);
        assert!(amplitude < 1.0 && amplitude > 0.8, "{amplitude}");
        let order = (phase.abs() / wave(0.6, second_difference_weight(0.6), 40).1.abs()).log2();
        assert!(order > 3.7, "{order}");
        let (grown, late) = wave(0.6, 0.0, 20);
        assert!(grown > 1.1 && late.abs() > 10.0 * phase.abs(), "{grown} {late} {phase}");
        // ωΔt from 0.1 to 1.5
        let steps = [4, 5, 6, 8, 12, 20, 60];
        assert!(steps.into_iter().all(|steps| wave(0.6, second_difference_weight(0.6), steps).0 < 1.0));
    }
}
