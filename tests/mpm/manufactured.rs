//! Order of accuracy by a manufactured solution (Wallstedt & Guilkey 2008; theory A.18), along one axis.
//!
//! The solution is given by the inverse motion X(x, t), so that the body force is a formula in x and t:
//!
//! ```text
//! X(x, t) = x − (A/k) sin(kx) s,   s = sin(ωt),   q = ∂X/∂x = 1 − A cos(kx) s = 1/F
//! v = −(∂X/∂t)/q,   a = ∂v/∂t + v ∂v/∂x,   σ = G (1/q − q)   (neo-Hookean, ν = 0),   ρ = ρ0 q
//! b = a − (∂σ/∂x)/ρ
//! ```
//!
//! Its ends rest on walls that slip.

use crate::model::*;
use lateen::math::{Signal, Vector};
use lateen::mpm::WallKind;

const AMPLITUDE: f64 = 0.02;
const WAVE: f64 = std::f64::consts::TAU;
/// G = 50 and ρ0 = 1 give the speed 10, and the standing wave of k the frequency 10 k.
const SHEAR: f64 = 50.0;
const FREQUENCY: f64 = 10.0 * WAVE;

/// b(x, t), written out.
fn body_force() -> Signal {
    let (a, k, w, g) = (AMPLITUDE, WAVE, FREQUENCY, SHEAR);
    let (s, ds, dds) = (format!("sin({w}*t)"), format!("({w}*cos({w}*t))"), format!("(-{w}*{w}*sin({w}*t))"));
    let (sin, cos) = (format!("sin({k}*x)"), format!("cos({k}*x)"));
    let q = format!("(1-{a}*{cos}*{s})");
    let (q_x, q_t) = (format!("({a}*{k}*{sin}*{s})"), format!("(-{a}*{cos}*{ds})"));
    let v = format!("({a}/{k}*{sin}*{ds}/{q})");
    let v_t = format!("({a}/{k}*{sin}*({dds}/{q}-{ds}*{q_t}/{q}^2))");
    let v_x = format!("({a}/{k}*({k}*{cos}*{ds}/{q}-{sin}*{ds}*{q_x}/{q}^2))");
    Signal::formula(&format!("{v_t}+{v}*{v_x}+{g}*(1/{q}^2+1)*{q_x}/{q}")).expect("the formula is sound")
}

/// Position at `t` of the particle that started at `x0`: X(x, t) = x0, by Newton's method.
fn exact(x0: f64, t: f64) -> f64 {
    let s = (FREQUENCY * t).sin();
    (0..50).fold(x0, |x, _| {
        let residual = x - AMPLITUDE / WAVE * (WAVE * x).sin() * s - x0;
        x - residual / (1.0 - AMPLITUDE * (WAVE * x).cos() * s)
    })
}

/// Root mean square of the displacement error with `cells` cells, over the amplitude, after a quarter period; steps are
/// `courant` of their bound.
fn error(cells: i32, courant: f64) -> f64 {
    let h = 1.0 / f64::from(cells);
    let mut setup = setup(grid([0.0, 0.0], h, [cells, 1], WallKind::Slip));
    setup.gravity = [body_force(), Signal::ZERO];
    let velocity = |x: Vector<2>| Vector([AMPLITUDE / WAVE * FREQUENCY * (WAVE * x[0]).sin(), 0.0]);
    let lattice = ([0.0, 0.0], [2 * cells as usize, 2], 0.5 * h);
    setup.bodies = vec![body(rubber(1.0, 2.0 * SHEAR, 0.0), lattice, |_| true, velocity)];
    let mut mpm = start(setup);
    let before = positions(&mpm);
    let end = 0.25 * std::f64::consts::TAU / FREQUENCY;
    run(&mut mpm, end, courant, |_, _, _| {}).unwrap();
    let after = positions(&mpm);
    let square: f64 = before.iter().zip(&after).map(|(a, b)| (b[0] - exact(a[0], end)).powi(2)).sum();
    (square / before.len() as f64).sqrt() * WAVE / AMPLITUDE
}

/// The displacement converges with the second order at least, down to 2e-4 of its amplitude, where the error of
/// quadrature by particles remains, which falls more slowly. The error of the step is smaller: halving it changes
/// little. Those last bounds are measured ones.
#[test]
fn the_displacement_of_a_manufactured_solution_converges_with_second_order() {
    let errors = [8, 16, 32, 64].map(|cells| error(cells, 0.5));
    let order = 0.5 * (errors[0] / errors[2]).log2();
    assert!(order > 2.0, "order {order}, errors {errors:?}");
    let halved = error(32, 0.25);
    assert!(halved < 3e-4 && errors[2] - halved < 1e-4, "{errors:?}, in steps of half the size {halved}");
    assert!(errors[3] < 2e-4, "{errors:?}");
}
