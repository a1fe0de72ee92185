//! The same bits for any number of threads and after a resumed run; errors that name their place.

use crate::bits::{restore, state, step};
use crate::model::*;
use lateen::error::Place;
use lateen::math::{Signal, Vector};
use lateen::mpm::{Dissipation, Locking, Mpm, StressUpdate, Transfer, WallKind};
use lateen::simulation::Solver;

/// Rubber that turns, with APIC.
fn rubber_cube() -> Mpm<3> {
    let mut setup = setup(grid([0.0; 3], 0.5, [8, 8, 8], WallKind::Slip));
    setup.transfer = Transfer::Apic;
    setup.gravity = [Signal::ZERO, Signal::ZERO, Signal::Constant(-10.0)];
    let velocity = |x: Vector<3>| Vector([0.1 * x[1], -0.2, 0.3 * x[0]]);
    setup.bodies = vec![body(rubber(10.0, 1e4, 0.3), ([0.5; 3], [12, 12, 12], 0.25), |_| true, velocity)];
    start(setup)
}

/// Gas in motion, with FLIP, its filter, and their heat.
fn gas_cube() -> Mpm<3> {
    let mut setup = setup(grid([0.0; 3], 0.5, [8, 8, 8], WallKind::Slip));
    setup.transfer = Transfer::Flip { relaxation: f64::INFINITY, filter_order: 2, filter_interval: 5 };
    setup.dissipation = Dissipation::Heat;
    let velocity = |x: Vector<3>| Vector([0.1 * x[1], (3.0 * x[2]).sin(), 0.3 * x[0]]);
    let mut gas = body(ideal_gas(1.0, 1.4), ([0.5; 3], [12, 12, 12], 0.25), |_| true, velocity);
    gas.state.iter_mut().for_each(|state| state.pressure = Some(1.0));
    setup.bodies = vec![gas];
    start(setup)
}

/// The same gas in an atmosphere, which has done work, and with corrected volumes, by the time that it is saved.
fn gas_cube_in_air() -> Mpm<3> {
    let mut setup = setup(grid([0.0; 3], 0.5, [8, 8, 8], WallKind::Slip));
    let velocity = |x: Vector<3>| Vector([0.1 * x[1], (3.0 * x[2]).sin(), 0.3 * x[0]]);
    let mut gas = body(ideal_gas(1.0, 1.4), ([0.5; 3], [12, 12, 12], 0.25), |_| true, velocity);
    gas.state.iter_mut().for_each(|state| state.pressure = Some(1.0));
    gas.ambient = 0.7;
    setup.bodies = vec![gas];
    start(setup)
}

/// Rubber on a floor that it may leave.
fn landed_cube() -> Mpm<3> {
    let mut setup = setup(grid([0.0; 3], 0.5, [8, 8, 8], WallKind::Open));
    setup.grid.walls[2][0] = wall(WallKind::Separate);
    let velocity = |x: Vector<3>| Vector([0.0, 0.1 * x[0], -1.0]);
    setup.bodies = vec![body(rubber(10.0, 1e4, 0.3), ([0.5, 0.5, 0.25], [8, 8, 8], 0.25), |_| true, velocity)];
    start(setup)
}

const MODELS: [fn() -> Mpm<3>; 4] = [rubber_cube, gas_cube, gas_cube_in_air, landed_cube];

#[test]
fn states_are_the_same_bits_for_any_number_of_threads() {
    for model in MODELS {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut mpm = model();
                (0..20).fold(0.0, |t, _| step(&mut mpm, t));
                state(&mut mpm)
            })
        };
        let one = run(1);
        assert!(one == run(2) && one == run(5));
    }
}

#[test]
fn a_restored_state_continues_with_the_same_bits() {
    MODELS.into_iter().for_each(resumes);
}

fn resumes(model: fn() -> Mpm<3>) {
    let mut first = model();
    let mut t = (0..15).fold(0.0, |t, _| step(&mut first, t));
    let saved = state(&mut first);
    let mut second = model();
    restore(&mut second, &saved);
    for _ in 0..15 {
        step(&mut second, t);
        t = step(&mut first, t);
    }
    assert!(state(&mut first) == state(&mut second));
}

/// Water that falls on a floor, with averaged volumes and pressures.
fn water_cube() -> Mpm<3> {
    let mut setup = setup(grid([0.0; 3], 0.5, [8, 8, 8], WallKind::Slip));
    (setup.transfer, setup.locking) = (Transfer::Apic, Locking::Average { blend: 1.0 });
    setup.gravity = [Signal::ZERO, Signal::ZERO, Signal::Constant(-10.0)];
    setup.bodies =
        vec![body(liquid(1000.0, 50.0), ([0.5; 3], [12, 12, 12], 0.25), |_| true, |x| Vector([0.1 * x[1], 0.0, -1.0]))];
    start(setup)
}

/// A run that stops shows the restored state without taking a step: fields, ledger, forces and counts must be complete.
#[test]
fn a_restored_state_has_the_same_snapshot() {
    for model in [rubber_cube, gas_cube, gas_cube_in_air, water_cube] {
        let mut first = model();
        (0..15).fold(0.0, |t, _| step(&mut first, t));
        let saved = state(&mut first);
        let mut second = model();
        restore(&mut second, &saved);
        let (before, after) = (first.snapshot(), second.snapshot());
        for (before, after) in before.points.iter().zip(&after.points) {
            for (before, after) in before.fields.iter().zip(&after.fields) {
                assert!(before.values() == after.values(), "{}", before.name);
            }
        }
        let terms = |ledger: &lateen::simulation::Ledger| -> Vec<u64> {
            ledger.terms.iter().map(|term| term.value.to_bits()).collect()
        };
        assert!(terms(&before.ledger) == terms(&after.ledger));
        assert!(before.forces == after.forces && before.counts == after.counts);
    }
}

#[test]
fn a_particle_that_leaves_the_domain_is_an_error_with_its_number() {
    let mut setup = setup(grid([0.0, 0.0], 1.0, [6, 6], WallKind::Open));
    let velocity = |_| Vector([0.0, 3.0]);
    setup.bodies = vec![body(rubber(1.0, 1e3, 0.3), ([2.0, 4.0], [2, 2], 0.5), |_| true, velocity)];
    let mut mpm = start(setup);
    let error = run(&mut mpm, 1.0, 1.0, |_, _, _| {}).unwrap_err();
    assert_eq!((error.what.as_str(), error.quantity), ("a particle left the domain", "y"));
    assert!(error.value > 6.0 && error.time > 0.3, "{error}");
    assert!(matches!(error.place, Place::Particle { id: 2, .. }), "{error}");
}

#[test]
fn a_particle_state_that_is_nan_is_an_error_with_its_number() {
    let mut setup = setup(grid([0.0, 0.0], 1.0, [6, 6], WallKind::Open));
    setup.stress_update = StressUpdate::First;
    setup.gravity[1] = Signal::Constant(f64::NAN);
    setup.bodies = vec![body(rubber(1.0, 1e3, 0.3), ([2.0, 2.0], [4, 4], 0.5), |_| true, |_| Vector::ZERO)];
    let error = run(&mut start(setup), 1.0, 1.0, |_, _, _| {}).unwrap_err();
    assert_eq!(error.what, "a particle's state is not a number");
    assert!(matches!(error.place, Place::Particle { id: 0, .. }), "{error}");
    assert!(error.advice.contains("mpm.safety"), "{error}");
}

#[test]
fn a_particle_turned_inside_out_is_an_error() {
    let mut setup = setup(grid([0.0, 0.0], 1.0, [8, 8], WallKind::Open));
    // Everything flies to the line x = 4 and is beyond it after a time of 1.
    let velocity = |x: Vector<2>| Vector([4.0 - x[0], 0.0]);
    setup.bodies = vec![body(rubber(1.0, 1e3, 0.3), ([2.0, 2.0], [8, 8], 0.5), |_| true, velocity)];
    let mut mpm = start(setup);
    let error = mpm.step(0.0, 8.0).unwrap_err();
    assert_eq!((error.what.as_str(), error.quantity), ("a particle was turned inside out", "volume ratio"));
    assert!(error.value <= 0.0 && matches!(error.place, Place::Particle { .. }), "{error}");
}

/// No particle is broken, but products of forces and velocities are beyond the largest number.
#[test]
fn an_energy_that_is_nan_is_an_error() {
    let mut setup = setup(grid([0.0, 0.0], 1.0, [8, 8], WallKind::Slip));
    let mut gas = body(ideal_gas(1.0, 1.4), ([2.0, 2.0], [8, 8], 0.5), |_| true, |_| Vector::ZERO);
    gas.state.iter_mut().for_each(|state| state.pressure = Some(1e300));
    setup.bodies = vec![gas];
    let mut mpm = start(setup);
    let mut t = 0.0;
    let error = (0..20).find_map(|_| {
        let dt = mpm.stable_dt();
        t += dt;
        mpm.step(t - dt, dt).err()
    });
    let error = error.expect("the run stops");
    assert_eq!((error.what.as_str(), error.quantity), ("the energy is not a number", "energy"));
}

/// The work of the atmosphere since the start, −p_a ΔV, continues after a restoration.
#[test]
fn the_work_of_the_atmosphere_continues_from_a_restored_state() {
    let mut first = gas_cube_in_air();
    let t = (0..15).fold(0.0, |t, _| step(&mut first, t));
    let mut second = gas_cube_in_air();
    restore(&mut second, &state(&mut first));
    step(&mut second, t);
    let volume = |mpm: &Mpm<3>| field(mpm, "volume").iter().sum::<f64>();
    let work = 0.7 * (volume(&gas_cube_in_air()) - volume(&second));
    assert!(work.abs() > 1e-3, "the gas has changed its volume: {work}");
    assert!((term(&second, "work of the atmosphere") - work).abs() < 1e-12, "{work}");
}

#[test]
fn wrong_models_are_errors_at_their_keys() {
    let mut setup = setup(grid([0.0, 0.0], 1.0, [6, 6], WallKind::Open));
    setup.bodies = vec![body(rubber(1.0, 1e3, 0.3), ([5.0, 4.0], [4, 4], 0.5), |_| true, |_| Vector::ZERO)];
    setup.safety = 0.0;
    let findings = Mpm::new(setup).err().unwrap();
    let keys: Vec<_> = findings.iter().map(|finding| finding.key.as_str()).collect();
    assert_eq!(keys, ["mpm.safety", "body[0].region"]);
}
