//! Fluid that solids close off from every opening.

use super::super::Construction;
use super::mesh::at;
use super::solids::{InitialSolid, solid_at};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::boundary::{BoundaryKind, BoundarySetup};

/// A node in a solid.
const SOLID: usize = usize::MAX;

impl Construction<'_> {
    /// Notes where solids close off a part of the fluid that nothing opens: fluids are incompressible, and motions that
    /// would change its volume are none, as the first mode of a strip between two chambers.
    pub(super) fn closed_off<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        sets: &[BoundarySetup<D>],
        solids: &[InitialSolid<D>],
    ) {
        if solids.is_empty() {
            return;
        }
        let (part, count) = parts(mesh, |x| solid_at(solids, x).is_some());
        if count < 2 {
            return;
        }
        let mut open = vec![false; count];
        for set in sets.iter().filter(|set| set.condition.kind() == BoundaryKind::Outlet) {
            for node in set.facets.iter().flat_map(|&facet| mesh.facet_nodes(facet)) {
                if let Some(open) = open.get_mut(part[node as usize]) {
                    *open = true;
                }
            }
        }
        for closed in (0..count).filter(|&closed| !open[closed]) {
            let nodes: Vec<Vector<D>> =
                mesh.nodes().iter().zip(&part).filter(|(_, own)| **own == closed).map(|(x, _)| *x).collect();
            let center = nodes.iter().copied().sum::<Vector<D>>() / nodes.len() as f64;
            self.notes.push(format!(
                "solids close off the fluid around ({}): it is incompressible, and nothing changes its volume",
                at(center)
            ));
        }
    }
}

/// The part of the fluid to which each node belongs, and the number of parts; nodes that share an element are of one.
fn parts<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    is_solid: impl Fn(Vector<D>) -> bool,
) -> (Vec<usize>, usize) {
    const NEW: usize = usize::MAX - 1;
    let mut part: Vec<usize> = mesh.nodes().iter().map(|&x| if is_solid(x) { SOLID } else { NEW }).collect();
    let mut count = 0;
    for first in 0..part.len() {
        // Nodes that no element uses are no fluid.
        if part[first] != NEW || mesh.elements_around(first).is_empty() {
            continue;
        }
        part[first] = count;
        let mut reached = vec![first];
        while let Some(node) = reached.pop() {
            for other in mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]) {
                if part[other as usize] == NEW {
                    part[other as usize] = count;
                    reached.push(other as usize);
                }
            }
        }
        count += 1;
    }
    (part, count)
}
