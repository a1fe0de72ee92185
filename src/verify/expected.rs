//! `expected.toml`: the comparisons of a case, beside its `case.toml`.
//!
//! ```toml
//! [measured]                    # what a run of the case took on one core, for `lateen cases`
//! time = "95 s"
//! size = "3054 particles, 2500 elements"
//!
//! [quick]                       # overrides of the default run, so that all cases take minutes
//! set = { "grid.cell" = "2 mm" }
//! [full]                        # overrides of `--full`
//! set = {}
//!
//! [[check]]
//! name = "deepest deflection"
//! history = "centre"            # history/centre.csv
//! value = "z"                   # a column, or a formula: "z / pi", "{kinetic energy: water} / 2"
//! kind = "minimum"
//! until = 0.45e-3
//! reference = -1.41e-3
//! tolerance = { relative = 0.03 }
//! quick = { relative = 0.08 }   # for the default run; `full` likewise
//! source = "two finite element programs, rigid sphere"
//!
//! [[check]]
//! name = "pressure inside less that outside"
//! history = "inside"
//! minus = "outside"             # the same value of another history is taken off; `plus` adds it
//! ...
//!
//! [[drawn]]                     # a published curve that is drawn and not compared
//! history = "tip-x"
//! value = "ux"
//! reference = [{ file = "reference/history.csv", x = "time", y = "ux" }]
//! phase = { history = "tip-y", value = "uy", reference = { file = "reference/history.csv", x = "time", y = "uy" } }
//! source = "FeatFlow"
//!
//! [[profile]]                   # a field of particles at the end, over a coordinate
//! name = "density, L1 error"
//! of = ["left", "right"]
//! field = "density"
//! axis = "x"
//! reference = { file = "reference/exact.csv", x = "x", y = "rho" }
//! tolerance = { absolute = 0.02 }
//! source = "exact Riemann solution"
//! ```

use super::curve::Curve;
use super::outcome::{Compare, Level, Tolerance};
use super::profile::Profile;
use crate::error::{Diagnostic, Error, Result};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use toml::Spanned;

/// Everything that a case is compared with.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    /// Cost of a run.
    #[serde(default)]
    pub measured: Measured,
    /// The default run.
    #[serde(default)]
    pub quick: Effort,
    /// The run of `--full`.
    #[serde(default)]
    pub full: Effort,
    /// Comparisons.
    #[serde(default, rename = "check")]
    pub checks: Vec<Check>,
    /// Comparisons of fields at the end of the run.
    #[serde(default, rename = "profile")]
    pub profiles: Vec<Profile>,
    /// Curves that are drawn but not compared.
    #[serde(default, rename = "drawn")]
    pub drawn: Vec<Drawn>,
}

/// Cost and size of a run, as measured.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Processor time on one core, outputs included.
    #[serde(default)]
    pub time: String,
    /// Particles, elements, cells.
    #[serde(default)]
    pub size: String,
}

/// Settings of a run at one level of effort.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effort {
    /// Keys of the case to override, as `--set` does.
    #[serde(default)]
    pub set: BTreeMap<String, toml::Value>,
    /// True: the case is left out at this level.
    #[serde(default)]
    pub skip: bool,
}

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

/// Curves that are drawn in the plot of a history, and not compared.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drawn {
    /// The table in `history/`, without `.csv`.
    pub history: String,
    /// The column.
    pub value: String,
    /// The curves; several make a band.
    pub reference: Vec<Curve>,
    /// The signal that tells the phase, where the curves are to be moved to that of the run.
    pub phase: Option<DrawnPhase>,
    /// Their source.
    pub source: String,
}

/// The phase of curves that are periodic: they are moved in time so that a signal of theirs rises when that of the run
/// does last.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnPhase {
    /// The table in `history/` with the signal, without `.csv`.
    pub history: String,
    /// Its column.
    pub value: String,
    /// The same signal of the reference, a period or more of it.
    pub reference: Curve,
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

impl Expected {
    /// The settings of the run at a level.
    pub fn effort(&self, level: Level) -> &Effort {
        match level {
            Level::Quick => &self.quick,
            Level::Full => &self.full,
        }
    }

    /// Reads `expected.toml`.
    ///
    /// # Errors
    /// Case errors: syntax, unknown keys, and checks that lack what their kind needs.
    pub fn parse(text: &str) -> Result<Self> {
        let expected: Self = toml::from_str(text).map_err(|error| {
            let finding = Diagnostic::error("expected.toml", error.message());
            Error::case(match error.span() {
                Some(span) => finding.at(span),
                None => finding,
            })
        })?;
        let places = toml::from_str::<CheckSpans>(text).map_or_else(|_| Vec::new(), |places| places.checks);
        let places = places.iter().map(Spanned::span).map(Some).chain(std::iter::repeat(None));
        let findings = expected.checks.iter().zip(places).filter_map(|(check, span)| {
            let finding = check.finding()?;
            Some(Diagnostic { span, ..finding })
        });
        let findings: Vec<Diagnostic> = findings.collect();
        if findings.is_empty() { Ok(expected) } else { Err(Error::Case(findings)) }
    }

    /// True if there is nothing that a run could be compared with.
    pub fn compares_nothing(&self) -> bool {
        self.checks.is_empty() && self.profiles.is_empty()
    }
}

/// Places of the checks in the text.
#[derive(Deserialize)]
struct CheckSpans {
    #[serde(default, rename = "check")]
    checks: Vec<Spanned<IgnoredAny>>,
}

impl Effort {
    /// The overrides as pairs of key and text.
    pub fn overrides(&self) -> Vec<(String, String)> {
        let text = |value: &toml::Value| match value {
            toml::Value::String(text) => text.clone(),
            value => value.to_string(),
        };
        self.set.iter().map(|(key, value)| (key.clone(), text(value))).collect()
    }
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

    fn finding(&self) -> Option<Diagnostic> {
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

#[cfg(test)]
mod tests {
    use super::*;

    const CHECK: &str = "[[check]]\nname = 'peak'\nhistory = 'centre'\nvalue = 'z'\nkind = 'minimum'\n\
        reference = -1.41e-3\ntolerance = { relative = 0.03 }\nsource = 'a paper'\n";

    #[test]
    fn a_check_reads_back() {
        let expected = Expected::parse(CHECK).unwrap();
        let check = &expected.checks[0];
        assert_eq!((check.kind, check.compare), (Measure::Minimum, Compare::Equal));
        assert_eq!(check.tolerance.limit(-2.0), 0.06);
        assert!(check.until > 1e300);
    }

    /// A middle of 1 and an amplitude of 3 about it are 1, −2 and 4; a bound, a rate, and an amplitude about an unknown
    /// middle are no values of the column.
    #[test]
    fn values_of_a_column_are_levels() {
        let check = |kind: &str, reference: f64, more: &str| {
            format!(
                "[[check]]\nname = 'a'\nhistory = 'h'\nvalue = 'z'\nkind = '{kind}'\nreference = {reference:?}\n{more}\n\
                 tolerance = {{ absolute = 1.0 }}\nsource = 's'\n"
            )
        };
        let levels = |text: &str| {
            let checks = Expected::parse(text).unwrap().checks;
            checks.iter().map(|check| check.levels(&checks)).collect::<Vec<_>>()
        };
        let swing = [check("midrange", 1.0, ""), check("amplitude", 3.0, ""), check("growth", 5.0, "")].concat();
        assert_eq!(levels(&swing), [vec![1.0], vec![-2.0, 4.0], vec![]]);
        assert_eq!(levels(&check("amplitude", 3.0, "")), [vec![]; 1] as [Vec<f64>; 1]);
        let others = [check("maximum", 2.0, "compare = 'at-most'"), check("mean", 2.0, "minus = 'g'")].concat();
        assert!(levels(&others).iter().all(Vec::is_empty));
        let passage = Expected::parse(&check("crossing", 0.25, "at = 0.0")).unwrap().checks[0].passage();
        assert_eq!(passage, Some([0.25, 0.0]));
        // The middle of a sum is that of the same sum.
        let sums =
            [check("midrange", 7.0, ""), check("midrange", 1.0, "plus = 'g'"), check("amplitude", 3.0, "plus = 'g'")];
        assert_eq!(levels(&sums.concat()), [vec![7.0], vec![1.0], vec![-2.0, 4.0]]);
    }

    #[test]
    fn checks_that_lack_something_are_errors() {
        for (from, to, expected) in [
            ("minimum", "value", "needs `at`"),
            ("minimum", "curve", "compared with curves"),
            ("minimum", "highest", "unknown variant"),
            ("source", "origin", "unknown field"),
        ] {
            let error = Expected::parse(&CHECK.replace(from, to)).unwrap_err();
            assert_eq!(error.exit_code(), 2);
            let Error::Case(findings) = &error else { panic!("{error}") };
            assert!(findings[0].span.is_some(), "{findings:?}");
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
