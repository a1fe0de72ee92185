//! `balance.csv`: mass, momentum, every energy term, and the closure of the ledger.
//!
//! closure = (stored − gained + lost) − the same at the first row [J]; round-off only, if the method
//! is right. Where a term is found as the remainder of all others, the closure says nothing: a column more shows what
//! part that term is of the largest other one so far.

use super::history::{History, HistoryTable, StepStart};
use super::label::UnitLabels;
use crate::error::Result;
use crate::simulation::{Ledger, Monitor, Snapshot, TermKind};
use std::path::Path;

const STORED: &str = "stored energy";
const GAINED: &str = "gained energy";
const LOST: &str = "lost energy";
const CLOSURE: &str = "closure";
/// Head of the remainder divided by the largest other term so far.
pub(super) const LOST_TO_ERRORS: &str = "part lost to errors";

/// Writes the ledger of every sample to `balance.csv`.
#[derive(Debug)]
pub struct BalanceHistory {
    history: History,
    interval: f64,
    units: UnitLabels,
    /// stored − gained + lost at the first row [J].
    start: Option<f64>,
    step_start: StepStart,
}

impl BalanceHistory {
    /// A balance in `directory`, every `interval` seconds.
    pub fn new(directory: &Path, interval: f64, units: UnitLabels) -> Self {
        Self {
            history: History::new(directory.join("balance.csv")),
            interval,
            units,
            start: None,
            step_start: StepStart::default(),
        }
    }
}

impl BalanceHistory {
    /// Heads, without the time.
    fn heads(&self, ledger: &Ledger) -> Vec<String> {
        let terms = ledger.terms.iter().map(|term| self.units.head(&term.name, term.unit));
        let totals = [STORED, GAINED, LOST, CLOSURE].map(|name| self.units.head(name, "J"));
        terms.chain(totals).chain(has_remainder(ledger).then(|| LOST_TO_ERRORS.to_owned())).collect()
    }

    /// The numbers below the heads.
    fn values(&mut self, ledger: &Ledger) -> Vec<f64> {
        let (stored, gained, lost) = (ledger.stored(), ledger.total(TermKind::Gain), ledger.lost());
        let explained = stored - gained + lost;
        let closure = explained - *self.start.get_or_insert(explained);
        let terms = ledger.terms.iter().map(|term| term.value);
        let remainder = has_remainder(ledger).then(|| ledger.remainder(0.0).unwrap_or(0.0));
        terms.chain([stored, gained, lost, closure]).chain(remainder).collect()
    }
}

fn has_remainder(ledger: &Ledger) -> bool {
    ledger.terms.iter().any(|term| term.kind == TermKind::Remainder)
}

impl Monitor for BalanceHistory {
    fn interval(&self) -> f64 {
        self.interval
    }

    fn interpolates(&self) -> bool {
        true
    }

    fn begin_step(&mut self, snapshot: &Snapshot<'_>) {
        let values = self.values(&snapshot.ledger);
        self.step_start.keep(snapshot.time, values);
    }

    fn sample(&mut self, snapshot: &Snapshot<'_>, due: f64) -> Result<()> {
        let heads = [vec![self.units.head("time", "s")], self.heads(&snapshot.ledger)].concat();
        let values = self.values(&snapshot.ledger);
        let row = [vec![due], self.step_start.between(due, snapshot.time, values)].concat();
        self.history.append(&heads, &row)
    }

    fn resume(&mut self, time: f64) -> Result<()> {
        self.history.resume(time)?;
        let table = HistoryTable::read(self.history.path())?;
        let first = |name| table.column(name).and_then(|column| column.first().copied());
        if let (Some(stored), Some(gained), Some(lost)) = (first(STORED), first(GAINED), first(LOST)) {
            self.start = Some(stored - gained + lost);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::BalanceTerm;

    fn term(name: &str, kind: TermKind, value: f64) -> BalanceTerm {
        BalanceTerm { name: name.into(), unit: "J", kind, value }
    }

    /// A ball that falls for `time`, bounces with a loss, and hides 0.25 J from the ledger per second.
    fn falling(time: f64) -> Snapshot<'static> {
        let terms = vec![
            term("kinetic energy: ball", TermKind::Stored, 10.0 + 9.0 * time),
            term("work of gravity", TermKind::Gain, 9.75 * time),
            term("contact", TermKind::Loss, 0.5 * time),
        ];
        Snapshot { time, ledger: Ledger { terms, ..Ledger::default() }, ..Snapshot::default() }
    }

    /// A remainder is measured by the largest other term so far, also when that is no longer there.
    #[test]
    fn a_remainder_has_a_column_of_its_own() {
        let dir = tempfile::tempdir().unwrap();
        let mut balance = BalanceHistory::new(dir.path(), 0.5, UnitLabels::Shown);
        for (time, kinetic, largest) in [(0.0, 10.0, 10.0), (1.0, 4.0, 12.0)] {
            let terms = vec![
                term("kinetic energy", TermKind::Stored, kinetic),
                term("viscous dissipation", TermKind::Loss, 3.0 * time),
                term("numerical dissipation", TermKind::Remainder, 10.0 - kinetic - 3.0 * time),
            ];
            balance.sample(&Snapshot { time, ledger: Ledger { terms, largest }, ..Snapshot::default() }, time).unwrap();
        }
        let table = HistoryTable::read(&dir.path().join("balance.csv")).unwrap();
        assert_eq!(table.column(CLOSURE).unwrap(), [0.0, 0.0]);
        assert_eq!(table.column(LOST).unwrap(), [0.0, 6.0]);
        assert_eq!(table.column(LOST_TO_ERRORS).unwrap(), [0.0, 0.25]);
    }

    #[test]
    fn closure_is_what_the_terms_do_not_explain_also_after_a_resume() {
        let dir = tempfile::tempdir().unwrap();
        let mut balance = BalanceHistory::new(dir.path(), 0.5, UnitLabels::Shown);
        for time in [0.0, 0.5, 1.0, 1.5] {
            balance.sample(&falling(time), time).unwrap();
        }
        let path = dir.path().join("balance.csv");
        let whole = std::fs::read_to_string(&path).unwrap();
        let closure = HistoryTable::read(&path).unwrap().column("closure").unwrap().to_vec();
        assert_eq!(closure, [0.0, -0.125, -0.25, -0.375]);

        let mut resumed = BalanceHistory::new(dir.path(), 0.5, UnitLabels::Shown);
        resumed.resume(0.5).unwrap();
        for time in [0.5, 1.0, 1.5] {
            resumed.sample(&falling(time), time).unwrap();
        }
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
    }
}
