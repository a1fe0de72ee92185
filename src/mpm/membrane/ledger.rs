//! The ledger of energy and momentum of a membrane (theory C.11).

use crate::simulation::{CompensatedSum, Record};
use bytemuck::{Pod, Zeroable};

/// Running sums since the start, a column of checkpoints. Impulses are padded with zeros in 2D.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct MembraneLedger {
    /// The last displacement step, Δt^{n−½} [s].
    pub displacement_dt: f64,
    /// Greatest ω² of an element [1/s²].
    pub frequency2: f64,
    /// Kinetic energy at the start [J].
    pub kinetic_start: f64,
    /// Strain energy at the start [J].
    pub strain_start: f64,
    /// Strain energy [J].
    pub strain: CompensatedSum,
    /// Work taken up by the hourglass control [J].
    pub hourglass: CompensatedSum,
    /// Loss to stiffness-proportional damping [J].
    pub stiffness_damping: CompensatedSum,
    /// Work of the element forces still to be done at the new velocity, half a step [J].
    pub half_step: f64,
    /// Work of the element forces on the nodes [J].
    pub elements: CompensatedSum,
    /// Work of the pressure [J].
    pub pressure: CompensatedSum,
    /// Work of gravity [J].
    pub gravity: CompensatedSum,
    /// Work of the contact forces [J].
    pub contact: CompensatedSum,
    /// Loss to mass-proportional damping [J].
    pub mass_damping: CompensatedSum,
    /// Work of the supports [J].
    pub supports: CompensatedSum,
    /// Impulse of pressure and gravity less mass damping [N s].
    pub external_impulse: [CompensatedSum; 3],
    /// Impulse of the contact forces [N s].
    pub contact_impulse: [CompensatedSum; 3],
    /// Impulse of the supports [N s].
    pub support_impulse: [CompensatedSum; 3],
}

impl Record for MembraneLedger {
    type Number = f64;
}

/// Energies of a membrane now and works since the start [J]:
/// Δ(kinetic + strain + hourglass) = pressure + gravity + supports + contact − damping + mismatch + closure.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Kinetic energy now.
    pub kinetic: f64,
    /// Kinetic energy at the start.
    pub kinetic_start: f64,
    /// Strain energy now, carried on by half a step to the time of the velocities.
    pub strain: f64,
    /// Strain energy at the start.
    pub strain_start: f64,
    /// Work taken up by the hourglass control.
    pub hourglass: f64,
    /// Loss to damping.
    pub damping: f64,
    /// Work of the pressure.
    pub pressure: f64,
    /// Work of gravity.
    pub gravity: f64,
    /// Work of the supports (prescribed motion).
    pub supports: f64,
    /// Work of the contact forces on the nodes, W_c.
    pub contact: f64,
    /// Energy that the integration of stresses made, ε_r.
    pub mismatch: f64,
}

impl Balance {
    /// The energy that no term accounts for [J]: rounding, if the ledger is right.
    pub fn closure(&self) -> f64 {
        let stored = self.kinetic - self.kinetic_start + self.strain - self.strain_start + self.hourglass;
        let gained = self.pressure + self.gravity + self.supports + self.contact + self.mismatch;
        stored - gained + self.damping
    }
}

impl MembraneLedger {
    /// The balance with the given kinetic energy [J].
    pub fn balance(&self, kinetic: f64) -> Balance {
        let strain = self.strain.value() + self.half_step;
        let (hourglass, stiffness_damping) = (self.hourglass.value(), self.stiffness_damping.value());
        let taken_up = strain - self.strain_start + hourglass + stiffness_damping;
        Balance {
            kinetic,
            kinetic_start: self.kinetic_start,
            strain,
            strain_start: self.strain_start,
            hourglass,
            damping: stiffness_damping + self.mass_damping.value(),
            pressure: self.pressure.value(),
            gravity: self.gravity.value(),
            supports: self.supports.value(),
            contact: self.contact.value(),
            mismatch: taken_up + self.elements.value(),
        }
    }

    /// Impulses since the start [N s]: of pressure, gravity and damping; of contact; of the supports.
    pub fn impulses(&self) -> [[f64; 3]; 3] {
        [self.external_impulse, self.contact_impulse, self.support_impulse].map(|j| j.map(CompensatedSum::value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten thousand works and impulses of less than half a unit in the last place of 10⁹: each of them alone is rounded off.
    #[test]
    fn small_works_and_impulses_are_kept_beside_large_ones() {
        const TERM: f64 = 5e-8;
        let mut ledger = MembraneLedger::default();
        for amount in std::iter::once(1e9).chain(std::iter::repeat_n(TERM, 10_000)) {
            let MembraneLedger { strain, hourglass, stiffness_damping, elements, pressure, .. } = &mut ledger;
            [strain, hourglass, stiffness_damping, elements, pressure].into_iter().for_each(|sum| sum.add(amount));
            let MembraneLedger { gravity, contact, mass_damping, supports, .. } = &mut ledger;
            [gravity, contact, mass_damping, supports].into_iter().for_each(|sum| sum.add(amount));
            let MembraneLedger { external_impulse, contact_impulse, support_impulse, .. } = &mut ledger;
            [external_impulse, contact_impulse, support_impulse].into_iter().flatten().for_each(|sum| sum.add(amount));
        }
        let expected = 1e9 + 1e4 * TERM;
        let balance = ledger.balance(0.0);
        let Balance { strain, hourglass, pressure, gravity, supports, contact, .. } = balance;
        for found in [strain, hourglass, pressure, gravity, supports, contact, 0.5 * balance.damping] {
            assert!((found - expected).abs() < 2e-7, "{found} {expected}");
        }
        assert!((balance.mismatch - 4.0 * expected).abs() < 1e-6, "{balance:?}");
        assert!(ledger.impulses().as_flattened().iter().all(|j| (j - expected).abs() < 2e-7));
    }
}
