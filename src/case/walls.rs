//! Walls and obstacles of the material point method, as a case file writes them.

use super::signal::SignalSpec;
use crate::geometry::Shape;
use crate::mpm::WallKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The ends of the domain.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct WallsSpec {
    /// Lower end of x.
    pub left: WallSpec,
    /// Upper end of x.
    pub right: WallSpec,
    /// Lower end of y (3D only).
    pub front: WallSpec,
    /// Upper end of y (3D only).
    pub back: WallSpec,
    /// Lower end of the last axis (y in 2D, z in 3D).
    pub bottom: WallSpec,
    /// Upper end of the last axis.
    pub top: WallSpec,
}

/// An end of the domain: a word, or a table when it moves or has friction.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum WallSpec {
    /// The kind by its name.
    Word(WallWord),
    /// Its kind and its velocity.
    Moving(Box<MovingWallSpec>),
}

/// Kinds of walls at the ends of the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallWord {
    /// Material that leaves stops the run with an error.
    Open,
    /// No motion at all.
    Fixed,
    /// No normal motion: a plane of symmetry.
    Slip,
    /// No motion into the wall; free to leave.
    Separate,
}

/// An end of the domain that moves or has friction.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum MovingWallSpec {
    /// Material that leaves stops the run with an error.
    Open {},
    /// No motion relative to the wall.
    Fixed {
        /// Velocity of the wall; may depend on t.
        #[serde(default)]
        #[schemars(extend("unit" = "m/s", "axes" = true))]
        velocity: [SignalSpec; 3],
    },
    /// No normal motion relative to the wall.
    Slip {
        /// Velocity of the wall; may depend on t.
        #[serde(default)]
        #[schemars(extend("unit" = "m/s", "axes" = true))]
        velocity: [SignalSpec; 3],
    },
    /// No motion into the wall; free to leave.
    Separate {
        /// Velocity of the wall; may depend on t.
        #[serde(default)]
        #[schemars(extend("unit" = "m/s", "axes" = true))]
        velocity: [SignalSpec; 3],
    },
    /// As `separate`, with Coulomb friction.
    Friction {
        /// Coefficient.
        #[schemars(extend("minimum" = 0.0))]
        coefficient: f64,
        /// Velocity of the wall; may depend on t.
        #[serde(default)]
        #[schemars(extend("unit" = "m/s", "axes" = true))]
        velocity: [SignalSpec; 3],
    },
}

impl Default for WallSpec {
    fn default() -> Self {
        Self::Word(WallWord::Open)
    }
}

impl WallSpec {
    /// Its kind and its velocity.
    pub fn parts(&self) -> (WallKind, [SignalSpec; 3]) {
        match self {
            Self::Word(WallWord::Open) => (WallKind::Open, Default::default()),
            Self::Word(WallWord::Fixed) => (WallKind::Fixed, Default::default()),
            Self::Word(WallWord::Slip) => (WallKind::Slip, Default::default()),
            Self::Word(WallWord::Separate) => (WallKind::Separate, Default::default()),
            Self::Moving(wall) => wall.parts(),
        }
    }
}

impl MovingWallSpec {
    fn parts(&self) -> (WallKind, [SignalSpec; 3]) {
        match self {
            Self::Open {} => (WallKind::Open, Default::default()),
            Self::Fixed { velocity } => (WallKind::Fixed, velocity.clone()),
            Self::Slip { velocity } => (WallKind::Slip, velocity.clone()),
            Self::Separate { velocity } => (WallKind::Separate, velocity.clone()),
            Self::Friction { coefficient, velocity } => {
                (WallKind::Friction { coefficient: *coefficient }, velocity.clone())
            }
        }
    }
}

/// A rigid obstacle.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ObstacleSpec {
    /// Its name in histories.
    pub name: String,
    /// Its shape at the start.
    pub region: Shape,
    /// Its kind.
    #[serde(default)]
    pub kind: ObstacleKind,
    /// Coefficient of friction, for `kind = "friction"`.
    #[serde(default)]
    #[schemars(extend("minimum" = 0.0))]
    pub coefficient: f64,
    /// Its velocity; may depend on t.
    #[serde(default)]
    #[schemars(extend("unit" = "m/s", "axes" = true))]
    pub velocity: [SignalSpec; 3],
}

impl ObstacleSpec {
    /// Its condition on the grid velocity.
    pub fn wall_kind(&self) -> WallKind {
        match self.kind {
            ObstacleKind::Fixed => WallKind::Fixed,
            ObstacleKind::Slip => WallKind::Slip,
            ObstacleKind::Separate => WallKind::Separate,
            ObstacleKind::Friction => WallKind::Friction { coefficient: self.coefficient },
        }
    }
}

/// Kinds of obstacles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleKind {
    /// No motion relative to it.
    Fixed,
    /// No normal motion relative to it.
    Slip,
    /// No motion into it; free to leave, no friction.
    #[default]
    Separate,
    /// As `separate`, with Coulomb friction.
    Friction,
}
