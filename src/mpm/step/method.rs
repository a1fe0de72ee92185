//! The choices of a case, and the clock of a run.

use super::LeapfrogStep;
use super::schedule::SweepSchedule;
use crate::math::{Signal, Vector};
use crate::mpm::executor::OperationParameters;
use crate::mpm::motion::Landing;
use crate::mpm::{Dissipation, Locking, Transfer};

/// The choices of a case that every step follows.
#[derive(Debug)]
pub(in crate::mpm) struct MethodChoices<const D: usize> {
    pub transfer: Transfer,
    /// The sweeps of a step, by stress update and locking.
    pub schedule: SweepSchedule,
    pub locking: Locking,
    /// Time between two noise filters [s].
    pub filter_time: f64,
    /// The fate of the energy that the transfer dissipates.
    pub dissipation: Dissipation,
    /// Fraction of the stable step of the bodies.
    pub safety: f64,
    /// Body force per unit mass [m/s²].
    pub gravity: [Signal; D],
}

impl<const D: usize> MethodChoices<D> {
    /// Gravity that is the same everywhere at time `t` acts on the nodes [m/s²]; other gravity on the particles.
    pub fn uniform_gravity(&self, t: f64) -> Vector<D> {
        let uniform = self.gravity.iter().all(Signal::is_uniform);
        Vector::from_fn(|a| if uniform { self.gravity[a].value([0.0; 3], t) } else { 0.0 })
    }

    /// The part of the particles' velocity that comes from v⁺ itself (theory A.6).
    pub fn pic_fraction(&self, dt: f64) -> f64 {
        match self.transfer {
            Transfer::Flip { relaxation, .. } => -(-dt / relaxation).exp_m1(),
            Transfer::Apic => 1.0,
        }
    }

    /// Order of the noise filter if it is due in this step, else 0. It is due by time, not by steps: a viscous gas or
    /// a short step would be filtered more often for no more noise.
    pub fn due_filter(&self, step: &LeapfrogStep) -> u32 {
        match self.transfer {
            Transfer::Flip { filter_order, .. }
                if ((step.t + step.dt) / self.filter_time).floor() > (step.t / self.filter_time).floor() =>
            {
                filter_order
            }
            _ => 0,
        }
    }

    /// The numbers of a step that operations on particles need, with stresses updated over `strain_dt` [s].
    pub fn parameters(&self, step: &LeapfrogStep, strain_dt: f64, landing: Landing<D>) -> OperationParameters<D> {
        let blend = match self.locking {
            Locking::None => 0.0,
            Locking::Average { blend } => blend,
        };
        let (momentum_dt, dissipation) = (step.momentum_dt, self.dissipation);
        OperationParameters {
            momentum_dt,
            pic_fraction: self.pic_fraction(momentum_dt),
            strain_dt,
            blend,
            dissipation,
            landing,
        }
    }
}

/// The steps that a run has taken, and the next.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::mpm) struct StepCount {
    /// The last step [s].
    pub dt_previous: f64,
    /// The bound of the next step [s].
    pub bound: f64,
    /// Number of steps so far.
    pub steps: u64,
}
