//! A sampled curve y(x) from a table, and measures of it.
//!
//! Between samples a curve is linear; outside its samples it has no value.

use crate::error::{Diagnostic, Error, Result};
use crate::math::formula::Formula;
use crate::output::history::HistoryTable;

/// A curve y(x) with increasing x.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Arguments, increasing.
    pub x: Vec<f64>,
    /// Values.
    pub y: Vec<f64>,
}

impl Series {
    /// The part with `from` ≤ x ≤ `until`.
    #[must_use]
    pub fn window(&self, from: f64, until: f64) -> Self {
        let inside = |&(&x, _): &(&f64, &f64)| x >= from && x <= until;
        let (x, y) = self.x.iter().zip(&self.y).filter(inside).map(|(&x, &y)| (x, y)).unzip();
        Self { x, y }
    }

    /// The value at `x`, or `None` outside the samples.
    pub fn at(&self, x: f64) -> Option<f64> {
        let right = self.x.partition_point(|&sample| sample < x);
        match (right.checked_sub(1), self.x.get(right)) {
            (_, Some(&sample)) if sample == x => Some(self.y[right]),
            (Some(left), Some(_)) => {
                let s = (x - self.x[left]) / (self.x[right] - self.x[left]);
                Some(self.y[left] + s * (self.y[right] - self.y[left]))
            }
            _ => None,
        }
    }

    /// The last value.
    pub fn last(&self) -> Option<f64> {
        self.y.last().copied()
    }

    /// The sample with the largest value, as (x, y).
    pub fn maximum(&self) -> Option<(f64, f64)> {
        let samples = self.x.iter().zip(&self.y).map(|(&x, &y)| (x, y));
        samples.reduce(|best, sample| if sample.1 > best.1 { sample } else { best })
    }

    /// The sample with the smallest value, as (x, y).
    pub fn minimum(&self) -> Option<(f64, f64)> {
        self.map(|y| -y).maximum().map(|(x, y)| (x, -y))
    }

    /// The mean over x, by the trapezoid rule.
    pub fn mean(&self) -> Option<f64> {
        let area = |n: usize| 0.5 * (self.y[n] + self.y[n + 1]) * (self.x[n + 1] - self.x[n]);
        let length = self.x.last()? - self.x.first()?;
        if length > 0.0 { Some((0..self.x.len() - 1).map(area).sum::<f64>() / length) } else { self.last() }
    }

    /// Every x at which the curve rises through `level`.
    pub fn rises_through(&self, level: f64) -> Vec<f64> {
        let rises = |n: &usize| self.y[*n] < level && self.y[*n + 1] >= level;
        let place = |n: usize| {
            let s = (level - self.y[n]) / (self.y[n + 1] - self.y[n]);
            self.x[n] + s * (self.x[n + 1] - self.x[n])
        };
        (0..self.x.len().saturating_sub(1)).filter(rises).map(place).collect()
    }

    /// Every x at which the curve passes `level`, in either direction.
    pub fn passes(&self, level: f64) -> Vec<f64> {
        let mut places = self.rises_through(level);
        places.extend(self.map(|y| -y).rises_through(-level));
        places.sort_by(f64::total_cmp);
        places
    }

    /// The mean distance of two rises through `level`, or the mean value; `None` with fewer than two rises.
    ///
    /// The mean of a damped wave over a window that is no whole number of periods lies off the middle: name the level
    /// where it is known.
    pub fn period(&self, level: Option<f64>) -> Option<f64> {
        let rises = self.rises_through(level.or_else(|| self.mean())?);
        let count = rises.len().checked_sub(1).filter(|&n| n > 0)?;
        Some((rises[count] - rises[0]) / count as f64)
    }

    /// One period, the mean of all those from one rise of `clock` through its mean to the next; nothing with fewer than
    /// two rises.
    #[must_use]
    pub fn folded(&self, clock: &Self) -> Self {
        const PHASES: u32 = 360;
        let rises = clock.mean().map(|level| clock.rises_through(level)).unwrap_or_default();
        let Some(period) = clock.period(None) else { return Self::default() };
        let mean = |phase: f64| {
            let values = rises.windows(2).filter_map(|pair| self.at(pair[0] + phase * (pair[1] - pair[0])));
            let (sum, count) = values.fold((0.0, 0.0), |(sum, count), y| (sum + y, count + 1.0));
            (phase * period, sum / count)
        };
        let (x, y) = (0..PHASES).map(|n| mean(f64::from(n) / f64::from(PHASES))).unzip();
        Self { x, y }
    }

    /// The rate β of an oscillation whose amplitude falls like e^(−βx): a straight line through the
    /// logarithms of its successive maxima about the mean; `None` with fewer than two maxima.
    pub fn decay(&self) -> Option<f64> {
        let mean = self.mean()?;
        let is_peak = |n: &usize| self.y[*n] > mean && self.y[*n - 1] < self.y[*n] && self.y[*n] >= self.y[*n + 1];
        let peaks = (1..self.x.len().saturating_sub(1)).filter(is_peak);
        let (x, y) = peaks.map(|n| (self.x[n], (self.y[n] - mean).ln())).unzip();
        Self { x, y }.slope().map(|slope| -slope)
    }

    /// The rate n of a growth like e^(nx): a straight line through the logarithms; `None` with fewer than two samples,
    /// or where the value isn't positive.
    pub fn growth(&self) -> Option<f64> {
        if self.y.iter().all(|&y| y > 0.0) { self.map(f64::ln).slope() } else { None }
    }

    /// This curve and `factor` times another one, where that has values.
    #[must_use]
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let sum = self.x.iter().zip(&self.y).filter_map(|(&x, &y)| Some((x, y + factor * other.at(x)?)));
        let (x, y) = sum.unzip();
        Self { x, y }
    }

    /// The slope of the straight line that fits the samples best; `None` with fewer than two.
    pub fn slope(&self) -> Option<f64> {
        let count = self.x.len() as f64;
        let (x0, y0) = (self.x.iter().sum::<f64>() / count, self.y.iter().sum::<f64>() / count);
        let (mut sxy, mut sxx) = (0.0, 0.0);
        for (x, y) in self.x.iter().zip(&self.y) {
            sxy += (x - x0) * (y - y0);
            sxx += (x - x0) * (x - x0);
        }
        (sxx > 0.0).then(|| sxy / sxx)
    }

    /// Every value through `f`.
    #[must_use]
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self { x: self.x.clone(), y: self.y.iter().map(|&y| f(y)).collect() }
    }
}

/// The band between curves: (x, smallest, largest) at every x that a curve is sampled at.
pub fn band(curves: &[Series]) -> Vec<[f64; 3]> {
    let mut places: Vec<f64> = curves.iter().flat_map(|curve| curve.x.iter().copied()).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places.into_iter().map(|x| envelope(curves, x)).collect()
}

/// (x, smallest, largest) of the curves that have a value at `x`.
pub fn envelope(curves: &[Series], x: f64) -> [f64; 3] {
    let values = curves.iter().filter_map(|curve| curve.at(x));
    values.fold([x, f64::INFINITY, f64::NEG_INFINITY], |[x, low, high], y| [x, low.min(y), high.max(y)])
}

/// `y` over `x` from a table, where `y` may be a formula of its columns: `sqrt(x^2 + y^2)`,
/// `{kinetic energy: water} / 2`.
///
/// # Errors
/// A column that isn't there, or a formula that can't be read.
pub fn series(table: &HistoryTable, x: &str, y: &str) -> Result<Series> {
    let x = table.column(x).ok_or_else(|| unknown(table, x, "no such column"))?;
    let y = match table.column(y) {
        Some(column) => column.to_vec(),
        None => formula(table, y, x.len())?,
    };
    Ok(Series { x: x.to_vec(), y })
}

fn formula(table: &HistoryTable, text: &str, rows: usize) -> Result<Vec<f64>> {
    let names = table.names();
    let formula = Formula::over(text, &names).map_err(|error| unknown(table, text, &error.message))?;
    let columns: Vec<&[f64]> = names.iter().filter_map(|name| table.column(name)).collect();
    Ok((0..rows).map(|n| formula.at(&columns.iter().map(|column| column[n]).collect::<Vec<f64>>())).collect())
}

fn unknown(table: &HistoryTable, name: &str, why: &str) -> Error {
    let finding = Diagnostic::error("column", format!("`{name}` is neither a column nor a formula of columns: {why}"));
    Error::case(finding.help(format!("the columns are `{}`", table.heads.join("`, `"))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sampled(f: impl Fn(f64) -> f64, end: f64, count: u32) -> Series {
        let x: Vec<f64> = (0..=count).map(|n| end * f64::from(n) / f64::from(count)).collect();
        Series { y: x.iter().map(|&x| f(x)).collect(), x }
    }

    #[test]
    fn a_curve_is_linear_between_samples_and_nothing_outside() {
        let line = Series { x: vec![0.0, 1.0, 3.0], y: vec![0.0, 2.0, 0.0] };
        assert_eq!(line.at(0.5), Some(1.0));
        assert_eq!(line.at(2.0), Some(1.0));
        assert_eq!(line.at(3.0), Some(0.0));
        assert_eq!((line.at(-0.1), line.at(3.1)), (None, None));
        assert_eq!(line.window(0.5, 3.0).x, [1.0, 3.0]);
    }

    #[test]
    fn extremes_carry_their_places() {
        let wave = sampled(|x| (TAU * x).sin(), 1.0, 100);
        assert_eq!(wave.maximum().unwrap().0, 0.25);
        assert_eq!(wave.minimum().unwrap(), (0.75, -1.0));
        assert!(wave.mean().unwrap().abs() < 1e-12);
    }

    #[test]
    fn the_period_of_a_damped_wave_about_an_offset() {
        let wave = sampled(|x| 5.0 + (-0.3 * x).exp() * (TAU * x / 0.8).sin(), 8.0, 4000);
        assert!((wave.period(None).unwrap() - 0.8).abs() < 0.002);
        assert!((wave.period(Some(5.0)).unwrap() - 0.8).abs() < 1e-6);
        let beta = sampled(|x| 5.0 + (-0.3 * x).exp() * (TAU * x / 0.1).sin(), 4.0, 40_000).decay().unwrap();
        assert!((beta - 0.3).abs() < 0.003, "{beta}");
    }

    #[test]
    fn half_a_wave_has_no_period() {
        assert_eq!(sampled(|x| (TAU * x).sin(), 0.5, 100).period(None), None);
        assert_eq!(Series::default().mean(), None);
    }

    #[test]
    fn a_level_is_passed_in_both_directions() {
        let wave = sampled(|x| (TAU * x).sin(), 1.0, 1000);
        let passes = wave.passes(0.5);
        assert_eq!(passes.len(), 2);
        assert!((passes[0] - 1.0 / 12.0).abs() < 1e-5 && (passes[1] - 5.0 / 12.0).abs() < 1e-5);
    }

    #[test]
    fn columns_are_found_without_their_unit_and_combined_by_formulas() {
        let table =
            HistoryTable::parse(b"# a comment\ntime [s],kinetic energy: water [J],z [m]\n0,3,4\n1, 6, 8\n").unwrap();
        assert_eq!(series(&table, "time", "z").unwrap().y, [4.0, 8.0]);
        assert_eq!(series(&table, "time", "sqrt({kinetic energy: water}^2 + z^2)").unwrap().y, [5.0, 10.0]);
        let error = series(&table, "time", "w + z").unwrap_err().to_string();
        assert!(error.contains("`w` is not known") && error.contains("z [m]"), "{error}");
        assert_eq!(series(&table, "time", "2 * z / pi").unwrap().y[0], 8.0 / std::f64::consts::PI);
    }
}
