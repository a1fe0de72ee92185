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
//!
//! The case with other settings: [`super::variant`].

use super::check::Check;
use super::curve::Curve;
use super::outcome::Level;
use super::profile::Profile;
use super::variant::Variant;
use crate::error::{Diagnostic, Error, Result};
use crate::output::label::file_name;
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
    /// The case with other settings, at the level `--full`.
    #[serde(default, rename = "variant")]
    pub variants: Vec<Variant>,
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
        let findings = expected.findings(&toml::from_str(text).unwrap_or_default());
        if findings.is_empty() { Ok(expected) } else { Err(Error::Case(findings)) }
    }

    /// What the checks lack, and variants without any.
    fn findings(&self, spans: &ExpectedSpans) -> Vec<Diagnostic> {
        let mut findings = findings_of(&self.checks, &spans.checks);
        for (variant, spans) in self.variants.iter().zip(&spans.variants) {
            findings.extend(findings_of(&variant.checks, &spans.get_ref().checks));
            if variant.checks.is_empty() {
                let finding = Diagnostic::error(format!("variant `{}`", variant.name), "it is compared with nothing");
                findings.push(finding.at(spans.span()).help("add a comparison, `[[variant.check]]`, after it"));
            }
        }
        findings
    }

    /// The runs of a level by their names: that of the case, then its variants in the order of the file, which are
    /// those of `--full`. The names are those of their folders, too.
    pub fn runs(&self, case: &str, level: Level) -> Vec<(String, Self)> {
        let compares = !(self.checks.is_empty() && self.profiles.is_empty());
        let own = compares.then(|| (case.to_owned(), self.clone()));
        let variants = self.variants.iter().filter(|_| level == Level::Full);
        let named = |variant: &Variant| (file_name(&format!("{case}-{}", variant.name)), self.of_variant(variant));
        own.into_iter().chain(variants.map(named)).collect()
    }

    /// The comparisons of a variant, as if it was a case of its own.
    fn of_variant(&self, variant: &Variant) -> Self {
        let mut set = self.full.set.clone();
        set.extend(variant.set.clone());
        Self { full: Effort { set, skip: false }, checks: variant.checks.clone(), ..Self::default() }
    }

    /// True if there is nothing that a run could be compared with.
    pub fn compares_nothing(&self) -> bool {
        self.checks.is_empty() && self.profiles.is_empty() && self.variants.is_empty()
    }
}

/// What checks lack that lie at `spans` in the text.
fn findings_of(checks: &[Check], spans: &[Spanned<IgnoredAny>]) -> Vec<Diagnostic> {
    let spans = spans.iter().map(Spanned::span).map(Some).chain(std::iter::repeat(None));
    checks.iter().zip(spans).filter_map(|(check, span)| Some(Diagnostic { span, ..check.finding()? })).collect()
}

/// Places of the checks in the text.
#[derive(Default, Deserialize)]
struct ExpectedSpans {
    #[serde(default, rename = "check")]
    checks: Vec<Spanned<IgnoredAny>>,
    #[serde(default, rename = "variant")]
    variants: Vec<Spanned<CheckSpans>>,
}

/// Places of the checks of a variant in the text.
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

#[cfg(test)]
mod tests {
    use super::super::check::Measure;
    use super::super::outcome::Compare;
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
