//! The dissipation of FLIP and its filter becomes heat: a closed box of gas keeps its energy.

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

/// Energy that transfers have dissipated since the start, and the part of it that became heat [J].
fn dissipated(mpm: &Mpm<2>) -> [f64; 2] {
    ["transfer dissipation", "heat of transfer dissipation"].map(|name| term(mpm, name))
}

/// Gas without external forces: the part of the nodal increments that particles don't take is no work of the stresses
/// either (guide, "Between particles and grid"), so that no energy is dissipated or heated.
#[test]
fn pure_flip_of_a_gas_dissipates_and_heats_nothing() {
    let mut mpm = start(box_of_gas(8, flip(f64::INFINITY, 0, 0), sloshing));
    run(&mut mpm, 1.0, 1.0, |_, _, _| {}).unwrap();
    let ([lost, heat], kept) = (dissipated(&mpm), term(&mpm, "stress update error"));
    // Exactly zero but for rounding and the error of the stress update; the work on the nodes beyond that is 1e-4 of
    // the energy.
    assert!(lost.abs() < 1e-6 * energy(&mpm) && heat.abs() < 1e-15 * energy(&mpm), "{lost} {heat}");
    assert!(kept.abs() < 1e-5 * energy(&mpm), "{kept}");
}

/// One step of a gas under uniform pressure, which nothing accelerates, with filters of every order.
#[test]
fn the_loss_of_every_filter_becomes_heat() {
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

/// The total energy of a closed box is constant. With heat it changes by the error of the stress update alone, less
/// than 0.2 % of the kinetic energy at the start, ½ ∫ ρ v² = 0.0325; without it the filter takes more than twice as
/// much.
#[test]
fn heat_of_dissipation_keeps_the_energy_of_a_closed_box_of_gas() {
    let defect = |dissipation| {
        let mut setup = box_of_gas(8, flip(f64::INFINITY, 2, 50), sloshing);
        setup.dissipation = dissipation;
        let mut mpm = start(setup);
        let before = energy(&mpm);
        run(&mut mpm, END, 1.0, |_, _, _| {}).unwrap();
        (energy(&mpm) - before) / 0.0325
    };
    let [kept, lost] = [Dissipation::Heat, Dissipation::Lost].map(defect);
    assert!(kept.abs() < 2e-3 && lost < -4e-3, "{kept} {lost}");
}
