//! Notices for the user while a run goes on: energies that show that errors rule.
//!
//! The dissipation of bodies, and the energy that strains or hourglass control take up, can't be below zero; errors
//! of stress updates and losses of transfers should be small beside the work W that is done: the largest of the works
//! from outside, of the kinetic energy, and of what the stresses took up or gave, so far. Nothing of this stops a run.

use super::energy::Energy;
use crate::mpm::coupling::Coupling;
use crate::simulation::{Column, Record, SaidOnce};
use bytemuck::{Pod, Zeroable};

/// Steps between two checks of the ledger.
const EVERY: u64 = 16;

/// Part of the largest term by which a loss or a stored energy may be below zero.
const BELOW: f64 = 0.01;

/// Part of the work done that errors may reach.
const LARGEST_ERROR: f64 = 0.2;

/// Part of the largest term below which an error is ignored: gas at rest does no work.
const LEAST_ERROR: f64 = 1e-6;

/// Terms of the ledger at one time [J].
#[derive(Debug, Clone, Default)]
struct Reading {
    /// Works, and energies exchanged.
    work: f64,
    /// The largest of all terms.
    largest: f64,
    /// Terms that can't be below zero, by name.
    positive: Vec<(String, f64)>,
    /// Errors of stress updates, by name.
    made: Vec<(String, f64)>,
    /// The part of the transfers' dissipation that did not become heat.
    lost: f64,
}

/// The notices so far, each kind given once.
#[derive(Debug, Clone, Default)]
pub(in crate::mpm) struct Notices {
    scales: EnergyScales,
    said: SaidOnce,
}

/// Energies that errors are compared with [J].
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
struct EnergyScales {
    /// Internal energy of the bodies at the start.
    internal_start: f64,
    /// The largest W so far.
    work: f64,
    /// The largest term so far.
    largest: f64,
}

impl Record for EnergyScales {
    type Number = f64;
}

impl Notices {
    /// Notices of bodies that begin with this internal energy [J].
    pub fn new(internal: f64) -> Self {
        let scales = EnergyScales { internal_start: internal, ..EnergyScales::default() };
        Self { scales, ..Self::default() }
    }

    /// The notices since the last call.
    pub fn take(&mut self) -> Vec<String> {
        self.said.take()
    }

    /// The columns of a checkpoint: the scales that the next look compares with, and the notices that were given.
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit("mpm.scales", Column::record(&mut self.scales));
        self.said.column("mpm.said", visit);
    }

    /// The first contradiction among restored columns, if there is one.
    pub fn misfit(&self) -> Option<String> {
        self.said.misfit()
    }

    /// Checks the ledger every few steps; `t` is the end of step number `steps` [s].
    pub fn check<const D: usize>(&mut self, steps: u64, t: f64, energy: &Energy, coupling: &Coupling<D>) {
        if steps.is_multiple_of(EVERY) {
            self.check_reading(&Reading::new(energy, coupling, self.scales.internal_start), t);
        }
    }

    /// Checks the ledger at time `t` [s].
    fn check_reading(&mut self, reading: &Reading, t: f64) {
        let EnergyScales { work, largest, .. } = &mut self.scales;
        *work = work.max(reading.work);
        *largest = largest.max(reading.largest).max(*work);
        let (work, largest) = (*work, *largest);
        for (name, value) in reading.positive.iter().filter(|(_, value)| *value < -BELOW * largest) {
            self.say(name, format!(
                "`{name}` is below zero by {:.1} % of the largest energy at t = {t:.4} s, which nothing real does: contact or \
                 elements give energy; take shorter steps (`mpm.safety`, `mpm.membrane-safety`), or elements and cells of one size",
                -100.0 * value / largest
            ));
        }
        let too_large = |value: f64| value.abs() > LARGEST_ERROR * work && value.abs() > LEAST_ERROR * largest;
        for (name, value) in reading.made.iter().filter(|(_, value)| too_large(*value)) {
            self.say(name, format!(
                "`{name}` has reached {:.0} % of the work done at t = {t:.4} s: stresses store what motion has not given; take \
                 smaller cells, a smoother `mpm.kernel` or shorter steps (`mpm.safety`)",
                100.0 * value / work
            ));
        }
        if too_large(reading.lost) {
            self.say("transfer dissipation", format!(
                "`transfer dissipation` has reached {:.0} % of the work done at t = {t:.4} s: the way through the grid takes \
                 motion that is as small as its cells, and nobody gets it; take smaller cells, or a `mpm.transfer` that damps less",
                100.0 * reading.lost / work
            ));
        }
    }

    fn say(&mut self, name: &str, text: String) {
        self.said.say(name, || format!("{text} (`history/balance.csv`)"));
    }
}

impl Reading {
    /// The terms of a run.
    fn new<const D: usize>(energy: &Energy, coupling: &Coupling<D>, internal_start: f64) -> Self {
        let Energy { sums, terms, kinetic, internal, .. } = energy;
        let (mut kinetic, internal) = (*kinetic, *internal);
        let taken = internal - internal_start;
        let from_outside = [terms.gravity, terms.traction, terms.wall, terms.atmosphere];
        let mut works: f64 = from_outside.iter().map(|&id| sums.value(id).abs()).sum();
        let losses = coupling.contact.losses();
        let mut positive = vec![
            ("contact dissipation".to_owned(), losses.normal),
            ("friction dissipation".to_owned(), losses.friction),
        ];
        let mut made = vec![("stress update error".to_owned(), sums.value(terms.stress))];
        let mut strain = 0.0f64;
        for membrane in &coupling.membranes {
            let (name, balance) = (&membrane.name, membrane.balance());
            works += balance.pressure.abs() + balance.gravity.abs() + balance.supports.abs();
            kinetic += balance.kinetic;
            strain = strain.max((balance.strain - balance.strain_start).abs());
            positive.push((format!("strain energy: {name}"), balance.strain));
            positive.push((format!("hourglass energy: {name}"), balance.hourglass));
            made.push((format!("stress update error: {name}"), balance.mismatch));
        }
        let work = works.max(kinetic).max(taken.abs()).max(strain);
        let lost = sums.value(terms.transfer) - sums.value(terms.heat);
        Self { work, largest: work.max(internal.abs()), positive, made, lost }
    }
}

#[cfg(test)]
mod tests {
    use super::{Notices, Reading};

    fn reading(contact: f64, made: f64, lost: f64) -> Reading {
        let (positive, made) =
            (vec![("contact dissipation".into(), contact)], vec![("stress update error".into(), made)]);
        Reading { work: 2.0, largest: 10.0, positive, made, lost }
    }

    #[test]
    fn an_energy_that_errors_rule_is_said_once_with_its_time() {
        let mut notices = Notices::new(0.0);
        notices.check_reading(&reading(-0.09, 0.39, 0.39), 0.5);
        assert_eq!(notices.take(), Vec::<String>::new());
        notices.check_reading(&reading(-0.11, -0.42, 0.42), 0.75);
        let said = notices.take();
        assert_eq!(said.len(), 3, "{said:?}");
        for (text, [name, percent]) in said.iter().zip([
            ["`contact dissipation`", "1.1 %"],
            ["`stress update error`", "-21 %"],
            ["`transfer dissipation`", "21 %"],
        ]) {
            assert!(text.starts_with(name) && text.contains(percent) && text.contains("t = 0.7500 s"), "{text}");
        }
        notices.check_reading(&reading(-0.2, 0.5, 0.5), 1.0);
        assert!(notices.take().is_empty());
    }

    /// A run that goes on from a checkpoint keeps the notices that were given, and the scales of their measures.
    #[test]
    fn notices_before_a_checkpoint_are_not_said_again() {
        let mut first = Notices::new(3.0);
        first.check_reading(&reading(0.0, 0.5, 0.0), 0.5);
        assert_eq!(first.take().len(), 1);
        let mut saved = Vec::new();
        first.columns(&mut |_, column| saved.push(column.data.bytes().to_vec()));
        let mut second = Notices::new(3.0);
        let mut next = saved.iter();
        second.columns(&mut |_, column| assert!(column.data.replace(next.next().unwrap())));
        assert_eq!((second.misfit(), second.scales), (None, first.scales));
        second.check_reading(&reading(0.0, 0.6, 0.6), 0.75);
        let said = second.take();
        assert!(said.len() == 1 && said[0].starts_with("`transfer dissipation`"), "{said:?}");
    }

    /// The largest work so far stays the scale where the work comes back; and gas at rest, which does none, gives no
    /// notice.
    #[test]
    fn the_work_done_is_the_largest_so_far() {
        let mut notices = Notices::new(0.0);
        notices.check_reading(&reading(0.0, 0.3, 0.3), 0.5);
        notices.check_reading(&Reading { work: 1e-3, ..reading(0.0, 0.3, 0.3) }, 1.0);
        let mut rest = Notices::new(0.0);
        rest.check_reading(&Reading { work: 1e-14, ..reading(0.0, 1e-13, 1e-13) }, 1.0);
        assert!(notices.take().is_empty() && rest.take().is_empty());
    }
}
