//! Energy of solids in the balance of a run (theory J.6).
//!
//! ```text
//! kinetic      ½ vᵀ M v              strain        ∫W(F) dV
//! gravity      Δt v·M b              supports      Δt v·(reactions and loads)
//! ```
//!
//! The fluid does on the cut points the work that the solid takes, in one system: it enters neither, and cancels in
//! their sum.

use crate::pfem2::history::StepWeights;
use crate::simulation::TermKind::{Gain, Stored};
use crate::simulation::{BalanceTerm, CompensatedSum, Record};
use bytemuck::{Pod, Zeroable};

/// Energies of solids [J], and powers from outside [W], at one time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SolidEnergies {
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Strain energy [J].
    pub strain: f64,
    /// Power of gravity [W].
    pub gravity: f64,
    /// Power of supports and loads, less that of damping [W].
    pub supports: f64,
}

impl Record for SolidEnergies {
    type Number = f64;
}

/// Energy of solids since the start, a column of checkpoints.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct SolidEnergy {
    gravity: CompensatedSum,
    supports: CompensatedSum,
    /// State at the end of the last step.
    pub last: SolidEnergies,
    /// State at the end of the step before.
    pub earlier: SolidEnergies,
    /// Kinetic and strain energy at the start [J].
    pub stored: f64,
    /// Kinetic energy that fluids and solids lost in the first step, because their velocities at the start didn't fit
    /// together [J].
    pub mismatch: f64,
}

impl Record for SolidEnergy {
    type Number = f64;
}

impl SolidEnergy {
    /// Opens the account with the state at the start.
    pub fn open(state: SolidEnergies) -> Self {
        Self { last: state, earlier: state, stored: state.kinetic + state.strain, ..Self::default() }
    }

    /// Takes the powers of the predicted step for those at the start, of which the first step takes its explicit part.
    /// Energies stay those of the start.
    pub fn begin(&mut self, predicted: SolidEnergies) {
        let SolidEnergies { gravity, supports, .. } = predicted;
        self.last = SolidEnergies { gravity, supports, ..self.last };
        self.earlier = self.last;
    }

    /// Adds a step by its `step_weights` with the state at its end.
    pub fn add(&mut self, step_weights: StepWeights, now: SolidEnergies) {
        let work = |of: fn(&SolidEnergies) -> f64| {
            step_weights.dt
                * (step_weights.end * of(&now)
                    + step_weights.start * of(&self.last)
                    + step_weights.earlier * of(&self.earlier))
        };
        let [gravity, supports] = [work(|state| state.gravity), work(|state| state.supports)];
        self.gravity.add(gravity);
        self.supports.add(supports);
        (self.earlier, self.last) = (self.last, now);
    }

    /// Energy of the solids that gravity and supports don't explain [J]: what the fluid has given them, less what the
    /// scheme has lost.
    pub fn gained(&self) -> f64 {
        self.last.kinetic + self.last.strain - (self.stored + self.gravity.value() + self.supports.value())
    }

    /// The largest of its terms [J].
    pub fn largest(&self) -> f64 {
        let SolidEnergies { kinetic, strain, .. } = self.last;
        [kinetic, strain, self.gravity.value(), self.supports.value()]
            .iter()
            .fold(0.0, |most, term| most.max(term.abs()))
    }

    /// Terms of the ledger.
    pub fn terms(&self) -> [BalanceTerm; 4] {
        [
            BalanceTerm::energy(Stored, "kinetic energy of solids", self.last.kinetic),
            BalanceTerm::energy(Stored, "strain energy", self.last.strain),
            BalanceTerm::energy(Gain, "work of gravity on solids", self.gravity.value()),
            BalanceTerm::energy(Gain, "work of supports", self.supports.value()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fall: ½ g² t² of kinetic energy per mass, all of it from gravity, with the weights of the trapezoidal rule.
    #[test]
    fn a_falling_solid_gains_what_gravity_gives() {
        let at = |t: f64| SolidEnergies {
            kinetic: 0.5 * (9.81 * t).powi(2),
            gravity: 9.81 * 9.81 * t,
            ..SolidEnergies::default()
        };
        let mut energy = SolidEnergy::open(at(0.0));
        let step_weights = StepWeights { dt: 0.1, end: 0.5, start: 0.5, earlier: 0.0 };
        (1..=10).for_each(|n| energy.add(step_weights, at(0.1 * f64::from(n))));
        assert!(energy.gained().abs() < 1e-12 && energy.largest() > 48.0, "{}", energy.gained());
    }

    /// A beam that bends in the predicted step has at the start the energy that it had.
    #[test]
    fn a_predicted_step_gives_solids_no_energy() {
        let start = SolidEnergies { kinetic: 2.0, strain: 0.5, ..SolidEnergies::default() };
        let mut energy = SolidEnergy::open(start);
        energy.begin(SolidEnergies { kinetic: 1.0, strain: 1.25, gravity: 3.0, supports: -4.0 });
        assert_eq!(energy.gained(), 0.0);
        assert_eq!(energy.last, SolidEnergies { gravity: 3.0, supports: -4.0, ..start });
    }
}
