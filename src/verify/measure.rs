//! A check applied to a history: computed value, deviation, verdict.

use super::check::{Check, Measure, Reference};
use super::curve::Curve;
use super::outcome::{Outcome, Tolerance};
use super::series::{Series, envelope, series};
use crate::error::Result;
use crate::output::history::HistoryTable;

impl Check {
    /// Applies the check to its history; `others` come with the factor with which they are added, `read_curve` reads
    /// the table of a reference curve.
    ///
    /// # Errors
    /// Columns that aren't there; tables that can't be read.
    pub fn apply(
        &self,
        history: &HistoryTable,
        others: &[(f64, HistoryTable)],
        tolerance: Tolerance,
        read_curve: impl Fn(&str) -> Result<HistoryTable>,
    ) -> Result<Outcome> {
        let phase = self.phase.as_ref().map(|phase| series(history, "time", phase)).transpose()?;
        let mut history = series(history, "time", &self.value)?;
        for (factor, other) in others {
            history = history.plus(*factor, &series(other, "time", &self.value)?);
        }
        let mut history = history.window(self.from, self.until);
        if let Some(phase) = phase {
            history = history.folded(&phase.window(self.from, self.until));
        }
        let (computed, reference, deviation) = match &self.reference {
            Reference::Number(reference) => {
                let computed = self.measure(&history);
                (computed, *reference, computed.map(|value| self.compare.deviation(value, *reference)))
            }
            Reference::Curves(curves) => {
                let read = |curve: &Curve| curve.read(&read_curve);
                let curves = curves.iter().map(read).collect::<Result<Vec<_>>>()?;
                distance_from_band(&history, &curves)
            }
        };
        Ok(Outcome {
            name: self.name.clone(),
            computed,
            reference,
            deviation: deviation.unwrap_or(f64::INFINITY),
            limit: tolerance.limit(reference),
            source: self.source.clone(),
        })
    }

    /// The quantity of this kind, measured on the history.
    fn measure(&self, series: &Series) -> Option<f64> {
        let extremes = || Some((series.minimum()?.1, series.maximum()?.1));
        match self.kind {
            Measure::Final => series.last(),
            Measure::Value => series.at(self.at?),
            Measure::Maximum => series.maximum().map(|sample| sample.1),
            Measure::Minimum => series.minimum().map(|sample| sample.1),
            Measure::Largest => extremes().map(|(low, high)| if -low > high { low } else { high }),
            Measure::Mean => series.mean(),
            Measure::Midrange => extremes().map(|(low, high)| 0.5 * (low + high)),
            Measure::Amplitude => extremes().map(|(low, high)| 0.5 * (high - low)),
            Measure::TimeOfMaximum => series.maximum().map(|sample| sample.0),
            Measure::TimeOfMinimum => series.minimum().map(|sample| sample.0),
            Measure::Period => series.period(self.at),
            Measure::Decay => series.decay(),
            Measure::Growth => series.growth(),
            Measure::Crossing => series.passes(self.at?).first().copied(),
            Measure::Curve => None,
        }
    }
}

/// The largest distance of a history from the band between the curves: (computed value there,
/// the largest value of the curves, distance). Samples at times that no curve covers are left out.
fn distance_from_band(series: &Series, curves: &[Series]) -> (Option<f64>, f64, Option<f64>) {
    let (first, last) = (series.x.first().copied(), series.x.last().copied());
    let (from, until) = (first.unwrap_or(0.0), last.unwrap_or(0.0));
    let values = curves.iter().flat_map(|curve| curve.window(from, until).y);
    let peak = values.fold(0.0_f64, |peak, y| if y.abs() > peak.abs() { y } else { peak });

    let distance = |x: f64, y: f64| {
        let [_, low, high] = envelope(curves, x);
        (low <= high).then(|| (low - y).max(y - high).max(0.0))
    };
    let distances = series.x.iter().zip(&series.y).filter_map(|(&x, &y)| Some((y, distance(x, y)?)));
    let worst = distances.reduce(|worst, next| if next.1 > worst.1 || next.1.is_nan() { next } else { worst });
    (worst.map(|(y, _)| y), peak, worst.map(|(_, distance)| distance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::expected::Expected;
    use std::f64::consts::TAU;

    /// e^(−t/2) cos(2πt/0.4) to t = 4, every 0.001.
    fn ringing() -> HistoryTable {
        let row = |n: u32| {
            let t = f64::from(n) * 1e-3;
            format!("{t},{}\n", (-0.5 * t).exp() * (TAU * t / 0.4).cos())
        };
        HistoryTable::parse(format!("time [s],z [m]\n{}", (0..=4000).map(row).collect::<String>()).as_bytes()).unwrap()
    }

    fn outcome(kind: &str, reference: &str, tolerance: &str) -> Outcome {
        let text = format!(
            "[[check]]\nname = 'a'\nhistory = 'h'\nvalue = 'z'\nkind = {kind}\nreference = {reference}\n\
             tolerance = {{ {tolerance} }}\nsource = 's'"
        );
        let check = Expected::parse(&text).unwrap().checks.remove(0);
        let curve = |_: &str| {
            let row = |n: u32| format!("{},{}\n", n, -1e3 * (f64::from(n) * 1e-3 * TAU / 0.4).cos());
            Ok(HistoryTable::parse(format!("t_ms,z_mm\n{}", (0..=100).map(row).collect::<String>()).as_bytes())
                .unwrap())
        };
        check.apply(&ringing(), &[], check.tolerance, curve).unwrap()
    }

    /// sin ωt + ¼ cos 2ωt swings from −5/4 to 3/4; what goes on at another frequency, at two thirds of its strength,
    /// does not count where it is averaged over eighty periods.
    #[test]
    fn averages_over_periods_remove_another_frequency() {
        let row = |n: u32| {
            let t = f64::from(n) * 1e-3;
            let [u, w] = [TAU * t / 0.1, 14.11 * TAU * t];
            format!("{t},{},{}\n", 1.0 + u.sin(), u.sin() + 0.25 * (2.0 * u).cos() + 0.5 * w.sin())
        };
        let rows = (0..=8000).map(row).collect::<String>();
        let table = HistoryTable::parse(format!("time [s],lift [N],drag [N]\n{rows}").as_bytes()).unwrap();
        let measured = |kind: &str, phase: &str| {
            let text = format!(
                "[[check]]\nname = 'a'\nhistory = 'h'\nvalue = 'drag'\n{phase}kind = '{kind}'\nreference = 1.0\n\
                 tolerance = {{ absolute = 0.01 }}\nsource = 's'"
            );
            let check = Expected::parse(&text).unwrap().checks.remove(0);
            check.apply(&table, &[], check.tolerance, |_| Ok(HistoryTable::default())).unwrap().computed.unwrap()
        };
        assert!((measured("amplitude", "phase = 'lift'\n") - 1.0).abs() < 0.01);
        assert!((measured("midrange", "phase = 'lift'\n") + 0.25).abs() < 0.01);
        assert!(measured("amplitude", "") > 1.3);
    }

    /// 0.3 e^(2t), and half of it.
    #[test]
    fn growth_is_that_of_the_difference_of_two_histories() {
        let table = |factor: f64| {
            let row = |n: u32| format!("{n},{}\n", factor * (2.0 * f64::from(n)).exp());
            HistoryTable::parse(format!("time [s],z [m]\n{}", (0..=9).map(row).collect::<String>()).as_bytes()).unwrap()
        };
        let text = "[[check]]\nname = 'a'\nhistory = 'h'\nminus = 'g'\nvalue = 'z'\nkind = 'growth'\nreference = 2.0\n\
                    tolerance = { absolute = 1e-12 }\nsource = 's'";
        let check = Expected::parse(text).unwrap().checks.remove(0);
        let none = |_: &str| Ok(HistoryTable::default());
        let apply =
            |other: &HistoryTable| check.apply(&table(0.3), &[(-1.0, other.clone())], check.tolerance, none).unwrap();
        assert!(apply(&table(0.15)).passed());
        // A difference that vanishes does not grow.
        assert_eq!(apply(&table(0.3)).computed, None);
    }

    #[test]
    fn every_kind_measures_what_it_says() {
        let omega = TAU / 0.4;
        // The decay moves extremes forward: tan ωt = −β/ω there.
        let delay = (0.5 / omega).atan() / omega;
        for (kind, exact, tolerance) in [
            ("'final'", (-2.0f64).exp(), 1e-9),
            ("'value'\nat = 0.4", (-0.2f64).exp(), 1e-9),
            ("'maximum'", 1.0, 1e-9),
            ("'minimum'", -(-0.1f64).exp(), 1e-3),
            ("'largest'\nfrom = 0.1\nuntil = 0.3", -(-0.1f64).exp(), 1e-3),
            ("'mean'\nuntil = 2.0", 0.5 * (1.0 - (-1.0f64).exp()) / (0.25 + omega * omega) / 2.0, 1e-6),
            ("'midrange'", 0.5 - 0.5 * (-0.1f64).exp(), 1e-3),
            ("'amplitude'", 0.5 + 0.5 * (-0.1f64).exp(), 1e-3),
            ("'time-of-minimum'", 0.2 - delay, 0.001),
            ("'time-of-maximum'\nfrom = 0.2", 0.4 - delay, 0.001),
            ("'period'", 0.4, 1e-3),
            ("'decay'", 0.5, 0.005),
            ("'crossing'\nat = 0.0", 0.1, 1e-6),
        ] {
            let outcome = outcome(kind, &exact.to_string(), &format!("absolute = {tolerance}"));
            assert!(outcome.passed(), "{kind}: {outcome:?}");
            let other = (exact + 3.0 * tolerance).to_string();
            assert!(!super::tests::outcome(kind, &other, &format!("absolute = {tolerance}")).passed(), "{kind}");
        }
    }

    #[test]
    fn bounds_hold_on_one_side_only() {
        assert!(outcome("'maximum'\ncompare = 'at-most'", "1.5", "absolute = 0").passed());
        assert!(!outcome("'maximum'\ncompare = 'at-least'", "1.5", "relative = 0.1").passed());
        assert!(outcome("'maximum'\ncompare = 'at-least'", "1.05", "relative = 0.1").passed());
    }

    #[test]
    fn a_curve_is_compared_relative_to_its_peak_in_its_own_units() {
        let curve = "[{ file = 'c.csv', x = 't_ms', y = '-z_mm', x-scale = 1e-3, y-scale = 1e-3 }]";
        // The largest (1 − e^(−t/2)) cos ωt is near ωt = 0.86, the maximum of x cos x = 0.561: about 0.561/(2ω).
        let outcome = outcome("'curve'", curve, "relative = 0.05");
        assert_eq!(outcome.reference, 1.0);
        assert!((outcome.deviation - 0.561 / (2.0 * TAU / 0.4)).abs() < 5e-4 && outcome.passed(), "{outcome:?}");
        let wrong_sign = super::tests::outcome("'curve'", &curve.replace("-z_mm", "z_mm"), "relative = 0.05");
        assert!(!wrong_sign.passed() && wrong_sign.deviation > 1.9);
    }

    #[test]
    fn a_history_between_two_curves_is_in_the_band() {
        let line = |y: f64| Series { x: vec![0.0, 1.0], y: vec![y, y] };
        let history = Series { x: vec![0.0, 0.5, 2.0], y: vec![1.0, 2.5, 99.0] };
        assert_eq!(distance_from_band(&history, &[line(0.5), line(2.0)]), (Some(2.5), 2.0, Some(0.5)));
    }

    #[test]
    fn a_column_that_is_not_in_the_history_fails() {
        assert!(!outcome("'value'\nat = 5.0", "0.0", "absolute = 1e9").passed());
        assert!(!outcome("'crossing'\nat = 5.0", "0.0", "absolute = 1e9").passed());
        assert!(!outcome("'period'\nuntil = 0.3", "0.4", "absolute = 1e9").passed());
    }
}
