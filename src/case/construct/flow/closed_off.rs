//! Fluid that solids close off from every opening.

use super::super::Construction;
use super::mesh::at;
use super::solids::{InitialSolid, solid_at};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::boundary::BoundarySetup;

/// An element in a solid.
const SOLID: usize = usize::MAX;

/// Parts of fewer elements are corners and films.
const FEWEST: usize = 10;

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
        let mut elements = vec![Vec::new(); count];
        (0..part.len()).filter(|&e| part[e] != SOLID).for_each(|e| elements[part[e]].push(e));
        let large: Vec<(usize, Vec<usize>)> =
            elements.into_iter().enumerate().filter(|(_, own)| own.len() >= FEWEST).collect();
        if large.len() < 2 {
            return;
        }
        let mut open = vec![false; count];
        for set in sets.iter().filter(|set| set.condition.kind().has_free_flux()) {
            for facet in &set.facets {
                if let Some(open) = open.get_mut(part[facet.element as usize]) {
                    *open = true;
                }
            }
        }
        // Of a closed box the largest part is the one that the walls close off.
        let is_box_open = large.iter().any(|(k, _)| open[*k]);
        let largest = large.iter().map(|(_, own)| own.len()).max().unwrap_or(0);
        let is_closed = |k: usize, own: &[usize]| !open[k] && (is_box_open || own.len() < largest);
        for (_, own) in large.iter().filter(|(k, own)| is_closed(*k, own)) {
            let center = own.iter().map(|&e| mesh.center(e)).sum::<Vector<D>>() / own.len() as f64;
            self.notes.push(format!(
                "solids close off the fluid around ({}): it is incompressible, and nothing changes its volume",
                at(center)
            ));
        }
    }
}

/// The part of the fluid to which each element belongs, and the number of parts: those with a node in common that lies in
/// no solid are of one.
fn parts<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    is_solid: impl Fn(Vector<D>) -> bool,
) -> (Vec<usize>, usize) {
    const NEW: usize = usize::MAX - 1;
    let mut part: Vec<usize> =
        (0..mesh.elements().len()).map(|e| if is_solid(mesh.center(e)) { SOLID } else { NEW }).collect();
    let is_open: Vec<bool> = mesh.nodes().iter().map(|&x| !is_solid(x)).collect();
    let mut count = 0;
    for first in 0..part.len() {
        if part[first] != NEW {
            continue;
        }
        part[first] = count;
        let mut reached = vec![first];
        while let Some(element) = reached.pop() {
            let nodes = mesh.elements()[element].map(|node| node as usize).into_iter().filter(|&node| is_open[node]);
            for other in nodes.flat_map(|node| mesh.elements_around(node)).map(|&e| e as usize) {
                if part[other] == NEW {
                    part[other] = count;
                    reached.push(other);
                }
            }
        }
        count += 1;
    }
    (part, count)
}
