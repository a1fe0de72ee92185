//! Meshes of simplices from Gmsh files.

use super::{Facet, Mesh};
use crate::math::Vector;
use crate::mesh::gmsh::GmshMesh;
use hashbrown::HashMap;

impl<const D: usize, const N: usize> Mesh<D, N> {
    /// The triangles (2D) or tetrahedra (3D) of a physical group, or all of them; `unit` is the length of one
    /// unit of the file [m]. Physical groups of boundary facets become named sets. Nodes that no element of the file
    /// uses are left out, and kept as [`Mesh::isolated`].
    ///
    /// # Errors
    /// No such group or element; quadrilaterals; whatever [`Mesh::new`] finds.
    pub fn from_gmsh(file: &GmshMesh, group: Option<&str>, unit: f64) -> Result<Self, String> {
        let cells = file.cells_of(group, D)?;
        let mut used: Vec<u32> = cells.iter().flat_map(|cell| cell.nodes()).copied().collect();
        used.sort_unstable();
        used.dedup();
        let index = |node: &u32| used.binary_search(node).ok().map(|place| place as u32);
        let place = |n: u32| Vector::from_fn(|i| file.nodes[n as usize][i] * unit);
        let nodes = used.iter().map(|&n| place(n)).collect();
        let mut elements = Vec::with_capacity(cells.len());
        for cell in &cells {
            let element: Vec<u32> = cell.nodes().iter().filter_map(index).collect();
            let element: [u32; N] = element
                .try_into()
                .map_err(|_| format!("element {} is no simplex: mesh with triangles", cell.number))?;
            elements.push(element);
        }
        let mut mesh = Self::numbered(nodes, elements, &|e| cells[e].number)?;
        mesh.name_boundary(file, index);
        mesh.isolated = file.isolated(D).into_iter().map(place).collect();
        Ok(mesh)
    }

    fn name_boundary(&mut self, file: &GmshMesh, index: impl Fn(&u32) -> Option<u32>) {
        let ascending = |mut nodes: Vec<u32>| {
            nodes.sort_unstable();
            nodes
        };
        let known: HashMap<Vec<u32>, Facet> =
            self.boundary().iter().map(|&facet| (ascending(self.facet_nodes(facet)), facet)).collect();
        for group in file.groups.iter().filter(|group| group.dimension + 1 == D) {
            let cells = file.cells_of(Some(&group.name), group.dimension).unwrap_or_default();
            let facet_of = |nodes: &[u32]| known.get(&ascending(nodes.iter().filter_map(&index).collect())).copied();
            let mut facets: Vec<Facet> = cells.iter().filter_map(|cell| facet_of(cell.nodes())).collect();
            facets.sort_unstable();
            if !facets.is_empty() {
                self.sets.insert(group.name.clone(), facets);
            }
        }
    }
}
