//! Velocities of particles that the mesh can't resolve (theory (F.37)).
//!
//! Particles keep their velocity relative to the mesh, as increments never damp it. Where a jet meets slow fluid, or a
//! splash falls back, fast and slow particles come to stand in one element; the mesh sees their mean, and the
//! difference would stay for hundreds of steps. The velocity of a particle relative to the mesh is bounded by the
//! differences between neighbouring nodes:
//!
//! ```text
//! u_p = v_p − Σ_i N_i(x_p) v_i,        b_p = Σ_i N_i(x_p) max_k |v_k − v_i|,   k: nodes of the elements around i
//! v_p ← v_p − (1 − min(1, b_p/|u_p|)) u_p + c_e,        Σ_{p in e} m_p (change of v_p) = 0 gives c_e
//! ```
//!
//! No momentum comes or goes. In a smooth flow u is of second order in the edge h, and b of first: vortices and waves
//! are left alone. The energy that the bound takes, Σ ½ m_p (|v_p|² before − after), is one that the ledger of the mesh
//! doesn't know; it is counted apart.

use super::Unresolved;
use super::particles::ParticleTracking;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::interpolate_nodal;

/// Part of the largest speed that is round-off.
const ROUND_OFF: f64 = 1e-9;

/// An element whose particles are changed: their velocities, and the energy that is taken.
struct BoundedElement<const D: usize> {
    element: usize,
    velocity: Vec<Vector<D>>,
    /// Kinetic energy that the bound takes [J].
    energy: f64,
}

impl<const D: usize> ParticleTracking<D> {
    /// Bounds the velocity of particles relative to the mesh; that of fluids that follow their side of the
    /// interface is larger.
    pub(in crate::pfem2) fn bound_unresolved<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        density: &[f64],
    ) {
        if self.rules.unresolved == Unresolved::Kept || self.rules.has_projectiles() {
            return;
        }
        let differences = differences(system);
        let elements = system.mesh.elements().len();
        let bounded = |e: usize| bounded(&self.columns, system, density, &differences, e);
        let changes = parallel::collect_some(elements, 256, bounded);
        for BoundedElement { element, velocity, energy } in changes {
            let own = self.columns.of(element);
            self.columns.velocity[own].copy_from_slice(&velocity);
            self.unresolved_energy += energy;
        }
    }
}

/// The largest difference between the velocity of each node and of those around it [m/s].
fn differences<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>) -> Vec<f64> {
    let VelocityPressureSystem { mesh, velocity, .. } = system;
    let fastest = parallel::max(velocity.len(), |node| velocity[node].norm());
    let of = |node: usize| {
        let around = mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]);
        around.fold(ROUND_OFF * fastest, |most: f64, k| most.max((velocity[k as usize] - velocity[node]).norm()))
    };
    parallel::collect(velocity.len(), 256, of)
}

/// The particles of an element after the bound, if it changes one.
fn bounded<const D: usize, const N: usize>(
    particles: &Particles<D>,
    system: &VelocityPressureSystem<D, N>,
    density: &[f64],
    differences: &[f64],
    element: usize,
) -> Option<BoundedElement<D>> {
    let VelocityPressureSystem { mesh, velocity, .. } = system;
    let nodes = &mesh.elements()[element];
    let cut = |p: usize| {
        let shape = mesh.shape_functions(element, particles.position[p]);
        let u = particles.velocity[p] - interpolate_nodal(&shape, nodes, velocity);
        let bound = nodes.iter().zip(shape).map(|(&i, n)| n * differences[i as usize]).sum::<f64>();
        let size = u.norm();
        if size > bound { u * (1.0 - bound / size) } else { Vector::ZERO }
    };
    let own = particles.of(element);
    if own.clone().all(|p| cut(p) == Vector::ZERO) {
        return None;
    }
    let cuts: Vec<Vector<D>> = own.clone().map(cut).collect();
    let density = |p: usize| density[usize::from(particles.phase[p])];
    let mass: f64 = own.clone().map(density).sum();
    let back = own.clone().zip(&cuts).map(|(p, cut)| *cut * density(p)).sum::<Vector<D>>() / mass;
    let bounded: Vec<Vector<D>> = own.clone().zip(cuts).map(|(p, cut)| particles.velocity[p] - cut + back).collect();
    let lost = |(p, v): (usize, &Vector<D>)| density(p) * (particles.velocity[p].norm_squared() - v.norm_squared());
    let particle_volume = system.fluid_volume(element) / own.len() as f64;
    let energy = 0.5 * particle_volume * own.zip(&bounded).map(lost).sum::<f64>();
    Some(BoundedElement { element, velocity: bounded, energy })
}
