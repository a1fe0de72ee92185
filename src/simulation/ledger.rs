//! The energy and momentum ledger: its terms in a snapshot, and the running sums that a solver keeps for it.
//!
//! ```text
//! stored now − stored at the start = Σ gains − Σ losses + closure
//! ```

use super::Column;
use super::column::Record;
use bytemuck::{Pod, Zeroable};

/// The ledger: rows of `balance.csv`.
#[derive(Debug, Clone, Default)]
pub struct Ledger {
    /// All terms, in a fixed order for a given solver.
    pub terms: Vec<BalanceTerm>,
    /// The largest energy so far, where the solver remembers it, and no less than what counts in this run [J].
    pub largest: f64,
}

impl Ledger {
    /// The sum of all terms of a kind.
    pub fn total(&self, kind: TermKind) -> f64 {
        self.terms.iter().filter(|term| term.kind == kind).map(|term| term.value).sum()
    }

    /// Energy stored now [J].
    pub fn stored(&self) -> f64 {
        self.total(TermKind::Stored)
    }

    /// Energy that the ledger can't explain [J], given the energy stored at the start: round-off only,
    /// if the method is right.
    pub fn closure(&self, stored_at_start: f64) -> f64 {
        self.stored() - stored_at_start - self.total(TermKind::Gain) + self.lost()
    }

    /// Energy lost since the start [J], with the remainder.
    pub fn lost(&self) -> f64 {
        self.total(TermKind::Loss) + self.total(TermKind::Remainder)
    }

    /// A scale for the closure [J]: the largest energy that is or was stored, added or lost, except for the remainder.
    pub fn scale(&self, stored_at_start: f64) -> f64 {
        let energies = self.terms.iter().filter(|term| !matches!(term.kind, TermKind::Other | TermKind::Remainder));
        energies.map(|term| term.value.abs()).fold(self.largest.max(stored_at_start.abs()), f64::max)
    }

    /// The part that errors have taken, or given if it is below zero, of the largest other term, where the ledger finds
    /// it as the remainder of all others.
    pub fn remainder(&self, stored_at_start: f64) -> Option<f64> {
        let scale = self.scale(stored_at_start);
        let found = self.terms.iter().any(|term| term.kind == TermKind::Remainder);
        (found && scale > 0.0).then(|| self.total(TermKind::Remainder) / scale)
    }
}

/// One term of the ledger.
#[derive(Debug, Clone)]
pub struct BalanceTerm {
    /// Name of the term, for example `kinetic energy: water`.
    pub name: String,
    /// `kg`, `N s`, `J`.
    pub unit: &'static str,
    /// Role of the term in the energy closure.
    pub kind: TermKind,
    /// Value of the term.
    pub value: f64,
}

/// Role of a term in the energy closure: stored energy now − stored energy at the start
/// = sum of gains − sum of losses + closure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TermKind {
    /// Energy stored now (kinetic, internal, hourglass).
    Stored,
    /// Energy added since the start (external work; numerical errors with their sign).
    Gain,
    /// Energy lost since the start (contact, FLIP, mapping).
    Loss,
    /// Energy lost since the start, as all other terms leave it: with it the closure says nothing.
    Remainder,
    /// Not an energy of the closure (mass, momentum, derived values).
    Other,
}

impl BalanceTerm {
    /// An energy of the closure [J].
    pub fn energy(kind: TermKind, name: impl Into<String>, value: f64) -> Self {
        Self { name: name.into(), unit: "J", kind, value }
    }

    /// A term that is not part of the closure.
    pub fn other(name: impl Into<String>, unit: &'static str, value: f64) -> Self {
        Self { name: name.into(), unit, kind: TermKind::Other, value }
    }
}

/// A sum that also adds up the rounding errors of its additions (Neumaier), so that ledgers of long runs close.
///
/// ```
/// use lateen::simulation::CompensatedSum;
///
/// let mut sum = CompensatedSum::default();
/// for term in [1e16, 1.0, -1e16, 3.0] {
///     sum.add(term);
/// }
/// assert_eq!(sum.value(), 4.0);
/// assert_eq!(1e16 + 1.0 - 1e16 + 3.0, 3.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    /// Adds a term.
    pub fn add(&mut self, term: f64) {
        let sum = self.sum + term;
        self.lost += if self.sum.abs() >= term.abs() { (self.sum - sum) + term } else { (term - sum) + self.sum };
        self.sum = sum;
    }

    /// The sum.
    pub fn value(self) -> f64 {
        self.sum + self.lost
    }
}

impl From<f64> for CompensatedSum {
    fn from(sum: f64) -> Self {
        Self { sum, lost: 0.0 }
    }
}

impl Record for CompensatedSum {
    type Number = f64;
}

/// A term of [`LedgerSums`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TermId(usize);

/// Running sums of named gains and losses [J] and of the external impulse [N s], since the start.
///
/// ```
/// use lateen::simulation::{LedgerSums, BalanceTerm, Ledger, TermKind};
///
/// let mut sums = LedgerSums::new(10.0);
/// let work = sums.add_term("work of gravity", TermKind::Gain);
/// let loss = sums.add_term("friction", TermKind::Loss);
/// sums.add(work, 5.0);
/// sums.add(loss, 2.0);
/// let mut terms = vec![BalanceTerm::energy(TermKind::Stored, "kinetic energy", 13.0)];
/// terms.extend(sums.terms());
/// assert_eq!(Ledger { terms, largest: 0.0 }.closure(sums.start()), 0.0);
/// ```
#[derive(Debug, Clone, Default)]
pub struct LedgerSums {
    sums: Vec<LedgerSum>,
    start: f64,
    impulse: [CompensatedSum; 3],
}

/// A running gain or loss.
#[derive(Debug, Clone)]
struct LedgerSum {
    name: String,
    kind: TermKind,
    total: CompensatedSum,
}

impl LedgerSums {
    /// No terms yet; `start` is the energy stored at the start [J].
    pub fn new(start: f64) -> Self {
        Self { start, ..Self::default() }
    }

    /// Adds a term, a gain or a loss, that begins with zero.
    pub fn add_term(&mut self, name: impl Into<String>, kind: TermKind) -> TermId {
        self.sums.push(LedgerSum { name: name.into(), kind, total: CompensatedSum::default() });
        TermId(self.sums.len() - 1)
    }

    /// Adds an energy [J] to a term.
    pub fn add(&mut self, term: TermId, energy: f64) {
        self.sums[term.0].total.add(energy);
    }

    /// The sum of a term [J].
    pub fn value(&self, term: TermId) -> f64 {
        self.sums[term.0].total.value()
    }

    /// The sum of all terms [J]: finite as long as every term is.
    pub fn sum(&self) -> f64 {
        self.sums.iter().map(|sum| sum.total.value()).sum()
    }

    /// Adds an external impulse [N s].
    pub fn add_impulse(&mut self, impulse: [f64; 3]) {
        for (total, part) in self.impulse.iter_mut().zip(impulse) {
            total.add(part);
        }
    }

    /// External impulse since the start [N s].
    pub fn impulse(&self) -> [f64; 3] {
        self.impulse.map(CompensatedSum::value)
    }

    /// Energy stored at the start [J].
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Sets the energy stored at the start [J].
    pub fn set_start(&mut self, stored: f64) {
        self.start = stored;
    }

    /// A term of the ledger for each sum, in the order in which they were added, then the energy stored at the start.
    pub fn terms(&self) -> impl Iterator<Item = BalanceTerm> {
        let energy = |sum: &LedgerSum| BalanceTerm::energy(sum.kind, &sum.name, sum.total.value());
        let start = BalanceTerm::other("stored energy at the start", "J", self.start);
        self.sums.iter().map(energy).chain([start])
    }

    /// Shows all sums to a checkpoint, as one column: the energy at the start, then each sum with its rounding error.
    pub fn column(&mut self, name: &str, visit: &mut dyn FnMut(&str, Column<'_>)) {
        let totals = self.sums.iter().map(|sum| sum.total).chain(self.impulse);
        let mut numbers: Vec<f64> =
            std::iter::once(self.start).chain(totals.flat_map(|total| [total.sum, total.lost])).collect();
        visit(name, Column::new(&mut numbers));
        let Some((&start, pairs)) = numbers.split_first() else { return };
        self.start = start;
        let totals = self.sums.iter_mut().map(|sum| &mut sum.total).chain(&mut self.impulse);
        for (total, &[sum, lost]) in totals.zip(pairs.as_chunks::<2>().0) {
            *total = CompensatedSum { sum, lost };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_restored_ledger_goes_on_with_the_same_bits() {
        let mut first = LedgerSums::new(10.0);
        let work = first.add_term("work", TermKind::Gain);
        first.add(work, 1e16);
        first.add(work, 1.0);
        first.add_impulse([1.0, 2.0, 3.0]);
        let mut stored = Vec::new();
        first.column("ledger", &mut |_, column| stored = column.data.bytes().to_vec());
        assert_eq!(stored.len(), (1 + 2 * (1 + 3)) * 8);
        let mut second = LedgerSums::default();
        second.add_term("work", TermKind::Gain);
        second.column("ledger", &mut |_, column| assert!(column.data.replace(&stored)));
        for sums in [&mut first, &mut second] {
            sums.add(work, -1e16);
            assert_eq!((sums.value(work), sums.start(), sums.impulse()), (1.0, 10.0, [1.0, 2.0, 3.0]));
        }
    }
}
