//! Data of the mesh and of the conditions on its boundary that the equations need, found once.

use super::outflow;
use super::slip;
use crate::mesh::Mesh;
use crate::pfem2::boundary::Boundary;

/// Sizes of the elements, and their facets on the boundary; bit k is for the facet opposite to local node k.
#[derive(Debug)]
pub struct MeshData {
    /// Shortest edge of each element [m].
    pub size: Vec<f64>,
    /// Facets of each element at outlets and under a pressure, as bits (see `outflow`).
    pub outlets: Vec<u8>,
    /// Slip facets of each element, as bits (see `slip`).
    pub slip: Vec<u8>,
    /// Facets of each element with a prescribed flux, as bits: walls, slip walls and inlets.
    pub held: Vec<u8>,
    /// Facets of each element with a free flux, as bits: outlets, tractions and pressures.
    pub openings: Vec<u8>,
    /// True for nodes on the boundary of the mesh.
    pub on_boundary: Vec<bool>,
}

impl MeshData {
    /// Of a mesh with these conditions on its boundary.
    pub fn new<const D: usize, const N: usize>(mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Self {
        Self {
            size: (0..mesh.elements().len()).map(|e| mesh.shortest_edge(e)).collect(),
            outlets: outflow::outlet_facets(mesh, boundary),
            slip: slip::slip_facets(mesh, boundary),
            held: boundary.facet_bits(mesh, |condition| condition.kind().carries_reaction()),
            openings: boundary.facet_bits(mesh, |condition| condition.kind().has_free_flux()),
            on_boundary: boundary_nodes(mesh),
        }
    }

    /// The shortest edge of the mesh [m].
    pub fn shortest(&self) -> f64 {
        self.size.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// True for nodes on the boundary of a mesh.
fn boundary_nodes<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Vec<bool> {
    let mut on_boundary = vec![false; mesh.nodes().len()];
    mesh.boundary()
        .iter()
        .flat_map(|&facet| mesh.facet_nodes(facet))
        .for_each(|node| on_boundary[node as usize] = true);
    on_boundary
}
