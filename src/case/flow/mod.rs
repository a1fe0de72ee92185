//! Keys of a case of PFEM-2: the choices of the method here, conditions on the boundary.

mod boundary;

pub use boundary::*;

use super::signal::SignalSpec;
use crate::linalg;
use crate::pfem2::particles::project;
use crate::pfem2::phases::phase_list;
use crate::pfem2::{Scheme, cut_element, element, setup, tracking};
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
    /// Representation of the interface of two fluids.
    pub interface: InterfaceSpec,
    /// Correction of the volume of two fluids.
    pub volume: VolumeSpec,
    /// Particles along the edge of an element at the start.
    #[schemars(extend("minimum" = 1, "maximum" = 10))]
    pub particles_per_edge: usize,
    /// Subdivision by which particles are added and removed.
    pub reseeding: ReseedingSpec,
    /// Density ratio from which heavy fluids fly through light ones like projectiles; `inf`: never.
    #[schemars(extend("minimum" = 1.0, "infinite" = true))]
    pub projectile_ratio: f64,
    /// Relaxation time of the particles' velocities towards that of the mesh; `inf`: no relaxation.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0.0, "infinite" = true))]
    pub relaxation: f64,
    /// Treatment of velocities of particles that the mesh can't resolve.
    pub unresolved: UnresolvedSpec,
    /// Elements that the flow may cross in a step where `time.step` is left out; `inf`: no bound.
    #[schemars(extend("exclusiveMinimum" = 0.0, "infinite" = true))]
    pub courant: f64,
    /// Largest error of a step in time over that of the mesh, both estimated, without `time.step`; `inf`: no bound.
    #[schemars(extend("exclusiveMinimum" = 0.0, "infinite" = true))]
    pub step_tolerance: f64,
    /// Place and value of the pressure of a closed box; by default it is zero at the highest node of the boundary.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_pin: Option<PinSpec>,
    /// Body force per unit mass.
    #[schemars(extend("unit" = "m/s^2", "axes" = true))]
    pub gravity: [SignalSpec; 3],
    /// State with which the run begins.
    pub start: InitialStateSpec,
    /// The linear solver.
    pub solver: SolverSpec,
}

impl Default for Pfem2Spec {
    /// The recommended choices; presets replace them.
    fn default() -> Self {
        Self {
            scheme: SchemeSpec::default(),
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
            unresolved: UnresolvedSpec::Bounded,
            courant: 5.0,
            step_tolerance: 2.0,
            pressure_pin: None,
            gravity: Default::default(),
            start: InitialStateSpec::Given,
            solver: SolverSpec::default(),
        }
    }
}

/// State with which a run begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InitialStateSpec {
    /// As the bodies are given.
    #[default]
    Given,
    /// At rest, with solids where they bear their weight, their loads at time 0 and the pressure of the fluids.
    Equilibrium,
}

impl From<InitialStateSpec> for setup::InitialState {
    fn from(start: InitialStateSpec) -> Self {
        match start {
            InitialStateSpec::Given => Self::AsGiven,
            InitialStateSpec::Equilibrium => Self::Equilibrium,
        }
    }
}

/// Time integration: a word, or a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SchemeSpec {
    /// By name, with default parameters.
    Word(SchemeWord),
    /// With parameters.
    Table(SchemeTable),
}

/// Names of the time integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SchemeWord {
    /// Backward Euler along the streamlines of the last step (the paper): first order.
    BackwardEuler,
    /// The θ-scheme along the particles' paths: second order at θ = ½.
    SecondOrder,
}

/// Time integration with its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum SchemeTable {
    /// Backward Euler along the streamlines of the last step (the paper): first order.
    BackwardEuler,
    /// The θ-scheme along the particles' paths: second order at θ = ½.
    SecondOrder {
        /// Implicit weight θ.
        #[serde(default = "theta")]
        #[schemars(extend("minimum" = 0.5, "maximum" = 1.0))]
        theta: f64,
    },
}

impl Default for SchemeSpec {
    fn default() -> Self {
        Self::Table(SchemeTable::SecondOrder { theta: theta() })
    }
}

fn theta() -> f64 {
    match Scheme::default() {
        Scheme::SecondOrder { theta } => theta,
        Scheme::BackwardEuler => 1.0,
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
    /// The same, of subscales that have an inertia.
    DynamicSubscales,
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

/// Representation of the interface of two fluids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InterfaceSpec {
    /// The place where the fraction of particles changes (the paper's pseudo level set).
    Pseudo,
    /// The zero of the signed distance that particles carry.
    Sharp,
}

/// Subdivision by which particles are added and removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReseedingSpec {
    /// Quarters of triangles, eighths of tetrahedra: none stays empty, none is crowded.
    SubCells,
    /// Elements, before the projection and at the end of the step (the paper).
    Elements,
}

/// Correction of the volumes of several fluids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VolumeSpec {
    /// It is only reported.
    None,
    /// The sharp interface of two fluids is shifted to the volume at the start; three and more in a closed box take
    /// weights of their fractions that keep their volumes. Shift or weights are reported.
    Shift,
}

/// Treatment of velocities of particles that the mesh can't resolve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UnresolvedSpec {
    /// They are kept (the paper).
    Kept,
    /// The difference between the velocity of a particle and that of the mesh is bounded by those between
    /// neighbouring nodes.
    Bounded,
}

/// The linear solver: a word, or a table.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SolverSpec {
    /// A preconditioner by name, with default parameters.
    Word(LinearKind),
    /// With parameters.
    Table(LinearSpec),
}

impl Default for SolverSpec {
    fn default() -> Self {
        Self::Table(LinearSpec::default())
    }
}

impl SolverSpec {
    /// All choices.
    pub fn choices(&self) -> LinearSpec {
        match self {
            Self::Word(kind) => LinearSpec { kind: *kind, ..LinearSpec::default() },
            Self::Table(spec) => spec.clone(),
        }
    }
}

/// The linear solver with its parameters.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct LinearSpec {
    /// The preconditioner.
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
        let linalg::SolverOptions { tolerance, max_iterations, restart, .. } = linalg::SolverOptions::default();
        Self { kind: LinearKind::Auto, tolerance, max_iterations, restart }
    }
}

impl LinearSpec {
    /// The options of the solver.
    pub fn options(&self) -> linalg::SolverOptions {
        let kind = match self.kind {
            LinearKind::Auto => linalg::SolverKind::Auto,
            LinearKind::Direct => linalg::SolverKind::Direct,
            LinearKind::Iterative => linalg::SolverKind::Iterative,
        };
        let &Self { tolerance, max_iterations, restart, .. } = self;
        linalg::SolverOptions { kind, tolerance, max_iterations, restart }
    }
}

impl From<&SchemeSpec> for Scheme {
    fn from(scheme: &SchemeSpec) -> Self {
        match *scheme {
            SchemeSpec::Word(SchemeWord::BackwardEuler) | SchemeSpec::Table(SchemeTable::BackwardEuler) => {
                Self::BackwardEuler
            }
            SchemeSpec::Word(SchemeWord::SecondOrder) => Self::SecondOrder { theta: theta() },
            SchemeSpec::Table(SchemeTable::SecondOrder { theta }) => Self::SecondOrder { theta },
        }
    }
}

impl From<StabilisationSpec> for element::Stabilisation {
    fn from(stabilisation: StabilisationSpec) -> Self {
        match stabilisation {
            StabilisationSpec::Pspg => Self::Pspg,
            StabilisationSpec::ConsistentPspg => Self::ConsistentPspg,
            StabilisationSpec::DynamicSubscales => Self::Dynamic,
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

impl From<EnrichmentSpec> for cut_element::Enrichment {
    fn from(enrichment: EnrichmentSpec) -> Self {
        match enrichment {
            EnrichmentSpec::None => Self::None,
            EnrichmentSpec::Kink => Self::Kink,
            EnrichmentSpec::Jump => Self::Jump,
        }
    }
}

impl From<ReseedingSpec> for phase_list::Reseeding {
    fn from(reseeding: ReseedingSpec) -> Self {
        match reseeding {
            ReseedingSpec::SubCells => Self::SubCells,
            ReseedingSpec::Elements => Self::Elements,
        }
    }
}

impl From<UnresolvedSpec> for tracking::Unresolved {
    fn from(unresolved: UnresolvedSpec) -> Self {
        match unresolved {
            UnresolvedSpec::Kept => Self::Kept,
            UnresolvedSpec::Bounded => Self::Bounded,
        }
    }
}

impl From<VolumeSpec> for tracking::VolumeCorrection {
    fn from(volume: VolumeSpec) -> Self {
        match volume {
            VolumeSpec::None => Self::None,
            VolumeSpec::Shift => Self::Shift,
        }
    }
}

impl From<ProjectionSpec> for project::AveragingKernel {
    fn from(kernel: ProjectionSpec) -> Self {
        match kernel {
            ProjectionSpec::Shape => Self::Shape,
            ProjectionSpec::Wendland => Self::Wendland,
            ProjectionSpec::Linear => Self::Linear,
        }
    }
}
