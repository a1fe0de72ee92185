//! Keys of a case of the material point method: its choices and its grid.

use super::friction::FrictionSpec;
use super::signal::SignalSpec;
use super::walls::WallsSpec;
use crate::mpm;
pub use crate::mpm::KernelKind as KernelSpec;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Choices of the material point method. Keys that are not written come from the preset.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct MpmSpec {
    /// Shape functions.
    pub kernel: KernelSpec,
    /// Particle–grid transfer.
    pub transfer: TransferSpec,
    /// Use of the energy that FLIP and its noise filter dissipate.
    pub dissipation: DissipationSpec,
    /// When stresses are updated.
    pub stress_update: StressUpdateSpec,
    /// Cure of volumetric locking.
    pub locking: LockingSpec,
    /// Fraction of the stable step of the particles.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub safety: f64,
    /// Fraction of the stable step of the membranes.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub membrane_safety: f64,
    /// Most membrane sub-steps per step of the bodies; 1: none.
    #[schemars(extend("minimum" = 1, "maximum" = 100_000))]
    pub max_substeps: usize,
    /// Passes of contact between membranes and bodies per sub-step.
    #[schemars(extend("minimum" = 1, "maximum" = 100))]
    pub contact_passes: usize,
    /// Body force per unit mass.
    #[schemars(extend("unit" = "m/s^2", "axes" = true))]
    pub gravity: [SignalSpec; 3],
    /// Contact of pairs that no `[[contact]]` names.
    pub friction: FrictionSpec,
    /// Contact between membranes and bodies.
    pub sheet_contact: SheetContactSpec,
    /// Gap below which contact acts, in cells.
    #[schemars(extend("minimum" = -1.0, "maximum" = 1.0))]
    pub gap_tolerance: f64,
}

/// Contact between membranes and bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SheetContactSpec {
    /// At grid nodes (the paper).
    Nodes,
    /// At the particles, on the surface of the membrane itself.
    Particles,
}

/// Particle–grid transfer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum TransferSpec {
    /// Increments of the grid velocity, relaxed towards the grid velocity.
    Flip {
        /// Time constant of the relaxation; `inf`: pure FLIP.
        #[serde(default = "infinity")]
        #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0.0, "infinite" = true))]
        relaxation: f64,
        /// Order k of the FMPM(k) filter that removes noise the grid can't see; 0: no filter.
        #[serde(default)]
        #[schemars(extend("maximum" = 10))]
        filter_order: u32,
        /// Time between two filters, in steps of 0.3 cells per speed of sound at the start.
        #[serde(default = "hundred")]
        #[schemars(extend("minimum" = 1))]
        filter_interval: u32,
    },
    /// Affine particle-in-cell: conserves angular momentum.
    Apic,
}

fn infinity() -> f64 {
    f64::INFINITY
}

fn hundred() -> u32 {
    100
}

/// Use of the energy that FLIP and its noise filter dissipate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DissipationSpec {
    /// Into the particles that lose it, where pressure depends on internal energy (gases).
    Heat,
    /// Nowhere (the paper).
    Lost,
}

/// When stresses are updated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StressUpdateSpec {
    /// Before the forces (the paper).
    First,
    /// After the particles moved.
    Last,
    /// After re-mapping the particles' new velocity.
    ModifiedLast,
    /// Half first, half modified last.
    Average,
}

/// Cure of volumetric locking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum LockingSpec {
    /// None (the paper).
    None,
    /// Volume change averaged through the grid.
    Average {
        /// Weight of the average.
        #[serde(default = "one")]
        #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
        blend: f64,
    },
}

fn one() -> f64 {
    1.0
}

/// The background grid.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct GridSpec {
    /// Size of a cell.
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub cell: f64,
    /// Lower corner.
    #[schemars(extend("unit" = "m", "axes" = true))]
    pub lower: [f64; 3],
    /// Upper corner: a whole number of cells away.
    #[schemars(extend("unit" = "m", "axes" = true))]
    pub upper: [f64; 3],
    /// Conditions at the ends of the domain.
    #[serde(default)]
    pub walls: WallsSpec,
}

impl Default for MpmSpec {
    /// The choices for elastic solids; presets replace them.
    fn default() -> Self {
        Self {
            kernel: KernelSpec::Quadratic,
            transfer: TransferSpec::Flip { relaxation: f64::INFINITY, filter_order: 0, filter_interval: 100 },
            dissipation: DissipationSpec::Heat,
            stress_update: StressUpdateSpec::Average,
            locking: LockingSpec::None,
            safety: 0.3,
            membrane_safety: 0.8,
            max_substeps: 500,
            contact_passes: 2,
            gravity: Default::default(),
            friction: FrictionSpec::Coefficient(0.0),
            sheet_contact: SheetContactSpec::Particles,
            gap_tolerance: 0.0,
        }
    }
}

impl From<SheetContactSpec> for mpm::SheetContact {
    fn from(place: SheetContactSpec) -> Self {
        match place {
            SheetContactSpec::Nodes => Self::Nodes,
            SheetContactSpec::Particles => Self::Particles,
        }
    }
}

impl From<&TransferSpec> for mpm::Transfer {
    fn from(transfer: &TransferSpec) -> Self {
        match *transfer {
            TransferSpec::Flip { relaxation, filter_order, filter_interval } => {
                Self::Flip { relaxation, filter_order, filter_interval }
            }
            TransferSpec::Apic => Self::Apic,
        }
    }
}

impl From<DissipationSpec> for mpm::Dissipation {
    fn from(dissipation: DissipationSpec) -> Self {
        match dissipation {
            DissipationSpec::Heat => Self::Heat,
            DissipationSpec::Lost => Self::Lost,
        }
    }
}

impl From<StressUpdateSpec> for mpm::StressUpdate {
    fn from(update: StressUpdateSpec) -> Self {
        match update {
            StressUpdateSpec::First => Self::First,
            StressUpdateSpec::Last => Self::Last,
            StressUpdateSpec::ModifiedLast => Self::ModifiedLast,
            StressUpdateSpec::Average => Self::Average,
        }
    }
}

impl From<&LockingSpec> for mpm::Locking {
    fn from(locking: &LockingSpec) -> Self {
        match *locking {
            LockingSpec::None => Self::None,
            LockingSpec::Average { blend } => Self::Average { blend },
        }
    }
}
