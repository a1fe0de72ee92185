//! A column of gas that ends in an atmosphere that isn't modelled: waves of one dimension, which have closed forms.

use crate::model::*;
use lateen::math::Vector;
use lateen::mpm::{BodySetup, Mpm, WallKind};

/// Width of the column in cells: so narrow that nothing but the law changes volumes.
const WIDE: i32 = 2;

/// Gas of density 1.4 (c² = p) between a wall at x = 0 and its free end at x = 1, `n` cells long, in air of `ambient`.
fn column(n: i32, [pressure, ambient]: [f64; 2], velocity: impl Fn(Vector<2>) -> Vector<2>) -> Mpm<2> {
    let cell = 1.0 / f64::from(n);
    let mut grid = grid([0.0; 2], cell, [2 * n, WIDE], WallKind::Slip);
    grid.walls[0][1] = wall(WallKind::Open);
    let count = [2 * n as usize, 2 * WIDE as usize];
    let mut gas = body(ideal_gas(1.4, 1.4), ([0.0; 2], count, 0.5 * cell), |_| true, velocity);
    gas.state.iter_mut().for_each(|state| state.pressure = Some(pressure));
    let mut setup = setup(grid);
    setup.bodies = vec![BodySetup { ambient, ..gas }];
    start(setup)
}

/// Growth of the length of the column since the start, from the volumes of its particles.
fn growth(mpm: &Mpm<2>, n: i32) -> f64 {
    field(mpm, "volume").iter().sum::<f64>() * f64::from(n) / f64::from(WIDE) - 1.0
}

/// An open pipe: a closed and a free end make the period 4 L/c, with c of the absolute pressure.
#[test]
fn a_gas_column_in_an_atmosphere_has_the_period_of_an_open_pipe() {
    let n = 20;
    let mode = |x: Vector<2>| Vector([0.01 * (0.5 * std::f64::consts::PI * x[0]).sin(), 0.0]);
    let mut mpm = column(n, [1.0, 1.0], mode);
    let (mut crossings, mut last) = (Vec::new(), [0.0; 2]);
    let mut largest = 0.0_f64;
    run(&mut mpm, 8.5, 1.0, |t, _, mpm| {
        let y = growth(mpm, n);
        if last[1] * y < 0.0 {
            crossings.push(last[0] + (t - last[0]) * last[1] / (last[1] - y));
        }
        largest = largest.max(y.abs());
        last = [t, y];
    })
    .unwrap();
    assert_eq!(crossings.len(), 4, "{crossings:?}");
    let period = 2.0 * (crossings[3] - crossings[0]) / 3.0;
    assert!((period / 4.0 - 1.0).abs() < 0.005, "{period}");
    // u/ω = 0.01 · 2/π
    assert!((largest / 0.006_366 - 1.0).abs() < 0.01, "{largest}");
}

/// Compares the work of the atmosphere on a column at another pressure, whose end moves with the speed u until waves
/// return from the wall, with −p_a A u t.
fn work_of_the_atmosphere([pressure, ambient]: [f64; 2], u: f64, [end, tolerance]: [f64; 2]) {
    let n = 80;
    let mut mpm = column(n, [pressure, ambient], |_| Vector::ZERO);
    run(&mut mpm, end, 1.0, |_, _, _| {}).unwrap();
    let area = f64::from(WIDE) / f64::from(n);
    let work = term(&mpm, "work of the atmosphere");
    assert!((work + ambient * area * growth(&mpm, n)).abs() < 1e-12, "it is −p_a ΔV: {work}");
    let expected = -ambient * area * u * end;
    assert!((work / expected - 1.0).abs() < tolerance, "{work} {expected}");
    let stored = term(&mpm, "kinetic energy: body") + term(&mpm, "internal energy: body");
    let gained = stored - term(&mpm, "stored energy at the start");
    assert!(
        (gained / work - 1.0).abs() < 1e-3,
        "of p dV the gas keeps what the atmosphere doesn't get: {gained} {work}"
    );
    assert!(closure(&mpm).abs() < 1e-12 * stored);
}

/// From twice the pressure of the atmosphere a rarefaction runs into the gas: u = 2c/(γ − 1) (1 − (p_a/p)^((γ−1)/2γ)).
#[test]
fn expanding_gas_does_the_work_of_a_rarefaction_on_the_atmosphere() {
    work_of_the_atmosphere([1.0, 0.5], 5.0 * (1.0 - 0.5_f64.powf(1.0 / 7.0)), [0.8, 0.01]);
}

/// From four fifths of it a shock does: u = (p_a − p) √(2/(ρ ((γ + 1) p_a + (γ − 1) p))), to the ringing behind the
/// shock.
#[test]
fn the_atmosphere_does_the_work_of_a_shock_on_gas_that_it_compresses() {
    work_of_the_atmosphere([0.8, 1.0], -0.2 * (2.0 / (1.4 * (2.4 + 0.4 * 0.8_f64))).sqrt(), [0.7, 0.03]);
}
