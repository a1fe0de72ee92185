//! Shapes made of other shapes: unions, intersections, differences, and shapes that are moved or turned.

use super::{BuildRegion, Shape, point};
use crate::error::Diagnostic;
use crate::geometry::{Direction, Region};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The union of its members.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnionShape {
    /// The members.
    #[schemars(length(min = 1))]
    pub of: Vec<Shape>,
}

impl BuildRegion for UnionShape {
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        Ok(Region::Union(members("of", &self.of, base_dir, dimension)?))
    }
}

/// The intersection of its members.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IntersectionShape {
    /// The members.
    #[schemars(length(min = 1))]
    pub of: Vec<Shape>,
}

impl BuildRegion for IntersectionShape {
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        Ok(Region::Intersection(members("of", &self.of, base_dir, dimension)?))
    }
}

/// A shape less others.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DifferenceShape {
    /// The shape to start from.
    pub of: Box<Shape>,
    /// The shapes that are taken away.
    #[schemars(length(min = 1))]
    pub minus: Vec<Shape>,
}

impl BuildRegion for DifferenceShape {
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        let whole = member("of", &self.of, base_dir, dimension)?;
        let taken = members("minus", &self.minus, base_dir, dimension)?;
        let rest = taken.into_iter().map(|region| Region::Complement(Box::new(region)));
        Ok(Region::Intersection(std::iter::once(whole).chain(rest).collect()))
    }
}

/// The complement of a shape.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComplementShape {
    /// The shape.
    pub of: Box<Shape>,
}

impl BuildRegion for ComplementShape {
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        Ok(Region::Complement(Box::new(member("of", &self.of, base_dir, dimension)?)))
    }
}

/// A shape moved by a vector.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TranslatedShape {
    /// The shape.
    pub of: Box<Shape>,
    /// The vector [m].
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub by: Vec<f64>,
}

impl BuildRegion for TranslatedShape {
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        let region = Box::new(member("of", &self.of, base_dir, dimension)?);
        let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Ok(Region::Placed { region, rotation, shift: point("by", &self.by, dimension)? })
    }
}

/// A shape turned about an axis, counter-clockwise seen against the axis.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotatedShape {
    /// The shape.
    pub of: Box<Shape>,
    /// Angle [rad]; `"30 deg"` for degrees.
    #[schemars(extend("unit" = "rad"))]
    pub angle: f64,
    /// Direction of the axis: `"z"`, `"-x"` or a vector of any length. In 2D always z.
    #[serde(default = "Direction::z")]
    pub axis: Direction,
    /// A point of the axis [m]; default: the origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m"), length(min = 2, max = 3))]
    pub about: Option<Vec<f64>>,
}

impl BuildRegion for RotatedShape {
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
        let region = Box::new(member("of", &self.of, base_dir, dimension)?);
        let axis = self.axis.unit("axis", 3)?.0;
        if dimension == 2 && self.axis != Direction::z() {
            return Err(Diagnostic::error("axis", "in 2D shapes turn about z only").help("leave `axis` out"));
        }
        if !self.angle.is_finite() {
            return Err(Diagnostic::error("angle", "the angle must be finite"));
        }
        let about = self.about.as_ref().map_or(Ok([0.0; 3]), |about| point("about", about, dimension))?;
        let rotation = rotation(axis, self.angle);
        let shift = std::array::from_fn(|i| about[i] - (0..3).map(|j| rotation[i][j] * about[j]).sum::<f64>());
        Ok(Region::Placed { region, rotation, shift })
    }
}

/// Rodrigues: R = cos θ 1 + sin θ [a]× + (1 − cos θ) a ⊗ a.
fn rotation(a: [f64; 3], angle: f64) -> [[f64; 3]; 3] {
    let (sin, cos) = angle.sin_cos();
    let cross = [[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let identity = if i == j { 1.0 } else { 0.0 };
            // On the axis itself the two terms add up to one: exact, whatever the angle.
            if i == j && a[i].abs() == 1.0 {
                1.0
            } else {
                cos * identity + sin * cross[i][j] + (1.0 - cos) * a[i] * a[j]
            }
        })
    })
}

fn member(key: &str, shape: &Shape, base_dir: &Path, dimension: usize) -> Result<Region, Diagnostic> {
    shape.build(base_dir, dimension).map_err(|mut finding| {
        finding.key = if finding.key.is_empty() { key.into() } else { format!("{key}.{}", finding.key) };
        finding
    })
}

fn members(key: &str, shapes: &[Shape], base_dir: &Path, dimension: usize) -> Result<Vec<Region>, Diagnostic> {
    if shapes.is_empty() {
        return Err(Diagnostic::error(key, "the list of shapes is empty"));
    }
    shapes.iter().enumerate().map(|(i, shape)| member(&format!("{key}[{i}]"), shape, base_dir, dimension)).collect()
}
