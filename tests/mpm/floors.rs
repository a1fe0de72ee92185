//! Bodies on walls and obstacles that they may leave: nothing that stands still gives energy.

use crate::model::*;
use lateen::geometry::Region;
use lateen::math::{Signal, Vector};
use lateen::mpm::{Mpm, Obstacle, WallKind};

const RADIUS: f64 = 0.04;
const SPEED: f64 = 2.0;
/// The lowest row of particles, which stops at once, has 1 % of the disc's energy.
const CELL: f64 = 0.005;
/// The heights of floors over a row of nodes [cells].
const OFFSETS: [f64; 7] = [0.0, 0.1, 0.25, 0.4, 0.5, 0.7, 0.9];

/// A soft disc that falls on the bottom of its grid, or on an obstacle with its top at `floor` [m].
fn disc(floor: Option<f64>) -> Mpm<2> {
    let mut grid = grid([0.0, 0.0], CELL, [32, 40], WallKind::Open);
    grid.walls[1][0] = wall(WallKind::Separate);
    let mut setup = setup(grid);
    if let Some(floor) = floor {
        setup.obstacles = vec![Obstacle {
            name: "floor".into(),
            region: Region::Box { lower: [-1.0, -1.0, -1.0], upper: [1.0, floor, 1.0] },
            kind: WallKind::Separate,
            velocity: [const { Signal::ZERO }; 3],
        }];
    }
    let center = Vector([0.08, floor.unwrap_or(0.0) + RADIUS + 0.02]);
    let inside = move |x: Vector<2>| (x - center).norm() < RADIUS;
    setup.bodies =
        vec![body(rubber(1000.0, 1e6, 0.3), ([0.0, floor.unwrap_or(0.0)], [64, 60], 0.5 * CELL), inside, |_| {
            Vector([0.0, -SPEED])
        })];
    start(setup)
}

/// A disc that bounces keeps its energy, wherever its floor lies between rows of nodes: the floor gives none at any time, and what stops
/// for good is what the nodes at the floor had of it. Floors that stop anew in every step what particles above them show of their own motion give a tenth.
#[test]
fn a_floor_gives_a_bouncing_disc_no_energy() {
    for floor in std::iter::once(None).chain(OFFSETS.map(|offset| Some((6.0 + offset) * CELL))) {
        let mut mpm = disc(floor);
        let energy = term(&mpm, "stored energy at the start");
        let mut least = 0.0_f64;
        run(&mut mpm, 0.05, 1.0, |_, _, mpm| least = least.min(term(mpm, "wall dissipation"))).unwrap();
        let velocity = field(&mpm, "velocity");
        let up = velocity.chunks(3).map(|v| v[1]).sum::<f64>() / (velocity.len() / 3) as f64;
        assert!(up > 0.9 * SPEED, "{floor:?}: it bounces with {up}");
        assert!(least > -1e-3 * energy, "{floor:?}: {least} of {energy}");
        for name in ["wall dissipation", "transfer dissipation", "stress update error"] {
            let term = term(&mpm, name) / energy;
            assert!(term.abs() < 0.02, "{floor:?}, {name}: {term}");
        }
    }
}
