//! Rigid solids whose surface comes from an STL or OBJ file.

use super::super::Construction;
use crate::error::Diagnostic;
use crate::geometry::Triangles;
use crate::math::Vector;
use crate::mesh::{QuadraticMesh, SurfacePatches};
use crate::pfem2::solid::mesh::SolidMesh;

impl Construction<'_> {
    /// The surface of the solid `body[index]`, inside `None` if it is elastic, which has elements inside, or its region
    /// has no surface of a file; outside if that is no use (and why was noted).
    pub(super) fn surface_of(&mut self, index: usize) -> Option<Option<Triangles>> {
        let spec = &self.case.file.body[index];
        let (Some(shape), true) = (&spec.region, self.is_rigid(index)) else { return Some(None) };
        let key = format!("body[{index}]");
        let Some(surface) = self.region(&format!("{key}.region"), shape)?.triangles() else { return Some(None) };
        if spec.mesh.is_some() {
            let message = "the surface of this rigid solid is that of the file: it has no elements inside";
            self.findings.push(Diagnostic::error(format!("{key}.mesh"), message).help("take it out"));
        }
        Some(Some(surface))
    }

    /// A rigid solid inside of a surface. Its sets are sides and the surface.
    pub(super) fn enclosed<const D: usize>(
        &mut self,
        index: usize,
        surface: &Triangles,
    ) -> Option<(QuadraticMesh, SolidMesh<D>)> {
        let made = SurfacePatches::new(surface).and_then(|SurfacePatches { mesh, patches }| {
            let nodes = mesh.nodes.iter().map(|&x| Vector(x)).collect();
            let SolidMesh { nodes, elements, facets, inner } = SolidMesh::enclosed(nodes, patches)?;
            // Surfaces from files are of three dimensions.
            let nodes = nodes.iter().map(|x| Vector::from3(x.0)).collect();
            Ok((mesh, SolidMesh { nodes, elements, facets, inner }))
        });
        made.map_err(|why| self.findings.push(Diagnostic::error(format!("body[{index}].region"), why))).ok()
    }
}
