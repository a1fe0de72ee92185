//! Shapes of references in a plot.

use super::HorizontalLine;

/// Shape of a reference in a plot.
#[derive(Debug, Clone, PartialEq)]
pub enum CurveShape {
    /// Points (x, y).
    Points(Vec<[f64; 2]>),
    /// The area between (x, lower) and (x, upper).
    Band(Vec<[f64; 3]>),
    /// Values that hold over a span of time, open where it is infinite.
    Levels(Vec<HorizontalLine>),
}

impl CurveShape {
    /// True for values, which are drawn beside other columns of a history; curves have a plot of their own.
    pub(super) fn is_levels(&self) -> bool {
        matches!(self, Self::Levels(_))
    }

    /// The same curve, later by `shift`.
    #[must_use]
    pub fn later(&self, shift: f64) -> Self {
        match self {
            Self::Points(points) => Self::Points(points.iter().map(|&[t, y]| [t + shift, y]).collect()),
            Self::Band(points) => Self::Band(points.iter().map(|&[t, low, high]| [t + shift, low, high]).collect()),
            Self::Levels(levels) => Self::Levels(
                levels.iter().map(|level| HorizontalLine { x: level.x.map(|t| t + shift), ..*level }).collect(),
            ),
        }
    }

    /// First time of the curve.
    pub fn begin(&self) -> Option<f64> {
        match self {
            Self::Points(points) => points.first().map(|point| point[0]),
            Self::Band(points) => points.first().map(|point| point[0]),
            Self::Levels(levels) => levels.first().map(|level| level.x[0]),
        }
    }
}
