//! Keys of solids of PFEM-2.

use super::signal::AxisMotion;
use crate::mesh::quadratic::QuadraticFile;
use crate::pfem2::solid::setup::{Damping, Inertia, Plane, SurfaceCondition};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The mesh of a solid: made of its region, or from a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SolidMeshSpec {
    /// Elements of a size that fill the region.
    Made(SolidCells),
    /// From a Gmsh file.
    File(QuadraticFile),
}

/// Elements of a solid: quadrilaterals with 9 nodes, hexahedra with 27.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidCells {
    /// Length of their edges, about.
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub cell: f64,
}

/// Prescribed motion of a rigid solid, where it isn't free.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RigidMotionSpec {
    /// Velocity of its centre of mass per axis; `"free"` where the axis is not prescribed. Default: free.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m/s", "axes" = true))]
    pub velocity: Option<[AxisMotion; 3]>,
    /// Angular velocity: in 2D one entry, in 3D one per axis; `"free"` where it is not prescribed. Default: free.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("unit" = "1/s"))]
    pub spin: Vec<AxisMotion>,
}

/// The third direction of a plane problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlaneSpec {
    /// No strain across the plane: the solid is long in that direction.
    #[default]
    Strain,
    /// No stress across the plane: it is thin.
    Stress,
}

impl From<PlaneSpec> for Plane {
    fn from(plane: PlaneSpec) -> Self {
        match plane {
            PlaneSpec::Strain => Self::Strain,
            PlaneSpec::Stress => Self::Stress,
        }
    }
}

/// Condition of the fluid on the surface of a solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SurfaceSpec {
    /// It sticks.
    #[default]
    NoSlip,
    /// It glides.
    Slip,
}

impl From<SurfaceSpec> for SurfaceCondition {
    fn from(surface: SurfaceSpec) -> Self {
        match surface {
            SurfaceSpec::NoSlip => Self::NoSlip,
            SurfaceSpec::Slip => Self::Slip,
        }
    }
}

/// Inertia of a solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InertiaSpec {
    /// Its mass.
    #[default]
    Dynamic,
    /// None: it is in equilibrium with its loads and the fluid at every time.
    QuasiStatic,
}

impl From<InertiaSpec> for Inertia {
    fn from(inertia: InertiaSpec) -> Self {
        match inertia {
            InertiaSpec::Dynamic => Self::Dynamic,
            InertiaSpec::QuasiStatic => Self::QuasiStatic,
        }
    }
}

/// Damping of a solid: forces in proportion to mass and to stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolidDampingSpec {
    /// Coefficient α of the mass, or the damping ratio that it gives at a frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<MassDampingSpec>,
    /// Coefficient β of the stiffness, or the damping ratio that it gives at a frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<StiffnessDampingSpec>,
}

/// Damping by mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum MassDampingSpec {
    /// Its coefficient.
    Coefficient(#[schemars(extend("unit" = "1/s", "minimum" = 0.0))] f64),
    /// Part of the critical damping at a frequency.
    Ratio(DampingRatioSpec),
}

/// Damping by stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StiffnessDampingSpec {
    /// Its coefficient.
    Coefficient(#[schemars(extend("unit" = "s", "minimum" = 0.0))] f64),
    /// Part of the critical damping at a frequency.
    Ratio(DampingRatioSpec),
}

/// Damping over critical damping at a frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DampingRatioSpec {
    /// Damping ratio.
    #[schemars(extend("minimum" = 0.0))]
    pub ratio: f64,
    /// The frequency.
    #[schemars(extend("unit" = "Hz", "exclusiveMinimum" = 0.0))]
    pub at: f64,
}

impl DampingRatioSpec {
    /// ω [rad/s].
    fn angular_frequency(self) -> f64 {
        std::f64::consts::TAU * self.at
    }

    /// α = 2 ζ ω [1/s].
    fn mass_coefficient(self) -> f64 {
        2.0 * self.ratio * self.angular_frequency()
    }

    /// β = 2 ζ/ω [s].
    fn stiffness_coefficient(self) -> f64 {
        2.0 * self.ratio / self.angular_frequency()
    }
}

impl From<SolidDampingSpec> for Damping {
    fn from(SolidDampingSpec { mass, stiffness }: SolidDampingSpec) -> Self {
        let mass = mass.map(|mass| match mass {
            MassDampingSpec::Coefficient(alpha) => alpha,
            MassDampingSpec::Ratio(ratio) => ratio.mass_coefficient(),
        });
        let stiffness = stiffness.map(|stiffness| match stiffness {
            StiffnessDampingSpec::Coefficient(beta) => beta,
            StiffnessDampingSpec::Ratio(ratio) => ratio.stiffness_coefficient(),
        });
        Self { mass: mass.unwrap_or_default(), stiffness: stiffness.unwrap_or_default() }
    }
}
