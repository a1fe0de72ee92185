//! Directions of a case file: `"z"`, `"-x"` or a vector of any length.

use crate::error::Diagnostic;
use crate::math::Vector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A direction: the name of an axis or a vector of any length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Direction {
    /// Along an axis.
    Axis(Axis),
    /// Along a vector of any length, with as many components as the case has dimensions.
    Vector(Vec<f64>),
}

/// An axis and its sense.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Axis {
    /// Along x.
    #[serde(rename = "x")]
    X,
    /// Along y.
    #[serde(rename = "y")]
    Y,
    /// Along z.
    #[serde(rename = "z")]
    Z,
    /// Against x.
    #[serde(rename = "-x")]
    MinusX,
    /// Against y.
    #[serde(rename = "-y")]
    MinusY,
    /// Against z.
    #[serde(rename = "-z")]
    MinusZ,
}

impl Direction {
    /// The direction z.
    pub fn z() -> Self {
        Self::Axis(Axis::Z)
    }

    /// The unit vector, padded with zeros.
    ///
    /// # Errors
    /// At `key`: a wrong number of components, no length, or z in 2D.
    pub fn unit(&self, key: &str, dimension: usize) -> Result<Vector<3>, Diagnostic> {
        let vector = match self {
            Self::Axis(axis) => axis.vector(),
            Self::Vector(components) if components.len() == dimension => {
                Vector::from_fn(|i| components.get(i).copied().unwrap_or(0.0))
            }
            Self::Vector(components) => {
                let message = format!("{} components where the case has {dimension} dimensions", components.len());
                return Err(Diagnostic::error(key, message).help(format!("write {dimension} components")));
            }
        };
        if dimension == 2 && vector[2] != 0.0 {
            return Err(Diagnostic::error(key, "there is no z in 2D"));
        }
        let unit = vector.normalized().filter(|d| d.is_finite());
        unit.ok_or_else(|| Diagnostic::error(key, "a direction needs a length above zero"))
    }
}

impl Axis {
    fn vector(self) -> Vector<3> {
        match self {
            Self::X => Vector::unit(0),
            Self::Y => Vector::unit(1),
            Self::Z => Vector::unit(2),
            Self::MinusX => -Vector::unit(0),
            Self::MinusY => -Vector::unit(1),
            Self::MinusZ => -Vector::unit(2),
        }
    }
}
