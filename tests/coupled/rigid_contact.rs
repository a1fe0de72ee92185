//! Sheets on walls and obstacles: Moreau's law with Coulomb's friction, exact where nothing else acts.

use crate::model::*;
use lateen::geometry::Region;
use lateen::math::{Signal, Vector};
use lateen::mpm::{MembraneSetup, Mpm, Obstacle, Setup, SheetContact, WallKind};
use lateen::simulation::Solver;

const GRAVITY: f64 = 9.81;

fn falling() -> [Signal; 2] {
    [Signal::ZERO, Signal::Constant(-GRAVITY)]
}

/// A strip of ten elements and 0.2 kg from `start` along the unit vector `along`.
fn strip(start: [f64; 2], along: [f64; 2]) -> MembraneSetup<2> {
    let place = |k: u32| Vector(start) + Vector(along) * (0.02 * f64::from(k));
    let elements = (0..10).map(|k| vec![k, k + 1]).collect();
    membrane((0..=10).map(place).collect(), elements, [1000.0, 1e7, 0.0, 1e-3], Vec::new())
}

fn plane(degrees: f64, kind: WallKind, velocity: [f64; 2]) -> Obstacle {
    let angle = degrees.to_radians();
    let region = Region::HalfSpace { point: [0.0; 3], normal: [-angle.sin(), angle.cos(), 0.0] };
    let velocity = [velocity[0], velocity[1], 0.0].map(Signal::Constant);
    Obstacle { name: "plane".into(), region, kind, velocity }
}

/// The strip on a plane under gravity.
fn on_plane(degrees: f64, kind: WallKind, velocity: [f64; 2]) -> Mpm<2> {
    let angle = degrees.to_radians();
    let (along, start_at) = ([angle.cos(), angle.sin()], [0.3 * angle.cos(), 0.3 * angle.sin()]);
    let setup = setup(open([-0.6, -0.6], 0.05, [24, 24]), Vec::new(), vec![strip(start_at, along)]);
    start(Setup { gravity: falling(), obstacles: vec![plane(degrees, kind, velocity)], ..setup })
}

fn force(mpm: &Mpm<2>, name: &str) -> [f64; 3] {
    let forces = mpm.snapshot().forces;
    forces.into_iter().find(|(own, _)| own == name).unwrap_or_else(|| panic!("no force `{name}`")).1
}

/// Steps of `dt` until `end`.
fn run_in_steps(mpm: &mut Mpm<2>, end: f64, dt: f64) {
    (0..(end / dt).round() as u32).for_each(|n| mpm.step(f64::from(n) * dt, dt).unwrap());
}

/// Mean velocity of the sheet, half a step before `t`.
fn mean_velocity(mpm: &Mpm<2>) -> Vector<2> {
    Vector([term(mpm, "momentum x"), term(mpm, "momentum y")]) / term(mpm, "mass")
}

/// On an incline a strip slides with g (sin θ − μ cos θ) if tan θ > μ, else it stays: to the last digits, since every
/// node does the same.
#[test]
fn a_strip_on_an_incline_slides_by_coulombs_law() {
    let (sin, cos) = (30.0_f64.to_radians().sin(), 30.0_f64.to_radians().cos());
    for coefficient in [0.0, 0.3, 0.57, 0.58, 0.9] {
        let mut mpm = on_plane(30.0, WallKind::Friction { coefficient }, [0.0; 2]);
        let mut last = 0.0;
        run(&mut mpm, 0.1, |t, _| last = t);
        let half = 0.5 * mpm.snapshot().dt;
        let expected = GRAVITY * (sin - coefficient * cos).max(0.0) * (last - half);
        let v = mean_velocity(&mpm);
        let error = (v - Vector([-cos, -sin]) * expected).norm();
        assert!(error < 1e-9, "μ = {coefficient}: {v:?} instead of {expected}");
        assert!(mpm.snapshot().ledger.closure(term(&mpm, "stored energy at the start")).abs() < 1e-12);
    }
}

/// A strip that falls askew on a floor of the domain comes to rest there: what it falls is what the wall dissipates,
/// its weight is what the wall bears, and it is nowhere below the floor.
#[test]
fn a_strip_that_falls_on_a_floor_comes_to_rest() {
    let mut grid = open([-0.1, 0.0], 0.05, [8, 8]);
    grid.walls[1][0].kind = WallKind::Separate;
    let sheet = strip([0.0, 0.05], [0.995, 0.099_874_921_777_190_89]);
    let sheet = MembraneSetup { damping: [20.0, 0.0], ..sheet };
    let mut mpm = start(Setup { gravity: falling(), ..setup(grid, Vec::new(), vec![sheet]) });
    let mut taken = 0.0_f64;
    run(&mut mpm, 1.0, |t, mpm| {
        let low = nodes(mpm).iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
        assert!(low > -1e-12, "t = {t}: a node lies at {low}");
        let now = term(mpm, "wall dissipation");
        assert!(now > taken - 1e-9, "t = {t}: the wall has taken {now} J, and {taken} J before");
        taken = taken.max(now);
    });
    let weight = term(&mpm, "mass") * GRAVITY;
    let borne = force(&mpm, "wall:bottom")[1];
    assert!((borne + weight).abs() < 1e-3 * weight, "the floor bears {borne} N of {weight}");
    assert!(term(&mpm, "kinetic energy: sheet") < 1e-6 * term(&mpm, "work of gravity: sheet"));
}

/// A floor that rises carries a strip at its own speed, does the work for it, and a belt that starts drags it along by
/// friction.
#[test]
fn moving_obstacles_do_work_on_a_strip() {
    // In short steps: momentum begins half of one later than positions, and the weight of that is not lifted.
    let mut mpm = on_plane(0.0, WallKind::Separate, [0.0, 0.5]);
    run_in_steps(&mut mpm, 0.1, 1e-4);
    let (mass, lift) = (term(&mpm, "mass"), 0.05);
    assert!((mean_velocity(&mpm) - Vector([0.0, 0.5])).norm() < 1e-9);
    let (work, lost) = (term(&mpm, "work of walls"), term(&mpm, "wall dissipation"));
    let (kinetic, height) = (0.5 * mass * 0.25, mass * GRAVITY * lift);
    assert!(
        (lost - kinetic).abs() < 0.02 * kinetic,
        "what is hit by a floor loses half of {} J, not {lost}",
        2.0 * kinetic
    );
    assert!((work - 2.0 * kinetic - height).abs() < 0.02 * work, "{work} J of {}", 2.0 * kinetic + height);

    let mut mpm = on_plane(0.0, WallKind::Friction { coefficient: 0.4 }, [0.3, 0.0]);
    let mut slipping = true;
    run(&mut mpm, 0.12, |t, mpm| {
        let expected = (0.4 * GRAVITY * (t - 0.5 * mpm.snapshot().dt)).min(0.3);
        let v = mean_velocity(mpm)[0];
        assert!((v - expected).abs() < 1e-9 || (t > 0.07 && v <= 0.3 + 1e-12), "t = {t}: {v} instead of {expected}");
        slipping &= v < 0.3 - 1e-9;
    });
    assert!(!slipping, "the belt has caught up");
}

/// A sheet pressed by water on an obstacle: the water is stopped with it, whatever the ratio of their masses, and
/// momentum is what gravity and the obstacle gave.
#[test]
fn a_light_sheet_under_water_on_an_obstacle_holds_the_water() {
    let eos = lateen::material::EquationsOfState::LinearLiquid(lateen::material::eos::LinearLiquid {
        sound_speed: 20.0,
        tensile_strength: 0.0,
    });
    let law = lateen::material::Fluid { density: 1000.0, viscosity: 0.0, bulk_viscosity: Default::default(), eos };
    let mut grid = open([0.0, -0.1], 0.025, [12, 16]);
    for end in 0..2 {
        grid.walls[0][end].kind = WallKind::Slip;
    }
    let water = body(
        "water",
        (Box::new(law), Default::default()),
        ([0.0, 0.008], [24, 12], 0.0125),
        |_| true,
        Vector([0.0, -0.3]),
    );
    let points: Vec<_> = (0..=24).map(|k| Vector([0.0125 * f64::from(k), 0.0])).collect();
    let held = support(vec![0, 24], [true, false, false]);
    let elements = (0..24).map(|k| vec![k, k + 1]).collect();
    // 0.1 kg/m² under 150 kg/m².
    let sheet = membrane(points, elements, [1000.0, 1e7, 0.0, 1e-4], vec![held]);
    let setup = setup(grid, vec![water], vec![sheet]);
    let floor = plane(0.0, WallKind::Separate, [0.0; 2]);
    let mut mpm =
        start(Setup { gravity: falling(), obstacles: vec![floor], sheet_contact: SheetContact::Particles, ..setup });
    run(&mut mpm, 0.5, |_, mpm| {
        let low = nodes(mpm).iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
        assert!(low > -1e-6, "a node lies at {low}");
    });
    let lowest = mpm.snapshot().points[0].position.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    assert!(lowest > 0.0, "a particle lies at {lowest}");
    let momentum = term(&mpm, "momentum y") + 0.3 * 0.3 * 0.15 * 1000.0;
    let outer = term(&mpm, "external impulse y");
    assert!((momentum - outer).abs() < 1e-9 * outer.abs().max(1.0), "{momentum} {outer}");
}
