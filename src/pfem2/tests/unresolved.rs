//! Velocities of particles relative to the mesh.

use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::particles::interpolate;
use crate::simulation::Solver;
use std::f64::consts::PI;

/// A box with slip walls, full of a fluid without viscosity.
fn boxed(cells: usize, start: impl Fn(Vector<2>) -> Vector<2> + Sync) -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap();
    let sets = vec![set(&mesh, "walls", Condition::Slip, |x| x.0.iter().any(|c| *c == 0.0 || *c == 1.0))];
    Pfem2::new(setup(mesh, sets, physics(vec![fluid("water", 1000.0, 0.0)], weightless()), |_| 0, start))
}

/// Speed of each particle relative to the mesh [m/s].
fn against_the_mesh(pfem: &Pfem2<2, 3>) -> Vec<f64> {
    let (mesh, particles) = (&pfem.system.mesh, &pfem.particles.columns);
    let of = |p: usize| {
        let e = particles.element[p] as usize;
        let nodes = mesh.elements()[e].map(|node| pfem.system.velocity[node as usize]);
        (particles.velocity[p] - interpolate(&mesh.shape_functions(e, particles.position[p]), &nodes)).norm()
    };
    (0..particles.len()).map(of).collect()
}

fn momentum(pfem: &Pfem2<2, 3>) -> Vector<2> {
    let of = |e: usize| {
        let own = pfem.particles.columns.of(e);
        let particle_volume = pfem.system.mesh.simplex(e).volume / own.len() as f64;
        own.map(|p| pfem.particles.columns.velocity[p]).sum::<Vector<2>>() * particle_volume
    };
    (0..pfem.system.mesh.elements().len()).map(of).sum()
}

fn energy(pfem: &Pfem2<2, 3>) -> f64 {
    let of = |e: usize| {
        let own = pfem.particles.columns.of(e);
        let particle_volume = pfem.system.mesh.simplex(e).volume / own.len() as f64;
        500.0 * particle_volume * own.map(|p| pfem.particles.columns.velocity[p].norm_squared()).sum::<f64>()
    };
    (0..pfem.system.mesh.elements().len()).map(of).sum()
}

/// The steady vortex of Euler's equations, sin πx cos πy, in long and short steps on a coarse mesh, for five turns of
/// its middle in long ones: next to what these lose, nothing is taken.
#[test]
fn the_bound_of_unresolved_velocities_leaves_a_vortex_unchanged() {
    let vortex = |x: Vector<2>| {
        let [(sx, cx), (sy, cy)] = x.0.map(|x| (PI * x).sin_cos());
        Vector([sx * cy, -cx * sy])
    };
    for dt in [0.1, 0.01] {
        let mut pfem = boxed(12, vortex);
        for k in 0..100 {
            pfem.step(f64::from(k) * dt, dt).unwrap();
        }
        let lost = pfem.balance.ledger.gained(&pfem.balance.totals, 0.0);
        let taken = pfem.particles.unresolved_energy;
        assert!(taken.abs() < 0.01 * lost.abs(), "{dt}: {taken} J where {lost} J are lost to the step and the mesh");
    }
}

/// Every fifth particle of a fluid at rest has a speed of 1 m/s, in turns to the left and to the right: the mesh sees
/// little of it. Momentum is kept, the energy that is taken is counted, and what is left is no more than what
/// neighbouring nodes show.
#[test]
fn unresolved_velocities_are_bounded_and_their_energy_is_counted() {
    let mut pfem = boxed(8, |_| Vector::ZERO);
    let sign = |p: usize| if p.is_multiple_of(10) { 1.0 } else { -1.0 };
    (0..pfem.particles.columns.len())
        .step_by(5)
        .for_each(|p| pfem.particles.columns.velocity[p] = Vector([sign(p), 0.0]));
    let (before, start) = (momentum(&pfem), energy(&pfem));
    let Pfem2 { system, particles, interface, .. } = &mut pfem;
    particles.bound_unresolved(system, interface.list.density());
    // The nodes are at rest.
    assert!(against_the_mesh(&pfem).iter().all(|u| *u < 0.2));
    assert!((momentum(&pfem) - before).norm() < 1e-14, "{:?}", momentum(&pfem) - before);
    let taken = start - energy(&pfem);
    assert!(
        taken > 0.9 * start && (pfem.particles.unresolved_energy / taken - 1.0).abs() < 1e-12,
        "{taken} of {start}, {}",
        pfem.particles.unresolved_energy
    );
}
