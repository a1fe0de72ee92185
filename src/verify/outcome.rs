//! The outcome of a comparison, and the tolerances that decide it.

use serde::Deserialize;

/// Level of effort of a verification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Minutes for all cases.
    Quick,
    /// The resolution of the papers.
    Full,
}

/// Kinds of reference numbers: a value or a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compare {
    /// Equal within the tolerance.
    #[default]
    Equal,
    /// Not smaller than the reference by more than the tolerance.
    AtLeast,
    /// Not larger than the reference by more than the tolerance.
    AtMost,
}

/// Allowed deviation: |computed − reference| ≤ absolute + relative·|reference|.
///
/// For curves the reference is the largest value of the curves.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerance {
    /// In the unit of the value.
    pub absolute: f64,
    /// As a fraction of the reference.
    pub relative: f64,
}

impl Compare {
    /// Deviation of a computed value from the reference.
    pub(super) fn deviation(self, computed: f64, reference: f64) -> f64 {
        match self {
            Self::Equal => (computed - reference).abs(),
            Self::AtLeast => (reference - computed).max(0.0),
            Self::AtMost => (computed - reference).max(0.0),
        }
    }
}

impl Tolerance {
    /// The largest allowed deviation from `reference`.
    pub fn limit(&self, reference: f64) -> f64 {
        self.absolute + self.relative * reference.abs()
    }
}

/// The outcome of one check.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Name of the comparison.
    pub name: String,
    /// The computed value; `None` if the history doesn't hold it (too short, no oscillation).
    pub computed: Option<f64>,
    /// The reference value (for curves: their largest value).
    pub reference: f64,
    /// |computed − reference|, or how far a bound is missed, or the largest distance from the curves.
    pub deviation: f64,
    /// The largest allowed deviation.
    pub limit: f64,
    /// Source of the reference.
    pub source: String,
}

impl Outcome {
    /// True if the deviation is within its limit.
    pub fn passed(&self) -> bool {
        self.computed.is_some() && self.deviation <= self.limit
    }
}
