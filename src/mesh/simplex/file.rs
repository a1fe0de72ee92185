//! Meshes of simplices from Gmsh files.

use super::{Facet, Mesh};
use crate::math::Vector;
use crate::mesh::gmsh::{CellKind, GmshMesh};
use hashbrown::HashMap;

/// Differences of z, over the largest coordinate, that are rounding.
const ROUNDING: f64 = 1e-9;

impl<const D: usize, const N: usize> Mesh<D, N> {
    /// The triangles (2D) or tetrahedra (3D) of a physical group, or all of them; `unit` is the length of one
    /// unit of the file [m]. Physical groups of boundary facets become named sets. Nodes that no element of the file
    /// uses are left out, and kept as [`Mesh::isolated`].
    ///
    /// # Errors
    /// No such group or element; quadrilaterals; in 2D what does not lie in a plane z = const; whatever [`Mesh::new`]
    /// finds.
    pub fn from_gmsh(file: &GmshMesh, group: Option<&str>, unit: f64) -> Result<Self, String> {
        let cells = file.cells_of(group, D)?;
        let mut used: Vec<u32> = cells.iter().flat_map(|cell| cell.nodes()).copied().collect();
        used.sort_unstable();
        used.dedup();
        let index = |node: &u32| used.binary_search(node).ok().map(|place| place as u32);
        if D == 2 {
            planar(file, group, &used)?;
        }
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
            let own = cells.iter().map(|cell| ascending(cell.nodes().iter().filter_map(&index).collect()));
            // Facets with nodes that the elements don't use belong to parts of the file that were not chosen.
            let own: Vec<Vec<u32>> = own.filter(|nodes| nodes.len() == D).collect();
            let mut facets: Vec<Facet> = own.iter().filter_map(|nodes| known.get(nodes).copied()).collect();
            facets.sort_unstable();
            if own.len() > facets.len() {
                self.inner.insert(group.name.clone(), own.len() - facets.len());
            }
            if !facets.is_empty() {
                self.sets.insert(group.name.clone(), facets);
            }
        }
    }
}

/// The elements of a mesh in 2D lie in a plane z = const, up to rounding, and are not the skin of a solid.
fn planar(file: &GmshMesh, group: Option<&str>, used: &[u32]) -> Result<(), String> {
    let solid = file.cells.iter().find(|cell| cell.kind == CellKind::Tetrahedron);
    if let (Some(solid), None) = (solid, group) {
        let message = format!("the case is in 2D, but element {} of the file is a tetrahedron", solid.number);
        return Err(format!("{message}: write `dimension = 3`, or choose a plane surface by its `group`"));
    }
    let z = |node: u32| file.nodes[node as usize][2];
    let extent = used.iter().flat_map(|&node| file.nodes[node as usize]).fold(0.0, |most: f64, c| most.max(c.abs()));
    let first = used[0];
    let Some(&off) = used.iter().find(|&&node| (z(node) - z(first)).abs() > ROUNDING * extent) else { return Ok(()) };
    let numbers = [first, off].map(|node| file.numbers[node as usize]);
    Err(format!(
        "in 2D the mesh must lie in a plane z = const, but node {} has z = {} and node {} has z = {}: make it in x and y, \
         or write `dimension = 3` for a solid",
        numbers[0],
        z(first),
        numbers[1],
        z(off)
    ))
}
