//! Domain meshes from Gmsh files.

use super::BuildMesh;
use crate::error::Diagnostic;
use crate::mesh::{Mesh, gmsh};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A mesh from a Gmsh file (`.msh`, versions 2.2 and 4.1) of triangles in 2D or tetrahedra in 3D. The physical
/// groups of its boundary are the names that conditions refer to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// The file, relative to the case file.
    pub path: PathBuf,
    /// Physical group of the domain's elements; by default all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Length of one unit of the file [m]: `unit = "1 mm"` for a file in millimetres.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub unit: f64,
}

fn one() -> f64 {
    1.0
}

impl BuildMesh for MeshFile {
    fn triangles(&self, base_dir: &Path) -> Result<Mesh<2, 3>, Diagnostic> {
        self.read(base_dir)
    }

    fn tetrahedra(&self, base_dir: &Path) -> Result<Mesh<3, 4>, Diagnostic> {
        self.read(base_dir)
    }
}

impl MeshFile {
    fn read<const D: usize, const N: usize>(&self, base_dir: &Path) -> Result<Mesh<D, N>, Diagnostic> {
        if !(self.unit > 0.0 && self.unit.is_finite()) {
            return Err(Diagnostic::error("unit", format!("must be positive and finite, not {}", self.unit)));
        }
        let wrong = |key: &str, why: String| Diagnostic::error(key, format!("{}: {why}", self.path.display()));
        let file = gmsh::read(&base_dir.join(&self.path)).map_err(|why| wrong("path", why.to_string()))?;
        let key = if self.group.is_some() { "group" } else { "path" };
        let mesh = Mesh::from_gmsh(&file, self.group.as_deref(), self.unit).map_err(|why| wrong(key, why))?;
        if mesh.sets.contains_key("rest") || mesh.inner.contains_key("rest") {
            let why = "a physical group is named `rest`, which means all parts of the boundary without a condition";
            return Err(wrong("path", why.to_owned()).help("give the group another name in the file"));
        }
        Ok(mesh)
    }
}
