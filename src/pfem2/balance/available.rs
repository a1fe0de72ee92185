//! The work that gravity can do in a closed box: what the fluids lose of potential energy when the heavy ones come to
//! rest below the light ones (Lorenz 1955; theory F.14).
//!
//! ```text
//! A = Σ m φ at the start − Σ m φ of the same volumes sorted by density,      φ = −b·x
//! ```
//!
//! Beside it stands the energy that no term of the ledger explains: waves on an interface that grow with the step,
//! fluid that leaks through the other, pressure that pushes along a wall, interfaces that aren't calm. It is too much
//! where it is more than half of the kinetic energy that the flow ever had and all that friction and walls exchanged,
//! which has errors as large as itself in steps that are long for friction.
//!
//! φ is taken from the middle of the mesh, so that a volume that isn't kept counts the same wherever the box lies.

use super::ledger::{EnergyLedger, FlowTotals};
use crate::error::StepError;
use crate::pfem2::checks::health;
use crate::pfem2::equations::system::VelocityPressureSystem;

/// Part of the largest kinetic energy that errors of discretisation may make.
const ERRORS: f64 = 0.5;

/// Part of the energy at hand (A, the energy at the start and the work that lifts all fluid by an element) below which
/// no notice is given: fluids at rest move a little.
const NEGLIGIBLE: f64 = 1e-3;

/// Part of A that errors are measured by as long as nothing larger has moved: a flow that has just begun has next to
/// none.
const LEAST_OF_AVAILABLE: f64 = 0.1;

/// Part of A, and of the work that lifts all fluid by an element, that the work of gravity may exceed A by.
const EXCESS_WORK: f64 = 0.1;

/// Times the energy at hand and all exchanged energy, beyond which a gain from errors stops the run.
const RUNAWAY: f64 = 10.0;

/// The available potential energy A at the start, and what is needed to find its loss.
#[derive(Debug, Clone, Copy)]
pub(in crate::pfem2) struct AvailablePotentialEnergy {
    /// −b [m/s²].
    up: [f64; 3],
    /// φ in the middle of the mesh [m²/s²].
    middle: f64,
    /// Σ m φ at the start [J].
    start: f64,
    /// A [J].
    energy: f64,
    /// Work that lifts all fluid by the shortest edge [J].
    lift: f64,
}

/// Outcome of the check of the energy that errors have given the flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::pfem2) enum EnergyCheck {
    /// No more than errors of discretisation make.
    Plausible,
    /// More than errors of discretisation make.
    Excessive,
}

impl AvailablePotentialEnergy {
    /// The energy available to the state at the start with these totals; `None` where fluid may come in or leave, or
    /// gravity is no steady, uniform one.
    pub fn new<const D: usize, const N: usize>(
        system: &VelocityPressureSystem<D, N>,
        totals: &FlowTotals,
    ) -> Option<Self> {
        let gravity = system.physics.steady_gravity()?;
        if !system.boundary.is_closed() {
            return None;
        }
        let mut slots: Vec<(f64, f64)> = (0..system.mesh.elements().len())
            .map(|e| (-gravity.dot(system.mesh.center(e)), system.mesh.simplex(e).volume))
            .collect();
        slots.sort_by(|a, b| a.0.total_cmp(&b.0));
        let volume: f64 = slots.iter().map(|(_, volume)| volume).sum();
        let middle = slots.iter().map(|(phi, volume)| phi * volume).sum::<f64>() / volume;
        slots.iter_mut().for_each(|(phi, _)| *phi -= middle);
        let mut fluids: Vec<(f64, f64)> =
            system.physics.fluids.iter().zip(&system.contents.volumes).map(|(fluid, v)| (fluid.density, *v)).collect();
        fluids.sort_by(|a, b| b.0.total_cmp(&a.0));
        let lift = totals.mass * gravity.norm() * system.shortest();
        let level = Self { up: (gravity * -1.0).to3(), middle, start: 0.0, energy: 0.0, lift };
        let start = level.potential(totals);
        Some(Self { start, energy: (start - sorted(&slots, &fluids)).max(0.0), ..level })
    }

    /// A [J].
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// Σ m φ [J].
    fn potential(&self, totals: &FlowTotals) -> f64 {
        self.up.iter().zip(totals.moment).map(|(up, moment)| up * moment).sum::<f64>() - totals.mass * self.middle
    }

    /// Potential energy that the fluids have lost since the start [J].
    pub fn released(&self, totals: &FlowTotals) -> f64 {
        self.start - self.potential(totals)
    }

    /// The least energy that errors are measured by [J].
    pub fn least(&self, ledger: &EnergyLedger) -> f64 {
        (NEGLIGIBLE * self.at_hand(ledger)).max(LEAST_OF_AVAILABLE * self.energy)
    }

    /// Energy at hand to move the fluids [J].
    fn at_hand(&self, ledger: &EnergyLedger) -> f64 {
        self.energy + self.lift + ledger.begun()
    }

    /// Compares the energy that the ledger doesn't explain with the errors of discretisation, and the work of gravity
    /// with A.
    ///
    /// # Errors
    /// The energy that errors have given is many times what there was; the fastest node is named.
    pub fn check<const D: usize, const N: usize>(
        &self,
        ledger: &EnergyLedger,
        totals: &FlowTotals,
        system: &VelocityPressureSystem<D, N>,
    ) -> Result<EnergyCheck, StepError> {
        let (gained, excess) =
            (ledger.gained(totals, system.surface_energy()), ledger.external().gravity - self.energy);
        let (at_hand, exchanged) = (self.at_hand(ledger), ledger.exchanged());
        if gained.max(excess) > RUNAWAY * (at_hand + exchanged) {
            return Err(health::runaway(system, gained.max(excess), at_hand));
        }
        let most = (ERRORS * ledger.peak + exchanged).max(NEGLIGIBLE * at_hand);
        let too_much = gained > most || excess > EXCESS_WORK * (self.energy + self.lift);
        Ok(if too_much { EnergyCheck::Excessive } else { EnergyCheck::Plausible })
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

    /// Water (1000) on oil (800), two slots of one cubic metre, 0.5 and 1.5 m high under 10 m/s²: 1000 kg sink by
    /// a metre, 800 kg rise.
    #[test]
    fn the_energy_of_a_heavy_layer_above_a_light_one_is_available() {
        let slots = [(5.0, 1.0), (15.0, 1.0)];
        let least = sorted(&slots, &[(1000.0, 1.0), (800.0, 1.0)]);
        assert_eq!(least, 5.0 * 1000.0 + 15.0 * 800.0);
        let start: f64 = 5.0 * 800.0 + 15.0 * 1000.0;
        assert_eq!(start - least, 2000.0);
    }

    /// A fluid that ends inside of a slot.
    #[test]
    fn sorted_fluids_may_share_an_element() {
        let least = sorted(&[(1.0, 2.0), (3.0, 2.0)], &[(10.0, 3.0), (1.0, 1.0)]);
        assert_eq!(least, 10.0 * 2.0 * 1.0 + 10.0 * 1.0 * 3.0 + 1.0 * 1.0 * 3.0);
    }
}
