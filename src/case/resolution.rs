//! How finely the mesh of the fluid resolves solids: sizes of its elements, and how many lie across a solid.

use crate::mesh::{Location, Mesh, QuadraticMesh};
use crate::pfem2::solid::setup::SolidSetup;

/// Elements of the fluid's mesh across a solid on its way, where they are fewest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathResolution {
    /// The fewest elements of the mesh across it.
    pub cells: f64,
    /// The place where these are [m].
    pub place: [f64; 3],
    /// Its thickness there [m].
    pub thickness: f64,
    /// The largest displacement of its nodes [m].
    pub way: f64,
    /// Corners of the box around all that it sweeps in the mesh [m].
    pub swept: [[f64; 3]; 2],
}

/// A place or a side of a box in words.
pub(super) fn shown(place: [f64; 3], dimension: usize) -> String {
    place[..dimension]
        .iter()
        .map(|c| format!("{:.3}", if c.abs() < 5e-4 { 0.0 } else { *c }))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Sizes of the elements of a mesh, smooth in space: means at the nodes.
pub(super) struct MeshSizes {
    at_nodes: Vec<f64>,
}

impl MeshSizes {
    /// Sizes of a mesh.
    pub fn new<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Self {
        let mut sums = vec![(0.0, 0u32); mesh.nodes().len()];
        for (e, nodes) in mesh.elements().iter().enumerate() {
            let size = size_of(mesh, e);
            nodes.iter().for_each(|&node| {
                let (sum, count) = &mut sums[node as usize];
                (*sum, *count) = (*sum + size, *count + 1);
            });
        }
        Self { at_nodes: sums.into_iter().map(|(sum, count)| sum / f64::from(count)).collect() }
    }

    /// The size of elements about a place in the mesh [m].
    pub fn at<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>, place: &Location<N>) -> Option<f64> {
        let Location::Inside { element, shape } = place else { return None };
        Some(
            mesh.elements()[*element]
                .iter()
                .zip(shape)
                .map(|(&node, shape)| self.at_nodes[node as usize] * shape)
                .sum(),
        )
    }
}

/// The mesh of a solid, to measure.
pub(super) fn quadratic<const D: usize>(solid: &SolidSetup<D>) -> QuadraticMesh {
    QuadraticMesh {
        dimension: D,
        nodes: solid.mesh.nodes.iter().map(|x| x.to3()).collect(),
        elements: solid.mesh.elements.clone(),
        sets: Default::default(),
    }
}

/// The edge of a cube, in 2D a square, from which an element of a lattice would be cut: (D! V)^(1/D) [m].
pub(super) fn size_of<const D: usize, const N: usize>(mesh: &Mesh<D, N>, element: usize) -> f64 {
    let factorial: f64 = (1..=D).map(|k| k as f64).product();
    (factorial * mesh.simplex(element).volume).powf(1.0 / D as f64)
}
