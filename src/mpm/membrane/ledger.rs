//! The ledger of energy and momentum of a membrane (theory C.11).

use crate::simulation::Record;
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
    pub strain: f64,
    /// Work taken up by the hourglass control [J].
    pub hourglass: f64,
    /// Loss to stiffness-proportional damping [J].
    pub stiffness_damping: f64,
    /// Work of the element forces still to be done at the new velocity, half a step [J].
    pub half_step: f64,
    /// Work of the element forces on the nodes [J].
    pub elements: f64,
    /// Work of the pressure [J].
    pub pressure: f64,
    /// Work of gravity [J].
    pub gravity: f64,
    /// Work of the contact forces [J].
    pub contact: f64,
    /// Loss to mass-proportional damping [J].
    pub mass_damping: f64,
    /// Work of the supports [J].
    pub supports: f64,
    /// Impulse of pressure and gravity less mass damping [N s].
    pub external_impulse: [f64; 3],
    /// Impulse of the contact forces [N s].
    pub contact_impulse: [f64; 3],
    /// Impulse of the supports [N s].
    pub support_impulse: [f64; 3],
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
        let strain = self.strain + self.half_step;
        let taken_up = strain - self.strain_start + self.hourglass + self.stiffness_damping;
        Balance {
            kinetic,
            kinetic_start: self.kinetic_start,
            strain,
            strain_start: self.strain_start,
            hourglass: self.hourglass,
            damping: self.stiffness_damping + self.mass_damping,
            pressure: self.pressure,
            gravity: self.gravity,
            supports: self.supports,
            contact: self.contact,
            mismatch: taken_up + self.elements,
        }
    }
}
