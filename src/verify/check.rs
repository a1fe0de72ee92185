//! One comparison of a case, `[[check]]` of `expected.toml`: a quantity of a history and its reference.

use super::curve::Curve;
use super::outcome::{Compare, Level, Tolerance};
use crate::error::Diagnostic;
use serde::Deserialize;

/// One comparison.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Check {
    /// Name of the comparison.
    pub name: String,
    /// The table in `history/`, without `.csv`.
    pub history: String,
    /// A column of the table, or a formula of its columns.
    pub value: String,
    /// Another table of the run, whose value at the same time is taken off.
    pub minus: Option<String>,
    /// Another table of the run, whose value at the same time is added.
    pub plus: Option<String>,
    /// A column of the table, or a formula, whose periods the value is averaged over, phase by phase: from one rise
    /// through its mean to the next. What particles add to an oscillation by chance is not in its extremes then.
    pub phase: Option<String>,
    /// The quantity measured on it.
    pub kind: Measure,
    /// Time of `kind = "value"` [s]; level of `kind = "crossing"` and "period", in the unit of the value.
    pub at: Option<f64>,
    /// Start of the window [s].
    #[serde(default = "always_from")]
    pub from: f64,
    /// End of the window [s].
    #[serde(default = "always_until")]
    pub until: f64,
    /// The reference: a number, or the curves of `kind = "curve"`.
    pub reference: Reference,
    /// Kind of the reference number: a value or a bound.
    #[serde(default)]
    pub compare: Compare,
    /// Allowed deviation.
    pub tolerance: Tolerance,
    /// The tolerance of the default run, where it is another one.
    pub quick: Option<Tolerance>,
    /// The tolerance of `--full`, where it is another one.
    pub full: Option<Tolerance>,
    /// Source of the reference.
    pub source: String,
}

/// Quantities measured on a history within the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The last value.
    Final,
    /// The value at the time `at`.
    Value,
    /// The largest value.
    Maximum,
    /// The smallest value.
    Minimum,
    /// The value that is farthest from zero.
    Largest,
    /// The mean over time.
    Mean,
    /// Half of the sum of the largest and the smallest value: the middle of an oscillation.
    Midrange,
    /// Half of the difference of the largest and the smallest value.
    Amplitude,
    /// The time of the largest value [s].
    TimeOfMaximum,
    /// The time of the smallest value [s].
    TimeOfMinimum,
    /// The mean period of an oscillation about the level `at`, or its mean [s].
    Period,
    /// The rate at which the amplitude of an oscillation falls [1/s].
    Decay,
    /// The rate at which a value grows like an exponential [1/s].
    Growth,
    /// The first time at which the level `at` is passed [s].
    Crossing,
    /// The largest distance from the band of the reference curves.
    Curve,
}

/// Reference of a check.
#[derive(Debug, Clone, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, or a list of curves: [{ file = \"reference.csv\", x = \"t\", y = \"u\" }]"
)]
pub enum Reference {
    /// A number.
    Number(f64),
    /// Curves from tables; several make a band.
    Curves(Vec<Curve>),
}

impl Check {
    /// The tolerance at a level of effort.
    pub fn tolerance_at(&self, level: Level) -> Tolerance {
        let special = match level {
            Level::Quick => self.quick,
            Level::Full => self.full,
        };
        special.unwrap_or(self.tolerance)
    }

    /// Values of the column that the reference is: those of an amplitude about the middle that another of the `checks`
    /// has. None for other quantities than values of a column, and for bounds.
    pub fn levels(&self, checks: &[Self]) -> Vec<f64> {
        let Reference::Number(reference) = self.reference else { return Vec::new() };
        if self.compare != Compare::Equal || self.minus.is_some() {
            return Vec::new();
        }
        let is_middle = |other: &&Self| {
            other.kind == Measure::Midrange
                && (&other.history, &other.plus, &other.value) == (&self.history, &self.plus, &self.value)
        };
        match (self.kind, checks.iter().find(is_middle).map(|middle| &middle.reference)) {
            (Measure::Amplitude, Some(Reference::Number(middle))) => vec![middle - reference, middle + reference],
            (
                Measure::Final
                | Measure::Value
                | Measure::Maximum
                | Measure::Minimum
                | Measure::Largest
                | Measure::Mean
                | Measure::Midrange,
                _,
            ) => vec![reference],
            _ => Vec::new(),
        }
    }

    /// The time at which the column passes a level, with this level: a point of its curve. None for other quantities.
    pub fn passage(&self) -> Option<[f64; 2]> {
        match (&self.reference, self.kind) {
            (Reference::Number(time), Measure::Crossing) if self.compare == Compare::Equal && self.minus.is_none() => {
                Some([*time, self.at?])
            }
            _ => None,
        }
    }

    /// What the comparison lacks.
    pub(super) fn finding(&self) -> Option<Diagnostic> {
        let key = format!("check `{}`", self.name);
        let needs_at = matches!(self.kind, Measure::Value | Measure::Crossing);
        if needs_at && self.at.is_none() {
            return Some(Diagnostic::error(key, "this kind needs `at`"));
        }
        match (&self.reference, self.kind) {
            (Reference::Number(_), Measure::Curve) => {
                Some(Diagnostic::error(key, "a curve is compared with curves").help("reference = [{ file, x, y }]"))
            }
            (Reference::Curves(_), kind) if kind != Measure::Curve => {
                Some(Diagnostic::error(key, "curves are compared by `kind = \"curve\"`"))
            }
            _ => None,
        }
    }
}

fn always_from() -> f64 {
    f64::NEG_INFINITY
}

fn always_until() -> f64 {
    f64::INFINITY
}
