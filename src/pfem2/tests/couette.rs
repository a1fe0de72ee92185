//! Flow between a cylinder that turns and one at rest: v = A r + B/r along circles, torque 4π μ B (Couette).

use super::*;
use crate::pfem2::Pfem2;
use crate::simulation::Solver;
use std::f64::consts::{PI, TAU};

/// Radii of the cylinders; the inner one turns with angular velocity one.
const RADII: [f64; 2] = [1.0, 2.0];

/// Viscosity, with density one.
const VISCOSITY: f64 = 0.01;

/// A = −ω r₁²/(r₂² − r₁²), B = ω r₁² r₂²/(r₂² − r₁²).
const COEFFICIENTS: [f64; 2] = [-1.0 / 3.0, 4.0 / 3.0];

fn exact(x: Vector<2>) -> Vector<2> {
    let rate = COEFFICIENTS[0] + COEFFICIENTS[1] / x.norm_squared();
    Vector([-rate * x[1], rate * x[0]])
}

/// `rings` rings of triangles about as long as wide.
fn annulus(rings: u32) -> Mesh<2, 3> {
    let count = (f64::from(rings) * 0.5 * TAU * (RADII[0] + RADII[1])) as u32;
    let node = |i: u32, j: u32| {
        let radius = RADII[0] + (RADII[1] - RADII[0]) * f64::from(j) / f64::from(rings);
        let angle = TAU * (f64::from(i) + 0.5 * f64::from(j % 2)) / f64::from(count);
        Vector([radius * angle.cos(), radius * angle.sin()])
    };
    let nodes = (0..=rings).flat_map(|j| (0..count).map(move |i| node(i, j))).collect();
    let cell = |i: u32, j: u32| {
        let at = |i: u32, j: u32| i % count + j * count;
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        if j.is_multiple_of(2) { [[a, d, b], [b, d, c]] } else { [[a, c, b], [a, d, c]] }
    };
    let elements = (0..rings).flat_map(|j| (0..count).flat_map(move |i| cell(i, j))).collect();
    Mesh::new(nodes, elements).unwrap()
}

#[test]
fn a_turning_cylinder_feels_its_torque_and_leads_the_particles_beside_it() {
    let mesh = annulus(12);
    let turning = Condition::Wall([formula("-y"), formula("x")]);
    let sets = vec![set(&mesh, "inner", turning, |x| x.norm() < 1.01 * RADII[0])];
    let setup = setup(mesh, sets, physics(vec![fluid("fluid", 1.0, VISCOSITY)], weightless()), |_| 0, exact);
    let mut pfem = Pfem2::new(setup);
    let (dt, steps, settled) = (0.2, 60, 30);
    let mut torque = 0.0;
    for k in 0..steps {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        // With angular velocity one, the power of the wall is its torque.
        torque += if k < settled { 0.0 } else { pfem.balance.ledger.last.boundary / f64::from(steps - settled) };
    }
    let deviation = torque / (4.0 * PI * VISCOSITY * COEFFICIENTS[1]) - 1.0;
    assert!(deviation.abs() < 0.01, "torque {deviation}");
    let particles = &pfem.particles.columns;
    let beside = (0..particles.len()).filter(|&p| particles.position[p].norm() < RADII[0] + 0.08);
    let off = beside.map(|p| (particles.velocity[p] - exact(particles.position[p])).norm()).fold(0.0, f64::max);
    assert!(off < 0.05, "particles beside the wall are off by {off}");
}
