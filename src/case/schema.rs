//! The case file as plain structs: its keys, units, ranges and defaults. The JSON Schema, the reference
//! pages and the checks while reading are all made from these.

use super::flow::{BoundarySpec, Pfem2Spec, TensionSpec};
use super::friction::FrictionSpec;
use super::parts::{BodySpec, ContactSpec, Material, MembraneSpec, ObstacleSpec, WallSpec};
use super::signal::SignalSpec;
use crate::material::PointLaws;
use crate::mesh::domain::DomainMesh;
use crate::mpm;
pub use crate::mpm::KernelKind as KernelSpec;
use crate::output::{PictureSpec, ProbeSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A case of lateen: what to compute, with which method, and what to write.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CaseFile {
    /// Short name; the run directory is called after it.
    pub name: String,
    /// One line for plots and lists.
    #[serde(default)]
    pub title: String,
    /// A description, with the source.
    #[serde(default)]
    pub description: String,
    /// The method.
    #[serde(default)]
    pub method: Method,
    /// 2 (plane strain, per metre of depth) or 3.
    #[schemars(extend("minimum" = 2, "maximum" = 3))]
    pub dimension: usize,
    /// `"SI"`: numbers may have units; `"none"`: everything is dimensionless.
    #[serde(default)]
    pub units: Units,
    /// Preset of the defaults of `[mpm]` or `[pfem2]`.
    #[serde(default)]
    pub preset: Preset,
    /// End time and time step.
    pub time: TimeSpec,
    /// The background grid of `method = "mpm"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grid: Option<GridSpec>,
    /// The mesh of `method = "pfem2"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<DomainMesh>,
    /// Choices of the material point method.
    #[serde(default)]
    pub mpm: MpmSpec,
    /// Choices of PFEM-2.
    #[serde(default)]
    pub pfem2: Pfem2Spec,
    /// Conditions on the boundary of the mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub boundary: Vec<BoundarySpec>,
    /// Surface tension of pairs of fluids.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tension: Vec<TensionSpec>,
    /// Bodies: of material points, or fluids on the mesh and solids in them; of fluids that overlap the first one counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub body: Vec<BodySpec>,
    /// Membranes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub membrane: Vec<MembraneSpec>,
    /// Rigid obstacles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacle: Vec<ObstacleSpec>,
    /// Contact of pairs that differ from `mpm.friction`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contact: Vec<ContactSpec>,
    /// Outputs and their intervals.
    #[serde(default)]
    pub output: OutputSpec,
    /// Histories of single quantities.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probe: Vec<ProbeSpec>,
    /// Pictures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub picture: Vec<PictureSpec>,
}

impl CaseFile {
    /// Places in `body` of the solids of a case of PFEM-2.
    pub fn solids(&self) -> Vec<usize> {
        let is_solid = |i: &usize| self.method == Method::Pfem2 && self.body[*i].material.is_solid();
        (0..self.body.len()).filter(is_solid).collect()
    }

    /// Places in `body` of the solids on particles of a case of PFEM-2: those with a rate law under the preset of the paper.
    pub fn particle_solids(&self) -> Vec<usize> {
        (0..self.body.len()).filter(|&i| self.is_on_particles(i)).collect()
    }

    /// Places in `body` of the fluids of a case of PFEM-2: all that are no solids. They are numbered in this order.
    pub fn fluids(&self) -> Vec<usize> {
        let is_solid = |i: usize| self.body[i].material.is_solid() || self.is_on_particles(i);
        (0..self.body.len()).filter(|&i| self.method == Method::Pfem2 && !is_solid(i)).collect()
    }

    fn is_on_particles(&self, body: usize) -> bool {
        let paper = self.method == Method::Pfem2 && self.preset == Preset::Becker2015;
        paper && matches!(self.body[body].material, Material::Point(PointLaws::Hypoelastic(_)))
    }
}

/// The methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The explicit material point method with membranes.
    #[default]
    Mpm,
    /// The particle finite element method for several fluids on a fixed mesh.
    Pfem2,
}

/// `"SI"`: numbers may have units; `"none"`: everything is dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub enum Units {
    /// A number without unit is in SI; text may carry any unit.
    #[default]
    SI,
    /// Everything is dimensionless: plain numbers only.
    #[serde(rename = "none")]
    None,
}

/// Presets of the defaults of `[mpm]` or `[pfem2]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub enum Preset {
    /// Chosen by the materials of the case.
    #[default]
    #[serde(rename = "recommended")]
    Recommended,
    /// The choices of Lian, Liu & Zhang (2014): linear shape functions, pure FLIP, stress first.
    #[serde(rename = "lian-2014")]
    Lian2014,
    /// The choices of Becker, Idelsohn & Oñate (2015): backward Euler, stabilisation without inertia, projection by
    /// shape functions.
    #[serde(rename = "becker-2015")]
    Becker2015,
}

/// End time and time step.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TimeSpec {
    /// When the run ends.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0.0))]
    pub end: f64,
    /// A fixed step; by default the step adapts to the stable one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0.0))]
    pub step: Option<f64>,
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

/// Outputs and their intervals.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct OutputSpec {
    /// Interval of the fields for ParaView; default: a fiftieth of the run.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0.0))]
    pub fields: Option<f64>,
    /// Interval of histories and balance; default: a five-hundredth of the run; a fiftieth where PFEM-2 chooses its
    /// steps, since outputs cut them short.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0.0))]
    pub history: Option<f64>,
    /// Wall-clock time between checkpoints; default: 60 s.
    #[schemars(extend("unit" = "s", "exclusiveMinimum" = 0.0, "clock" = true))]
    pub checkpoint: Option<f64>,
}

impl OutputSpec {
    /// Fills in what depends on the length of the run; with a fixed step, as whole numbers of steps.
    pub(super) fn complete(&mut self, method: Method, TimeSpec { end, step }: TimeSpec) {
        let step = step.filter(|step| *step > 0.0);
        let whole = |interval: f64| step.map_or(interval, |step| (interval / step).round().max(1.0) * step);
        let rows = if method == Method::Pfem2 && step.is_none() { 50.0 } else { 500.0 };
        self.fields.get_or_insert(whole(end / 50.0));
        self.history.get_or_insert(whole(end / rows));
        self.checkpoint.get_or_insert(60.0);
    }
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
