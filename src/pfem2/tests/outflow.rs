//! The volume of a fluid in a domain that it may leave.

use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::simulation::Solver;

/// Volume of the fluid and what has left of it, as histories show them [m³].
fn volumes<const D: usize, const N: usize>(pfem: &Pfem2<D, N>, fluid: &str) -> [f64; 2] {
    let ledger = pfem.snapshot().ledger;
    ["volume", "outflow"].map(|what| {
        let name = format!("{what}: {fluid}");
        ledger.terms.iter().find(|term| term.name == name).unwrap().value
    })
}

/// Water between the planes x = 1.1 and 1.7 in a channel of length 2.4 that air flows through, with the speed 1.3: its
/// volume over that of the channel's section, less V₀ − v (t − t₀), at its worst, and the largest shift.
fn plug<const D: usize, const N: usize>(mesh: Mesh<D, N>, section: f64, dt: f64) -> [f64; 2] {
    const SPEED: f64 = 1.3;
    let (from, to, end) = (1.1, 1.7, 2.4);
    let along: [Signal; D] = std::array::from_fn(|axis| if axis == 0 { SPEED.into() } else { 0.0.into() });
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    let mut sets = vec![
        set(&mesh, "in", Condition::Inlet(along), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Outlet, |x| near(x[0], end)),
        set(&mesh, "sides", Condition::Slip, |x| (1..D).any(|axis| x[axis] == 0.0 || near(x[axis], 0.4))),
    ];
    sets[0].brings = Some(1);
    let phi = |x: Vector<D>| (x[0] - 0.5 * (from + to)).abs() - 0.5 * (to - from);
    let physics = physics(vec![fluid("water", 1000.0, 0.0), fluid("air", 1.0, 0.0)], weightless());
    let start = |_: Vector<D>| Vector::from_fn(|axis| if axis == 0 { SPEED } else { 0.0 });
    let mut setup = setup(mesh, sets, physics, |x| u8::from(phi(x) >= 0.0), start);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, phi, &mut setup.particles));
    let mut pfem = Pfem2::new(setup);
    let (mut worst, mut shift) = (0.0f64, 0.0f64);
    for k in 0..(1.0 / dt) as usize {
        pfem.step(k as f64 * dt, dt).unwrap();
        let gone = |place: f64| (place + SPEED * (k + 1) as f64 * dt - end).max(0.0);
        let [volume, left] = volumes(&pfem, "water").map(|volume| volume / section);
        worst = worst.max((left - (gone(to) - gone(from))).abs());
        worst = worst.max((volume + left - (to - from)).abs());
        shift = if volume > 0.05 { shift.max(pfem.interface.shift.abs()) } else { shift };
    }
    [worst, shift]
}

/// Exactly, but for the line between the particles' depths: six tetrahedra across the plug know it to a thousandth of
/// one.
#[test]
fn a_plug_of_water_leaves_through_an_outlet_as_fast_as_it_moves() {
    let flat = Mesh::<2, 3>::block(Vector::ZERO, Vector([2.4, 0.4]), [36, 6]).unwrap();
    let [volume, shift] = plug(flat, 0.4, 0.032);
    assert!(volume < 1e-5 && shift < 1e-3, "{volume:e} {shift:e}");
    let full = Mesh::<3, 4>::block(Vector::ZERO, Vector([2.4, 0.4, 0.4]), [24, 4, 4]).unwrap();
    let [volume, shift] = plug(full, 0.16, 0.05);
    assert!(volume < 2e-4 && shift < 1e-3, "{volume:e} {shift:e}");
}

/// Water falls in a tank that is open above; air comes and goes.
#[test]
fn the_volume_of_water_in_an_open_tank_is_kept_to_the_last_digits() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 0.8]), [20, 16]).unwrap();
    let sets = vec![
        set(&mesh, "top", Condition::Pressure(0.0.into()), |x| x[1] == 0.8),
        set(&mesh, "floor and sides", Condition::Slip, |x| x[0] == 0.0 || x[0] == 1.0 || x[1] == 0.0),
    ];
    let phi = |x: Vector<2>| (x[0] - 0.37).max(x[1] - 0.52);
    let physics = physics(vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)], [0.0.into(), (-9.81).into()]);
    let mut setup = setup(mesh, sets, physics, |x| u8::from(phi(x) >= 0.0), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, phi, &mut setup.particles));
    let mut pfem = Pfem2::new(setup);
    let [start, _] = volumes(&pfem, "water");
    for k in 0..40 {
        pfem.step(f64::from(k) * 0.01, 0.01).unwrap();
        let [volume, left] = volumes(&pfem, "water");
        assert!((volume / start - 1.0).abs() < 1e-10 && left == 0.0, "{k}: {volume} {left}");
    }
    // The front has run through the tank.
    assert!(pfem.balance.totals.kinetic > 100.0, "{}", pfem.balance.totals.kinetic);
}

/// Fluid enters at the left, and the right side is open from top to bottom under no pressure: it falls out below, and
/// comes in above. None falls deeper than the height of the channel, which gives √(2 g H) (Torricelli).
#[test]
fn the_outflow_of_an_open_side_is_no_faster_than_free_fall() {
    const HEIGHT: f64 = 1.0;
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([2.0, HEIGHT]), [20, 10]).unwrap(), 0.1);
    let sets = vec![
        set(&mesh, "in", Condition::Inlet([formula("0.3*ramp(t, 1)"), 0.0.into()]), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Outlet, |x| x[0] == 2.0),
        set(&mesh, "floor and top", Condition::Slip, |x| x[1] == 0.0 || x[1] == HEIGHT),
    ];
    let physics = physics(vec![fluid("oil", 900.0, 0.5)], [0.0.into(), (-9.81).into()]);
    let mut pfem = Pfem2::new(setup(mesh, sets, physics, |_| 0, |_| Vector::ZERO));
    let bound = (2.0 * 9.81 * HEIGHT).sqrt();
    for k in 0..150 {
        pfem.step(f64::from(k) * 0.02, 0.02).unwrap();
        let speed = fastest(&pfem.system.velocity);
        assert!(speed < 1.2 * bound, "{k}: {speed} of {bound}");
    }
}

/// Flow between plates that a traction A at one end drives against no pressure at the other: when nothing changes any
/// more, each plate takes half of the force A on the section, to the corners that it shares with the open ends, and
/// momentum stays.
#[test]
fn plates_take_the_force_that_drives_the_flow_between_them() {
    let (mesh, driving) = (Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [8; 2]).unwrap(), 0.001);
    let sets = vec![
        set(&mesh, "in", Condition::Traction([driving.into(), Signal::ZERO]), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Pressure(Signal::ZERO), |x| x[0] == 1.0),
        set(&mesh, "bottom", Condition::wall(), |x| x[1] == 0.0),
        set(&mesh, "top", Condition::wall(), |x| x[1] == 1.0),
    ];
    let fluids = vec![fluid("oil", 1.0, 0.5)];
    let mut pfem = Pfem2::new(setup(mesh, sets, physics(fluids, weightless()), |_| 0, |_| Vector::ZERO));
    (0..60).for_each(|k| pfem.step(f64::from(k) * 0.1, 0.1).unwrap());
    let both: f64 = pfem.forces.on_parts.last.iter().map(|force| force[0]).sum();
    assert!((both / driving - 1.0).abs() < 1e-3, "{both}");
    assert!((pfem.forces.on_parts.last[0][0] / pfem.forces.on_parts.last[1][0] - 1.0).abs() < 0.1, "{:?}", pfem.forces);
}

/// Half of a plug of water leaves a channel full of air and the flow turns back, x(t) = x₀ + A sin(πt): what comes back
/// is the air that the outlet had at the start.
#[test]
fn backflow_brings_the_fluid_of_the_place_at_the_start() {
    const REACH: f64 = 0.5;
    const HEIGHT: f64 = 0.2;
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.2, HEIGHT]), [48, 8]).unwrap();
    let speed = format!("{REACH}*pi*cos(pi*t)");
    let sets = vec![
        set(&mesh, "in", Condition::Inlet([formula(&speed), 0.0.into()]), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Outlet, |x| x[0] == 1.2),
        set(&mesh, "sides", Condition::Slip, |x| x[1] == 0.0 || x[1] == HEIGHT),
    ];
    let phi = |x: Vector<2>| (x[0] - 0.7).abs() - 0.2;
    let physics = physics(vec![fluid("water", 1000.0, 0.0), fluid("air", 1.0, 0.0)], weightless());
    let start = Vector([REACH * std::f64::consts::PI, 0.0]);
    let mut setup = setup(mesh, sets, physics, |x| u8::from(phi(x) >= 0.0), |_| start);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, phi, &mut setup.particles));
    let mut pfem = Pfem2::new(setup);
    let mut shift = 0.0f64;
    for k in 0..100 {
        pfem.step(f64::from(k) * 0.01, 0.01).unwrap();
        shift = shift.max(pfem.interface.shift.abs());
    }
    let volume = pfem.system.contents.volumes[0] / HEIGHT;
    assert!((volume - 0.2).abs() < 1e-3 && shift < 1e-3, "{volume} {shift}");
    for x in &pfem.interface.outline.position {
        let away = (x[0] - 0.5).abs().min((x[0] - 0.7).abs());
        assert!(away < 2e-3, "{x:?}");
    }
}

/// A drop of water in air of a thousandth of its density drifts out of a channel with 0.1 m/s: it is gone when it
/// should be, and stirs up the air no more than a drop inside the channel does.
#[test]
fn a_drop_with_surface_tension_leaves() {
    const SPEED: f64 = 0.1;
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([0.04, 0.02]), [28, 14]).unwrap();
    let sets = vec![
        set(&mesh, "in", Condition::Inlet([SPEED.into(), 0.0.into()]), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Outlet, |x| x[0] == 0.04),
        set(&mesh, "sides", Condition::Slip, |x| x[1] == 0.0 || x[1] == 0.02),
    ];
    let phi = |x: Vector<2>| (x - Vector([0.028, 0.0101])).norm() - 0.005;
    let mut physics = physics(vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1.8e-5)], weightless());
    physics.tension = vec![([0, 1], 0.07)];
    let mut setup = setup(mesh, sets, physics, |x| u8::from(phi(x) >= 0.0), |_| Vector([SPEED, 0.0]));
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, phi, &mut setup.particles));
    let mut pfem = Pfem2::new(setup);
    let start = pfem.system.contents.volumes[0];
    let mut most = start;
    for k in 0..500 {
        pfem.step(f64::from(k) * 5e-4, 5e-4).unwrap();
        let (volume, speed) = (pfem.system.contents.volumes[0], fastest(&pfem.system.velocity));
        assert!(volume <= most * (1.0 + 1e-9) && speed < 2.0, "{k}: {volume:e} of {start:e}, {speed} m/s");
        most = volume;
    }
    // Its end is at the outlet after 0.17 s.
    assert!(most < 0.02 * start, "{most:e} of {start:e}");
}
