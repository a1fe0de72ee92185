//! Tests that every sheet law must pass.

use super::{LANES, Sheet, SheetKind};

/// Deformations C = (C11, C22, C12): taut, sheared, wrinkled and slack.
const DEFORMATIONS: [[f64; 3]; 6] =
    [[1.3, 1.1, 0.05], [2.5, 1.6, -0.7], [1.4, 0.5, 0.1], [1.1, 1.05, 0.3], [0.8, 0.7, 0.05], [1.001, 1.0004, 0.0001]];

/// A plane tensor in axes turned by `angle`.
fn turned([a11, a22, a12]: [f64; 3], angle: f64) -> [f64; 3] {
    let (s, c) = angle.sin_cos();
    [
        c * c * a11 + s * s * a22 + 2.0 * s * c * a12,
        s * s * a11 + c * c * a22 - 2.0 * s * c * a12,
        (c * c - s * s) * a12 + s * c * (a22 - a11),
    ]
}

fn assert_close(a: [f64; 3], b: [f64; 3], tolerance: f64, what: &str) {
    for i in 0..3 {
        assert!((a[i] - b[i]).abs() <= tolerance, "{what}: {a:?} and {b:?}");
    }
}

/// Stress is the derivative of the energy, `S = 2 ∂W/∂C`; stress-free at rest; lanes agree with single calls;
/// the wave speed is that of the stiffness.
pub fn total_law(law: &dyn Sheet) {
    assert_eq!(law.kind(), SheetKind::Total);
    let scale = law.modulus();
    assert_close(law.total([1.0, 1.0, 0.0]).stress, [0.0; 3], 1e-12 * scale, "stress at rest");
    assert!(law.total([1.0, 1.0, 0.0]).energy.abs() < 1e-14 * scale);
    let lanes =
        law.total_lanes(&std::array::from_fn(|i| std::array::from_fn(|k| DEFORMATIONS[k % DEFORMATIONS.len()][i])));
    for k in 0..LANES {
        let c = DEFORMATIONS[k % DEFORMATIONS.len()];
        assert_eq!(lanes.stress.map(|s| s[k]), law.total(c).stress);
        assert_eq!((lanes.energy[k], lanes.stiffness[k]), (law.total(c).energy, law.stiffness(c)));
    }
    for c in DEFORMATIONS {
        let derivative: [f64; 3] = std::array::from_fn(|i| {
            let step = 1e-6;
            let energy = |sign: f64| {
                let mut moved = c;
                moved[i] += sign * step;
                law.total(moved).energy
            };
            // C12 stands for both off-diagonal entries.
            let factor = if i == 2 { 1.0 } else { 2.0 };
            factor * (energy(1.0) - energy(-1.0)) / (2.0 * step)
        });
        assert_close(law.total(c).stress, derivative, 2e-8 * scale, "S = 2 ∂W/∂C");
    }
    for c in DEFORMATIONS {
        let differences = super::stiffness_by_differences(&|c| law.total(c), c);
        assert!((law.stiffness(c) - differences).abs() < 1e-6 * scale, "stiffness at {c:?}");
    }
    let (speed, stiffness) = (law.wave_speed(), law.stiffness([1.0 + 1e-3, 1.0 + 1e-3, 0.0]));
    assert!((law.density() * speed * speed / stiffness - 1.0).abs() < 0.02, "wave speed {speed}");
}

/// As [`total_law`]; indifferent to the choice of axes; E and ν at small strain.
pub fn isotropic_total_law(law: &dyn Sheet, young: f64, poisson: f64) {
    total_law(law);
    for c in DEFORMATIONS {
        let state = law.total(c);
        for angle in [0.3, 1.1, 2.5] {
            let other = law.total(turned(c, angle));
            assert_close(other.stress, turned(state.stress, angle), 1e-11 * law.modulus(), "isotropy");
            assert!((other.energy - state.energy).abs() < 1e-11 * law.modulus());
        }
    }
    let e = 1e-6;
    let state = law.total([1.0 + 2.0 * e, 1.0 + 2.0 * e, 0.0]);
    assert!((state.stress[0] / e * (1.0 - poisson) / young - 1.0).abs() < 1e-4, "biaxial modulus");
    assert!((state.thickness - 1.0 + 2.0 * e * poisson / (1.0 - poisson)).abs() < 1e-11, "thickness");
    let sheared = law.total([1.0 + 20.0 * e, 1.0 + 20.0 * e, 2.0 * e]).stress[2];
    assert!((sheared / (2.0 * e) / (0.5 * young / (1.0 + poisson)) - 1.0).abs() < 1e-3, "shear modulus");
}

/// An isotropic rate law: indifferent to the choice of axes; symmetric moduli, so that an energy exists; E and ν;
/// wave speed.
pub fn rate_law(law: &dyn Sheet, young: f64, poisson: f64) {
    assert_eq!(law.kind(), SheetKind::Rate);
    let stress_of = |[d11, d22, d12]: [f64; 3]| {
        let mut stress = [0.0; 3];
        law.rate([d11, d22, 2.0 * d12], &mut stress);
        stress
    };
    let strain = [1e-3, -0.4e-3, 0.7e-3];
    for angle in [0.3, 1.1, 2.5] {
        assert_close(
            stress_of(turned(strain, angle)),
            turned(stress_of(strain), angle),
            1e-14 * young,
            "frame indifference",
        );
    }
    let unit = |i: usize| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 });
    assert_eq!(stress_of(unit(0))[1], stress_of(unit(1))[0], "symmetric moduli");
    assert!((stress_of([1.0, -poisson, 0.0])[0] / young - 1.0).abs() < 1e-14);
    assert!((law.density() * law.wave_speed().powi(2) / stress_of(unit(0))[0] - 1.0).abs() < 1e-14);
}
