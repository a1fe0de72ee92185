//! Regions in a case file: `{ shape = "sphere", center = [...], radius = ... }`.
//!
//! One struct per shape, those made of other shapes in `composed`, the region below a curve in `graph`; its fields are the keys. The case reader has
//! converted units when a shape is built, so every number is in SI here.

mod composed;
mod graph;

pub use composed::{ComplementShape, DifferenceShape, IntersectionShape, RotatedShape, TranslatedShape, UnionShape};
pub use graph::{BelowShape, Height};

use super::{Direction, Polygon, Region, Surface};
use crate::error::Diagnostic;
use crate::math::Vector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A shape of a case file.
pub trait BuildRegion {
    /// Checks the shape and makes its region. Surface files are looked for below `base_dir`.
    ///
    /// # Errors
    /// A finding with a key relative to this shape (`radius`, `of[1].center`).
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic>;
}

crate::registry! {
    /// A region of space, as a case file writes it.
    pub enum Shape: BuildRegion, tag = "shape" {
        "box" => BoxShape,
        "sphere" => SphereShape,
        "ellipsoid" => EllipsoidShape,
        "cylinder" => CylinderShape,
        "half-space" => HalfSpaceShape,
        "polygon" => PolygonShape,
        "below" => BelowShape,
        "surface" => SurfaceShape,
        "union" => UnionShape,
        "intersection" => IntersectionShape,
        "difference" => DifferenceShape,
        "complement" => ComplementShape,
        "translated" => TranslatedShape,
        "rotated" => RotatedShape,
    }
}

impl Shape {
    /// Checks the shape and makes its region. Surface files are looked for below `base_dir`.
    ///
    /// # Errors
    /// A finding with a key relative to this shape (`radius`, `of[1].center`).
    pub fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        self.as_dyn().build(base_dir, dimension)
    }
}

/// An axis-aligned box; a rectangle in 2D.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxShape {
    /// Lower corner [m].
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub lower: Vec<f64>,
    /// Upper corner [m].
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub upper: Vec<f64>,
}

impl BuildRegion for BoxShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        let mut lower = point("lower", &self.lower, dimension)?;
        let mut upper = point("upper", &self.upper, dimension)?;
        if let Some(axis) = (0..dimension).find(|&i| lower[i] >= upper[i]) {
            let axis_name = ["x", "y", "z"][axis];
            return Err(Diagnostic::error("upper", format!("the box has no extent along {axis_name}"))
                .help("every coordinate of `upper` must exceed that of `lower`"));
        }
        if dimension == 2 {
            (lower[2], upper[2]) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        Ok(Region::Box { lower, upper })
    }
}

/// A sphere; a disc in 2D.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereShape {
    /// Centre [m].
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub center: Vec<f64>,
    /// Radius [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub radius: f64,
}

impl BuildRegion for SphereShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        Ok(Region::Sphere {
            center: point("center", &self.center, dimension)?,
            radius: positive("radius", self.radius)?,
        })
    }
}

/// An ellipsoid with its axes along x, y, z; an ellipse in 2D. Wrap it in `rotated` for other directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EllipsoidShape {
    /// Centre [m].
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub center: Vec<f64>,
    /// Half of the extent along each axis [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0), length(min = 2, max = 3))]
    pub semi_axes: Vec<f64>,
}

impl BuildRegion for EllipsoidShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        let mut semi_axes = point("semi-axes", &self.semi_axes, dimension)?;
        for &semi_axis in &semi_axes[..dimension] {
            positive("semi-axes", semi_axis)?;
        }
        if dimension == 2 {
            semi_axes[2] = f64::INFINITY;
        }
        Ok(Region::Ellipsoid { center: point("center", &self.center, dimension)?, semi_axes })
    }
}

/// A cylinder with flat ends; 3D only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderShape {
    /// Centre of one end [m].
    #[schemars(extend("unit" = "m"))]
    pub from: [f64; 3],
    /// Centre of the other end [m].
    #[schemars(extend("unit" = "m"))]
    pub to: [f64; 3],
    /// Radius [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub radius: f64,
}

impl BuildRegion for CylinderShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        only_3d(dimension, "a cylinder", "use `shape = \"sphere\"` for a disc")?;
        let (from, to) = (point("from", &self.from, 3)?, point("to", &self.to, 3)?);
        if from == to {
            return Err(Diagnostic::error("to", "the ends of the cylinder coincide"));
        }
        Ok(Region::Cylinder { from, to, radius: positive("radius", self.radius)? })
    }
}

/// Everything behind a plane: the side from which `normal` points away.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceShape {
    /// A point of the plane [m].
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub point: Vec<f64>,
    /// Direction out of the region: `"z"`, `"-x"` or a vector of any length.
    pub normal: Direction,
}

impl BuildRegion for HalfSpaceShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        let normal = self.normal.unit("normal", dimension)?;
        Ok(Region::HalfSpace { point: point("point", &self.point, dimension)?, normal: normal.0 })
    }
}

/// A polygon in the x-y plane; in 3D extruded between two heights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolygonShape {
    /// Corners in order [m], `[[x, y], ...]`; the last is joined to the first.
    #[schemars(extend("unit" = "m"), length(min = 3))]
    pub corners: Vec<[f64; 2]>,
    /// Heights z between which the polygon is extruded [m]; 3D only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m"))]
    pub heights: Option<[f64; 2]>,
}

impl BuildRegion for PolygonShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        let [lower, upper] = match (dimension, self.heights) {
            (2, None) => [f64::NEG_INFINITY, f64::INFINITY],
            (2, Some(_)) => return Err(Diagnostic::error("heights", "a polygon has no heights in 2D")),
            (_, Some([lower, upper])) if lower < upper && lower.is_finite() && upper.is_finite() => [lower, upper],
            (_, Some(_)) => return Err(Diagnostic::error("heights", "the second height must exceed the first")),
            (_, None) => {
                return Err(Diagnostic::error("heights", "in 3D a polygon needs the heights between which it lies")
                    .help("for example `heights = [\"0 m\", \"1 m\"]`"));
            }
        };
        for corner in &self.corners {
            point("corners", corner, 2)?;
        }
        let corners = self.corners.iter().map(|&c| Vector(c)).collect();
        let polygon = Polygon::new(corners, lower, upper).map_err(|why| Diagnostic::error("corners", why))?;
        Ok(Region::Polygon(Arc::new(polygon)))
    }
}

/// The volume inside a closed triangulated surface from an STL or OBJ file; 3D only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceShape {
    /// The file, relative to the case file; its ending (`.stl`, `.obj`) says the format.
    pub file: PathBuf,
    /// Length of one unit of the file [m]: `unit = "1 mm"` for a file in millimetres.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub unit: f64,
}

fn one() -> f64 {
    1.0
}

impl BuildRegion for SurfaceShape {
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        only_3d(dimension, "a surface", "use `shape = \"polygon\"` in 2D")?;
        let unit = positive("unit", self.unit)?;
        let surface = Surface::read(&base_dir.join(&self.file), unit)
            .map_err(|why| Diagnostic::error("file", format!("{}: {why}", self.file.display())))?;
        Ok(Region::Surface(Arc::new(surface)))
    }
}

fn only_3d(dimension: usize, what: &str, instead: &str) -> Result<(), Diagnostic> {
    if dimension == 3 {
        return Ok(());
    }
    Err(Diagnostic::error("shape", format!("{what} needs `dimension = 3`")).help(instead))
}

/// A point or vector with as many finite components as the case has dimensions, padded with zeros.
fn point(key: &str, components: &[f64], dimension: usize) -> Result<[f64; 3], Diagnostic> {
    if components.len() != dimension {
        let message = format!("{} components where the case has {dimension} dimensions", components.len());
        return Err(Diagnostic::error(key, message).help(format!("write {dimension} components")));
    }
    if components.iter().any(|c| !c.is_finite()) {
        return Err(Diagnostic::error(key, "every component must be finite"));
    }
    Ok(std::array::from_fn(|i| components.get(i).copied().unwrap_or(0.0)))
}

fn positive(key: &str, value: f64) -> Result<f64, Diagnostic> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Diagnostic::error(key, format!("must be positive and finite, not {value}")))
}
