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

/// Two equal elastic bars (ν = 0, c = 10, ρ = 1, length 1) that meet head-on with ±0.1: the fraction of the speed that
/// they part with, and the mean stress between them while the first waves travel over ρ c V.
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

/// Elastic bars of equal length exchange their velocities in full, and the stress between them is ρ c V (theory A.18).
/// The exact restitution is 1; the loss at the nodes of the contact is of the order of the cell.
#[test]
fn colliding_bars_exchange_velocities_at_the_stress_rho_c_v() {
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
fn a_block_slides_down_an_incline_with_coulombs_acceleration() {
    let angle = std::f64::consts::FRAC_PI_6;
    for (coefficient, tolerance) in [(0.0, 0.01), (0.1, 0.02), (0.3, 0.02)] {
        let a = acceleration(&mut incline(angle, Friction::Slip(coefficient), FLIP, block()), 0.5);
        let expected = GRAVITY * (angle.sin() - coefficient * angle.cos());
        assert!((a / expected - 1.0).abs() < tolerance, "μ = {coefficient}: {a}, expected {expected}");
    }
}

/// With μ > tan θ the block stays at rest but for its elastic oscillation. In the last 0.2 s, in which a free block
/// would slide 0.4 m, it moves by less than 3 % of that; the exact distance is zero.
#[test]
fn a_block_sticks_on_an_incline_below_the_angle_of_friction() {
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

/// A disc on an incline of 30° slides with g (sin θ − μ cos θ) below μ = tan θ/3 (theory A.18).
#[test]
fn a_disc_slides_down_an_incline_with_coulombs_acceleration() {
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

/// Time of the first force whose name begins so [s].
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

/// A disc of radius 0.2 with the depth of each particle below its rim; its lattice is not aligned with the grid.
fn disc(center: [f64; 2], spacing: f64, velocity: [f64; 2]) -> BodySetup<2> {
    let away = |x: Vector<2>| (x - Vector(center)).norm();
    let lattice = (center.map(|c| c - 0.2 - 0.3 * spacing), [(0.5 / spacing) as usize; 2], spacing);
    let disc = body(rubber(1000.0, 1000.0, 0.3), lattice, |x| away(x) < 0.2, |_| Vector(velocity));
    BodySetup { depth: disc.position.iter().map(|&x| 0.2 - away(x)).collect(), ..disc }
}

/// Time of contact of two circles (theory A.18): the contours of particles would touch later, the supports of shape
/// functions earlier.
#[test]
fn contact_of_two_discs_begins_when_their_rims_touch() {
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

/// A floor with its top at `height` [m].
fn floor(height: f64, kind: WallKind) -> Obstacle {
    let region = Region::Box { lower: [-1.0, -1.0, -1.0], upper: [9.0, height, 1.0] };
    Obstacle { name: "floor".into(), region, kind, velocity: std::array::from_fn(|_| Signal::ZERO) }
}

/// Time of contact with a plane at any height between the nodes, of an obstacle or a wall of the domain.
#[test]
fn contact_with_an_obstacle_or_a_wall_begins_when_the_rim_touches() {
    for surface in [0.0, 0.1, 0.115, 0.14] {
        let rough = WallKind::Friction { coefficient: 0.3 };
        let mut setup = setup(grid([0.0, 0.0], 0.05, [20, 20], WallKind::Open));
        let name = if surface > 0.0 {
            setup.obstacles = vec![floor(surface, rough)];
            "obstacle:floor"
        } else {
            setup.grid.walls[1][0] = wall(rough);
            "wall:bottom"
        };
        setup.bodies = vec![disc([0.51, surface + 0.32], 0.05 / 3.0, [0.0, -0.2])];
        let expected = 0.12 / 0.2;
        let mut mpm = start(setup);
        let begin = first_force(&mut mpm, name, 0.8);
        let step = mpm.stable_dt();
        assert!((begin - expected).abs() < step + 0.005, "{surface}: {begin}, expected {expected}, step {step}");
    }
}

/// A grid whose bottom is a wall of this kind, under gravity turned by `angle`.
fn on_wall(kind: WallKind, angle: f64, (cell, cells): (f64, [i32; 2]), body: BodySetup<2>) -> Mpm<2> {
    let mut grid = grid([0.0, 0.0], cell, cells, WallKind::Open);
    grid.walls[1][0] = wall(kind);
    let mut setup = setup(grid);
    setup.gravity = [Signal::Constant(GRAVITY * angle.sin()), Signal::Constant(-GRAVITY * angle.cos())];
    setup.bodies = vec![body];
    start(setup)
}

/// On a wall of the domain a disc rolls with ⅔ g sin θ where μ is above tan θ/3; below, it slides with g (sin θ − μ cos
/// θ).
#[test]
fn a_disc_on_a_wall_rolls_or_slides_with_the_acceleration_of_a_rigid_one() {
    let angle = std::f64::consts::FRAC_PI_6;
    for (coefficient, factor) in [(0.5, 2.0 / 3.0), (0.1, 1.0 - 0.1 / angle.tan())] {
        let kind = WallKind::Friction { coefficient };
        let away = |x: Vector<2>| (x - Vector([0.5, 0.3])).norm();
        let lattice = ([0.2, 0.0], [36, 36], 0.05 / 3.0);
        let disc = body(rubber(1000.0, 1e7, 0.3), lattice, |x| away(x) < 0.3, |_| Vector::ZERO);
        let disc = BodySetup { depth: disc.position.iter().map(|&x| 0.3 - away(x)).collect(), ..disc };
        let a = acceleration(&mut on_wall(kind, angle, (0.05, [40, 16]), disc), 0.5);
        let expected = factor * GRAVITY * angle.sin();
        assert!((a / expected - 1.0).abs() < 0.03, "μ = {coefficient}: {a}, expected {expected}");
    }
}

/// The mean height of a block at rest is half its own less ρ g H²/3E′ (plane strain). A wall that acts as soon as its
/// nodes are within reach of shape functions holds it nine tenths of a cell higher.
#[test]
fn a_block_rests_on_a_wall_at_the_height_of_its_own_compression() {
    let (height, cell) = (0.4, 0.05);
    for kind in [WallKind::Separate, WallKind::Friction { coefficient: 0.5 }] {
        let block = body(rubber(1000.0, 1e6, 0.3), ([0.3, 0.02], [24, 16], 0.5 * cell), |_| true, |_| Vector::ZERO);
        let mut mpm = on_wall(kind, 0.0, (cell, [24, 16]), block);
        let (mut sum, mut time) = (0.0, 0.0);
        run(&mut mpm, 1.2, 1.0, |t, dt, mpm| {
            if t > 0.6 {
                let places = positions(mpm);
                sum += places.iter().map(|x| x[1]).sum::<f64>() / places.len() as f64 * dt;
                time += dt;
            }
        })
        .unwrap();
        let expected = 0.5 * height - 1000.0 * GRAVITY * height * height / 3.0 / (1e6 / 0.91);
        let off = (sum / time - expected) / cell;
        assert!(off.abs() < 0.1, "{kind:?}: {off} cells too high");
    }
}

/// To solids a wall that they may leave is the face of a half-space in a grid that extends beyond it: both ways agree
/// to rounding.
#[test]
fn a_wall_and_the_face_of_a_half_space_move_a_solid_alike() {
    let fall = |wall_itself: bool| {
        let kind = WallKind::Friction { coefficient: 0.3 };
        let beyond = if wall_itself { 0 } else { 4 };
        let lower = [0.0, -f64::from(beyond) * 0.05];
        let mut setup = setup(grid(lower, 0.05, [20, 20 + beyond], WallKind::Open));
        if wall_itself {
            setup.grid.walls[1][0] = wall(kind);
        } else {
            setup.obstacles = vec![floor(0.0, kind)];
        }
        setup.bodies = vec![disc([0.45, 0.22], 0.05 / 3.0, [0.3, -0.4])];
        let mut mpm = start(setup);
        run(&mut mpm, 0.6, 1.0, |_, _, _| {}).unwrap();
        positions(&mpm)
    };
    let (wall, floor) = (fall(true), fall(false));
    assert!(wall[0][1] > 0.0 && wall.len() == floor.len());
    let apart = wall.iter().zip(&floor).map(|(a, b)| (Vector(*a) - Vector(*b)).norm()).fold(0.0, f64::max);
    assert!(apart < 1e-6 * 0.05, "{apart}");
}
