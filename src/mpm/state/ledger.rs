//! The energy and momentum ledger, which closes to round-off (theory A.17).
//!
//! With v̂ = ½(v⁻ + v⁺) at the nodes and Δt the step of the momentum:
//!
//! ```text
//! nodes          ΔK_I = Δt Σ f_I · v̂_I                       exact, since p⁺ = p⁻ + Δt f; of stresses that are updated with
//!                                                            velocities mapped back, less the part that particles don't get (`energy`)
//! transfer loss  D    = Σ ΔK_I − ΔK_p                        FLIP, PIC, APIC, filter and bound p⁻
//! its heat       Q    = Σ q_p                                what of D the particles keep (`heat`)
//! atmosphere     W_a  = −Δ Σ p_a V_p                         work on gases whose forces count from p_a (`ambient`)
//! stress error   ε_s  = ΔU_p − Q + Δt Σ f_I^int · v̂_I − W_a  first: gains; modified last: loses
//! external       W    = Δt Σ F_p · Σ N_Ip v̂_I                equals Δt Σ f_I^ext · v̂_I
//! walls          W_w − D_w = Δt Σ f_I^wall · v̂_I
//! balance        Δ(K + U) = Σ gains − Σ losses + closure
//! ```
//!
//! The closure ([`Ledger::closure`]) is what no term accounts for: f_I is booked where it is made, so it
//! shows any force that changed a node without being booked.

use crate::simulation::{BalanceTerm, Ledger, TermKind};

/// A sum with the rounding errors of its additions (Neumaier), so that long runs still close.
#[derive(Debug, Clone, Copy, Default)]
pub struct Total {
    sum: f64,
    lost: f64,
}

impl Total {
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

/// A running gain or loss.
#[derive(Debug, Clone)]
struct Term {
    name: String,
    kind: TermKind,
    total: Total,
}

/// The number of a term of the [`EnergyLedger`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TermId(usize);

/// The gains and losses of a run and the energy that it started with.
#[derive(Debug, Clone, Default)]
pub struct EnergyLedger {
    terms: Vec<Term>,
    /// Stored energy at the start [J].
    start: f64,
    /// Impulse of gravity, tractions, walls and supports since the start [N s].
    impulse: [Total; 3],
}

impl EnergyLedger {
    /// Opens a term for a gain or a loss.
    pub fn open(&mut self, name: impl Into<String>, kind: TermKind) -> TermId {
        self.terms.push(Term { name: name.into(), kind, total: Total::default() });
        TermId(self.terms.len() - 1)
    }

    /// EnergyLedger energy [J].
    pub fn add(&mut self, term: TermId, energy: f64) {
        self.terms[term.0].total.add(energy);
    }

    /// The value of a term so far [J].
    pub fn value(&self, term: TermId) -> f64 {
        self.terms[term.0].total.value()
    }

    /// The sum of all terms [J]: finite as long as each is.
    pub fn sum(&self) -> f64 {
        self.terms.iter().map(|term| term.total.value()).sum()
    }

    /// EnergyLedger an external impulse [N s].
    pub fn push(&mut self, impulse: [f64; 3]) {
        for (total, part) in self.impulse.iter_mut().zip(impulse) {
            total.add(part);
        }
    }

    /// External impulse since the start [N s].
    pub fn impulse(&self) -> [f64; 3] {
        self.impulse.map(Total::value)
    }

    /// Sets the stored energy of the start [J].
    pub fn start(&mut self, stored: f64) {
        self.start = stored;
    }

    /// Completes the ledger: `terms` holds the stored energies, gains and losses kept elsewhere, and other terms.
    pub fn ledger(&self, mut terms: Vec<BalanceTerm>) -> Ledger {
        terms.extend(self.terms.iter().map(|term| BalanceTerm {
            name: term.name.clone(),
            unit: "J",
            kind: term.kind,
            value: term.total.value(),
        }));
        terms.push(other("stored energy at the start".into(), "J", self.start));
        Ledger { terms, largest: 0.0 }
    }

    /// The state as numbers, for checkpoints.
    pub fn to_numbers(&self) -> Vec<f64> {
        let totals = self.terms.iter().map(|term| term.total).chain(self.impulse);
        std::iter::once(self.start).chain(totals.flat_map(|total| [total.sum, total.lost])).collect()
    }

    /// Restores the state from [`Self::to_numbers`].
    pub fn set_numbers(&mut self, numbers: &[f64]) {
        let Some((&start, rest)) = numbers.split_first() else { return };
        self.start = start;
        let totals = self.terms.iter_mut().map(|term| &mut term.total).chain(&mut self.impulse);
        for (total, pair) in totals.zip(rest.chunks_exact(2)) {
            *total = Total { sum: pair[0], lost: pair[1] };
        }
    }
}

/// A term that is not part of the energy closure.
pub fn other(name: String, unit: &'static str, value: f64) -> BalanceTerm {
    BalanceTerm { name, unit, kind: TermKind::Other, value }
}

/// An energy of the closure [J].
pub fn energy(kind: TermKind, name: String, value: f64) -> BalanceTerm {
    BalanceTerm { name, unit: "J", kind, value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_keep_what_plain_sums_lose() {
        let mut total = Total::default();
        for term in [1e16, 1.0, -1e16, 3.0] {
            total.add(term);
        }
        assert_eq!(total.value(), 4.0);
    }

    #[test]
    fn closure_is_what_no_term_explains() {
        let mut sums = EnergyLedger::default();
        let work = sums.open("work", TermKind::Gain);
        let loss = sums.open("loss", TermKind::Loss);
        sums.start(10.0);
        sums.add(work, 5.0);
        sums.add(loss, 2.0);
        let ledger = sums.ledger(vec![energy(TermKind::Stored, "energy".into(), 13.5)]);
        assert_eq!(ledger.closure(10.0), 0.5);
        let mut copy = sums.clone();
        copy.set_numbers(&sums.to_numbers());
        assert_eq!(copy.to_numbers(), sums.to_numbers());
    }
}
