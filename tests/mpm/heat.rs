//! What FLIP and its filter dissipate becomes heat: a box of gas keeps its energy.

use crate::model::*;
use lateen::math::Vector;
use lateen::mpm::{Dissipation, KernelKind, Mpm, Setup, Transfer, WallKind};
use lateen::simulation::Solver;

const END: f64 = 2.0;

/// A unit box full of gas at pressure 1 and density 1 with `velocity`, `n` cells and 3 n particles wide.
fn box_of_gas(n: i32, transfer: Transfer, velocity: impl Fn(Vector<2>) -> Vector<2>) -> Setup<2> {
    let mut setup = setup(grid([0.0; 2], 1.0 / f64::from(n), [n; 2], WallKind::Slip));
    (setup.transfer, setup.dissipation) = (transfer, Dissipation::Heat);
    let count = 3 * n as usize;
    let mut gas = body(ideal_gas(1.0, 1.4), ([0.0; 2], [count; 2], 1.0 / count as f64), |_| true, velocity);
    gas.state.iter_mut().for_each(|state| state.pressure = Some(1.0));
    setup.bodies = vec![gas];
    setup
}

/// Gas that sloshes between the walls and turns.
fn sloshing(x: Vector<2>) -> Vector<2> {
    use std::f64::consts::PI;
    let (s, c) = (x.map(|x| (PI * x).sin()), x.map(|x| (PI * x).cos()));
    Vector([0.3 * s[0] + 0.2 * s[0] * c[1], -0.2 * c[0] * s[1]])
}

/// A velocity without any order.
fn noise(x: Vector<2>) -> Vector<2> {
    Vector([(1e4 * x[0] + 3e3 * x[1]).sin(), (7e3 * x[0] - 2e4 * x[1]).sin()])
}

fn flip(relaxation: f64, filter_order: u32, filter_interval: u32) -> Transfer {
    Transfer::Flip { relaxation, filter_order, filter_interval }
}

fn energy(mpm: &Mpm<2>) -> f64 {
    term(mpm, "kinetic energy: body") + term(mpm, "internal energy: body")
}

/// What was dissipated since the start, and what of it became heat.
fn dissipated(mpm: &Mpm<2>) -> [f64; 2] {
    ["transfer dissipation", "heat of transfer dissipation"].map(|name| term(mpm, name))
}

/// Gas that moves by itself: what particles don't take of the increments of the nodes, the stresses don't do as work, and no
/// account holds it.
#[test]
fn what_flip_leaves_of_stresses_is_in_no_account() {
    let mut mpm = start(box_of_gas(8, flip(f64::INFINITY, 0, 0), sloshing));
    run(&mut mpm, 1.0, 1.0, |_, _, _| {}).unwrap();
    let ([lost, heat], kept) = (dissipated(&mpm), term(&mpm, "stress update error"));
    // Work on nodes that nobody gets: 1e-4 of the energy and more.
    assert!(lost.abs() < 1e-6 * energy(&mpm) && heat.abs() < 1e-15 * energy(&mpm), "{lost} {heat}");
    assert!(kept.abs() < 1e-5 * energy(&mpm), "{kept}");
}

/// One step of a gas under uniform pressure, which nothing accelerates, with filters of every order.
#[test]
fn what_filters_take_is_heat() {
    for transfer in (1..=5).map(|order| flip(f64::INFINITY, order, 1)) {
        for kernel in [KernelKind::Linear, KernelKind::Quadratic] {
            let mut setup = box_of_gas(6, transfer, noise);
            setup.kernel = kernel;
            let mut mpm = start(setup);
            let dt = 0.31 / 6.0 / f64::sqrt(1.4); // the filter is due after 0.3 h/c
            mpm.step(0.0, dt).unwrap();
            let [lost, heat] = dissipated(&mpm);
            assert!(heat > 0.4, "{transfer:?} {kernel:?}: {heat} of 0.5");
            assert!((lost - heat).abs() < 1e-14, "{transfer:?} {kernel:?}: {lost} {heat}");
        }
    }
}

/// The energy of a closed box is constant. What is left to lose is the error of the stress update.
#[test]
fn a_closed_box_keeps_its_energy() {
    let defect = |dissipation| {
        let mut setup = box_of_gas(8, flip(f64::INFINITY, 2, 50), sloshing);
        setup.dissipation = dissipation;
        let mut mpm = start(setup);
        let before = energy(&mpm);
        run(&mut mpm, END, 1.0, |_, _, _| {}).unwrap();
        (energy(&mpm) / before - 1.0).abs()
    };
    let [kept, lost] = [Dissipation::Heat, Dissipation::Lost].map(defect);
    assert!(kept < 0.2 * lost, "{kept} {lost}");
}
