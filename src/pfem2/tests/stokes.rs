//! The mesh stage alone, without convection.

use super::*;
use crate::material::Bingham;
use crate::pfem2::boundary::{Boundary, PressurePin};

/// Flow between plates from rest under a body force; the ends are open and far. Exact, in the middle:
/// u_c = 1 − 32 Σ (−1)ⁿ/((2n+1)π)³ exp(−((2n+1)π)² ν t/H²) for H = ν = 1, G = 8 μ.
#[test]
fn flow_between_plates_starts_as_the_series_says() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([6.0, 1.0]), [36, 16]).unwrap();
    let middle = mesh.nodes().iter().position(|x| (*x - Vector([3.0, 0.5])).norm() < 1e-9).unwrap();
    let sets = vec![set(&mesh, "ends", Condition::Outlet, |x| x[0] == 0.0 || x[0] == 6.0)];
    for (t, exact) in [(0.05, 0.3703863), (0.25, 0.9124771)] {
        let boundary = Boundary::new(&mesh, sets.clone(), Vector::ZERO);
        let still = vec![Vector::ZERO; mesh.nodes().len()];
        let physics = physics(vec![fluid("oil", 1.0, 1.0)], [8.0.into(), 0.0.into()]);
        let mut system = VelocityPressureSystem::new(mesh.clone(), boundary, physics, still, SolverOptions::default());
        march(&mut system, &one(&PhaseList::fluids(&[1.0])), t / 20.0, 20);
        let speed = system.velocity[middle][0];
        assert!((speed / exact - 1.0).abs() < 0.01, "t = {t}: {speed} instead of {exact}");
    }
}

/// Plates that a Bingham fluid fills: u = G (H/2 − y_p)²/(2 k) in the plug, with y_p = τ_y/G, so (1 − τ_y/(G H/2))² of
/// the Newtonian value.
#[test]
fn a_bingham_fluid_moves_as_a_plug_between_layers() {
    let (force, yield_stress) = (8.0, 1.6);
    let law = Bingham { density: 1.0, viscosity: 1.0, yield_stress, regularisation: 0.01 };
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([6.0, 1.0]), [24, 20]).unwrap();
    let sets = vec![set(&mesh, "ends", Condition::Outlet, |x| x[0] == 0.0 || x[0] == 6.0)];
    let at = |y: f64| mesh.nodes().iter().position(|x| (*x - Vector([3.0, y])).norm() < 1e-9).unwrap();
    let boundary = Boundary::new(&mesh, sets, Vector::ZERO);
    let fluids = vec![FluidSetup::new("paste", Box::new(law))];
    let still = vec![Vector::ZERO; mesh.nodes().len()];
    let mut system = VelocityPressureSystem::new(
        mesh.clone(),
        boundary,
        physics(fluids, [force.into(), 0.0.into()]),
        still,
        SolverOptions::default(),
    );
    for _ in 0..60 {
        let convected = system.velocity.clone();
        system.solve(ThetaStep { t: 0.0, dt: 0.05, theta: 1.0 }, &one(&PhaseList::fluids(&[1.0])), &convected).unwrap();
    }
    let exact = force * (0.5 - yield_stress / force).powi(2) / 2.0;
    for y in [0.35, 0.5, 0.65] {
        let speed = system.velocity[at(y)][0];
        assert!((speed / exact - 1.0).abs() < 0.02, "y = {y}: {speed} instead of {exact}");
    }
}

/// Rigid rotation has no strain and no flux through a round slip wall: it goes on for ever.
#[test]
fn a_disc_of_fluid_rotates_along_its_round_slip_wall() {
    let mesh = disc(5, 24);
    let sets = vec![BoundarySetup {
        name: "rim".into(),
        facets: mesh.boundary().to_vec(),
        condition: Condition::Slip,
        brings: None,
    }];
    let boundary = Boundary::new(&mesh, sets, Vector::ZERO);
    let turn = |x: Vector<2>| Vector([-x[1], x[0]]);
    let start = mesh.nodes().iter().map(|x| turn(*x)).collect();
    let options = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    let mut system = VelocityPressureSystem::new(
        mesh,
        boundary,
        physics(vec![fluid("oil", 1.0, 0.1)], weightless()),
        start,
        options,
    );
    march(&mut system, &one(&PhaseList::fluids(&[1.0])), 0.1, 5);
    assert!(rms(system.mesh.nodes(), &system.velocity, turn) < 1e-10);
}

/// A linear velocity prescribed all around, in three dimensions, with the pressure that gravity asks for.
#[test]
fn a_linear_flow_and_a_linear_pressure_are_exact() {
    let mesh = shaken(&Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [3, 3, 3]).unwrap(), 0.33);
    let around = Condition::Inlet([formula("x + 2*y"), formula("z - 3*y"), formula("2*z - x")]);
    let sets =
        vec![BoundarySetup { name: "all".into(), facets: mesh.boundary().to_vec(), condition: around, brings: None }];
    let gravity = Vector([1.0, -2.0, 0.5]);
    let boundary = Boundary::new(&mesh, sets, gravity);
    let flow = |x: Vector<3>| Vector([x[0] + 2.0 * x[1], x[2] - 3.0 * x[1], 2.0 * x[2] - x[0]]);
    let start = mesh.nodes().iter().map(|x| flow(*x)).collect();
    let pin = PressurePin { at: Vector([0.3, 0.7, 0.6]), value: 5.0.into() };
    let boundary = boundary.pinned(&mesh, Some(&pin));
    let pin = boundary.pin.as_ref().unwrap().node as usize;
    let physics = physics(vec![fluid("oil", 2.0, 0.1)], gravity.0.map(Signal::Constant));
    let options = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    let mut system = VelocityPressureSystem::new(mesh, boundary, physics, start, options);
    march(&mut system, &one(&PhaseList::fluids(&[2.0])), 0.1, 3);
    assert!(rms(system.mesh.nodes(), &system.velocity, flow) < 1e-10);
    let held = system.mesh.nodes()[pin];
    for (x, p) in system.mesh.nodes().iter().zip(&system.pressure) {
        assert!((p - 5.0 - 2.0 * gravity.dot(*x - held)).abs() < 1e-9);
    }
}
