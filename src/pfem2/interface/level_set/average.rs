//! The average of the depths of particles at the nodes: the sharp level set (theory G.2).
//!
//! ```text
//! P f    = Σ_e w [R_k + G_e (x_k Σ_k − Σ_l S_kl x_l)] / Σ_e w Σ_k,   R_k = Σ_p N_k f_p               theory (G.3)
//! φ_k    = P (s d) + r_k P (s d − Σ_l N_l (P s d)_l)                                                 theory (G.3a)
//! w      = V_e/n_e (ρ/ρ_light)^r_k,   r_k = max(0, 1 − 20 (1 − R²))                                   theory (G.3b)
//! ```
//!
//! with the part R² of the variance of s d around node k that a linear field explains. Weighed with their mass,
//! particles move the interface with the velocity by which it works on the heavy fluid: with equal weights, waves on a
//! line of the mesh gain energy from the light one. In a film or a drop, where no plane fits, all weigh the same.

use super::LevelSet;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::project::gradient::LinearFit;
use crate::pfem2::particles::project::moments::{GroupMoments, MomentTable};

/// How fast r falls with the part of the variance that isn't explained.
const NOT_PLANAR: f64 = 20.0;

impl LevelSet {
    /// φ [m] at the nodes from the depths of the particles. Nodes whose particles are all deeper than the band take ±
    /// the band; nodes without particles keep φ, `before` [m].
    pub(super) fn average<const D: usize, const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        particles: &Particles<D>,
        before: &[f64],
    ) -> Vec<f64> {
        let near = self.near(mesh, particles);
        let table = self.depths(mesh, particles, &near);
        let mut linear = table.clone();
        let planar: Vec<f64> = linear.make_linear_together(mesh).iter().map(planarity).collect();
        let weights: Vec<[f64; 2]> = planar.iter().map(|&planar| self.weights(planar)).collect();
        let first = means(mesh, &linear, &weights);
        let mut rest = table;
        rest.subtract(mesh, |_, node| Vector([first[node].unwrap_or(0.0), 0.0]));
        rest.make_linear_together(mesh);
        let second = means(mesh, &rest, &weights);
        let level = |node: usize| {
            let around = mesh.elements_around(node).iter().map(|&e| e as usize);
            if !around.clone().any(|e| near[e]) {
                let fluid = around.flat_map(|e| particles.of(e)).next().map(|p| particles.phase[p]);
                return fluid.map_or(before[node], |fluid| self.sign(fluid) * self.band);
            }
            let mean = first[node].zip(second[node]).map(|(first, second)| first + planar[node] * second);
            mean.map_or(before[node], |mean| mean.clamp(-self.band, self.band))
        };
        parallel::collect(mesh.nodes().len(), 256, level)
    }

    /// Moments of ± the depths and of their squares, of each fluid, in the elements that are `near` the interface.
    fn depths<const D: usize, const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        particles: &Particles<D>,
        near: &[bool],
    ) -> MomentTable<2, N> {
        MomentTable::collect(mesh.elements().len(), |e, entries| {
            let own = particles.of(e);
            if !near[e] || own.is_empty() {
                return;
            }
            let count = own.len();
            let mut p = own.start;
            for run in particles.phase[own].chunk_by(|a, b| a == b) {
                let mut moments = GroupMoments::new(run[0]);
                for &fluid in run {
                    let phi = self.sign(fluid) * particles.depth[p].min(self.band);
                    moments.add(&mesh.shape_functions(e, particles.position[p]), Vector([phi, phi * phi]));
                    p += 1;
                }
                entries.put(&moments);
            }
            entries.weigh(mesh.simplex(e).volume / count as f64);
        })
    }

    /// What a volume of each fluid weighs in the average at a node, over that of the lighter one.
    fn weights(&self, planar: f64) -> [f64; 2] {
        let lighter = self.density[0].min(self.density[1]);
        self.density.map(|density| (density / lighter).powf(planar))
    }

    /// Elements around nodes whose particles are not all deep in one fluid.
    fn near<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>, particles: &Particles<D>) -> Vec<bool> {
        let elements = mesh.elements().len();
        let shallow = |e: usize| {
            let own = particles.of(e);
            let mixed = particles.phase[own.clone()].windows(2).any(|pair| pair[0] != pair[1]);
            mixed || particles.depth[own].iter().any(|&depth| depth < 0.99 * self.band)
        };
        let shallow = parallel::collect(elements, 256, shallow);
        let node = |node: usize| {
            let around = mesh.elements_around(node);
            let fluids = || around.iter().filter_map(|&e| particles.of(e as usize).next()).map(|p| particles.phase[p]);
            around.iter().any(|&e| shallow[e as usize]) || fluids().any(|fluid| Some(fluid) != fluids().next())
        };
        let node = parallel::collect(mesh.nodes().len(), 256, node);
        parallel::collect(elements, parallel::CHUNK, |e| mesh.elements()[e].iter().any(|&n| node[n as usize]))
    }
}

/// r: one where a linear field fits the depths, zero where it leaves a twentieth of their variance or more.
fn planarity<const D: usize>(fit: &Option<LinearFit<2, D>>) -> f64 {
    let Some(LinearFit { mean, explained, .. }) = fit else { return 0.0 };
    let variance = mean[1] - mean[0] * mean[0];
    if variance > 0.0 { (1.0 - NOT_PLANAR * (1.0 - explained[0] / variance)).clamp(0.0, 1.0) } else { 0.0 }
}

/// The average at each node; `None` at those that no particle is near.
fn means<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    table: &MomentTable<2, N>,
    weights: &[[f64; 2]],
) -> Vec<Option<f64>> {
    let mean = |node: usize| {
        let (mut sum, mut weight) = (0.0, 0.0);
        for e in mesh.elements_around(node).iter().map(|&e| e as usize) {
            let k = mesh.elements()[e].iter().position(|&n| n as usize == node).unwrap_or(0);
            for entry in table.of(e) {
                let own = weights[node][usize::from(entry.group)] * entry.weight;
                sum += own * entry.values[k][0];
                weight += own * entry.sum(k);
            }
        }
        (weight > 0.0).then(|| sum / weight)
    };
    parallel::collect(mesh.nodes().len(), 256, mean)
}
