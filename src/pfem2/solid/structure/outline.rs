//! The surfaces of solids as outputs see them: nodes, cells, and the traction of the fluid at the nodes (theory J.6).
//!
//! ```text
//! t_a = f_a/A_a,      A_a = ∫ N_a da over the deformed surface          f_a: force of the fluid on node a
//! ```
//!
//! A pressure that is the same everywhere is exact; at an edge or a corner t_a is the mean over the sides that meet
//! there.

use super::support::node_areas_at;
use crate::math::Vector;
use crate::pfem2::solid::mesh::{SolidFacet, SolidMesh};
use std::collections::BTreeSet;

/// The surface of a solid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SolidOutline {
    /// Name of the output.
    pub name: String,
    /// Nodes of the solid's mesh on the surface, ascending.
    pub nodes: Vec<u32>,
    /// Cells by their places in `nodes`: in 2D two segments to each facet, in 3D four quadrilaterals, seen from outside
    /// counter-clockwise.
    pub cells: Vec<Vec<u32>>,
}

impl SolidOutline {
    /// Outline of the solid `name`.
    pub fn new<const D: usize>(name: &str, mesh: &SolidMesh<D>) -> Self {
        let all: BTreeSet<u32> = mesh.facets.iter().flat_map(|facet| facet.nodes.iter().copied()).collect();
        let nodes: Vec<u32> = all.into_iter().collect();
        let place = |node: u32| nodes.binary_search(&node).unwrap_or(0) as u32;
        let pieces: &[&[usize]] = match D {
            2 => &[&[0, 1], &[1, 2]],
            _ => &[&[0, 1, 4, 3], &[1, 2, 5, 4], &[3, 4, 7, 6], &[4, 5, 8, 7]],
        };
        let of = |facet: &SolidFacet| -> Vec<Vec<u32>> {
            pieces.iter().map(|piece| piece.iter().map(|&a| place(facet.nodes[a])).collect()).collect()
        };
        let cells = mesh.facets.iter().flat_map(of).collect();
        Self { name: format!("{name}-surface"), nodes, cells }
    }

    /// Values of its nodes, of those of all nodes of the solid.
    pub fn gather<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.nodes.iter().map(|&node| values[node as usize]).collect()
    }

    /// Traction [Pa] at its nodes of forces on the nodes of the solid [N], which are at `positions` [m].
    pub fn tractions<const D: usize>(
        &self,
        mesh: &SolidMesh<D>,
        positions: &[Vector<D>],
        forces: &[Vector<D>],
    ) -> Vec<Vector<D>> {
        let mut areas = vec![0.0; positions.len()];
        for facet in &mesh.facets {
            node_areas_at(positions, &facet.nodes).into_iter().for_each(|(node, area)| areas[node as usize] += area);
        }
        self.nodes.iter().map(|&node| forces[node as usize] / areas[node as usize]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cells of a block lie on its sides and cover them once: ∮ x·n dA = 3 V with normals that point outwards.
    #[test]
    fn cells_enclose_the_solid() {
        let mesh = SolidMesh::<3>::block(Vector::ZERO, Vector([1.0, 2.0, 3.0]), [2, 1, 2]).unwrap();
        let outline = SolidOutline::new("block", &mesh);
        let places = outline.gather(&mesh.nodes);
        let volume: f64 = outline
            .cells
            .iter()
            .map(|cell| {
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| places[cell[k] as usize]);
                (c - a).cross(d - b).dot(a) / 6.0
            })
            .sum();
        assert!((volume - 6.0).abs() < 1e-12, "{volume}");
        assert_eq!((outline.nodes.len(), outline.cells.len()), (5 * 3 * 5 - 3 * 3, 4 * 16));
        assert_eq!(outline.name, "block-surface");
    }

    /// A pressure p on the deformed surface: t = −p n inside of the sides, whatever the lengths of the facets.
    #[test]
    fn an_even_pressure_is_a_traction_of_its_size() {
        let mesh = SolidMesh::<2>::block(Vector::ZERO, Vector([1.0, 1.0]), [2, 3]).unwrap();
        let positions: Vec<_> = mesh.nodes.iter().map(|x| Vector([2.0 * x[0], 0.5 * x[1]])).collect();
        let mut forces = vec![Vector::ZERO; positions.len()];
        for facet in &mesh.facets {
            let ends = [0, 2].map(|k| positions[facet.nodes[k] as usize]);
            let along = ends[1] - ends[0];
            // ∫ N_a n da of a straight facet: its area vector times 1/6, 4/6, 1/6.
            for (node, weight) in facet.nodes.iter().zip([1.0, 4.0, 1.0]) {
                forces[*node as usize] -= Vector([along[1], -along[0]]) * (50.0 * weight / 6.0);
            }
        }
        let outline = SolidOutline::new("block", &mesh);
        let places = outline.gather(&positions);
        for (x, t) in places.iter().zip(outline.tractions(&mesh, &positions, &forces)) {
            let right = x[0] == 2.0 && x[1] > 0.0 && x[1] < 0.5;
            let top = x[1] == 0.5 && x[0] > 0.0 && x[0] < 2.0;
            let expected = if right { Vector([-50.0, 0.0]) } else { Vector([0.0, -50.0]) };
            assert!(!(right || top) || (t - expected).norm() < 1e-11, "{x:?} {t:?}");
        }
    }
}
