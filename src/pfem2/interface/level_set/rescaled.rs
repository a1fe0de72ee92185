//! The distance that a stretched level set stands for, without moving its zero line (theory (G.5)).
//!
//! ```text
//! node of elements where φ vanishes   D_i = φ_i ⟨1/|∇φ_e|⟩             mean over these, by volume
//! node beside such nodes k            D_i = ⟨D_k + (x_i − x_k)·n_e⟩    mean over shared elements, n_e = ∇φ_e/|∇φ_e|
//! ```
//!
//! An interface stretches what lies on both sides of it differently, and the mesh bends φ at its nodes. Each element
//! straightens its part of the way, so that a plane line keeps its place whatever slopes φ has beside it, and a
//! curve keeps what its polygon cuts off. One mean slope for a whole neighbourhood doesn't: it moved the line by 2 % of
//! the way it had gone since the last measurement. Late by five steps on average, that fed waves: those of 40 elements
//! had 2.4 times their energy after ten periods.

use super::LevelSet;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;

/// Rows of elements beside these.
const ROWS: usize = 4;

impl LevelSet {
    /// D at the nodes near the interface [m]; elsewhere `None`.
    pub(super) fn straightened<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>) -> Vec<Option<f64>> {
        let mut known = each(mesh, |node| self.across(mesh, node));
        for _ in 0..ROWS {
            known = each(mesh, |node| known[node].or_else(|| self.onward(mesh, node, &known)));
        }
        known
    }

    /// D at a node of elements where φ vanishes.
    fn across<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>, node: usize) -> Option<f64> {
        let (mut sum, mut volume) = (0.0, 0.0);
        for element in mesh.elements_around(node).iter().map(|&e| e as usize) {
            let own = mesh.elements()[element].map(|i| self.level[i as usize]);
            let (slope, weight) = (self.gradient(mesh, element), mesh.simplex(element).volume);
            if own.iter().any(|phi| *phi <= 0.0) && own.iter().any(|phi| *phi >= 0.0) && slope != Vector::ZERO {
                sum += weight / slope.norm();
                volume += weight;
            }
        }
        (volume > 0.0).then(|| self.level[node] * sum / volume)
    }

    /// D at a node from known ones in its elements, where φ isn't flat.
    fn onward<const D: usize, const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        node: usize,
        known: &[Option<f64>],
    ) -> Option<f64> {
        let (mut sum, mut weight) = (0.0, 0.0);
        for element in mesh.elements_around(node).iter().map(|&e| e as usize) {
            let others = || mesh.elements()[element].iter().filter_map(|&k| Some((k as usize, known[k as usize]?)));
            if others().next().is_none() {
                continue;
            }
            let (slope, own) = (self.gradient(mesh, element), mesh.simplex(element).volume);
            if slope == Vector::ZERO {
                continue;
            }
            for (other, from) in others() {
                let way = mesh.nodes()[node] - mesh.nodes()[other];
                sum += own * (from + way.dot(slope) / slope.norm());
                weight += own;
            }
        }
        (weight > 0.0).then(|| sum / weight)
    }

    /// ∇φ in an element.
    pub(super) fn gradient<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>, element: usize) -> Vector<D> {
        let nodes = mesh.elements()[element].iter().zip(&mesh.simplex(element).gradient);
        nodes.map(|(&node, &g)| g * self.level[node as usize]).sum()
    }
}

fn each<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    at: impl Fn(usize) -> Option<f64> + Sync,
) -> Vec<Option<f64>> {
    parallel::collect(mesh.nodes().len(), 256, at)
}
