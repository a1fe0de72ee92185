//! Conditions on one velocity, by the kind of the wall (theory E.1).

use super::WallKind;
use crate::math::Vector;

impl WallKind {
    /// True if the condition binds always, in both directions.
    pub fn binds(self) -> bool {
        matches!(self, Self::Fixed | Self::Slip)
    }

    /// The order in which several conditions of one node are applied: the strictest last.
    pub fn strictness(self) -> u8 {
        match self {
            Self::Open => 0,
            Self::Separate | Self::Friction { .. } => 1,
            Self::Slip => 2,
            Self::Fixed => 3,
        }
    }

    /// The velocity after the condition.
    pub fn constrain<const D: usize>(self, v: Vector<D>, wall: Vector<D>, normal: Vector<D>) -> Vector<D> {
        let relative = v - wall;
        let approach = relative.dot(normal);
        match self {
            Self::Open => v,
            Self::Fixed => wall,
            Self::Slip => v - normal * approach,
            Self::Separate | Self::Friction { .. } if approach >= 0.0 => v,
            Self::Separate => v - normal * approach,
            Self::Friction { coefficient } => {
                let tangential = relative - normal * approach;
                let speed = tangential.norm();
                let kept = if speed > 0.0 { (1.0 - coefficient * -approach / speed).max(0.0) } else { 0.0 };
                wall + tangential * kept
            }
        }
    }
}
