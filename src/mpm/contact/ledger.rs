//! Named contact forces, the energy that contact has dissipated, and counts of particles that crossed sheets (theory
//! D.15, D.16).

use super::impulse::ContactTotals;
use crate::math::Vector;
use crate::simulation::{Column, CompensatedSum, Record, SaidOnce};
use bytemuck::{Pod, Zeroable};
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

/// Energy that a pair has dissipated since the start [J].
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
struct PairLosses {
    /// Inelastic impact along the normals.
    normal: CompensatedSum,
    /// Friction.
    friction: CompensatedSum,
}

impl Record for PairLosses {
    type Number = f64;
}

/// Forces and losses of all pairs that touch: each field with each sheet, then fields with each other.
#[derive(Debug)]
pub(super) struct ContactLedger<const D: usize> {
    forces: Vec<NamedForce<D>>,
    /// Index of the force of each pair: parts of one body share one.
    force_of: Vec<usize>,
    /// Energy that each pair has dissipated since the start.
    dissipated: Vec<PairLosses>,
    /// Mapping loss of each sheet since the start [J].
    mapping: Vec<CompensatedSum>,
    /// Angular momentum that contact of sheets has added since the start [N m s].
    spin: [CompensatedSum; 3],
}

impl<const D: usize> ContactLedger<D> {
    /// A ledger for pairs with these names, of so many sheets.
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
        let dissipated = vec![PairLosses::default(); force_of.len()];
        let mapping = vec![CompensatedSum::default(); sheets];
        Self { forces, force_of, dissipated, mapping, spin: Default::default() }
    }

    /// Records the energy [J] that a sheet has lost in mapping.
    pub fn record_mapping_loss(&mut self, sheet: usize, lost: f64) {
        self.mapping[sheet].add(lost);
    }

    /// Records forces and losses of all pairs in a step of length `dt` [s].
    pub fn record_step(&mut self, pairs: impl Iterator<Item = ContactTotals<D>>, dt: f64) {
        self.forces.iter_mut().for_each(|force| force.value = Vector::ZERO);
        for (index, totals) in pairs.enumerate() {
            self.forces[self.force_of[index]].value += totals.impulse / dt;
            self.dissipated[index].normal.add(totals.dissipated.normal);
            self.dissipated[index].friction.add(totals.dissipated.friction);
            (0..3).for_each(|axis| self.spin[axis].add(totals.spin[axis]));
        }
    }

    /// Names and values of the forces.
    pub fn forces(&self) -> impl Iterator<Item = (&str, [f64; 3])> {
        self.forces.iter().map(|force| (force.name.as_str(), force.value.to3()))
    }

    /// The energy that was dissipated since the start.
    pub fn losses(&self) -> Losses {
        Losses {
            normal: self.dissipated.iter().map(|pair| pair.normal.value()).sum(),
            friction: self.dissipated.iter().map(|pair| pair.friction.value()).sum(),
            mapping: self.mapping.iter().map(|lost| lost.value()).sum(),
            spin: self.spin.map(CompensatedSum::value),
        }
    }

    /// Shows the losses to a checkpoint.
    pub fn columns(&mut self, prefix: &str, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit(&format!("{prefix}dissipated"), Column::new(&mut self.dissipated));
        visit(&format!("{prefix}mapping-loss"), Column::new(&mut self.mapping));
        visit(&format!("{prefix}spin"), Column::record(&mut self.spin));
    }
}

/// Counts since the start, and the notices that they give.
#[derive(Debug, Default)]
pub(super) struct ContactCounts {
    /// Steps taken.
    pub steps: u64,
    /// Particles found to have crossed each sheet.
    pub crossed: Vec<u64>,
    /// Particles put back to their least distance from a sheet, once per step each.
    pub held_back: u64,
    notices: SaidOnce,
}

impl ContactCounts {
    /// Totals of so many sheets.
    pub fn new(sheets: usize) -> Self {
        Self { crossed: vec![0; sheets], ..Self::default() }
    }

    /// The largest of them.
    pub fn largest(&self) -> u64 {
        self.crossed.iter().copied().fold(self.steps.max(self.held_back), u64::max)
    }

    /// Notices since the last call: one in a run for each sheet that particles have crossed; `names` are those of the
    /// sheets.
    pub fn notices<'a>(&mut self, names: impl Iterator<Item = &'a str>) -> Vec<String> {
        for (name, _) in names.zip(&self.crossed).filter(|(_, count)| **count > 0) {
            self.notices.say(name, || {
                format!(
                    "particles have crossed the membrane `{name}` (`crossed:{name}` in counts.csv): its elements may be much \
                     larger than cells, or a body begins on both sides of it"
                )
            });
        }
        self.notices.take()
    }

    /// The contradiction in columns that were just restored, if there is one.
    pub fn misfit(&self) -> Option<String> {
        self.notices.misfit()
    }

    /// Shows the counts to a checkpoint, and the notices that were given.
    pub fn columns(&mut self, prefix: &str, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit(&format!("{prefix}steps"), Column::scalar(&mut self.steps));
        visit(&format!("{prefix}crossed"), Column::new(&mut self.crossed));
        visit(&format!("{prefix}held-back"), Column::scalar(&mut self.held_back));
        self.notices.column(&format!("{prefix}said"), visit);
    }
}

#[cfg(test)]
mod tests {
    use super::super::impulse::PairDissipation;
    use super::*;

    /// Ten thousand losses of less than half a unit in the last place of 10⁹: each of them alone is rounded off.
    #[test]
    fn small_losses_are_kept_beside_large_ones() {
        const TERM: f64 = 5e-8;
        let pairs = vec![["water", "sheet"].map(|name| vec![name.to_owned()])];
        let mut ledger = ContactLedger::<3>::new(pairs, 1);
        for amount in std::iter::once(1e9).chain(std::iter::repeat_n(TERM, 10_000)) {
            let dissipated = PairDissipation { normal: amount, friction: 2.0 * amount };
            let totals = ContactTotals { impulse: Vector::ZERO, dissipated, spin: Vector([amount; 3]) };
            ledger.record_step(std::iter::once(totals), 1.0);
            ledger.record_mapping_loss(0, amount);
        }
        let expected = 1e9 + 1e4 * TERM;
        let Losses { normal, friction, mapping, spin } = ledger.losses();
        for found in [normal, 0.5 * friction, mapping, spin[0], spin[1], spin[2]] {
            assert!((found - expected).abs() < 2e-7, "{found} {expected}");
        }
    }
}
