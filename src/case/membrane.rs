//! Membranes, as a case file writes them.

use super::parts::{SupportSpec, yes};
use super::signal::SignalSpec;
use crate::material::sheet::SheetLaw;
use crate::mesh::MembraneShape;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A membrane.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct MembraneSpec {
    /// Its name in contacts, probes and files.
    pub name: String,
    /// Its mesh.
    pub geometry: MembraneShape,
    /// Thickness.
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub thickness: f64,
    /// Velocity at the start; may depend on x, y, z.
    #[serde(default)]
    #[schemars(extend("unit" = "m/s", "axes" = true))]
    pub velocity: [SignalSpec; 3],
    /// The law.
    pub material: SheetLaw,
    /// Stress in the sheet at the start, along its first and second axis.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa"))]
    pub prestress: [f64; 2],
    /// Direction of the first material axis (warp), projected on each element; for fabrics.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("axes" = true))]
    pub warp: Option<[f64; 3]>,
    /// Hourglass control of quadrilaterals.
    #[serde(default)]
    pub hourglass: HourglassSpec,
    /// Damping.
    #[serde(default)]
    pub damping: DampingSpec,
    /// Nodes whose motion is prescribed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub supports: Vec<SupportSpec>,
    /// Pressure on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<PressureSpec>,
    /// True: contact is at the surface, half the thickness away; false: at the mid-surface.
    #[serde(default)]
    pub contact_thickness: bool,
}

/// Hourglass control of quadrilaterals.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct HourglassSpec {
    /// In-plane stiffness r_m, of sheets that don't wrinkle; quadrilaterals of those that do have 2 × 2 points instead.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub stiffness: f64,
    /// In-plane viscosity r_v.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub viscosity: f64,
    /// Viscosity against warping r_w.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub warping: f64,
}

impl Default for HourglassSpec {
    fn default() -> Self {
        Self { stiffness: 0.05, viscosity: 0.0, warping: 0.01 }
    }
}

/// Damping of a membrane.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct DampingSpec {
    /// Stiffness-proportional damping time, as a fraction of the step; sheets that wrinkle have 0.05 at least.
    #[schemars(extend("minimum" = 0.0, "maximum" = 0.05))]
    pub stiffness: f64,
    /// Mass-proportional rate.
    #[schemars(extend("unit" = "1/s", "minimum" = 0.0))]
    pub mass: f64,
}

/// Pressure on a membrane.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PressureSpec {
    /// Pushes along the element normal where positive.
    #[schemars(extend("unit" = "Pa"))]
    pub value: SignalSpec,
    /// True: it follows the deformed surface; false: it is a dead load on the undeformed one.
    #[serde(default = "yes")]
    pub follower: bool,
}
