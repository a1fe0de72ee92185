//! Surfaces swept along a straight line: circular cylinders and tubes of any cross-section.

use super::chain::polyline;
use super::patch::RectanglePatch;
use super::{BuildFacets, ElementKind, Facets, divisions, finite, frame, only, positive};
use crate::error::Diagnostic;
use crate::math::Vector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::path::Path;

/// The mantle of a circular cylinder, or a strip of it, with outward normals. Its end rings are `front`
/// (at `from`) and `back` (at `to`); a strip also has `left` and `right`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderMeshShape {
    /// Centre of one end [m].
    #[schemars(extend("unit" = "m"))]
    pub from: [f64; 3],
    /// Centre of the other end [m].
    #[schemars(extend("unit" = "m"))]
    pub to: [f64; 3],
    /// Radius [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub radius: f64,
    /// Elements around and along the axis.
    pub divisions: [usize; 2],
    /// Angles between which a strip lies [rad], counted around the axis from the axis direction that follows
    /// its own in the order x, y, z, x; by default all around.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "rad"))]
    pub arc: Option<[f64; 2]>,
    /// Elements.
    #[serde(default)]
    pub elements: ElementKind,
}

impl BuildFacets for CylinderMeshShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        only(dimension, 3, "in 2D use `shape = \"circle\"`")?;
        let radius = positive("radius", self.radius)?;
        let (from, to) = (Vector(finite("from", self.from)?), Vector(finite("to", self.to)?));
        let axis = (to - from).normalized().ok_or_else(|| Diagnostic::error("to", "the ends coincide"))?;
        let [start, end] = finite("arc", self.arc.unwrap_or([0.0, TAU]))?;
        if !(end > start && end - start <= TAU * (1.0 + 1e-12)) {
            return Err(Diagnostic::error("arc", "the angles must increase, by a full turn at most"));
        }
        let closed = end - start >= TAU * (1.0 - 1e-12);
        let cells = divisions("divisions", self.divisions, 1)?;
        divisions("divisions", [cells[0]], if closed { 3 } else { 1 })?;
        let [e_1, e_2] = frame(axis);
        let position = |i: usize, j: usize| {
            let (sin, cos) = (start + (end - start) * i as f64 / cells[0] as f64).sin_cos();
            from + (to - from) * (j as f64 / cells[1] as f64) + (e_1 * cos + e_2 * sin) * radius
        };
        Ok(RectanglePatch { cells, closed }.facets(self.elements, position))
    }
}

/// A cross-section in the x-y plane swept along z. The normal points out of a cross-section that runs
/// counter-clockwise. Its ends in z are `front` and `back`; an open cross-section begins at `left` and
/// ends at `right`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TubeShape {
    /// Corners of the cross-section [m], `[[x, y], ...]`.
    #[schemars(extend("unit" = "m"), length(min = 2))]
    pub points: Vec<[f64; 2]>,
    /// Elements on each side of the cross-section; a single number holds for all.
    #[schemars(length(min = 1))]
    pub divisions: Vec<usize>,
    /// True: the last corner is joined to the first.
    #[serde(default)]
    pub closed: bool,
    /// Heights z of its ends [m].
    #[schemars(extend("unit" = "m"))]
    pub heights: [f64; 2],
    /// Elements along z.
    pub layers: usize,
    /// Elements.
    #[serde(default)]
    pub elements: ElementKind,
}

impl BuildFacets for TubeShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        only(dimension, 3, "in 2D use `shape = \"chain\"`")?;
        let [lower, upper] = finite("heights", self.heights)?;
        if lower >= upper {
            return Err(Diagnostic::error("heights", "the second height must exceed the first"));
        }
        let line = polyline(&self.points, &self.divisions, self.closed)?;
        let around = if self.closed { line.len() } else { line.len() - 1 };
        let [_, layers] = divisions("layers", [around, self.layers], 1)?;
        let position = |i: usize, j: usize| {
            let height = lower + (upper - lower) * j as f64 / layers as f64;
            Vector([line[i][0], line[i][1], height])
        };
        Ok(RectanglePatch { cells: [around, layers], closed: self.closed }.facets(self.elements, position))
    }
}
