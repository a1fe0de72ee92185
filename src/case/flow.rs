//! What a case of PFEM-2 is made of: the choices of the method, conditions on the boundary, surface tension.

use super::signal::SignalSpec;
use crate::linalg;
use crate::material::Viscosity;
use crate::pfem2::{element, interface, project, reseed, setup};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Choices of PFEM-2. Keys that are not written come from the preset.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct Pfem2Spec {
    /// Time integration.
    pub scheme: SchemeSpec,
    /// Stabilisation of the pressure.
    pub stabilisation: StabilisationSpec,
    /// Mass matrix.
    pub mass: MassSpec,
    /// Pressure in elements that an interface cuts; with surface tension it always jumps.
    pub enrichment: EnrichmentSpec,
    /// From particles to nodes.
    pub kernel: ProjectionSpec,
    /// Where the interface of two fluids is.
    pub interface: InterfaceSpec,
    /// What is done about the volume of two fluids in a closed box.
    pub volume: VolumeSpec,
    /// Particles along the edge of an element at the start.
    #[schemars(extend("minimum" = 1, "maximum" = 10))]
    pub particles_per_edge: usize,
    /// By what particles are added and taken away.
    pub reseeding: ReseedingSpec,
    /// Density ratio from which heavy fluids fly through light ones like projectiles; `inf`: never.
    #[schemars(extend("minimum" = 1.0, "infinite" = true))]
    pub projectile_ratio: f64,
    /// Time in which particles forget what the mesh can't see; `inf`: never.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0.0, "infinite" = true))]
    pub relaxation: f64,
    /// Elements that the flow may cross in a step where `time.step` is left out; `inf`: no bound.
    #[schemars(extend("exclusiveMinimum" = 0.0, "infinite" = true))]
    pub courant: f64,
    /// Body force per unit mass.
    #[schemars(extend("unit" = "m/s^2", "axes" = true))]
    pub gravity: [SignalSpec; 3],
    /// The linear solver.
    pub solver: LinearSpec,
}

impl Default for Pfem2Spec {
    /// The recommended choices; presets replace them.
    fn default() -> Self {
        Self {
            scheme: SchemeSpec::SecondOrder { theta: theta() },
            stabilisation: StabilisationSpec::Oss,
            mass: MassSpec::Consistent,
            enrichment: EnrichmentSpec::Jump,
            kernel: ProjectionSpec::Linear,
            interface: InterfaceSpec::Sharp,
            volume: VolumeSpec::Shift,
            particles_per_edge: 3,
            reseeding: ReseedingSpec::SubCells,
            projectile_ratio: f64::INFINITY,
            relaxation: f64::INFINITY,
            courant: 5.0,
            gravity: Default::default(),
            solver: LinearSpec::default(),
        }
    }
}

/// Time integration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum SchemeSpec {
    /// Backward Euler along the streamlines of the last step (the paper): first order.
    BackwardEuler,
    /// The θ-scheme along the particles' paths: second order at θ = ½.
    SecondOrder {
        /// Implicit share θ.
        #[serde(default = "theta")]
        #[schemars(extend("minimum" = 0.5, "maximum" = 1.0))]
        theta: f64,
    },
}

fn theta() -> f64 {
    match setup::Scheme::default() {
        setup::Scheme::SecondOrder { theta } => theta,
        setup::Scheme::BackwardEuler => 1.0,
    }
}

/// Stabilisation of the pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StabilisationSpec {
    /// Without inertia in the residual (the paper).
    Pspg,
    /// The whole residual; the system is not symmetric.
    ConsistentPspg,
    /// Orthogonal subscales.
    Oss,
}

/// Mass matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MassSpec {
    /// A diagonal (the paper).
    Lumped,
    /// The full one, in cut elements over each side.
    Consistent,
}

/// Pressure in elements that an interface cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EnrichmentSpec {
    /// Linear, as elsewhere.
    None,
    /// With a kink at the interface.
    Kink,
    /// With a jump and a kink.
    Jump,
}

/// From particles to nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProjectionSpec {
    /// Shape functions (the paper).
    Shape,
    /// Wendland's function of the distance (the paper's alternative).
    Wendland,
    /// Mass-weighted, for each fluid, exact for linear fields.
    Linear,
}

/// Where the interface of two fluids is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InterfaceSpec {
    /// Where the share of particles changes (the paper's pseudo level set).
    Pseudo,
    /// Where the depths that particles carry change their sign.
    Sharp,
}

/// By what particles are added and taken away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReseedingSpec {
    /// By quarters of triangles, eighths of tetrahedra: none stays empty, none is crowded.
    SubCells,
    /// By elements, before the projection and at the end of the step (the paper).
    Elements,
}

/// What is done about the volume of two fluids in a closed box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VolumeSpec {
    /// It is only reported.
    None,
    /// The sharp interface is shifted to the volume at the start; the shift is reported.
    Shift,
}

/// The linear solver.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct LinearSpec {
    /// Which preconditioner.
    pub kind: LinearKind,
    /// Residual to reach, relative to the right-hand side.
    #[schemars(extend("minimum" = 1e-14, "maximum" = 0.1))]
    pub tolerance: f64,
    /// Iterations before giving up.
    #[schemars(extend("minimum" = 1, "maximum" = 100_000))]
    pub max_iterations: usize,
    /// Iterations before a restart.
    #[schemars(extend("minimum" = 2, "maximum" = 1000))]
    pub restart: usize,
}

/// Preconditioners of the linear solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LinearKind {
    /// By dimension and size.
    Auto,
    /// A factorisation, kept over steps.
    Direct,
    /// Block-triangular, with multigrid.
    Iterative,
}

impl Default for LinearSpec {
    fn default() -> Self {
        let linalg::Options { tolerance, max_iterations, restart, .. } = linalg::Options::default();
        Self { kind: LinearKind::Auto, tolerance, max_iterations, restart }
    }
}

impl LinearSpec {
    /// The options of the solver.
    pub fn options(&self) -> linalg::Options {
        let kind = match self.kind {
            LinearKind::Auto => linalg::Kind::Auto,
            LinearKind::Direct => linalg::Kind::Direct,
            LinearKind::Iterative => linalg::Kind::Iterative,
        };
        let &Self { tolerance, max_iterations, restart, .. } = self;
        linalg::Options { kind, tolerance, max_iterations, restart }
    }
}

/// A condition on a part of the boundary of the mesh.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BoundarySpec {
    /// Its name in histories of forces; by default the name of the part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Parts of the boundary: sides (`"left"`), holes, physical groups of the file, or `"rest"`.
    pub on: Names,
    /// What it does.
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
    /// The body whose fluid comes in through an inlet or an open boundary; by default the fluid of each place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<String>,
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
    /// As a list.
    pub fn list(&self) -> Vec<&str> {
        match self {
            Self::One(name) => vec![name],
            Self::Many(names) => names.iter().map(String::as_str).collect(),
        }
    }
}

/// What a part of the boundary does.
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

/// Laws of fluids on a mesh, for `method = "pfem2"`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum FlowLaw {
    /// Constant viscosity.
    Newtonian {
        /// Density.
        #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
        density: f64,
        /// Viscosity µ.
        #[serde(default)]
        #[schemars(extend("unit" = "Pa s", "minimum" = 0.0))]
        viscosity: f64,
    },
    /// A yield stress and a constant plastic viscosity.
    Bingham {
        /// Density.
        #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
        density: f64,
        /// Plastic viscosity.
        #[schemars(extend("unit" = "Pa s", "minimum" = 0.0))]
        viscosity: f64,
        /// Yield stress.
        #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
        yield_stress: f64,
        /// Shear rate below which the law is regularised.
        #[serde(default = "regularisation")]
        #[schemars(extend("unit" = "1/s", "exclusiveMinimum" = 0.0))]
        regularisation: f64,
    },
    /// A yield stress and a power law k γ̇ⁿ.
    HerschelBulkley {
        /// Density.
        #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
        density: f64,
        /// Consistency k [Pa sⁿ], in SI.
        #[schemars(extend("minimum" = 0.0))]
        consistency: f64,
        /// Exponent n.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 3.0))]
        index: f64,
        /// Yield stress.
        #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
        yield_stress: f64,
        /// Shear rate below which the law is regularised.
        #[serde(default = "regularisation")]
        #[schemars(extend("unit" = "1/s", "exclusiveMinimum" = 0.0))]
        regularisation: f64,
    },
}

fn regularisation() -> f64 {
    1e-2
}

impl FlowLaw {
    /// The names that a case may use.
    pub const NAMES: &'static [&'static str] = &["newtonian", "bingham", "herschel-bulkley"];

    /// Its name, as a case writes it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Newtonian { .. } => "newtonian",
            Self::Bingham { .. } => "bingham",
            Self::HerschelBulkley { .. } => "herschel-bulkley",
        }
    }

    /// Density [kg/m³] and law of viscosity.
    pub fn parts(&self) -> (f64, Viscosity) {
        match *self {
            Self::Newtonian { density, viscosity } => (density, Viscosity::Newtonian(viscosity)),
            Self::Bingham { density, viscosity, yield_stress, regularisation } => {
                let law =
                    Viscosity::HerschelBulkley { consistency: viscosity, index: 1.0, yield_stress, regularisation };
                (density, law)
            }
            Self::HerschelBulkley { density, consistency, index, yield_stress, regularisation } => {
                (density, Viscosity::HerschelBulkley { consistency, index, yield_stress, regularisation })
            }
        }
    }
}

impl From<&SchemeSpec> for setup::Scheme {
    fn from(scheme: &SchemeSpec) -> Self {
        match *scheme {
            SchemeSpec::BackwardEuler => Self::BackwardEuler,
            SchemeSpec::SecondOrder { theta } => Self::SecondOrder { theta },
        }
    }
}

impl From<StabilisationSpec> for element::Stabilisation {
    fn from(stabilisation: StabilisationSpec) -> Self {
        match stabilisation {
            StabilisationSpec::Pspg => Self::Pspg,
            StabilisationSpec::ConsistentPspg => Self::ConsistentPspg,
            StabilisationSpec::Oss => Self::Oss,
        }
    }
}

impl From<MassSpec> for element::Mass {
    fn from(mass: MassSpec) -> Self {
        match mass {
            MassSpec::Lumped => Self::Lumped,
            MassSpec::Consistent => Self::Consistent,
        }
    }
}

impl From<EnrichmentSpec> for interface::Enrichment {
    fn from(enrichment: EnrichmentSpec) -> Self {
        match enrichment {
            EnrichmentSpec::None => Self::None,
            EnrichmentSpec::Kink => Self::Kink,
            EnrichmentSpec::Jump => Self::Jump,
        }
    }
}

impl From<ReseedingSpec> for reseed::Reseeding {
    fn from(reseeding: ReseedingSpec) -> Self {
        match reseeding {
            ReseedingSpec::SubCells => Self::SubCells,
            ReseedingSpec::Elements => Self::Elements,
        }
    }
}

impl From<VolumeSpec> for setup::VolumeCorrection {
    fn from(volume: VolumeSpec) -> Self {
        match volume {
            VolumeSpec::None => Self::None,
            VolumeSpec::Shift => Self::Shift,
        }
    }
}

impl From<ProjectionSpec> for project::Kernel {
    fn from(kernel: ProjectionSpec) -> Self {
        match kernel {
            ProjectionSpec::Shape => Self::Shape,
            ProjectionSpec::Wendland => Self::Wendland,
            ProjectionSpec::Linear => Self::Linear,
        }
    }
}
