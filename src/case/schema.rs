//! The case file as plain structs: its keys, units, ranges and defaults. The JSON Schema, the reference
//! pages and the checks while reading are all made from these.

use super::flow::{BoundarySpec, Pfem2Spec, TensionSpec};
use super::membrane::MembraneSpec;
use super::mpm::{GridSpec, MpmSpec};
use super::parts::{BodySpec, ContactSpec, Material};
use super::walls::ObstacleSpec;
use crate::material::PointLaws;
use crate::mesh::domain::DomainMesh;
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
    /// Bodies: of material points, or fluids on the mesh and solids in them; of fluids that overlap the first one
    /// counts.
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

    /// Places in `body` of the solids on particles of a case of PFEM-2: those with a rate law under the preset of the
    /// paper.
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
    /// The particle finite element method for several fluids, and solids in them, on a fixed mesh.
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
