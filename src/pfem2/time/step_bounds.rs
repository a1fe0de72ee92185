//! Bounds of the step by waves on interfaces and by the flow (theory H.6–H.8).

use super::step_control::StepControl;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::balance::EnergyBalance;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::theta_step::Scheme;

/// Part of the bound by capillary waves that an automatic step takes. At the bound a drop of water of ten elements in
/// air stirs up the air by 7 m/s, at half of it by 4 m/s, at a quarter by 0.1 m/s; heavier gases are calm at the bound.
const CAPILLARY_FRACTION: f64 = 0.25;

/// ωΔt of the shortest wave up to which waves on water in a box of 20 × 20 cells don't grow; at 1.73 they do.
const LARGEST_OMEGA_DT: f64 = 1.5;

/// The first step, over the longest that bounds allow: nothing is known yet of how the flow will change.
const START: f64 = 0.1;

/// The shortest step, over what carries the flow through one element and over the bounds of waves: noise of particles
/// doesn't shrink with the step, and shorter steps would follow nothing else. Impacts of solids have shorter ones.
const SHORTEST_STEP: f64 = 0.05;

/// Times at which lids and inlets are asked for their speed.
const SAMPLES: usize = 16;

/// Bounds of the step, and the control of automatic ones.
#[derive(Debug, Clone, Copy)]
pub(in crate::pfem2) struct StepLimits {
    /// Bound of ωΔt for waves on interfaces.
    max_omega_dt: f64,
    /// Elements that a particle may cross in a step; infinity: no bound.
    courant: f64,
    /// Automatic steps.
    pub control: StepControl,
}

impl StepLimits {
    /// Limits of a scheme, with a Courant number and the largest error of a step over that of the mesh; infinity: no
    /// bound.
    pub fn new(scheme: Scheme, courant: f64, tolerance: f64) -> Self {
        Self { max_omega_dt: max_omega_dt(scheme), courant, control: StepControl::new(tolerance) }
    }

    /// The longest stable step [s].
    pub fn stable_dt<const D: usize, const N: usize>(&self, system: &VelocityPressureSystem<D, N>) -> f64 {
        self.wave_dt(system).min(self.courant_dt(system))
    }

    /// The longest step in which the shortest wave on an interface doesn't grow [s] (theory H.7).
    fn wave_dt<const D: usize, const N: usize>(&self, system: &VelocityPressureSystem<D, N>) -> f64 {
        self.max_omega_dt / system.wave_frequency()
    }

    /// The longest step with which surface tension leaves the lighter fluid at rest [s] (theory H.8).
    fn capillary_dt<const D: usize, const N: usize>(&self, system: &VelocityPressureSystem<D, N>) -> f64 {
        CAPILLARY_FRACTION * self.max_omega_dt / system.capillary_frequency()
    }

    /// The longest step as far as waves go [s].
    fn interface_dt<const D: usize, const N: usize>(&self, system: &VelocityPressureSystem<D, N>) -> f64 {
        self.wave_dt(system).min(self.capillary_dt(system))
    }

    /// The step in which no particle crosses more elements than asked for [s].
    fn courant_dt<const D: usize, const N: usize>(&self, system: &VelocityPressureSystem<D, N>) -> f64 {
        if self.courant.is_finite() { system.crossing_time() * self.courant } else { f64::INFINITY }
    }

    /// The automatic step after so many `steps` [s].
    pub fn automatic_dt<const D: usize, const N: usize>(
        &self,
        system: &VelocityPressureSystem<D, N>,
        steps: u64,
    ) -> f64 {
        let waves = self.interface_dt(system);
        let bound = waves.min(self.courant_dt(system));
        match steps {
            _ if !self.control.is_active() => bound,
            0 => START * bound,
            _ => {
                let shortest = (SHORTEST_STEP * waves.min(system.crossing_time())).min(self.control.impact);
                bound.min(self.control.recommended.max(shortest))
            }
        }
    }

    /// The shortest and the longest automatic steps that may be expected in a flow of this speed [m/s]: of one element
    /// and of `courant`. `None` where nothing tells the speed.
    pub fn foreseen<const D: usize, const N: usize>(
        &self,
        system: &VelocityPressureSystem<D, N>,
        speed: f64,
    ) -> Option<[f64; 2]> {
        let crossing = system.shortest() / speed;
        let waves = self.interface_dt(system);
        let least = crossing.min(0.2 * waves);
        crossing.is_finite().then(|| [least, waves.min(crossing * self.courant).max(least)])
    }
}

/// Bound of ωΔt. The interface moves with a velocity that is known before the pressure is: the paper's scheme bears 2
/// (theory H.7). The second order's bears √(1/(2θ − 1)), where the shortest wave changes its sign from step to step;
/// below that its waves grow a little in theory, and the damping of the scheme outweighs it up to [`LARGEST_OMEGA_DT`].
fn max_omega_dt(scheme: Scheme) -> f64 {
    match scheme {
        Scheme::SecondOrder { theta } => LARGEST_OMEGA_DT.min((2.0 * theta - 1.0).max(0.0).sqrt().recip()),
        Scheme::BackwardEuler => 2.0,
    }
}

/// The speed that the start, walls and inlets up to the time `end` [s], and the fall of fluids can make [m/s].
pub(in crate::pfem2) fn foreseen_speed<const D: usize, const N: usize>(
    system: &VelocityPressureSystem<D, N>,
    balance: &EnergyBalance<D>,
    end: f64,
) -> f64 {
    let VelocityPressureSystem { mesh, boundary, velocity, .. } = system;
    let times = (0..=SAMPLES).map(|k| end * k as f64 / SAMPLES as f64);
    let fastest = |held: Vec<(usize, Vector<D>)>| parallel::max(held.len(), |n| held[n].1.norm());
    let held = times.map(|t| fastest(boundary.held(mesh, t))).fold(0.0, f64::max);
    let start = parallel::max(velocity.len(), |i| velocity[i].norm());
    let fall = balance.available.as_ref().map_or(0.0, |available| available.energy());
    // The heavy parts of a flow are about as fast as if all that can be set free moved them alone.
    held.max(start).max((2.0 * fall / balance.totals.mass).sqrt())
}
