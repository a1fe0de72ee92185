//! One stiff element as an oscillator: frequency and damping of the scheme of (J.1), (J.2), and of what it is compared
//! with in K.3.
//!
//! ```text
//! u'' = −ω² u, x ~ zⁿ      z² − z = i h (θ z² + β₁ z + β₂),   h = ω Δt,   β₂ = θ − ½,   β₁ = 1 − θ − β₂        (F.8), (J.1), (J.2)
//! backward Euler           z = 1/(1 − i h)
//! ln z = i h_d − ζ h_d/√(1 − ζ²)                                                          frequency h_d/h, damping ratio ζ
//! ```

use super::*;
use crate::pfem2::tests::complex::{over, plus, root, scaled, times};

const MODULI: [f64; 3] = [1000.0, 2.0e6, 0.3];

/// A square of side two of one element, whose nodes are held but the one in its middle along x; its ω [1/s], by hand:
/// N = (1 − ξ²)(1 − η²) has ∫N² = (16/15)², and with the deviator of its strain and the linear part −4/3 ξ of its
/// dilatation K = 2 μ · 448/135 + κ · 64/27.
fn element() -> (SolidSetup<2>, usize, f64) {
    let mesh = SolidMesh::block(Vector::splat(-1.0), Vector::splat(1.0), [1, 1]).unwrap();
    let middle = mesh.nodes.iter().position(|x| x.norm() < 1e-12).unwrap();
    let mut setup = solid(mesh, MODULI, |x| x.norm() > 1e-12);
    let held = HeldNodes { nodes: vec![middle as u32], velocity: [None, Some(Signal::ZERO)] };
    setup.held.push(held);
    let [density, young, poisson] = MODULI;
    let [shear, bulk] = [young / (2.0 + 2.0 * poisson), young / (3.0 - 6.0 * poisson)];
    let stiffness = 2.0 * shear * 448.0 / 135.0 + bulk * 64.0 / 27.0;
    setup.velocity[middle] = Vector([1e-4, 0.0]);
    (setup, middle, (stiffness / (density * (16.0 / 15.0_f64).powi(2))).sqrt())
}

/// Frequency over ω and damping ratio of steps of `h`/ω, θ = `None`: by backward Euler.
///
/// Of two roots z, z̄ any sequence obeys x_{n+2} = 2 Re z x_{n+1} − |z|² x_n; the third root of the scheme has died out
/// by then.
fn measured(theta: Option<f64>, h: f64) -> [f64; 2] {
    let (setup, middle, omega) = element();
    let dt = h / omega;
    let mut run = SolidsAlone::new(setup, dt, theta.unwrap_or(1.0));
    let swings = 40;
    let x: Vec<f64> = (0..swings)
        .map(|_| {
            // The first step of a run is one of backward Euler.
            run.steps = if theta.is_none() { 0 } else { run.steps };
            run.solve_alone(Vector::ZERO);
            run.structure.state.velocity[middle][0]
        })
        .collect();
    let [a, b, c, d]: [f64; 4] = x[swings - 4..].try_into().unwrap();
    let determinant = b * b - a * c;
    let (trace, square) = ((b * c - a * d) / determinant, (c * c - b * d) / determinant);
    let angle = (0.5 * trace / square.sqrt()).acos();
    let decay = -0.5 * square.ln();
    [angle / h, decay / angle.hypot(decay)]
}

/// The same by the amplification of the scheme.
fn exact(theta: Option<f64>, h: f64) -> [f64; 2] {
    let z = match theta {
        None => over([1.0, 0.0], [1.0, -h]),
        Some(theta) => {
            let (b2, b1) = (theta - 0.5, 1.5 - 2.0 * theta);
            // (1 − i h θ) z² − (1 + i h β₁) z − i h β₂ = 0: the root near one.
            let (a, b) = ([1.0, -h * theta], [1.0, h * b1]);
            let four = times(a, [0.0, 4.0 * h * b2]);
            over(plus(b, root(plus(times(b, b), four))), scaled(a, 2.0))
        }
    };
    let (angle, decay) = (z[1].atan2(z[0]), -z[0].hypot(z[1]).ln());
    [angle / h, decay / angle.hypot(decay)]
}

#[test]
fn an_oscillator_has_frequency_and_damping_of_the_scheme() {
    for theta in [None, Some(1.0), Some(0.6), Some(0.5)] {
        for h in [0.1, 0.2, 0.4] {
            let (found, closed) = (measured(theta, h), exact(theta, h));
            assert!((found[0] - closed[0]).abs() < 1e-6 && (found[1] - closed[1]).abs() < 1e-6, "{theta:?} {h}");
        }
    }
}

/// The published sizes for small steps: backward Euler h/2 and 1 − h²/3; midpoint (the trapezoidal rule, θ = ½) 0 and
/// 1 − h²/12; θ = 0.6 0.05 h³ and 1 − 0.18 h² (J.1).
#[test]
fn small_steps_have_the_published_damping() {
    let h = 0.1_f64;
    for (theta, damping, frequency) in
        [(None, h / 2.0, 1.0 / 3.0), (Some(0.6), 0.05 * h.powi(3), 0.18), (Some(0.5), 0.0, 1.0 / 12.0)]
    {
        let [found, zeta] = measured(theta, h);
        assert!((zeta - damping).abs() < 0.05 * damping + 1e-7, "{theta:?}: {zeta} {damping}");
        assert!(((1.0 - found) / h.powi(2) / frequency - 1.0).abs() < 0.05, "{theta:?}: {found}");
    }
}
