//! Sub-cells, channels and crowds; mirrors.

use super::*;
use crate::mesh::CellCut;
use crate::pfem2::boundary::BoundaryKind;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::particles::convect::Flow;
use crate::pfem2::phases::FluidRegion;
use std::f64::consts::PI;

#[test]
fn sub_cells_have_equal_volumes_and_their_centres_are_centroids() {
    fn check<const N: usize>(cells: usize) {
        let points = crate::pfem2::particles::lattice::<N>(48);
        for cell in 0..cells {
            let own = || points.iter().filter(|&n| sub_cells(n) >> cell & 1 == 1);
            let count = own().count() as f64;
            assert!((count * cells as f64 / points.len() as f64 - 1.0).abs() < 0.1, "{cell}: {count}");
            let center = center::<N>(cell);
            assert_eq!(sub_cells(&center), 1 << cell);
            for k in 0..N {
                let mean = own().map(|n| n[k]).sum::<f64>() / count;
                assert!((mean - center[k]).abs() < 0.01, "{cell}: {mean} {center:?}");
            }
        }
    }
    check::<3>(4);
    check::<4>(8);
}

/// Symmetric particles stay symmetric, to round-off, while particles are added and merged.
fn mirrored<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    per_edge: usize,
    flow: impl Fn(Vector<D>) -> Vector<D> + Sync,
) {
    let mirror = |x: Vector<D>| Vector::from_fn(|axis| if axis == 0 { -x[axis] } else { x[axis] });
    let velocity: Vec<_> = mesh.nodes().iter().map(|&x| flow(x)).collect();
    let boundary = vec![BoundaryKind::Slip; mesh.boundary().len()];
    let lines = Streamlines::new(mesh, &Flow { velocity: &velocity, boundary: &boundary, projectiles: None });
    let surface = |x: Vector<D>| x[1] - 0.4 - 0.3 * x[0] * x[0];
    let mut particles = Particles::seed(mesh, per_edge, |x| Some(u8::from(surface(x) >= 0.0)), &flow);
    let mut set = LevelSet::new(mesh, 0, surface, &mut particles);
    let target = ParticleCounts::new::<D>(particles.len() / mesh.elements().len());
    let dt = 0.25;
    let mut done = [0, 0];
    for _ in 0..6 {
        particles.convect(&lines, dt);
        let (fluid, inflow) = (|place: &MeshPoint<N>| set.at(mesh, place), |_: &MeshPoint<N>, _: usize, _: f64| None);
        let origin = ParticleSource {
            lines: &lines,
            dt,
            velocity: &velocity,
            fluid: &fluid,
            inflow: &inflow,
            is_fluid: &|_| true,
        };
        let reseeded = particles.reseed(mesh, &PhaseList::fluids(&[1.0; 2]), target, &origin);
        done = [done[0] + reseeded.added, done[1] + reseeded.merged];
        set.update(&FluidRegion::whole(mesh), &mut particles, &[]);
    }
    assert!(done.iter().all(|&count| count > particles.len() / 50), "{done:?} of {}", particles.len());
    let image = |p: usize| {
        let (x, own) = (mirror(particles.position[p]), (particles.phase[p], particles.depth[p]));
        let near = |q: &usize| (particles.position[*q] - x).norm() < 1e-9;
        (0..particles.len())
            .filter(near)
            .any(|q| particles.phase[q] == own.0 && (particles.depth[q] - own.1).abs() < 1e-9)
    };
    let alone = (0..particles.len()).filter(|&p| !image(p)).count();
    assert!(alone == 0, "{alone} of {} particles have no image", particles.len());
}

#[test]
fn symmetric_particles_stay_symmetric() {
    let lines = |from: f64| (0..=8).map(|i| from + (1.0 - from) * f64::from(i) / 8.0).collect::<Vec<_>>();
    let vortices = |x: &[f64]| [-(PI * x[0]).sin() * (PI * x[1]).cos(), (PI * x[0]).cos() * (PI * x[1]).sin()];
    let flat = Mesh::<2, 3>::lattice(&[lines(-1.0), lines(0.0)], CellCut::Mirrored).unwrap();
    mirrored(&flat, 3, |x| Vector(vortices(&x.0)));
    let full = Mesh::<3, 4>::lattice(&[lines(-1.0), lines(0.0), lines(0.0)], CellCut::Mirrored).unwrap();
    mirrored(&full, 3, |x| {
        let [u, v] = vortices(&x.0);
        Vector([u, v, 0.3 * x[2] * (1.0 - x[2]) * (PI * x[0]).cos()])
    });
}

fn uniform(mesh: &Mesh<2, 3>) -> Vec<Vector<2>> {
    vec![Vector([1.0, 0.0]); mesh.nodes().len()]
}

#[test]
fn a_channel_is_filled_with_its_inflow() {
    // Fluid 1 comes in from t = 0.1 on with a velocity that tells the time.
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([2.0, 1.0]), [16, 8]).unwrap();
    let velocity = uniform(&mesh);
    let boundary = vec![BoundaryKind::Outlet; mesh.boundary().len()];
    let flow = Flow { velocity: &velocity, boundary: &boundary, projectiles: None };
    let lines = Streamlines::new(&mesh, &flow);
    let mut particles = Particles::seed(&mesh, 5, |_| Some(0), |_| Vector::ZERO);
    let dt = 0.25;
    for step in 0..4 {
        particles.convect(&lines, dt);
        let inflow = |place: &MeshPoint<3>, _: usize, after: f64| {
            let (velocity, fluid) = (Vector([dt * step as f64 + after, 0.0]), u8::from(step > 0));
            (place.position(&mesh)[0] < 1e-9).then_some(NewParticle { velocity, fluid, depth: 0.0 })
        };
        let origin = ParticleSource {
            lines: &lines,
            dt,
            velocity: &velocity,
            fluid: &|_| (0, 0.0),
            inflow: &inflow,
            is_fluid: &|_| true,
        };
        let done = particles.reseed(&mesh, &PhaseList::fluids(&[1.0; 2]), ParticleCounts::new::<2>(15), &origin);
        assert!(done.inflow > 0 && done.empty > 0, "{done:?}");
    }
    assert!((0..mesh.elements().len()).all(|e| particles.of(e).len() >= 4));
    for p in 0..particles.len() {
        // It came in at t = 1 − x.
        let (x, v) = (particles.position[p][0], particles.velocity[p][0]);
        if x < 0.7 {
            assert!((v - (1.0 - x)).abs() < 1e-12, "{x} {v}");
            assert_eq!(particles.phase[p], u8::from(1.0 - x > 0.25));
        }
    }
}

#[test]
fn merging_keeps_centres_and_fluids() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [1, 1]).unwrap();
    let velocity = uniform(&mesh);
    let boundary = vec![BoundaryKind::Wall; mesh.boundary().len()];
    let lines = Streamlines::new(&mesh, &Flow { velocity: &velocity, boundary: &boundary, projectiles: None });
    let mut particles = Particles::seed(&mesh, 12, |x| Some(u8::from(x[1] > 0.37)), |x| x);
    let origin = ParticleSource {
        lines: &lines,
        dt: 0.0,
        velocity: &velocity,
        fluid: &|_| (0, 0.0),
        inflow: &|_, _, _| None,
        is_fluid: &|_| true,
    };
    let target = ParticleCounts { nominal: 15, most: 14 };
    let before = particles.len();
    let done = particles.reseed(&mesh, &PhaseList::fluids(&[1.0; 2]), target, &origin);
    assert!(done.merged > 0 && particles.len() == before - done.merged);
    for (x, (v, &fluid)) in particles.position.iter().zip(particles.velocity.iter().zip(&particles.phase)) {
        assert!((*x - *v).norm() < 1e-15 && fluid == u8::from(x[1] > 0.37));
    }
}
