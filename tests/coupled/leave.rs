//! A membrane that leaves the grid through an open end, or gets into an obstacle that it doesn't meet, stops the run by name.

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
fn a_node_beyond_the_end_of_the_grid_is_named() {
    let error = error(falling());
    assert_eq!((error.what.as_str(), error.quantity), ("a node of a membrane left the grid", "y"));
    assert!(error.value < 0.0 && (error.time - 0.5).abs() < 0.1, "{error}");
    assert!(matches!(&error.place, Place::Node { body, index: 0, .. } if body == "sheet"), "{error}");
    assert!(error.advice.contains("enlarge the grid") && error.advice.contains("supports"), "{error}");
}

#[test]
fn a_node_in_an_obstacle_is_named() {
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
