//! Rigid solids, and springs, against closed forms.

use super::*;
use crate::material::Rigid;
use crate::pfem2::solid::setup::SpringSupport;
use crate::pfem2::solid::surface::tests::disc;
use std::f64::consts::PI;

/// A rigid solid of this density [kg/m³] with a velocity [m/s] at the start.
fn rigid<const D: usize>(mesh: SolidMesh<D>, density: f64, velocity: impl Fn(Vector<D>) -> Vector<D>) -> SolidSetup<D> {
    let mut setup = solid(mesh, [density, 1.0, 0.0], |_| false);
    setup.law = Box::new(Rigid { density });
    setup.velocity = setup.mesh.nodes.iter().map(|x| velocity(*x)).collect();
    setup
}

/// The complete elliptic integral of the first kind of the parameter m = k², by the arithmetic and geometric mean
/// (Gauss).
fn elliptic(m: f64) -> f64 {
    let (mut a, mut g) = (1.0, (1.0 - m).sqrt());
    for _ in 0..20 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    0.5 * PI / a
}

/// Zeros of samples a step apart, by cubic interpolation of four of them: times of the change of sign.
fn zeros(samples: &[f64], dt: f64) -> Vec<f64> {
    let cubic = |f: &[f64], s: f64| {
        -s * (s - 1.0) * (s - 2.0) / 6.0 * f[0] + (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0 * f[1]
            - (s + 1.0) * s * (s - 2.0) / 2.0 * f[2]
            + (s + 1.0) * s * (s - 1.0) / 6.0 * f[3]
    };
    let change = |k: &usize| samples[*k] * samples[*k + 1] < 0.0;
    let at = |k: usize| {
        let (f, mut low, mut high) = (&samples[k - 1..k + 3], 0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *if cubic(f, middle) * f[1] > 0.0 { &mut low } else { &mut high } = middle;
        }
        (k as f64 + low) * dt
    };
    (1..samples.len() - 2).filter(change).map(at).collect()
}

/// A disc that is thrown turns with its spin and falls as a point does; after thirty turns its shape is that of the
/// start to rounding.
#[test]
fn a_disc_that_is_thrown_keeps_spin_and_shape() {
    let (spin, speed, dt) = (7.0, Vector([2.0, 3.0]), 0.01);
    let setup = rigid(disc(3), 500.0, |x| speed + Vector([-x[1], x[0]]) * spin);
    let reference = setup.mesh.nodes.clone();
    let mut run = SolidsAlone::new(setup, dt, 0.6);
    let steps = (30.0 * 2.0 * PI / spin / dt) as usize;
    (0..steps).for_each(|_| drop(run.solve_alone(Vector([0.0, -9.81]))));
    let state = run.structure.state.rigid[0];
    assert!((state.spin[0][2] - spin).abs() < 1e-9, "{:?}", state.spin);
    let t = steps as f64 * dt;
    // The first step takes nothing of what was before it.
    let late = (0.6 - 0.5) * dt;
    assert!((state.velocity[0][0] - 2.0).abs() < 1e-9, "{:?}", state.velocity[0]);
    assert!((state.velocity[0][1] - 3.0 + 9.81 * (t - late)).abs() < 1e-8, "{:?}", state.velocity[0]);
    let places = run.structure.positions(&run.structure.state.displacement);
    let change = |a: usize, b: usize| ((places[a] - places[b]).norm() - (reference[a] - reference[b]).norm()).abs();
    let worst = (0..places.len()).map(|a| change(a, (7 * a + 3) % places.len())).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst:e}");
    // The angle of a turn, and mass and moment of inertia of a disc.
    let turned = places[0] - Vector([state.displacement[0], state.displacement[1]]);
    let expected = Vector([
        reference[0][0] * (spin * t).cos() - reference[0][1] * (spin * t).sin(),
        reference[0][0] * (spin * t).sin() + reference[0][1] * (spin * t).cos(),
    ]);
    assert!((turned - expected).norm() < 1e-9, "{turned:?} {expected:?}");
    let body = &run.structure.rigid[0];
    assert!((body.mass / (500.0 * PI) - 1.0).abs() < 1e-3, "{}", body.mass);
    assert!((body.inertia[2][2] / (250.0 * PI) - 1.0).abs() < 1e-3, "{:?}", body.inertia);
}

/// A plate hinged at the middle of its upper side swings out from 60°: T = 4 √(J/(m g d)) K(sin² 30°); the hinge stays
/// where it is.
#[test]
fn a_plate_on_a_hinge_swings_as_a_physical_pendulum() {
    let (width, height, dt) = (0.2, 1.0, 0.004);
    let mut mesh = SolidMesh::block(Vector([-0.5 * width, -height]), Vector([0.5 * width, 0.0]), [2, 4]).unwrap();
    let (sin, cos) = (PI / 3.0).sin_cos();
    mesh.nodes.iter_mut().for_each(|x| *x = Vector([x[0] * cos - x[1] * sin, x[0] * sin + x[1] * cos]));
    let mut setup = rigid(mesh, 700.0, |_| Vector::ZERO);
    let hinge = setup.mesh.nodes.iter().position(|x| x.norm() < 1e-12).unwrap();
    setup.held = vec![HeldNodes { nodes: vec![hinge as u32], velocity: [Some(Signal::ZERO), Some(Signal::ZERO)] }];
    let mut run = SolidsAlone::new(setup, dt, 0.6);
    let angle = |run: &SolidsAlone<2>| run.structure.state.rigid[0].displacement[0] + 0.5 * height * sin;
    let swing: Vec<f64> = (0..1500)
        .map(|_| {
            run.solve_alone(Vector([0.0, -9.81]));
            angle(&run)
        })
        .collect();
    assert!(run.structure.state.displacement[hinge].norm() < 1e-13, "{:?}", run.structure.state.displacement[hinge]);
    let crossings = zeros(&swing, dt);
    let measured = 2.0 * (crossings[6] - crossings[0]) / 6.0;
    // J/(m d) with J = m (w² + h²)/12 + m d², d = h/2.
    let length = ((width * width + height * height) / 12.0 + 0.25 * height * height) / (0.5 * height);
    let exact = 4.0 * (length / 9.81).sqrt() * elliptic(0.25);
    assert!((measured / exact - 1.0).abs() < 5e-4, "{measured} {exact}");
}

/// A brick thrown about its middle axis tumbles with the period of Landau & Lifshitz (Mechanics, § 37), and its angular
/// momentum stays.
#[test]
fn a_brick_tumbles_about_its_middle_axis_with_eulers_period() {
    let (sides, dt) = (Vector([1.0, 0.7, 0.3]), 0.004);
    let mesh = SolidMesh::block(sides * -0.5, sides * 0.5, [1, 1, 1]).unwrap();
    // Moments I₁ < I₂ < I₃ about x, y, z; the turn begins near the axis of I₂.
    let spin = Vector([0.15, 5.0, 0.4]);
    let mut run = SolidsAlone::new(rigid(mesh, 1000.0, |x| spin.cross(x)), dt, 0.6);
    let inertia = run.structure.rigid[0].inertia;
    let mass = 1000.0 * sides[0] * sides[1] * sides[2];
    let exact = |a: usize, b: usize| mass * (sides[a].powi(2) + sides[b].powi(2)) / 12.0;
    let i = [exact(1, 2), exact(0, 2), exact(0, 1)];
    assert!((0..3).all(|k| (inertia[k][k] / i[k] - 1.0).abs() < 1e-12), "{inertia:?} {i:?}");
    let energy2: f64 = (0..3).map(|k| i[k] * spin[k] * spin[k]).sum();
    let square: f64 = (0..3).map(|k| (i[k] * spin[k]).powi(2)).sum();
    assert!(square > energy2 * i[1], "the other branch");
    let rate = ((i[2] - i[1]) * (square - energy2 * i[0]) / (i[0] * i[1] * i[2])).sqrt();
    let m = (i[1] - i[0]) * (energy2 * i[2] - square) / ((i[2] - i[1]) * (square - energy2 * i[0]));
    let period = 4.0 * elliptic(m) / rate;
    let start = run.structure.state.rigid[0].momentum;
    let middle: Vec<f64> = (0..(2.2 * period / dt) as usize)
        .map(|_| {
            run.solve_alone(Vector::ZERO);
            let state = run.structure.state.rigid[0];
            state.rotation.transpose().apply(state.spin[0])[1]
        })
        .collect();
    let state = run.structure.state.rigid[0];
    assert!((state.momentum - start).norm() < 1e-10 * start.norm(), "{:?} {start:?}", state.momentum);
    assert!(
        (state.rotation.dot(&state.rotation.transpose()) - Tensor::identity()).contract(&Tensor([[1.0; 3]; 3])).abs()
            < 1e-14
    );
    let crossings = zeros(&middle, dt);
    let measured = crossings[2] - crossings[0];
    assert!((measured / period - 1.0).abs() < 2e-3, "{measured} {period} {crossings:?}");
}

/// A block on springs of 4 kN/m in all: x = a cos ωt, ω² = k/m; with a dashpot of a tenth of the critical resistance it
/// decays by e^(−0.1 ω t).
#[test]
fn a_block_on_springs_has_their_period_and_damping() {
    let (stiffness, mass) = (4000.0f64, 1000.0 * 0.4 * 0.2);
    let omega = (stiffness / mass).sqrt();
    for (law, damping) in [(true, 0.0), (false, 0.0), (true, 0.1)] {
        let mesh = SolidMesh::block(Vector([0.0, 0.0]), Vector([0.4, 0.2]), [2, 1]).unwrap();
        let mut setup = match law {
            true => rigid(mesh, 1000.0, |_| Vector([1.0, 0.0])),
            false => solid(mesh, [1000.0, 1e9, 0.3], |_| false),
        };
        setup.velocity.fill(Vector([1.0, 0.0]));
        let weights = [0u32, 10].map(|node| (node, 0.5)).to_vec();
        let resistance = 2.0 * damping * stiffness / omega;
        setup.springs = vec![SpringSupport { weights, stiffness: [stiffness, 0.0], damping: [resistance, 0.0] }];
        let dt = 2.0 * PI / omega / 100.0;
        let mut run = SolidsAlone::new(setup, dt, 0.6);
        let way: Vec<f64> = (0..420)
            .map(|_| {
                run.solve_alone(Vector::ZERO);
                run.structure.state.displacement[4][0]
            })
            .collect();
        let crossings = zeros(&way, dt);
        let period = 2.0 * (crossings[6] - crossings[0]) / 6.0;
        let exact = 2.0 * PI / omega / (1.0 - damping * damping).sqrt();
        assert!((period / exact - 1.0).abs() < 1e-3, "{law} {damping}: {period} {exact}");
        let most = |range: std::ops::Range<usize>| way[range].iter().copied().fold(f64::MIN, f64::max);
        let left = most(300..400) / most(0..100);
        let expected = (-damping * omega * 3.0 * exact).exp();
        assert!((left / expected - 1.0).abs() < 0.02, "{law} {damping}: {left} {expected}");
    }
}

/// A prescribed turn, at the rate cos t about the centre of mass that moves by sin t: angle and way after 1 s.
#[test]
fn a_prescribed_motion_is_followed() {
    let mesh = SolidMesh::block(Vector([1.0, 1.0]), Vector([1.4, 1.2]), [2, 1]).unwrap();
    let mut setup = rigid(mesh, 1000.0, |_| Vector::ZERO);
    let cosine = || Some(Signal::formula("cos(t)").unwrap());
    setup.motion = PrescribedMotion { velocity: [cosine(), Some(Signal::ZERO), None], spin: [None, None, cosine()] };
    let mut run = SolidsAlone::new(setup, 0.01, 0.6);
    (0..100).for_each(|_| drop(run.solve_alone(Vector([0.0, -9.81]))));
    let state = run.structure.state.rigid[0];
    let angle = state.rotation[1][0].atan2(state.rotation[0][0]);
    assert!((angle - 1f64.sin()).abs() < 1e-4, "{angle}");
    assert!((state.displacement[0] - 1f64.sin()).abs() < 1e-4 && state.displacement[1].abs() < 1e-14);
}

/// Supports that pull a rigid solid apart are told before a run.
#[test]
fn a_rigid_solid_cannot_be_pulled_apart() {
    let mesh = SolidMesh::block(Vector([0.0, 0.0]), Vector([1.0, 0.2]), [2, 1]).unwrap();
    let mut setup = rigid(mesh, 1000.0, |_| Vector::ZERO);
    let along = |node: u32, speed: f64| HeldNodes { nodes: vec![node], velocity: [Some(speed.into()), None] };
    setup.held = vec![along(0, 0.0), along(4, 1.0)];
    assert!(Structure::new(vec![setup]).unwrap_err().contains("ask for a deformation"));
}
