//! Meshes of a whole domain, as a case file writes them: `{ shape = "box", lower = [...], upper = [...],
//! cell = 0.01 }`, or a Gmsh file.
//!
//! Elements follow a size h(x): the size asked for, and around each refined region its size, growing
//! with the distance,
//!
//! ```text
//! h(x) = min(cell, cell_k + growth · dist(x, region_k))
//! ```

mod block;
mod boundary;
mod carve;
mod file;
mod graded;
pub(super) mod planar;
mod relax;
pub(super) mod size;

pub use block::{BoxMesh, CellPattern, Hole, Refinement};
pub use file::MeshFile;

use super::Mesh;
use crate::error::Diagnostic;
use std::path::Path;

/// A mesh of a case file.
pub trait BuildMesh {
    /// Triangles, for a case in 2D. Files are looked for below `base_dir`.
    ///
    /// # Errors
    /// A finding with a key relative to this mesh.
    fn triangles(&self, base_dir: &Path) -> Result<Mesh<2, 3>, Diagnostic>;

    /// Tetrahedra, for a case in 3D. Files are looked for below `base_dir`.
    ///
    /// # Errors
    /// A finding with a key relative to this mesh.
    fn tetrahedra(&self, base_dir: &Path) -> Result<Mesh<3, 4>, Diagnostic>;
}

impl DomainMesh {
    /// The difference between its elements and the requested ones, as a sentence.
    pub fn adjusted(&self) -> Option<String> {
        match self {
            Self::BoxMesh(mesh) => mesh.adjusted(),
            Self::MeshFile(_) => None,
        }
    }
}

crate::registry! {
    /// The mesh of a domain, as a case file writes it.
    pub enum DomainMesh: BuildMesh, tag = "shape" {
        "box" => BoxMesh,
        "file" => MeshFile,
    }
}
