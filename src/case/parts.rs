//! Bodies of a case, supports and loads of bodies and membranes, contact of pairs.

use super::friction::FrictionSpec;
use super::signal::{AxisMotion, SignalSpec};
use super::solid::{InertiaSpec, PlaneSpec, RigidMotionSpec, SolidDampingSpec, SolidMeshSpec, SurfaceSpec};
use crate::geometry::Shape;
use crate::material::{PointLaws, ViscousLaws};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// A body: of material points, a fluid on a mesh, or an elastic or rigid solid in such a fluid.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BodySpec {
    /// Its name in contacts, probes and files.
    pub name: String,
    /// Its region at the start; only a solid whose mesh comes from a file has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Shape>,
    /// The mesh of a solid of `method = "pfem2"`; by default its elements are about two cells of the fluid's mesh long,
    /// and two or more across its thinnest part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<SolidMeshSpec>,
    /// The third direction of an elastic solid of `method = "pfem2"`, in 2D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<PlaneSpec>,
    /// Prescribed motion of a rigid solid of `method = "pfem2"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<RigidMotionSpec>,
    /// Solids of `method = "pfem2"` that this one is bonded to, where they touch at the start.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bond: Vec<String>,
    /// Damping of a solid of `method = "pfem2"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<SolidDampingSpec>,
    /// Inertia of an elastic solid of `method = "pfem2"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<InertiaSpec>,
    /// Coefficient of Coulomb's friction of a solid of `method = "pfem2"` at walls; of two solids that meet the root of
    /// their product counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0))]
    pub friction: Option<f64>,
    /// Coefficient of restitution of a rigid solid of `method = "pfem2"` at walls; of two that meet the root of their
    /// product counts. Default: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub restitution: Option<f64>,
    /// Condition of the fluid on the surface of a solid of `method = "pfem2"`. Default: it glides along elastic solids
    /// beside which elements are wider than half the layer that the solid slows down in its longest period, in the
    /// stream from inlets, and, if nothing holds it, in the whole run, likewise along rigid ones between two fluids
    /// without inlets, and sticks to the others; `lateen check` says where it glides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceSpec>,
    /// A place about which the force of the fluid on a solid of `method = "pfem2"` has a moment, in the history of the
    /// force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "axes" = true))]
    pub moment_about: Option<[f64; 3]>,
    /// Nodes of a solid of `method = "pfem2"` whose motion is prescribed, or that springs hold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub supports: Vec<SupportSpec>,
    /// Distance of the particles; or give `particles-per-cell`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub spacing: Option<f64>,
    /// Particles per cell along each axis; or give `spacing`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1, "maximum" = 16))]
    pub particles_per_cell: Option<u32>,
    /// Scale the particles' volume so that the body's volume is exact, where a formula gives it.
    #[serde(default = "yes")]
    pub exact_volume: bool,
    /// Position of the lattice of particles.
    #[serde(default)]
    pub lattice: LatticeSpec,
    /// Velocity at the start; may depend on x, y, z.
    #[serde(default)]
    #[schemars(extend("unit" = "m/s", "axes" = true))]
    pub velocity: [SignalSpec; 3],
    /// Pressure at the start; may depend on x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "Pa"))]
    pub pressure: Option<SignalSpec>,
    /// Internal energy per reference volume at the start; may depend on x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "J/m^3"))]
    pub energy: Option<SignalSpec>,
    /// Cauchy stress xx, yy, zz, xy, yz, zx at the start; may depend on x, y, z. Of an elastic solid of
    /// `method = "pfem2"` the stress that it has in the shape in which it is given, the same everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "Pa"))]
    pub stress: Option<[SignalSpec; 6]>,
    /// Pressure of the atmosphere outside, of an ideal gas only: it acts wherever the gas ends, so that sheets and
    /// walls feel the pressure above it. Everything that meets the gas counts pressures from it.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub ambient: f64,
    /// Bodies with the same group share a velocity field and so stick together; by default no two share one. Closed
    /// membranes part the inside from the outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// The law.
    pub material: Material,
    /// Loads on its surface; on fluids of `method = "pfem2"` none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub traction: Vec<TractionSpec>,
}

/// The law of a body: of material points, elastic solids among them, or of a fluid on a mesh.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Material {
    /// For `method = "mpm"`, and, if elastic or rigid, for solids of `method = "pfem2"`.
    Point(PointLaws),
    /// For `method = "pfem2"`.
    Flow(ViscousLaws),
}

impl Material {
    /// True for a law that solids in a fluid on a mesh can have: rigid, or elastic with a stress that follows from the
    /// deformation, not from rates.
    pub fn is_solid(&self) -> bool {
        match self {
            Self::Point(law) if law.as_dyn().is_rigid() => true,
            Self::Point(law) => law.as_dyn().elastic_law().is_ok() && law.as_dyn().storage().deformation,
            Self::Flow(_) => false,
        }
    }
}

impl<'de> Deserialize<'de> for Material {
    /// Chooses by the name of the law, so that errors in its numbers are those of the law.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = toml::Value::deserialize(deserializer)?;
        let law = table.get("law").and_then(toml::Value::as_str).unwrap_or_default();
        let made = if ViscousLaws::NAMES.contains(&law) {
            ViscousLaws::deserialize(table).map(Self::Flow)
        } else {
            PointLaws::deserialize(table).map(Self::Point)
        };
        made.map_err(|error| serde::de::Error::custom(error.message()))
    }
}

pub(super) fn yes() -> bool {
    true
}

/// Position of the lattice of particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LatticeSpec {
    /// Symmetric about the centre of the region.
    #[default]
    Centred,
    /// Alike in every cell of the grid.
    Grid,
}

/// A load on the surface of a body.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TractionSpec {
    /// The loaded part of the surface. Of material points a side, `"left"`: the outermost layer of particles towards
    /// it; of a solid of `method = "pfem2"` sides of elements all of whose nodes are in this place.
    pub on: SupportPlace,
    /// Force per area of the undeformed surface, fixed in direction; or give `pressure`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "Pa", "axes" = true))]
    pub value: Option<[SignalSpec; 3]>,
    /// Pressure that follows the deformed surface, into the body where positive; or give `value`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "Pa"))]
    pub pressure: Option<SignalSpec>,
}

/// A side of a body or membrane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Towards −x.
    Left,
    /// Towards +x.
    Right,
    /// Towards −y (3D only).
    Front,
    /// Towards +y (3D only).
    Back,
    /// Towards the lower end of the last axis.
    Bottom,
    /// Towards the upper end of the last axis.
    Top,
}

impl Side {
    /// All sides, by their names.
    pub const NAMED: [(&str, Self); 6] = [
        ("left", Self::Left),
        ("right", Self::Right),
        ("front", Self::Front),
        ("back", Self::Back),
        ("bottom", Self::Bottom),
        ("top", Self::Top),
    ];

    /// Axis, and whether the side is its upper end; `None` if there is no such side in `dimension`.
    pub fn axis(self, dimension: usize) -> Option<(usize, bool)> {
        match self {
            Self::Left => Some((0, false)),
            Self::Right => Some((0, true)),
            Self::Front => (dimension == 3).then_some((1, false)),
            Self::Back => (dimension == 3).then_some((1, true)),
            Self::Bottom => Some((dimension - 1, false)),
            Self::Top => Some((dimension - 1, true)),
        }
    }
}

/// Nodes whose motion is prescribed.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SupportSpec {
    /// The nodes that are held or moved.
    pub on: SupportPlace,
    /// Velocity per axis; `"free"` where the axis is not prescribed. Default: held.
    #[serde(default)]
    #[schemars(extend("unit" = "m/s", "axes" = true))]
    pub velocity: [AxisMotion; 3],
    /// Instead of a velocity, of a solid: stiffness of a spring per axis that pulls these nodes to where they start, of
    /// all together; 0: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "N/m", "axes" = true))]
    pub stiffness: Option<[f64; 3]>,
    /// Instead of a velocity, of a solid: resistance of a dashpot per axis, of these nodes together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "N s/m", "axes" = true))]
    pub damping: Option<[f64; 3]>,
}

impl SupportSpec {
    /// True for springs and dashpots.
    pub fn is_spring(&self) -> bool {
        self.stiffness.is_some() || self.damping.is_some()
    }
}

/// Nodes of a membrane or solid: by name, the nearest to a point, or those in a region.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SupportPlace {
    /// `"all"`, `"edges"` of a membrane, `"surface"` of a solid, a side such as `"left"`, or a group of the mesh.
    Named(String),
    /// The node nearest to this point.
    Point(#[schemars(extend("unit" = "m", "axes" = true))] [f64; 3]),
    /// The nodes in this region (those on its boundary included).
    Region(Shape),
}

/// Contact of a pair.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ContactSpec {
    /// Names of two bodies or membranes.
    pub between: [String; 2],
    /// Friction between them.
    pub friction: FrictionSpec,
}
