//! Bodies that meet: impact along a line, friction on an incline.

use crate::model::*;
use lateen::geometry::Region;
use lateen::math::{Signal, Vector};
use lateen::mpm::{BodySetup, Friction, Mpm, Obstacle, Transfer, WallKind};
use lateen::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// A body with a name and a velocity field of its own.
fn named<const D: usize>(name: &str, group: usize, body: BodySetup<D>) -> BodySetup<D> {
    BodySetup { name: name.into(), group, ..body }
}

/// Mean velocity of the first body's particles, which all have the same mass [m/s].
fn mean_velocity<const D: usize>(mpm: &Mpm<D>) -> Vector<D> {
    let v = field(mpm, "velocity");
    let n = v.len() / 3;
    Vector::from_fn(|a| (0..n).map(|p| v[3 * p + a]).sum::<f64>() / n as f64)
}

/// Two equal elastic bars (ν = 0, c = 10, ρ = 1, length 1) that meet head-on with ±0.1: the share of the speed that they
/// part with, and the mean stress between them while the first waves travel over ρ c V.
fn bars(cells: i32) -> (f64, f64) {
    let h = 1.0 / f64::from(cells);
    let mut grid = grid([0.0, 0.0], h, [3 * cells, 1], WallKind::Slip);
    grid.walls[0] = [wall(WallKind::Open), wall(WallKind::Open)];
    let mut setup = setup(grid);
    let bar = |lower: f64, speed: f64| {
        let lattice = ([lower, 0.0], [2 * cells as usize, 2], 0.5 * h);
        body(rubber(1.0, 100.0, 0.0), lattice, |_| true, move |_| Vector([speed, 0.0]))
    };
    setup.bodies = vec![named("left", 0, bar(0.33, 0.1)), named("right", 1, bar(1.38, -0.1))];
    let mut mpm = start(setup);
    let (mut impulse, mut time) = (0.0, 0.0);
    run(&mut mpm, 0.7, 1.0, |t, dt, mpm| {
        // Contact at 0.25; the waves are back at 0.45.
        if t > 0.28 && t < 0.42 {
            let forces = mpm.snapshot().forces;
            impulse += forces.iter().find(|(name, _)| name == "contact:left-right").unwrap().1[0].abs() * dt;
            time += dt;
        }
    })
    .unwrap();
    (-mean_velocity(&mpm)[0] / 0.1, impulse / time / (h * 10.0 * 0.1))
}

/// Bars of equal length exchange their speeds without a rest, and the stress between them is ρ c V (theory 14.1). What
/// the nodes of the contact lose is of the order of the cell.
#[test]
fn bars_exchange_their_speeds_as_cells_shrink() {
    let [(coarse, _), (fine, stress)] = [20, 40].map(bars);
    assert!((stress - 1.0).abs() < 0.02, "stress over ρ c V: {stress}");
    assert!(fine > 0.94 && fine < 1.01, "restitution {coarse} {fine}");
    assert!((1.0 - fine).abs() < 0.7 * (1.0 - coarse).abs(), "restitution {coarse} {fine}");
}

/// A soft block, 0.7 by 0.4, on the slab.
fn block() -> BodySetup<2> {
    body(rubber(1000.0, 1e6, 0.3), ([0.63, 0.3], [14, 8], 0.05), |_| true, |_| Vector::ZERO)
}

/// A slab on a fixed floor under gravity turned by `angle`, and `slider` on it; cells of 0.1.
fn incline(angle: f64, friction: Friction, transfer: Transfer, slider: BodySetup<2>) -> Mpm<2> {
    let mut grid = grid([0.0, 0.0], 0.1, [32, 14], WallKind::Open);
    grid.walls[0] = [wall(WallKind::Slip), wall(WallKind::Slip)];
    grid.walls[1][0] = wall(WallKind::Fixed);
    let mut setup = setup(grid);
    (setup.default_friction, setup.transfer) = (friction, transfer);
    setup.gravity = [Signal::Constant(GRAVITY * angle.sin()), Signal::Constant(-GRAVITY * angle.cos())];
    let slab = body(rubber(1000.0, 1e6, 0.3), ([0.0, 0.0], [64, 6], 0.05), |_| true, |_| Vector::ZERO);
    setup.bodies = vec![named("slider", 0, slider), named("slab", 1, slab)];
    start(setup)
}

/// Accelerations of the slider along the slab, by least squares from 0.1 s to `end`.
fn acceleration(mpm: &mut Mpm<2>, end: f64) -> f64 {
    let mut sums = [0.0; 4];
    run(mpm, end, 1.0, |t, dt, mpm| {
        let (t, v) = (t - 0.5 * dt, mean_velocity(mpm)[0]);
        if t > 0.1 {
            sums.iter_mut().zip([dt, t * dt, t * t * dt, 0.0]).for_each(|(s, add)| *s += add);
            sums[3] += (t - 0.5 * (0.1 + end)) * v * dt;
        }
    })
    .unwrap();
    let mean = sums[1] / sums[0];
    sums[3] / (sums[2] - sums[0] * mean * mean)
}

/// A block on an incline of 30° slides with g (sin θ − μ cos θ).
#[test]
fn a_block_slides_on_an_incline() {
    let angle = std::f64::consts::FRAC_PI_6;
    for (coefficient, tolerance) in [(0.0, 0.01), (0.1, 0.02), (0.3, 0.02)] {
        let a = acceleration(&mut incline(angle, Friction::Slip(coefficient), FLIP, block()), 0.5);
        let expected = GRAVITY * (angle.sin() - coefficient * angle.cos());
        assert!((a / expected - 1.0).abs() < tolerance, "μ = {coefficient}: {a}, expected {expected}");
    }
}

/// It stays where μ > tan θ: it swings about its place, but doesn't leave it: in the last 0.2 s, in which it would
/// slide 0.4 m if it were free, it creeps by less than 3 % of that while it bounces.
#[test]
fn a_block_sticks_on_an_incline() {
    let mut mpm = incline(std::f64::consts::FRAC_PI_6, Friction::Slip(0.7), FLIP, block());
    let mut place = 0.0;
    let mut settled = None;
    run(&mut mpm, 0.5, 1.0, |t, dt, mpm| {
        place += mean_velocity(mpm)[0] * dt;
        if t > 0.3 && settled.is_none() {
            settled = Some(place);
        }
    })
    .unwrap();
    let moved = (place - settled.unwrap()).abs();
    assert!(moved < 0.012, "{moved}");
}

/// A disc on an incline of 30° slides with g (sin θ − μ cos θ) below μ = tan θ/3 (theory 14.10).
#[test]
fn a_disc_slides_on_an_incline() {
    let angle = std::f64::consts::FRAC_PI_6;
    for coefficient in [0.0, 0.1] {
        let centre = Vector([0.8, 0.7]);
        let inside = |x: Vector<2>| (x - centre).norm() < 0.4;
        let disc = body(rubber(1000.0, 1e6, 0.3), ([0.4, 0.3], [16, 16], 0.05), inside, |_| Vector::ZERO);
        let a = acceleration(&mut incline(angle, Friction::Slip(coefficient), Transfer::Apic, disc), 0.6);
        let expected = GRAVITY * (angle.sin() - coefficient * angle.cos());
        assert!((a / expected - 1.0).abs() < 0.03, "μ = {coefficient}: {a}, expected {expected}");
    }
}

/// When a force with this beginning of its name first acts [s].
fn first_force(mpm: &mut Mpm<2>, name: &str, end: f64) -> f64 {
    let mut begin = f64::INFINITY;
    run(mpm, end, 1.0, |t, _, mpm| {
        let forces = mpm.snapshot().forces;
        let (_, f) = forces.iter().find(|(own, _)| own.starts_with(name)).expect("the force has a name");
        if f.iter().any(|f| f.abs() > 1e-9) {
            begin = begin.min(t);
        }
    })
    .unwrap();
    begin
}

/// A disc of radius 0.2 whose particles know how deep they lie below its rim, not in line with the grid.
fn disc(center: [f64; 2], spacing: f64, velocity: [f64; 2]) -> BodySetup<2> {
    let away = |x: Vector<2>| (x - Vector(center)).norm();
    let lattice = (center.map(|c| c - 0.2 - 0.3 * spacing), [(0.5 / spacing) as usize; 2], spacing);
    let disc = body(rubber(1000.0, 1000.0, 0.3), lattice, |x| away(x) < 0.2, |_| Vector(velocity));
    BodySetup { depth: disc.position.iter().map(|&x| 0.2 - away(x)).collect(), ..disc }
}

/// Two discs meet when they touch (theory 14.3): not when their staircases of particles do, nor a cell early.
#[test]
fn discs_meet_when_they_touch() {
    let mut setup = setup(grid([0.0, 0.0], 0.05, [20, 20], WallKind::Open));
    let spacing = 0.05 / 3.0;
    setup.bodies = vec![
        named("left", 0, disc([0.2, 0.2], spacing, [0.1, 0.1])),
        named("right", 1, disc([0.8, 0.8], spacing, [-0.1, -0.1])),
    ];
    let expected = (0.72_f64.sqrt() - 0.4) / 0.08_f64.sqrt();
    let mut mpm = start(setup);
    let begin = first_force(&mut mpm, "contact:left", 1.7);
    let step = mpm.stable_dt();
    assert!((begin - expected).abs() < step + 0.005, "{begin}, expected {expected}, step {step}");
}

/// A disc meets an obstacle when it touches it, wherever the surface lies between the nodes.
#[test]
fn a_disc_meets_an_obstacle_when_it_touches_it() {
    for surface in [0.1, 0.115, 0.14] {
        let mut setup = setup(grid([0.0, 0.0], 0.05, [20, 20], WallKind::Open));
        setup.obstacles = vec![Obstacle {
            name: "floor".into(),
            region: Region::Box { lower: [-1.0, -1.0, -1.0], upper: [2.0, surface, 1.0] },
            kind: WallKind::Friction { coefficient: 0.3 },
            velocity: std::array::from_fn(|_| Signal::ZERO),
        }];
        setup.bodies = vec![disc([0.51, 0.42], 0.05 / 3.0, [0.0, -0.2])];
        let expected = (0.22 - surface) / 0.2;
        let mut mpm = start(setup);
        let begin = first_force(&mut mpm, "obstacle:floor", 0.8);
        let step = mpm.stable_dt();
        assert!((begin - expected).abs() < step + 0.005, "{surface}: {begin}, expected {expected}, step {step}");
    }
}
