//! A membrane that leaves the grid through an open end, gets into an obstacle that it doesn't meet, or has no way out
//! between what moves, stops the run by name.

use crate::model::*;
use lateen::error::{Place, StepError};
use lateen::geometry::Region;
use lateen::math::{Signal, Vector};
use lateen::mpm::{Friction, Obstacle, Setup, WallKind};
use lateen::simulation::Solver;

/// A chain 0.5 above the lower end of the grid that falls with a speed of 1.
fn falling() -> Setup<2> {
    let position: Vec<Vector<2>> = (0..5_u32).map(|k| Vector([1.0 + 0.25 * f64::from(k), 0.5])).collect();
    let mut chain = membrane(position, (0..4).map(|k| vec![k, k + 1]).collect(), [1.0, 100.0, 0.0, 0.1], Vec::new());
    chain.velocity.fill(Vector([0.0, -1.0]));
    let mut setup = setup(open([0.0, 0.0], 0.25, [12, 12]), Vec::new(), vec![chain]);
    // Nothing but the membrane bounds the step.
    setup.max_substeps = 1;
    setup
}

/// The error of a run to t = 2.
fn error(setup: Setup<2>) -> StepError {
    let (mut mpm, mut t) = (start(setup), 0.0);
    while t < 2.0 {
        let dt = mpm.stable_dt();
        if let Err(error) = mpm.step(t, dt) {
            return error;
        }
        t += dt;
    }
    panic!("the run must stop");
}

#[test]
fn a_node_beyond_the_end_of_the_grid_stops_the_run() {
    let error = error(falling());
    assert_eq!((error.what.as_str(), error.quantity), ("a node of a membrane left the grid", "y"));
    assert!(error.value < 0.0 && (error.time - 0.5).abs() < 0.1, "{error}");
    assert!(matches!(&error.place, Place::Node { body, index: 0, .. } if body == "sheet"), "{error}");
    assert!(error.advice.contains("enlarge the grid") && error.advice.contains("supports"), "{error}");
}

#[test]
fn a_node_in_an_obstacle_without_contact_stops_the_run() {
    let mut setup = falling();
    let region = Region::HalfSpace { point: [0.0, 0.3, 0.0], normal: [0.0, 1.0, 0.0] };
    let velocity = std::array::from_fn(|_| Signal::ZERO);
    setup.obstacles.push(Obstacle { name: "floor".into(), region, kind: WallKind::Separate, velocity });
    setup.friction = vec![("sheet".into(), "floor".into(), Friction::None)];
    let error = error(setup);
    assert!(error.what.contains("went into the obstacle `floor`"), "{error}");
    // Half a cell below its surface.
    assert!((error.time - (0.2 + 0.125)).abs() < 0.1, "{error}");
}

/// A sheet that ends on a plane of symmetry stays there for thousands of steps.
#[test]
fn a_sheet_may_lie_on_the_end_of_the_grid() {
    let position: Vec<Vector<2>> = (0..5_u32).map(|k| Vector([0.25 * f64::from(k), 3.0])).collect();
    let elements = (0..4).map(|k| vec![k, k + 1]).collect();
    let mut chain = membrane(position, elements, [1.0, 100.0, 0.0, 0.1], vec![support(vec![0], [true, false, false])]);
    chain.velocity = (0..5_u32).map(|k| Vector([0.1 * f64::from(k), 0.0])).collect();
    let mut setup = setup(symmetric(open([0.0, 0.0], 0.25, [12, 12]), &[0]), Vec::new(), vec![chain]);
    setup.max_substeps = 1;
    let mut mpm = start(setup);
    run(&mut mpm, 10.0, |_, _| {});
    assert_eq!(nodes(&mpm)[0], [0.0, 3.0, 0.0]);
}

/// The chain at rest, 0.1 thick.
fn resting(height: f64) -> Setup<2> {
    let mut setup = falling();
    let chain = &mut setup.membranes[0];
    chain.velocity.fill(Vector::ZERO);
    chain.position.iter_mut().for_each(|x| x[1] = height);
    chain.contact_thickness = true;
    setup
}

/// A plate, a fifth of a cell thick, between these heights.
fn plate(name: &str, [low, high]: [f64; 2], speed: f64) -> Obstacle {
    let region = Region::Box { lower: [0.5, low, -1.0], upper: [2.5, high, 1.0] };
    let velocity = [Signal::ZERO, Signal::Constant(speed), Signal::ZERO];
    Obstacle { name: name.into(), region, kind: WallKind::Separate, velocity }
}

/// Plates at the heights 0.3 + t and 0.7 − t close on the chain: the lower one takes it along from 0.1 on, at 0.15
/// nothing is left but its thickness, at 0.17 three fifths of that. Steps are 0.02 long. (Without a stop it ends up on
/// the other side of one of them.)
#[test]
fn two_plates_that_squeeze_a_sheet_stop_the_run() {
    let closing = || {
        let mut setup = resting(0.45);
        setup.obstacles = vec![plate("lower", [0.25, 0.3], 1.0), plate("upper", [0.7, 0.75], -1.0)];
        setup
    };
    run(&mut start(closing()), 0.149, |t, mpm| {
        let off = nodes(mpm).iter().map(|x| (x[1] - 0.5).abs()).fold(0.0, f64::max);
        assert!(off < 0.15 - t + 1e-9, "t = {t}: {off}");
    });
    let error = error(closing());
    for what in ["`obstacle:lower`", "`obstacle:upper`", "close on a membrane"] {
        assert!(error.what.contains(what), "{error}");
    }
    assert!((0.14..0.18).contains(&error.time), "{error}");
    assert!((0.0..0.06).contains(&error.value) && error.quantity == "their distance", "{error}");
    assert!(matches!(&error.place, Place::Node { body, .. } if body == "sheet"), "{error}");
    assert!(error.advice.contains("by its thickness"), "{error}");
}

/// The same between a plate and a wall: 0.5 − t apart.
#[test]
fn a_plate_that_squeezes_a_sheet_against_a_wall_stops_the_run() {
    let mut setup = resting(0.05);
    setup.grid.walls[1][0].kind = WallKind::Separate;
    setup.obstacles = vec![plate("press", [0.5, 0.55], -1.0)];
    let error = error(setup);
    assert!(error.what.contains("`wall:bottom`") && error.what.contains("`obstacle:press`"), "{error}");
    assert!((0.4..0.48).contains(&error.time), "{error}");
}

/// Contact at the mid-surface: the node is out of the grid before the plate overlaps with the wall by anything that
/// counts.
#[test]
fn a_plate_that_presses_a_sheet_through_a_wall_stops_the_run() {
    let mut setup = resting(0.0);
    setup.membranes[0].contact_thickness = false;
    setup.grid.walls[1][0].kind = WallKind::Separate;
    setup.obstacles = vec![plate("press", [0.5, 0.55], -1.0)];
    let error = error(setup);
    let told = ["`press` pressed a node of a membrane out of the grid", "`wall:bottom`"];
    assert!(told.iter().any(|what| error.what.contains(what)) && error.what.contains("press`"), "{error}");
    assert!((error.time - 0.5).abs() < 0.05, "{error}");
}

/// A chain that lies on an obstacle and runs out of an open end of the grid: that is no fault of the obstacle.
#[test]
fn a_node_that_leaves_the_grid_along_an_obstacle_is_not_blamed_on_it() {
    let mut setup = resting(0.5);
    setup.membranes[0].contact_thickness = false;
    setup.membranes[0].velocity.fill(Vector([-2.0, 0.0]));
    let region = Region::HalfSpace { point: [0.0, 0.5, 0.0], normal: [0.0, 1.0, 0.0] };
    let velocity = std::array::from_fn(|_| Signal::ZERO);
    setup.obstacles.push(Obstacle { name: "floor".into(), region, kind: WallKind::Separate, velocity });
    let error = error(setup);
    assert_eq!((error.what.as_str(), error.quantity), ("a node of a membrane left the grid", "x"));
    assert!((error.time - 0.5).abs() < 0.05, "{error}");
}

/// Nobody gives way where a plate at the height 0.3 + t meets a node that is held at 0.5. One that is held in an
/// obstacle from the start stays in it.
#[test]
fn a_plate_that_overruns_a_held_node_stops_the_run() {
    let held = |start: f64, speed: f64| {
        let mut setup = resting(0.5);
        setup.membranes[0].contact_thickness = false;
        setup.membranes[0].supports = vec![support(vec![0], [true; 3])];
        setup.obstacles = vec![plate("lower", [start - 0.05, start], speed)];
        setup
    };
    let error = error(held(0.3, 1.0));
    assert!(error.what.contains("supports hold a node") && error.what.contains("`obstacle:lower`"), "{error}");
    assert!((error.time - 0.2).abs() < 0.03 && matches!(error.place, Place::Node { index: 0, .. }), "{error}");
    assert!((0.005..0.03).contains(&error.value), "{error}");
    let mut clamped = held(0.52, 0.0);
    clamped.membranes[0].supports = vec![support((0..5).collect(), [true; 3])];
    run(&mut start(clamped), 0.5, |_, _| {});
}
