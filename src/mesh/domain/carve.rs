//! Boxes cut out of a lattice of tetrahedra whose planes pass through their sides.

use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use std::collections::BTreeSet;

/// A box to cut out: lower and upper corner [m].
pub type CutBox = [[f64; 3]; 2];

/// The planes through the sides of the blocks that lie between two corners, along each axis, ascending [m].
pub fn planes(blocks: &[CutBox], lower: [f64; 3], upper: [f64; 3]) -> [Vec<f64>; 3] {
    std::array::from_fn(|axis| {
        let sides = blocks.iter().flatten().map(|corner| corner[axis]);
        let mut inside: Vec<f64> = sides.filter(|&x| x > lower[axis] && x < upper[axis]).collect();
        inside.sort_unstable_by(f64::total_cmp);
        inside.dedup();
        inside
    })
}

/// The lattice without the elements in the blocks. The sides of the box keep their names, those of block k have
/// the name `names[k]`. `ends`: lower and upper end of the box along each axis [m].
///
/// # Errors
/// No element is left, or the remaining elements make no mesh.
pub fn carve(
    lattice: &Mesh<3, 4>,
    ends: [[f64; 2]; 3],
    blocks: &[CutBox],
    names: &[&str],
) -> Result<Mesh<3, 4>, String> {
    let within = |block: &CutBox, x: Vector<3>, room: f64| {
        (0..3).all(|i| x[i] >= block[0][i] - room && x[i] <= block[1][i] + room)
    };
    let kept = (0..lattice.elements().len()).filter(|&e| !blocks.iter().any(|b| within(b, lattice.center(e), 0.0)));
    let mut number = vec![u32::MAX; lattice.nodes().len()];
    let mut nodes = Vec::new();
    let mut renumbered = |node: u32| {
        let own = &mut number[node as usize];
        if *own == u32::MAX {
            *own = nodes.len() as u32;
            nodes.push(lattice.nodes()[node as usize]);
        }
        *own
    };
    let elements: Vec<[u32; 4]> = kept.map(|e| lattice.elements()[e].map(&mut renumbered)).collect();
    let mut mesh = Mesh::new(nodes, elements)?;
    mesh.name_sides(ends);
    let named: BTreeSet<Facet> = mesh.sets.values().flatten().copied().collect();
    let bare: Vec<Facet> = mesh.boundary().iter().filter(|facet| !named.contains(facet)).copied().collect();
    for facet in bare {
        let corners = mesh.facet_nodes(facet);
        let middle = corners.iter().map(|&n| mesh.nodes()[n as usize]).sum::<Vector<3>>() / corners.len() as f64;
        let room = 1e-9 * mesh.facet_area(facet).norm().sqrt();
        if let Some(hole) = blocks.iter().position(|block| within(block, middle, room)) {
            mesh.sets.entry(names[hole].to_owned()).or_default().push(facet);
        }
    }
    Ok(mesh)
}
