//! Single elements and patches: constant strain, rigid motion, hourglass modes.

use super::*;
use crate::mpm::membrane::build::bisector_axes;

/// A 4 × 4 patch with skewed quadrilaterals, the last row split into triangles; and its inner nodes.
fn skewed_patch() -> (Vec<Vector<3>>, Vec<Vec<u32>>, Vec<usize>) {
    let (mut position, elements) = rectangle([4, 4], [0.4, 0.4]);
    let inner: Vec<usize> = (0..25).filter(|k| (1..4).contains(&(k % 5)) && (1..4).contains(&(k / 5))).collect();
    let mut seed = 7;
    for &k in &inner {
        position[k] += Vector([0.03 * noise(&mut seed), 0.03 * noise(&mut seed), 0.0]);
    }
    let split = |quad: &Vec<u32>| match *quad.as_slice() {
        [a, b, c, d] if a >= 15 => vec![vec![a, b, c], vec![a, c, d]],
        _ => vec![quad.clone()],
    };
    (position, elements.iter().flat_map(split).collect(), inner)
}

/// A rotation about an oblique axis (Rodrigues' formula).
fn turn(x: Vector<3>, angle: f64) -> Vector<3> {
    let axis = Vector([1.0, 2.0, -1.5]).normalized().unwrap();
    let (sin, cos) = angle.sin_cos();
    x * cos + axis.cross(x) * sin + axis * (axis.dot(x) * (1.0 - cos))
}

/// Moves the nodes to `target` in one step of length one, as the time loop would.
fn move_to(membrane: &mut Membrane<3>, target: impl Fn(Vector<3>) -> Vector<3>) {
    for k in 0..membrane.position.len() {
        let x = target(membrane.reference[k]);
        membrane.velocity[k] = x - membrane.position[k];
        membrane.position[k] = x;
    }
    membrane.ledger.displacement_dt = 1.0;
    membrane.internal_force(0.0).unwrap();
}

fn largest_residual(membrane: &Membrane<3>, nodes: &[usize]) -> f64 {
    nodes.iter().map(|&k| membrane.element_force[k].norm()).fold(0.0, f64::max)
}

#[test]
fn uniform_prestress_is_in_equilibrium_in_a_skewed_mesh() {
    let (position, elements, inner) = skewed_patch();
    let warp = vec![Vector([1.0, 0.5, 0.0]); elements.len()];
    let setup =
        MembraneSetup { warp, prestress: [5.0, 2.0], ..setup(elastic(1.0, 1000.0, 0.3), position, elements, 0.1) };
    let mut membrane = Membrane::new(setup).unwrap();
    membrane.internal_force(0.0).unwrap();
    // Forces of one element are about σ h L = 5 · 0.1 · 0.1.
    assert!(largest_residual(&membrane, &inner) < 1e-14 * 0.05);
    assert!(membrane.element_force[0].norm() > 0.1 * 0.05);
}

#[test]
fn homogeneous_deformation_of_a_total_law_is_in_equilibrium() {
    let (position, elements, inner) = skewed_patch();
    let law = sheet::NeoHookean { density: 1.0, shear: 1000.0, poisson: 0.5, wrinkling: false };
    let mut membrane = Membrane::new(setup(law, position, elements, 0.1)).unwrap();
    let deformed = |x: Vector<3>| Vector([1.4 * x[0] + 0.3 * x[1], 1.2 * x[1] - 0.1 * x[0], 0.0]);
    move_to(&mut membrane, |x| turn(deformed(x), 0.9));
    assert!(largest_residual(&membrane, &inner) < 1e-14 * 1000.0 * 0.1 * 0.1);
    let stretch = membrane.thickness(0) / 0.1;
    assert!((stretch * (1.4 * 1.2 + 0.3 * 0.1) - 1.0).abs() < 1e-13, "volume is kept");
}

#[test]
fn linear_velocities_strain_a_skewed_mesh_uniformly() {
    let (position, elements, inner) = skewed_patch();
    let mut membrane = Membrane::new(setup(elastic(1.0, 1000.0, 0.3), position, elements, 0.1)).unwrap();
    let e = 1e-7;
    move_to(&mut membrane, |x| x + Vector([x[0] + 0.5 * x[1], -0.2 * x[1] + 0.1 * x[0], 0.0]) * e);
    // Plane stress: E/(1−ν²) (ε11 + ν ε22) and the like; principal values don't depend on the frame.
    let (e11, e22, e12) = (1.0, -0.2, 0.3);
    let factor = 1000.0 * e / (1.0 - 0.09);
    let (s11, s22, s12) = (factor * (e11 + 0.3 * e22), factor * (e22 + 0.3 * e11), 1000.0 * e / 1.3 * e12);
    let radius = (0.25 * (s11 - s22) * (s11 - s22) + s12 * s12).sqrt();
    let exact = [0.5 * (s11 + s22) + radius, 0.5 * (s11 + s22) - radius];
    for element in 0..membrane.elements.len() {
        let stress = membrane.principal_stress(element);
        assert!((0..2).all(|i| (stress[i] / exact[i] - 1.0).abs() < 1e-6), "{stress:?} {exact:?}");
    }
    assert!(largest_residual(&membrane, &inner) < 1e-6 * 1000.0 * e * 0.1 * 0.1);
    assert!(membrane.ledger.hourglass.value().abs() < 1e-12 * membrane.ledger.strain.value());
}

#[test]
fn a_full_turn_returns_the_stress() {
    let (position, elements, _) = skewed_patch();
    let setup = MembraneSetup { prestress: [5.0, 2.0], ..setup(elastic(1.0, 1000.0, 0.3), position, elements, 0.1) };
    let mut membrane = Membrane::new(setup).unwrap();
    for step in 1..=100 {
        let angle = std::f64::consts::TAU * f64::from(step) / 100.0;
        move_to(&mut membrane, |x| turn(x, angle));
    }
    for element in 0..membrane.elements.len() {
        let [s1, s2] = membrane.principal_stress(element);
        assert!((s1 - 5.0).abs() < 1e-10 && (s2 - 2.0).abs() < 1e-10, "{s1} {s2}");
    }
    assert!(membrane.ledger.hourglass.value().abs() < 1e-20);
}

#[test]
fn rigid_rotation_turns_the_forces_the_right_way() {
    // Uniaxial stress along x in a square, turned by 90° about z: the forces must then pull along y.
    let (position, elements) = rectangle([1, 1], [1.0, 1.0]);
    let setup = MembraneSetup { prestress: [3.0, 0.0], ..setup(elastic(1.0, 1000.0, 0.3), position, elements, 0.1) };
    let mut membrane = Membrane::new(setup).unwrap();
    membrane.internal_force(0.0).unwrap();
    let before = membrane.element_force[1];
    for step in 1..=90 {
        let (sin, cos) = f64::from(step).to_radians().sin_cos();
        move_to(&mut membrane, |x| Vector([cos * x[0] - sin * x[1], sin * x[0] + cos * x[1], 0.0]));
    }
    let after = membrane.element_force[1];
    assert!((before - Vector([-0.15, 0.0, 0.0])).norm() < 1e-14);
    assert!((after - Vector([0.0, -0.15, 0.0])).norm() < 1e-12);
}

#[test]
fn simple_shear_follows_the_mid_rotation_rate() {
    // E = 1000, ν = 0, γ = 0.2: G γ = 100; σ12 = 99.36 and σ11 = −σ22 = 9.77.
    let (position, elements) = rectangle([1, 1], [1.0, 1.0]);
    let mut membrane = Membrane::new(setup(elastic(1.0, 1000.0, 0.0), position, elements, 0.1)).unwrap();
    for step in 1..=400 {
        let gamma = 0.2 * f64::from(step) / 400.0;
        move_to(&mut membrane, |x| Vector([x[0] + gamma * x[1], x[1], 0.0]));
    }
    let [e1, e2] = bisector_axes([Vector([2.0, 0.0, 0.0]), Vector([0.4, 2.0, 0.0])]);
    let [s11, s22, s12] = membrane.blocks[0].stress.map(|s| s[0]);
    let global = |i: usize, j: usize| s11 * e1[i] * e1[j] + s22 * e2[i] * e2[j] + s12 * (e1[i] * e2[j] + e2[i] * e1[j]);
    assert!((global(0, 1) - 99.36).abs() < 0.02, "σ12 = {}", global(0, 1));
    assert!((global(0, 0) - 9.77).abs() < 0.02, "σ11 = {}", global(0, 0));
    assert!((global(1, 1) + 9.77).abs() < 0.02, "σ22 = {}", global(1, 1));
}

#[test]
fn hourglass_modes_are_resisted() {
    // A square of side s: k = r_m E h / 4 and energy ½ k (γ·u)² with γ·u = 4 ε (theory (C.17)).
    let (position, elements) = rectangle([1, 1], [0.5, 0.5]);
    let pattern = [1.0, -1.0, -1.0, 1.0];
    for axis in 0..2 {
        let setup = setup(elastic(1.0, 1000.0, 0.3), position.clone(), elements.clone(), 0.1);
        let mut membrane = Membrane::new(setup).unwrap();
        let e = 1e-8;
        for (k, h) in pattern.into_iter().enumerate() {
            membrane.velocity[k] = Vector::unit(axis) * (h * e);
            membrane.position[k] += membrane.velocity[k];
        }
        membrane.ledger.displacement_dt = 1.0;
        membrane.internal_force(0.0).unwrap();
        let k = 0.05 * 1000.0 * 0.1 / 4.0;
        let energy = membrane.ledger.hourglass.value();
        assert!((energy / (0.5 * k * (4.0 * e) * (4.0 * e)) - 1.0).abs() < 1e-6, "{energy}");
        assert!(membrane.ledger.strain.value().abs() < 1e-12 * energy);
        assert!((membrane.element_force[0][axis] / (-k * 4.0 * e) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn warping_has_the_geometric_stiffness_of_the_bilinear_element() {
    // Compare with 2 × 2 Gauss quadrature of ½ h ∫ σ_ij w,i w,j dA, exact for this mode of a parallelogram.
    let corners = [[0.0, 0.0], [2.0, 0.3], [2.7, 3.3], [0.7, 3.0]];
    let (s11, s22, thickness, e) = (5.0, 2.0, 0.1, 1e-3);
    let position: Vec<_> = corners.iter().map(|c| Vector([c[0], c[1], 0.0])).collect();
    let setup = MembraneSetup {
        warp: vec![Vector([1.0, 0.0, 0.0])],
        prestress: [s11, s22],
        hourglass: [0.05, 0.0, 0.0],
        ..setup(elastic(1.0, 1000.0, 0.3), position, vec![vec![0, 1, 2, 3]], thickness)
    };
    let mut membrane = Membrane::new(setup).unwrap();
    let pattern = [1.0, -1.0, 1.0, -1.0];
    (0..4).for_each(|k| membrane.position[k][2] = pattern[k] * e);
    membrane.internal_force(0.0).unwrap();

    let (mut stiffness, g) = (0.0, 3f64.sqrt().recip());
    for (xi, eta) in [(-g, -g), (g, -g), (g, g), (-g, g)] {
        // N_K = ¼ (1 + ξ ξ_K)(1 + η η_K); the map of a parallelogram is linear.
        let (a, b) = (Vector([1.0, 0.15]), Vector([0.35, 1.5]));
        let det = a[0] * b[1] - a[1] * b[0];
        let (w_xi, w_eta) = (eta, xi);
        let (w1, w2) = ((w_xi * b[1] - w_eta * a[1]) / det, (w_eta * a[0] - w_xi * b[0]) / det);
        stiffness += thickness * (s11 * w1 * w1 + s22 * w2 * w2) * det;
    }
    // f·w over the mode shape: Σ_K h_K f_K = −e · stiffness.
    let work: f64 = (0..4).map(|k| pattern[k] * membrane.element_force[k][2]).sum();
    assert!((work / (-e * stiffness) - 1.0).abs() < 1e-12, "{work} {}", -e * stiffness);
}

#[test]
fn the_stable_step_of_a_square_is_that_of_its_stiffest_mode() {
    let (position, elements) = rectangle([1, 1], [0.5, 0.5]);
    let membrane = Membrane::new(setup(elastic(2.0, 1000.0, 0.3), position, elements, 0.1)).unwrap();
    let c = (1000.0f64 / (1.0 - 0.09) / 2.0).sqrt();
    assert!((membrane.stable_dt() * c * 1.3f64.sqrt() / 0.5 - 1.0).abs() < 1e-12);
}

#[test]
fn prestress_of_a_total_law_is_the_true_stress_at_the_start() {
    let (position, elements, inner) = skewed_patch();
    let law = sheet::NeoHookean { density: 1.0, shear: 1000.0, poisson: 0.4, wrinkling: true };
    let warp = vec![Vector([1.0, 0.5, 0.0]); elements.len()];
    let setup = MembraneSetup { warp, prestress: [500.0, 200.0], ..setup(law, position, elements, 0.1) };
    let mut membrane = Membrane::new(setup).unwrap();
    membrane.internal_force(0.0).unwrap();
    for element in 0..membrane.elements.len() {
        let [s1, s2] = membrane.principal_stress(element);
        assert!((s1 - 500.0).abs() < 1e-7 && (s2 - 200.0).abs() < 1e-7, "{s1} {s2}");
        assert!((membrane.thickness(element) - 0.1).abs() < 1e-14);
    }
    assert!(largest_residual(&membrane, &inner) < 1e-13 * 500.0 * 0.1 * 0.1);
}
