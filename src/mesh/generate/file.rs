//! Membranes from files: Gmsh, STL, OBJ.

use super::{BuildFacets, Facets, positive};
use crate::error::Diagnostic;
use crate::geometry::Faces;
use crate::mesh::check::check;
use crate::mesh::gmsh;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A mesh from a file: Gmsh (`.msh`, versions 2.2 and 4.1) in 2D and 3D, STL or OBJ in 3D. The physical
/// groups of a Gmsh file are the names of its node sets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileShape {
    /// The file, relative to the case file; its ending (`.msh`, `.stl`, `.obj`) says the format.
    pub path: PathBuf,
    /// Physical group of the membrane's elements; by default all surfaces (in 2D all lines) of the file.
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

impl BuildFacets for FileShape {
    fn build(&self, base_dir: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        let unit = positive("unit", self.unit)?;
        let wrong = |why: String| Diagnostic::error("path", format!("{}: {why}", self.path.display()));
        let path = base_dir.join(&self.path);
        let gmsh = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("msh"));
        let facets = if gmsh {
            let mesh = gmsh::read(&path).map_err(|why| wrong(why.to_string()))?;
            mesh.facets(self.group.as_deref(), dimension, unit).map_err(|why| Diagnostic {
                key: if self.group.is_some() { "group" } else { "path" }.into(),
                ..wrong(why)
            })?
        } else {
            self.surface(&path, dimension, unit).map_err(wrong)?
        };
        match check(&facets).iter().find(|finding| finding.problem.is_error()) {
            Some(finding) => Err(wrong(finding.to_string())),
            None => Ok(facets),
        }
    }
}

impl FileShape {
    fn surface(&self, path: &Path, dimension: usize, unit: f64) -> Result<Facets, String> {
        if dimension != 3 {
            return Err(
                "triangulated surfaces need `dimension = 3`; in 2D use `shape = \"chain\"` or a .msh file".into()
            );
        }
        if let Some(group) = &self.group {
            return Err(format!("a surface file has no groups, so no `{group}`; leave `group` out"));
        }
        let Faces { vertices, faces } = Faces::read(path, unit)?;
        match faces.iter().position(|face| face.len() > 4) {
            Some(face) => Err(format!(
                "face {face} has {} corners: elements have three or four; save it as triangles or quadrilaterals",
                faces[face].len()
            )),
            None => Ok(Facets { nodes: vertices, elements: faces, ..Facets::default() }),
        }
    }
}
