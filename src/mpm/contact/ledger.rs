//! Named contact forces, and the energy that contact has dissipated.

use super::impulse::ContactTotals;
use crate::math::Vector;
use std::collections::BTreeMap;

/// The energy that contact has dissipated since the start [J] (theory D.16).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Losses {
    /// Inelastic impact along the normals.
    pub normal: f64,
    /// Friction.
    pub friction: f64,
    /// Mapping between grid and membrane nodes.
    pub mapping: f64,
    /// Angular momentum that contact of sheets has added [N m s], because friction and nodes that are not opposite
    /// each other push along lines that don't coincide (theory D.15).
    pub spin: [f64; 3],
}

/// A contact force: its name, and the mean over the last step [N] on the body that is named first.
#[derive(Debug, Clone)]
struct NamedForce<const D: usize> {
    name: String,
    value: Vector<D>,
}

/// Forces and losses of all pairs that touch: each field with each sheet, then fields with each other.
#[derive(Debug)]
pub(super) struct ContactLedger<const D: usize> {
    forces: Vec<NamedForce<D>>,
    /// Index of the force of each pair: parts of one body share one.
    force_of: Vec<usize>,
    sheets: usize,
    /// Losses of each pair (normal, friction), then the mapping loss of each sheet, then the spin.
    pub losses: Vec<f64>,
}

impl<const D: usize> ContactLedger<D> {
    /// For pairs with these names, of so many sheets.
    pub fn new(pairs: Vec<[Vec<String>; 2]>, sheets: usize) -> Self {
        let mut numbers: BTreeMap<[Vec<String>; 2], usize> = BTreeMap::new();
        let (mut forces, mut force_of) = (Vec::new(), Vec::new());
        for pair in pairs {
            let name = format!("contact:{}-{}", pair[0].join("+"), pair[1].join("+"));
            let number = *numbers.entry(pair).or_insert(forces.len());
            if number == forces.len() {
                forces.push(NamedForce { name, value: Vector::ZERO });
            }
            force_of.push(number);
        }
        Self { losses: vec![0.0; 2 * force_of.len() + sheets + 3], forces, force_of, sheets }
    }

    /// Records the energy [J] that a sheet has lost in mapping.
    pub fn record_mapping_loss(&mut self, sheet: usize, lost: f64) {
        self.losses[2 * self.force_of.len() + sheet] += lost;
    }

    /// Records forces and losses of all pairs in a step of length `dt` [s].
    pub fn record_step(&mut self, pairs: impl Iterator<Item = ContactTotals<D>>, dt: f64) {
        let spin = 2 * self.force_of.len() + self.sheets;
        self.forces.iter_mut().for_each(|force| force.value = Vector::ZERO);
        for (index, totals) in pairs.enumerate() {
            self.forces[self.force_of[index]].value += totals.impulse / dt;
            self.losses[2 * index] += totals.lost[0];
            self.losses[2 * index + 1] += totals.lost[1];
            (0..3).for_each(|axis| self.losses[spin + axis] += totals.spin[axis]);
        }
    }

    /// Names and values of the forces.
    pub fn forces(&self) -> impl Iterator<Item = (&str, [f64; 3])> {
        self.forces.iter().map(|force| (force.name.as_str(), force.value.to3()))
    }

    /// The energy that was dissipated since the start.
    pub fn losses(&self) -> Losses {
        let (pairs, rest) = self.losses.split_at(2 * self.force_of.len());
        let (mapping, spin) = rest.split_at(self.sheets);
        Losses {
            normal: pairs.iter().step_by(2).sum(),
            friction: pairs.iter().skip(1).step_by(2).sum(),
            mapping: mapping.iter().sum(),
            spin: std::array::from_fn(|axis| spin[axis]),
        }
    }
}
