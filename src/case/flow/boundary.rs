//! Conditions on the boundary, and surface tension between fluids.

use crate::case::signal::SignalSpec;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A condition on a part of the boundary of the mesh.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BoundarySpec {
    /// Its name in histories of forces; by default the name of the part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Parts of the boundary: sides (`"left"`), holes, physical groups of the file, or `"rest"`.
    pub on: Names,
    /// Its kind.
    #[serde(default)]
    pub kind: BoundaryWord,
    /// Velocity of a wall or inlet; may depend on x, y, z, t.
    #[serde(default)]
    #[schemars(extend("unit" = "m/s", "axes" = true))]
    pub velocity: [SignalSpec; 3],
    /// Force per area, for `kind = "traction"`.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "axes" = true))]
    pub traction: [SignalSpec; 3],
    /// Pressure from outside, for `kind = "pressure"`.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa"))]
    pub pressure: SignalSpec,
    /// A place about which the force of the fluid on it has a moment, in the history of the force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "axes" = true))]
    pub moment_about: Option<[f64; 3]>,
    /// The body whose fluid comes in through an inlet, or back through an open boundary; by default the fluid that each
    /// place had at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<String>,
}

impl BoundarySpec {
    /// Its name in histories of forces.
    pub fn part_name(&self) -> String {
        self.name.clone().unwrap_or_else(|| self.on.list().join("+"))
    }
}

/// A name, or a list of names.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Names {
    /// One.
    One(String),
    /// Several.
    Many(Vec<String>),
}

impl Names {
    /// The names as a list.
    pub fn list(&self) -> Vec<&str> {
        match self {
            Self::One(name) => vec![name],
            Self::Many(names) => names.iter().map(String::as_str).collect(),
        }
    }
}

/// Kinds of parts of the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BoundaryWord {
    /// The fluid sticks to it; moves with `velocity`.
    #[default]
    Wall,
    /// The fluid glides along it without friction.
    Slip,
    /// A plane of symmetry: as `slip`.
    Symmetry,
    /// The fluid comes in with `velocity`.
    Inlet,
    /// Open: a developed flow leaves undisturbed, −p n + µ ∂v/∂n = 0.
    Outlet,
    /// Open, under `traction`.
    Traction,
    /// Open, under `pressure`: −p n + µ ∂v/∂n = −`pressure` n.
    Pressure,
}

impl BoundaryWord {
    /// True if the force on it is in its history: no traction or pressure is prescribed there.
    pub fn carries_reaction(self) -> bool {
        match self {
            Self::Wall | Self::Slip | Self::Symmetry | Self::Inlet => true,
            Self::Outlet | Self::Traction | Self::Pressure => false,
        }
    }
}

/// The place where the pressure of a closed box is prescribed.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PinSpec {
    /// A place in the mesh; the nearest node is taken.
    #[schemars(extend("unit" = "m", "axes" = true))]
    pub at: [f64; 3],
    /// The pressure there; may depend on t.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa"))]
    pub value: SignalSpec,
}

/// Surface tension between two fluids.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TensionSpec {
    /// Names of two bodies.
    pub between: [String; 2],
    /// Energy per area.
    #[schemars(extend("unit" = "N/m", "minimum" = 0.0))]
    pub value: f64,
}
