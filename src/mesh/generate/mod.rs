//! Membranes made in the case file: `{ shape = "sheet", center = [...], size = [...], divisions = [50, 50] }`.
//!
//! Every generator gives elements with consistent normals and named sets of nodes. A surface that is a
//! mapped rectangle (u, v) has the sets `left`, `right` (u at its ends) and `front`, `back` (v at its ends);
//! its normal is e_u × e_v.

mod chain;
mod disc;
mod file;
mod patch;
mod sphere;
mod swept;

pub use chain::{ChainShape, CircleShape};
pub use disc::DiscShape;
pub use file::FileShape;
pub use patch::SheetShape;
pub use sphere::SphereMeshShape;
pub use swept::{CylinderMeshShape, TubeShape};

use super::Facets;
use crate::error::Diagnostic;
use crate::math::Vector;
use crate::memory;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A membrane shape of a case file.
pub trait BuildFacets {
    /// Checks the shape and makes its mesh. Files are looked for below `base_dir`.
    ///
    /// # Errors
    /// A finding with a key relative to this shape.
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Facets, Diagnostic>;
}

crate::registry! {
    /// A membrane, as a case file writes it.
    pub enum MembraneShape: BuildFacets, tag = "shape" {
        "sheet" => SheetShape,
        "disc" => DiscShape,
        "cylinder" => CylinderMeshShape,
        "tube" => TubeShape,
        "sphere" => SphereMeshShape,
        "chain" => ChainShape,
        "circle" => CircleShape,
        "file" => FileShape,
    }
}

impl MembraneShape {
    /// Checks the shape and makes its mesh. Files are looked for below `base_dir`.
    ///
    /// # Errors
    /// A finding with a key relative to this shape.
    pub fn build(&self, base_dir: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        self.as_dyn().build(base_dir, dimension)
    }
}

/// Elements of a generated surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ElementKind {
    /// Quadrilaterals.
    #[default]
    Quadrilaterals,
    /// Two triangles per quadrilateral, all cut alike; on a sphere the subdivided icosahedron.
    Triangles,
    /// Two triangles per quadrilateral, cut in alternating directions: no preferred diagonal.
    UnionJack,
}

/// A quadrilateral of a block of them, and whether its place (i, j) has an even i + j.
struct Quad {
    nodes: [u32; 4],
    even: bool,
}

impl ElementKind {
    fn cut(self, quads: impl Iterator<Item = Quad>) -> Vec<Vec<u32>> {
        let mut elements = Vec::new();
        for Quad { nodes: [a, b, c, d], even } in quads {
            match (self, even) {
                (Self::Quadrilaterals, _) => elements.push(vec![a, b, c, d]),
                (Self::UnionJack, false) => elements.extend([vec![a, b, d], vec![b, c, d]]),
                (Self::Triangles, _) | (Self::UnionJack, true) => elements.extend([vec![a, b, c], vec![a, c, d]]),
            }
        }
        elements
    }
}

/// Unit vectors (e_u, e_v) with e_u × e_v = `normal`. For an axis they are the next two axes in the order
/// x, y, z, x; otherwise e_u is as near to the axis after the dominant one as can be.
fn frame(normal: Vector<3>) -> [Vector<3>; 2] {
    let dominant = (0..3).max_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs())).unwrap_or(2);
    let next = Vector::unit((dominant + 1) % 3);
    let first = (next - normal * next.dot(normal)).normalized().unwrap_or(next);
    [first, normal.cross(first)]
}

/// Most elements of one membrane.
const MOST_ELEMENTS: usize = 100_000_000;

/// Memory per element at least.
const BYTES: f64 = 500.0;

fn divisions<const N: usize>(key: &str, counts: [usize; N], least: usize) -> Result<[usize; N], Diagnostic> {
    if let Some(count) = counts.iter().find(|&&count| count < least) {
        return Err(Diagnostic::error(key, format!("{count} divisions are too few")).help(format!("at least {least}")));
    }
    let product = counts.iter().try_fold(1usize, |product, &count| product.checked_mul(count));
    match product {
        Some(product) if product <= MOST_ELEMENTS => match memory::refusal(BYTES * product as f64) {
            Some(refusal) => Err(Diagnostic::error(key, format!("{product} elements take {refusal}"))),
            None => Ok(counts),
        },
        _ => Err(Diagnostic::error(key, format!("more than {MOST_ELEMENTS} elements"))),
    }
}

fn positive(key: &str, value: f64) -> Result<f64, Diagnostic> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Diagnostic::error(key, format!("must be positive and finite, not {value}")))
}

fn finite<const N: usize>(key: &str, x: [f64; N]) -> Result<[f64; N], Diagnostic> {
    if x.iter().all(|c| c.is_finite()) {
        return Ok(x);
    }
    Err(Diagnostic::error(key, "every component must be finite"))
}

fn only(dimension: usize, needed: usize, instead: &str) -> Result<(), Diagnostic> {
    if dimension == needed {
        return Ok(());
    }
    Err(Diagnostic::error("shape", format!("this membrane needs `dimension = {needed}`")).help(instead))
}
