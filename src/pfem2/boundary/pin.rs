//! The node at which the pressure of a closed box is held: velocities follow from its differences alone (theory F.9).

use crate::math::{Signal, Vector};
use crate::mesh::Mesh;

/// A node whose pressure is held.
#[derive(Debug, Clone)]
pub struct Pin {
    /// The node.
    pub node: u32,
    /// Pressure at the place [Pa].
    pub value: Signal,
}

/// A place whose pressure is to be held.
#[derive(Debug, Clone)]
pub struct PressurePin<const D: usize> {
    /// The place [m]; the nearest node is taken.
    pub at: Vector<D>,
    /// Pressure at the node [Pa].
    pub value: Signal,
}

impl Pin {
    /// No pressure at the boundary node that lies highest against gravity; of several at the first.
    pub fn highest<const D: usize, const N: usize>(mesh: &Mesh<D, N>, gravity: Vector<D>) -> Self {
        let nodes = mesh.boundary().iter().flat_map(|&facet| mesh.facet_nodes(facet));
        let depth = |node: &u32| gravity.dot(mesh.nodes()[*node as usize]);
        let node = nodes.min_by(|a, b| depth(a).total_cmp(&depth(b)).then(a.cmp(b))).unwrap_or(0);
        Self { node, value: Signal::ZERO }
    }
}

impl<const D: usize> PressurePin<D> {
    /// The nearest node, the first of several.
    pub fn held<const N: usize>(&self, mesh: &Mesh<D, N>) -> Pin {
        let distance = |node: &u32| (mesh.nodes()[*node as usize] - self.at).norm_squared();
        let nodes = 0..mesh.nodes().len() as u32;
        let node = nodes.min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b))).unwrap_or(0);
        Pin { node, value: self.value.clone() }
    }
}
