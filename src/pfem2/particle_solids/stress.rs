//! The rate law on the particles (Becker (8), (13)–(16); theory (K.1)–(K.3)).
//!
//! ```text
//! turn      σ̂'_p = Q σ'_p Qᵀ,   Q = (1 − ½Δt W)⁻¹ (1 + ½Δt W),   W = skew ∇vⁿ           theory (K.3)
//! deviator  σ'_p ← σ̂'_p + 2μΔt d',   d' = d − ⅓ tr d 1,   d = sym ∇vⁿ⁺¹                 Becker (15), theory (K.2)
//! pressure  p_p ← p_p + Σ N_i (p_i − p̂_i) / Σ N_i     over the nodes of the solid         theory (K.6)
//!           p_p ← p_p − κΔt tr d                      where an element has none          Becker (15)
//! ```
//!
//! The paper pushes forward with F, Becker (12), (16), which equals Q up to terms of the size of the strain increment;
//! Q leaves invariants of the stress what they are.

use super::columns::{ACCELERATION, PRESSURE, STRESS};
use super::solids::ParticleSolids;
use super::strain_rate::{deviatoric_rate, gradient};
use crate::material::rotation;
use crate::math::{SymTensor, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::particles::Particles;

/// Velocity and pressure at the end of a step, and the pressure that was projected at its start.
#[derive(Debug, Clone, Copy)]
pub struct SolvedFlow<'a, const D: usize> {
    /// The step Δt [s].
    pub dt: f64,
    /// vⁿ⁺¹ at the nodes [m/s].
    pub velocity: &'a [Vector<D>],
    /// pⁿ⁺¹ at the nodes [Pa].
    pub pressure: &'a [f64],
}

impl<const D: usize, const N: usize> ParticleSolids<D, N> {
    /// Turns the stress of the particles with the spin of the velocity `velocity` [m/s] over `dt` [s].
    pub fn rotate(&self, particles: &mut Particles<D>, mesh: &Mesh<D, N>, velocity: &[Vector<D>], dt: f64) {
        particles.change_column(STRESS, |stress, particles| {
            let stress: &mut [SymTensor] = bytemuck::cast_slice_mut(stress);
            parallel::change(stress, parallel::CHUNK, |p, stress| {
                if self.law_of(particles.phase[p]).is_some() {
                    let spin = gradient(mesh, particles.element[p] as usize, velocity).embed(0.0);
                    // Becker (16) with a rotation in place of the push forward, Becker (12); theory (K.3).
                    *stress = stress.rotated(&rotation(&spin, dt));
                }
            });
        });
    }

    /// Gives the particles the increments of stress and pressure of a step.
    pub fn update(&self, particles: &mut Particles<D>, mesh: &Mesh<D, N>, solved: &SolvedFlow<'_, D>) {
        particles.change_column(STRESS, |stress, particles| {
            let stress: &mut [SymTensor] = bytemuck::cast_slice_mut(stress);
            parallel::change(stress, parallel::CHUNK, |p, stress| {
                if let Some(law) = self.law_of(particles.phase[p]) {
                    let rate = deviatoric_rate(&gradient(mesh, particles.element[p] as usize, solved.velocity));
                    // Becker (15), the deviator of Becker (13) with the rate of Becker (8); theory (K.2).
                    *stress += rate * (2.0 * law.shear * solved.dt);
                }
            });
        });
        particles.change_column(PRESSURE, |pressure, particles| {
            parallel::change(pressure, parallel::CHUNK, |p, pressure| {
                *pressure = self.new_pressure(p, *pressure, particles, mesh, solved);
            });
        });
    }

    /// Keeps the acceleration of the particles of solids, Σ N_i δv_i/Δt, of the increments δv of the nodes by phase
    /// [m/s] in `dt` [s] (theory (K.7)).
    pub fn keep_acceleration(
        &self,
        particles: &mut Particles<D>,
        mesh: &Mesh<D, N>,
        increment: &[Vec<Vector<D>>],
        dt: f64,
    ) {
        particles.change_column(ACCELERATION, |acceleration, particles| {
            let acceleration: &mut [Vector<D>] = bytemuck::cast_slice_mut(acceleration);
            parallel::change(acceleration, parallel::CHUNK, |p, acceleration| {
                if self.law_of(particles.phase[p]).is_some() {
                    let e = particles.element[p] as usize;
                    let shape = mesh.shape_functions(e, particles.position[p]);
                    let nodes = mesh.elements()[e].iter().zip(&shape);
                    *acceleration =
                        nodes.map(|(&i, n)| increment[usize::from(particles.phase[p])][i as usize] * (n / dt)).sum();
                }
            });
        });
    }

    /// The pressure of a particle after a step [Pa], where it was `old`.
    fn new_pressure(
        &self,
        p: usize,
        old: f64,
        particles: &Particles<D>,
        mesh: &Mesh<D, N>,
        solved: &SolvedFlow<'_, D>,
    ) -> f64 {
        let e = particles.element[p] as usize;
        let nodes = mesh.elements()[e].map(|node| node as usize);
        let shape = mesh.shape_functions(e, particles.position[p]);
        let Some(law) = self.law_of(particles.phase[p]) else {
            // The pressure of the fluid's side; theory (K.6).
            let side = self.pressures_in(e, nodes.map(|i| solved.pressure[i]), false);
            return shape.iter().zip(side).map(|(n, p)| n * p).sum();
        };
        let (mut sum, mut weight) = (0.0, 0.0);
        for (n, i) in shape.iter().zip(nodes).filter(|(_, i)| self.nodal.solid[*i]) {
            sum += n * (solved.pressure[i] - self.nodal.pressure[i]);
            weight += n;
        }
        if weight > 0.0 {
            return old + sum / weight;
        }
        // Becker (15), Becker (21).
        old - law.bulk * solved.dt * gradient(mesh, e, solved.velocity).trace()
    }
}
