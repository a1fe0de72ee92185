//! The region below a curve y = η(x), as a polygon.

use super::BuildRegion;
use crate::error::Diagnostic;
use crate::geometry::{Polygon, Region};
use crate::math::{Signal, Vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

/// The region below a curve y = η(x), between two ends and above a bottom; 2D only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BelowShape {
    /// Height η [m], a formula in x.
    #[schemars(extend("unit" = "m", "formula" = true))]
    pub height: Height,
    /// Left end [m].
    #[schemars(extend("unit" = "m"))]
    pub from: f64,
    /// Right end [m].
    #[schemars(extend("unit" = "m"))]
    pub to: f64,
    /// Lower end [m].
    #[schemars(extend("unit" = "m"))]
    pub bottom: f64,
    /// Straight pieces of the curve.
    #[serde(default = "pieces")]
    #[schemars(extend("minimum" = 1, "maximum" = 10_000))]
    pub pieces: usize,
}

/// A number or a formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Height {
    /// A constant height [m].
    Number(f64),
    /// A formula in x.
    Formula(String),
}

fn pieces() -> usize {
    200
}

impl BuildRegion for BelowShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        if dimension != 2 {
            return Err(Diagnostic::error("shape", "`below` is for 2D").help("in 3D use a `half-space` or a `surface`"));
        }
        if !(self.to > self.from && (self.to - self.from).is_finite()) {
            return Err(Diagnostic::error("to", "the right end must lie right of the left one"));
        }
        let height = match &self.height {
            Height::Number(height) => Signal::Constant(*height),
            Height::Formula(source) => Signal::formula(source).map_err(|why| Diagnostic::error("height", why))?,
        };
        if let Signal::Formula(formula) = &height
            && (1..=3).any(|variable| formula.uses(variable))
        {
            return Err(Diagnostic::error("height", "the curve depends on x alone").help("drop y, z and t"));
        }
        let mut corners = vec![Vector([self.to, self.bottom]), Vector([self.from, self.bottom])];
        corners.reverse();
        for piece in (0..=self.pieces).rev() {
            let x = self.from + (self.to - self.from) * piece as f64 / self.pieces as f64;
            let y = height.value([x, 0.0, 0.0], 0.0);
            if !(y > self.bottom && y.is_finite()) {
                let message = format!("the curve is at y = {y} for x = {x}, not above the bottom");
                return Err(Diagnostic::error("height", message));
            }
            corners.push(Vector([x, y]));
        }
        let polygon = Polygon::new(corners, f64::NEG_INFINITY, f64::INFINITY);
        let polygon = polygon.map_err(|why| Diagnostic::error("height", why))?;
        Ok(Region::Polygon(Arc::new(polygon)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_below_a_cosine_ends_at_it() {
        let height = Height::Formula("-0.1*cos(2*pi*x)".into());
        let shape = BelowShape { height, from: -0.5, to: 0.5, bottom: -2.0, pieces: 400 };
        let region = shape.build(Path::new(""), 2).unwrap();
        for (x, y, inside) in [(0.0, -0.11, true), (0.0, -0.09, false), (0.49, 0.09, true), (0.49, 0.11, false)] {
            assert_eq!(region.signed_distance([x, y, 0.0]) < 0.0, inside, "{x} {y}");
        }
        // The crest of the curve is flat: the distance below it is vertical.
        assert!((region.signed_distance([0.0, -0.2, 0.0]) + 0.1).abs() < 1e-3);
        assert!(shape.build(Path::new(""), 3).is_err());
    }
}
