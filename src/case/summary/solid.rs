//! Size of a solid in the fluids of PFEM-2.

use crate::case::resolution::{MeshSizes, PathResolution, shown};
use crate::linalg::{SparseMatrix, factor_numbers};
use crate::mesh::Locator;
use crate::pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::SolidSetup;

/// Memory of an entry of the matrix of a solid in all its forms, as measured [bytes].
const ENTRY: f64 = 80.0;

/// One solid in a fluid.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidSummary {
    /// Name.
    pub name: String,
    /// True without a strain.
    pub is_rigid: bool,
    /// 2 or 3.
    pub dimension: usize,
    /// Elements.
    pub elements: usize,
    /// Nodes.
    pub nodes: usize,
    /// Mass [kg; kg/m in 2D].
    pub mass: f64,
    /// Thickness of its thinnest part [m].
    pub thickness: f64,
    /// The place of that [m].
    pub thinnest: [f64; 3],
    /// Elements across it.
    pub across: usize,
    /// Elements of the fluid's mesh across it; `None` outside of that mesh.
    pub cells_across: Option<f64>,
    /// Part of its sides behind which it is thinner than an element of the fluid's mesh.
    pub thin_part: f64,
    /// Elements of the fluid's mesh across it along the way that it is likely to take; `None` if it stays where it is, as far as that can be
    /// foreseen.
    pub path: Option<PathResolution>,
}

impl std::fmt::Display for SolidSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let unit = if self.dimension == 2 { "kg/m" } else { "kg" };
        if self.elements == 0 {
            let Self { name, nodes, mass, thickness, .. } = self;
            return write!(
                f,
                "rigid solid {name}: a surface of {nodes} nodes, {mass:.4} {unit}; its least extent is {thickness:.4e} m"
            )
            .and_then(|()| self.write_cells(f));
        }
        write!(
            f,
            "{} {}: {} elements, {} nodes, {:.4} {unit}; its thinnest part, {:.4e} m, is {} elements across",
            if self.is_rigid { "rigid solid" } else { "solid" },
            self.name,
            self.elements,
            self.nodes,
            self.mass,
            self.thickness,
            self.across
        )?;
        self.write_cells(f)
    }
}

impl SolidSummary {
    /// Elements of the mesh across it, at rest and along its way.
    fn write_cells(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Some(cells), path) = (self.cells_across, self.path) else { return Ok(()) };
        write!(f, ", {cells:.1} of the mesh")?;
        let Some(path) = path else { return Ok(()) };
        if format!("{cells:.1}") == format!("{:.1}", path.cells) {
            return write!(f, ", also on the {:.1e} m that it is likely to move", path.way);
        }
        let place = shown(path.place, self.dimension);
        write!(f, " at rest, {:.1} on the {:.1e} m that it is likely to move (at {place})", path.cells, path.way)
    }
}

/// Memory that the matrices and the factor of elastic solids take in a step [bytes].
pub(super) fn factor_memory<const D: usize>(solids: &[SolidSetup<D>]) -> f64 {
    let elastic = solids.iter().filter(|solid| !solid.law.is_rigid());
    elastic
        .map(|solid| {
            D.pow(2) as f64
                * node_numbers(&solid.mesh).map_or(f64::INFINITY, |[own, factor]| 4.0 * factor + ENTRY * own)
        })
        .sum()
}

/// Blocks of the matrix of a solid, and of its factor.
fn node_numbers<const D: usize>(mesh: &SolidMesh<D>) -> Option<[f64; 2]> {
    let pairs =
        mesh.elements.iter().flat_map(|nodes| nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| (a, b, 1.0))));
    let graph = SparseMatrix::from_triplets(mesh.nodes.len(), pairs);
    Some([graph.values.len() as f64, factor_numbers(&graph)? as f64])
}

/// The solids in the mesh of the fluid.
pub(super) fn solid_summaries<const D: usize, const N: usize>(
    setup: &pfem2::Setup<D, N>,
    paths: &[Option<PathResolution>],
) -> Vec<SolidSummary> {
    let mesh = &setup.mesh;
    if setup.solids.is_none() {
        return Vec::new();
    }
    let (locator, sizes) = (Locator::new(mesh), MeshSizes::new(mesh));
    let solids = setup.solid_setups().iter().zip(paths);
    solids.map(|(solid, path)| SolidSummary::new(solid, mesh, &locator, &sizes, *path)).collect()
}
