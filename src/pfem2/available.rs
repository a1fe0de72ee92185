//! The work that gravity can do in a closed box: what the fluids lose of potential energy when the heavy ones come to rest
//! below the light ones (Lorenz 1955).
//!
//! ```text
//! A = Σ m φ at the start − Σ m φ of the same volumes sorted by density,      φ = −b·x
//! ```
//!
//! Against it, and against the kinetic energy that the flow has had at most, stands what it has gained from nothing: waves on
//! an interface that grow with the step, fluid that leaks through the other, pressure that pushes along a wall.

use super::health;
use super::implicit::Implicit;
use crate::error::StepError;

/// Part of the largest kinetic energy that errors of discretisation may make.
const ALLOWED: f64 = 0.5;

/// Part of A, and of the work that lifts all fluid by an element, below which nothing is said: fluids at rest stir a little.
const NOTHING: f64 = 1e-3;

/// So many times more is no flow any more.
const HOPELESS: f64 = 10.0;

/// What gravity can do from the start on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Available {
    /// Σ m φ at the start [J].
    pub start: f64,
    /// A [J].
    pub energy: f64,
    /// Work that lifts all fluid by the shortest edge [J].
    lift: f64,
}

/// What the energy from nothing tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It can be.
    Possible,
    /// It is more than errors of discretisation make.
    TooMuch,
}

impl Available {
    /// Of the state at the start, with Σ m φ = `start` [J]; `None` where fluid may come in or leave, or gravity is no steady, uniform one.
    pub fn new<const D: usize, const N: usize>(implicit: &Implicit<D, N>, start: f64) -> Option<Self> {
        let gravity = implicit.physics.steady_gravity()?;
        if implicit.boundary.kinds.iter().any(|kind| kind.is_open()) || gravity.norm() == 0.0 {
            return None;
        }
        let mut slots: Vec<(f64, f64)> = (0..implicit.mesh.elements().len())
            .map(|e| (-gravity.dot(implicit.mesh.center(e)), implicit.mesh.simplex(e).volume))
            .collect();
        slots.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut fluids: Vec<(f64, f64)> =
            implicit.physics.fluids.iter().zip(&implicit.volumes).map(|(fluid, v)| (fluid.density, *v)).collect();
        fluids.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mass: f64 = fluids.iter().map(|(density, volume)| density * volume).sum();
        let energy = (start - sorted(&slots, &fluids)).max(0.0);
        Some(Self { start, energy, lift: mass * gravity.norm() * implicit.shortest() })
    }

    /// Whether a flow whose kinetic energy was `peak` at most may have gained this energy from nothing [J].
    ///
    /// # Errors
    /// It is many times what there was; the fastest node is named.
    pub fn judge<const D: usize, const N: usize>(
        &self,
        (gained, peak): (f64, f64),
        implicit: &Implicit<D, N>,
    ) -> Result<Verdict, StepError> {
        if gained > HOPELESS * (self.energy + self.lift) {
            return Err(health::runaway(implicit, gained, self.energy));
        }
        let most = (ALLOWED * peak).max(NOTHING * (self.energy + self.lift));
        Ok(if gained > most { Verdict::TooMuch } else { Verdict::Possible })
    }
}

/// Σ m φ of fluids (density, volume), heaviest first, in slots (φ, volume), lowest first [J].
fn sorted(slots: &[(f64, f64)], fluids: &[(f64, f64)]) -> f64 {
    let mut fluids = fluids.iter().copied();
    let (mut density, mut left) = fluids.next().unwrap_or_default();
    let mut energy = 0.0;
    for &(phi, mut room) in slots {
        while room > left {
            energy += density * left * phi;
            room -= left;
            let Some(next) = fluids.next() else { return energy };
            (density, left) = next;
        }
        energy += density * room * phi;
        left -= room;
    }
    energy
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Water (1000) on oil (800), two slots of one cubic metre, 0.5 and 1.5 m high under 10 m/s²: 1000 kg sink by a metre,
    /// 800 kg rise.
    #[test]
    fn what_falls_below_what_floats_is_available() {
        let slots = [(5.0, 1.0), (15.0, 1.0)];
        let least = sorted(&slots, &[(1000.0, 1.0), (800.0, 1.0)]);
        assert_eq!(least, 5.0 * 1000.0 + 15.0 * 800.0);
        let start: f64 = 5.0 * 800.0 + 15.0 * 1000.0;
        assert_eq!(start - least, 2000.0);
    }

    /// A fluid that ends inside of a slot.
    #[test]
    fn a_slot_may_hold_two_fluids() {
        let least = sorted(&[(1.0, 2.0), (3.0, 2.0)], &[(10.0, 3.0), (1.0, 1.0)]);
        assert_eq!(least, 10.0 * 2.0 * 1.0 + 10.0 * 1.0 * 3.0 + 1.0 * 1.0 * 3.0);
    }
}
