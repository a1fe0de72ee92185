//! Stage `correct`: particles take over what the implicit step changed (Becker (40); theory F.11),
//!
//! ```text
//! v_p ← (1 − α)(v_p + Σ N_i δv_i) + α Σ N_i v_i,   δv_i = v_i − v̂_αi,   α = 1 − e^(−dt/T)        theory (F.36)
//! ```
//!
//! with the mean v̂_αi of the fluid of the particle at the node (theory G.11). With that of all, light particles would
//! keep for ever what they have against the heavy ones beside them: by mass the mean is that of the heavy fluid. No
//! momentum comes or goes, Σ_p m_p Σ_i N_i δv_i = Σ_i m_i (v_i − v̂_i); what the fluids have against each other at a
//! node that both reach is lost, as the mesh has one velocity for both.
//!
//! Keeping increments (α = 0, as the paper) never damps what the particles of an element have against each other, of
//! which the mesh knows nothing. The small fraction α of the mesh velocity removes it within the time T, whatever the
//! step; what it takes from resolved motion is a viscosity of about h²/10T.
//!
//! Projectiles, heavy particles in a light fluid (Becker (36); theory G.13), take the increments of their side of the
//! interface; those without a heavy node in reach fall, δv = b dt (1 − ρ_light/ρ_heavy), with the body force b where
//! they are.

use super::convect::{Continued, Projectiles};
use super::{Particles, interpolate_nodal};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;

/// Particles per parallel task.
const TASK: usize = 1024;

/// Increments and velocities of the nodes that the particles receive.
#[derive(Debug, Clone, Copy)]
pub struct Correction<'a, const D: usize> {
    /// Increment of the nodes for the particles of each fluid, v_i − v̂_αi [m/s].
    pub increment: &'a [&'a [Vector<D>]],
    /// Velocity of the nodes after the step, v_i [m/s].
    pub velocity: &'a [Vector<D>],
    /// The fraction α of the mesh velocity.
    pub filter: f64,
    /// The correction of projectiles, if a fluid has any.
    pub projectiles: Option<ProjectileCorrection<'a, D>>,
}

/// Correction of projectiles.
#[derive(Debug, Clone, Copy)]
pub struct ProjectileCorrection<'a, const D: usize> {
    /// The projectile rule: the fluids that it holds for, and the body force on them.
    pub rule: Projectiles<'a, D>,
    /// Time for which projectiles fall in the step, less what buoyancy takes of it, dt (1 − ρ_l/ρ_h) [s].
    pub fall_time: f64,
}

/// The fraction of the mesh velocity that removes noise within the time `relaxation` [s]: 1 − e^(−dt/T).
pub fn filter(dt: f64, relaxation: f64) -> f64 {
    -(-dt / relaxation).exp_m1()
}

/// Increments and velocities that heavy particles receive.
struct Heavy<'a, const D: usize> {
    /// Increments by fluid; none of a fluid that is no projectile.
    increment: Vec<Option<Continued<D>>>,
    velocity: Continued<D>,
    projectiles: ProjectileCorrection<'a, D>,
}

impl<const D: usize> Particles<D> {
    /// Corrects the velocities of all particles.
    pub fn correct<const N: usize>(&mut self, mesh: &Mesh<D, N>, correction: &Correction<D>) {
        let &Correction { increment, velocity, filter, projectiles } = correction;
        let heavy = projectiles.map(|projectiles @ ProjectileCorrection { rule, .. }| Heavy {
            increment: (rule.fluids.iter().zip(increment))
                .map(|(&is_projectile, own)| is_projectile.then(|| Continued::new(mesh, own, rule.level)))
                .collect(),
            velocity: Continued::new(mesh, velocity, rule.level),
            projectiles,
        });
        let Self { position, velocity: v, phase, element, .. } = self;
        parallel::change(v, TASK, |p, v| {
            let e = element[p] as usize;
            let nodes = &mesh.elements()[e];
            let shape = mesh.shape_functions(e, position[p]);
            let blend = |increment: &[Vector<D>], velocity: &[Vector<D>]| {
                // Becker (40).
                let kept = *v + interpolate_nodal(&shape, nodes, increment);
                kept + (interpolate_nodal(&shape, nodes, velocity) - kept) * filter
            };
            let own = phase[p] as usize;
            *v = match heavy.as_ref().and_then(|heavy| Some((heavy, heavy.increment[own].as_ref()?))) {
                Some((heavy, increment)) if increment.reaches(nodes) => {
                    blend(&increment.values, &heavy.velocity.values)
                }
                // Theory (G.28).
                Some((heavy, _)) => {
                    *v + heavy.projectiles.rule.body_force_at(&shape, nodes) * heavy.projectiles.fall_time
                }
                None => blend(increment[own], velocity),
            };
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pfem2::particles::project::{AveragingKernel, project};

    #[test]
    fn increments_are_added_and_unresolved_velocities_decay_within_the_relaxation_time() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [6; 2]).unwrap();
        let rough = |x: Vector<2>| Vector([x[0] + (9e4 * x[0]).sin(), (9e4 * x[1]).sin()]);
        let mut particles = Particles::seed(&mesh, 5, |_| Some(0), rough);
        let still = vec![Vector::ZERO; mesh.nodes().len()];
        let seen = |particles: &Particles<2>| {
            project(&mesh, particles, &[1.0], AveragingKernel::Linear, &still, &|e| mesh.simplex(e).volume)
                .velocity
                .mean
        };
        let unseen = |particles: &Particles<2>| {
            let nodal = seen(particles);
            let square = |p: usize| {
                let e = particles.element[p] as usize;
                let shape = mesh.shape_functions(e, particles.position[p]);
                (particles.velocity[p] - interpolate_nodal(&shape, &mesh.elements()[e], &nodal)).norm_squared()
            };
            (0..particles.len()).map(square).sum::<f64>().sqrt()
        };
        let mean = |particles: &Particles<2>| particles.velocity.iter().copied().sum::<Vector<2>>();
        let (start, before) = (unseen(&particles), mean(&particles));
        let (step, steps, relaxation) = (Vector([0.01, -0.02]), 40, 2.0);
        for _ in 0..steps {
            let old = seen(&particles);
            let velocity: Vec<_> = old.iter().map(|&v| v + step).collect();
            let filter = filter(0.1, relaxation);
            let increment = vec![step; old.len()];
            particles.correct(
                &mesh,
                &Correction { increment: &[&increment], velocity: &velocity, filter, projectiles: None },
            );
        }
        let left = unseen(&particles) / start;
        assert!((left / f64::exp(-2.0) - 1.0).abs() < 0.1, "{left}");
        let gained = (mean(&particles) - before) / (particles.len() * steps) as f64;
        assert!((gained - step).norm() < 0.05 * step.norm(), "{gained:?}");
    }

    /// Air at speed 1 over water at rest, no forces: at the nodes that both reach the air comes to rest, and
    /// the momentum of all particles stays what it was.
    #[test]
    fn light_particles_take_the_velocity_of_the_heavy_ones_beside_them() {
        const DENSITY: [f64; 2] = [1000.0, 1.0];
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [6; 2]).unwrap();
        let fluid = |x: Vector<2>| u8::from(x[1] + 0.2 * x[0] > 0.613);
        let mut particles = Particles::seed(&mesh, 5, |x| Some(fluid(x)), |x| Vector([f64::from(fluid(x)), 0.0]));
        let still = vec![Vector::ZERO; mesh.nodes().len()];
        let momentum = |particles: &Particles<2>| {
            let of = |e: usize| {
                let (own, volume) = (particles.of(e), mesh.simplex(e).volume);
                let particle_volume = volume / own.len() as f64;
                own.map(|p| particles.velocity[p] * (particle_volume * DENSITY[particles.phase[p] as usize]))
                    .sum::<Vector<2>>()
            };
            (0..mesh.elements().len()).map(of).sum::<Vector<2>>()
        };
        let start = momentum(&particles);
        for _ in 0..30 {
            let hat =
                project(&mesh, &particles, &DENSITY, AveragingKernel::Linear, &still, &|e| mesh.simplex(e).volume)
                    .velocity;
            let missing = hat.increments(&hat.mean, 2);
            let increment = [&missing[0][..], &missing[1]];
            let correction = Correction { increment: &increment, velocity: &hat.mean, filter: 0.0, projectiles: None };
            particles.correct(&mesh, &correction);
        }
        assert!((momentum(&particles) - start).norm() < 1e-12 * start.norm());
        let projected =
            project(&mesh, &particles, &DENSITY, AveragingKernel::Linear, &still, &|e| mesh.simplex(e).volume);
        for (node, fraction) in projected.fraction[0].iter().enumerate() {
            let air = projected.velocity.own[1][node][0];
            assert!(!(0.1..0.9).contains(fraction) || air.abs() < 0.05, "{fraction} {air}");
        }
        let far = particles.position.iter().zip(&particles.velocity).filter(|(x, _)| x[1] > 5.0 / 6.0);
        assert!(far.clone().count() > 100 && far.clone().all(|(_, v)| *v == Vector([1.0, 0.0])));
    }
}
