//! A round drop at rest under surface tension: the pressure jump σ/R.

use super::*;
use crate::pfem2::boundary::Boundary;

/// Mean pressure inside minus outside, away from the interface, over σ/R = 98 Pa (Laplace), and the largest
/// spurious speed, after five steps with the interface held.
fn jump(cells: usize) -> [f64; 2] {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap();
    let level: Vec<f64> = mesh.nodes().iter().map(|x| (*x - Vector([0.503, 0.497])).norm() - 0.25).collect();
    let boundary = Boundary::new(&mesh, Vec::new(), Vector::ZERO);
    let mut physics = physics(vec![fluid("drop", 1000.0, 1.0), fluid("around", 1.0, 0.01)], weightless());
    physics.tension = vec![([1, 0], 24.5)];
    let still = vec![Vector::ZERO; mesh.nodes().len()];
    let mut system = VelocityPressureSystem::new(mesh, boundary, physics, still, SolverOptions::default());
    let phases = Phases { list: &PhaseList::fluids(&[1000.0, 1.0]), fraction: &[], level: &level };
    for k in 0..5 {
        let convected = system.velocity.clone();
        let step = ThetaStep { t: 1e-3 * f64::from(k), dt: 1e-3, theta: 1.0 };
        system.solve(step, &phases, &convected).unwrap();
    }
    let far = |inside: f64| {
        let own = level.iter().zip(&system.pressure).filter(|(phi, _)| **phi * inside > 2.0 / cells as f64);
        let pressures: Vec<f64> = own.map(|(_, p)| *p).collect();
        pressures.iter().sum::<f64>() / pressures.len() as f64
    };
    [(far(-1.0) - far(1.0)) / 98.0, fastest(&system.velocity)]
}

#[test]
fn the_pressure_jumps_by_tension_over_radius() {
    for cells in [16, 24] {
        let [jump, speed] = jump(cells);
        assert!((jump - 1.0).abs() < 0.02, "{cells}: {jump}");
        assert!(speed < 0.5, "{cells}: {speed}");
    }
}
