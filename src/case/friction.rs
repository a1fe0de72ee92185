//! Friction between two parts.

use crate::mpm;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Friction of a pair: a coefficient, `"stick"`, or `"none"` (the pair never meets).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FrictionSpec {
    /// Coulomb's coefficient; 0: frictionless.
    Coefficient(#[schemars(extend("minimum" = 0.0))] f64),
    /// A word.
    Word(FrictionWord),
}

/// Words for friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FrictionWord {
    /// No relative motion while pressed together.
    Stick,
    /// The pair never meets.
    None,
}

impl From<FrictionSpec> for mpm::Friction {
    fn from(friction: FrictionSpec) -> Self {
        match friction {
            FrictionSpec::Coefficient(coefficient) => Self::Slip(coefficient),
            FrictionSpec::Word(FrictionWord::Stick) => Self::Stick,
            FrictionSpec::Word(FrictionWord::None) => Self::None,
        }
    }
}
