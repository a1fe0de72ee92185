//! The elements of a physical group as the mesh of a membrane.

use super::{Cell, GmshMesh};
use crate::mesh::{Facets, FileNumbers};
use hashbrown::HashSet;
use std::collections::{BTreeMap, BTreeSet};

impl<const MOST_NODES: usize> GmshMesh<MOST_NODES> {
    /// The elements of one dimension that belong to a group, or all of them; each once.
    ///
    /// # Errors
    /// There is no such group (the message lists those there are), or no such element.
    pub fn cells_of(&self, group: Option<&str>, dimension: usize) -> Result<Vec<Cell<MOST_NODES>>, String> {
        let things = ["points", "lines", "surfaces", "volumes"][dimension.min(3)];
        let tags: Vec<i64> =
            self.groups.iter().filter(|g| g.dimension == dimension && group == Some(&g.name)).map(|g| g.tag).collect();
        if let (Some(name), true) = (group, tags.is_empty()) {
            return Err(match self.groups.iter().find(|g| g.name == name) {
                Some(other) => {
                    format!("the group `{name}` holds elements of dimension {}, not {things}", other.dimension)
                }
                None => format!("there is no physical group `{name}` of {things}; {}", self.list_groups(dimension)),
            });
        }
        let in_group = |cell: &Cell<MOST_NODES>| {
            group.is_none() || self.memberships[cell.membership as usize].iter().any(|t| tags.contains(t))
        };
        let mut seen = HashSet::new();
        let of_dimension = self.cells.iter().filter(|cell| cell.kind.dimension() == dimension);
        // Version 2.2 repeats an element for each of its groups.
        let cells: Vec<Cell<MOST_NODES>> =
            of_dimension.filter(|cell| in_group(cell) && seen.insert((cell.kind, cell.nodes))).copied().collect();
        if cells.is_empty() {
            return Err(format!("the file holds no {things}; {}", self.list_groups(dimension)));
        }
        Ok(cells)
    }

    /// Nodes that no element of a dimension uses, whatever its group, ascending.
    pub fn isolated(&self, dimension: usize) -> Vec<u32> {
        let mut used = vec![false; self.nodes.len()];
        let cells = self.cells.iter().filter(|cell| cell.kind.dimension() == dimension);
        cells.flat_map(Cell::nodes).for_each(|&node| used[node as usize] = true);
        (0u32..).zip(used).filter(|(_, used)| !used).map(|(node, _)| node).collect()
    }

    fn list_groups(&self, dimension: usize) -> String {
        let names: Vec<_> =
            self.groups.iter().filter(|g| g.dimension == dimension).map(|g| format!("`{}`", g.name)).collect();
        if names.is_empty() { "it has no such groups".into() } else { format!("its groups are {}", names.join(", ")) }
    }

    /// The surfaces (in 2D the lines) of a group, or all of them, as a membrane; `unit` is the length of one
    /// unit of the file [m]. Nodes that they don't use are left out. Every physical group that shares nodes
    /// with the membrane gives a set of nodes of its name.
    ///
    /// # Errors
    /// As [`GmshMesh::cells_of`]; or the mesh of a case in 2D leaves the plane z = 0.
    pub fn facets(&self, group: Option<&str>, dimension: usize, unit: f64) -> Result<Facets, String> {
        let cells = self.cells_of(group, dimension - 1)?;
        let mut used: Vec<u32> = cells.iter().flat_map(Cell::nodes).copied().collect();
        used.sort_unstable();
        used.dedup();
        let index = |node: &u32| used.binary_search(node).ok().map(|place| place as u32);
        let mut nodes: Vec<[f64; 3]> = used.iter().map(|&n| self.nodes[n as usize].map(|c| c * unit)).collect();
        if dimension == 2 {
            flatten(&mut nodes)?;
        }
        let elements = cells.iter().map(|cell| cell.nodes().iter().filter_map(index).collect()).collect();
        let sets = self.node_sets(&used);
        let numbers = FileNumbers {
            nodes: used.iter().map(|&n| self.numbers[n as usize]).collect(),
            elements: cells.iter().map(|cell| cell.number).collect(),
        };
        Ok(Facets { nodes, elements, sets, numbers })
    }
}

impl<const MOST_NODES: usize> GmshMesh<MOST_NODES> {
    /// The nodes of each physical group among those that are `used`, ascending, as places in that list; groups without
    /// any are left out.
    pub(in crate::mesh) fn node_sets(&self, used: &[u32]) -> BTreeMap<String, Vec<u32>> {
        let index = |node: &u32| used.binary_search(node).ok().map(|place| place as u32);
        self.node_sets_of(|cell| cell.nodes().iter().filter_map(index).collect())
    }

    /// The nodes of each physical group, ascending, with the nodes that `members` finds of each element; groups without
    /// any are left out.
    pub(in crate::mesh) fn node_sets_of(
        &self,
        members: impl Fn(&Cell<MOST_NODES>) -> Vec<u32>,
    ) -> BTreeMap<String, Vec<u32>> {
        let mut sets: BTreeMap<String, BTreeSet<u32>> = BTreeMap::new();
        for cell in &self.cells {
            for tag in &self.memberships[cell.membership as usize] {
                let named = |g: &&super::PhysicalGroup| g.dimension == cell.kind.dimension() && g.tag == *tag;
                let Some(group) = self.groups.iter().find(named) else { continue };
                let members = members(cell);
                if !members.is_empty() {
                    sets.entry(group.name.clone()).or_default().extend(members);
                }
            }
        }
        sets.into_iter().map(|(name, nodes)| (name, nodes.into_iter().collect())).collect()
    }
}

/// Rounding in the z of a plane mesh is removed; more than that is an error.
pub(in crate::mesh) fn flatten(nodes: &mut [[f64; 3]]) -> Result<(), String> {
    const ROUNDING: f64 = 1e-9;
    let extent = nodes.iter().flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
    if let Some([x, y, z]) = nodes.iter().find(|x| x[2].abs() > ROUNDING * extent) {
        return Err(format!("in 2D the mesh must lie in the plane z = 0, but it has a node at ({x}, {y}, {z})"));
    }
    nodes.iter_mut().for_each(|x| x[2] = 0.0);
    Ok(())
}
