//! Sheets with a body on both sides, and folded ones (theory D.3, D.4).

use crate::model::*;
use lateen::math::{Signal, Vector};
use lateen::mpm::{Friction, MembraneSetup, Setup, SheetContact};
use lateen::simulation::Solver;

/// A chain through these places, `n` segments from each to the next, held everywhere.
fn wall(corners: &[[f64; 2]], n: u32) -> MembraneSetup<2> {
    let legs = corners.windows(2).flat_map(|leg| {
        let (from, to) = (Vector(leg[0]), Vector(leg[1]));
        (0..n).map(move |k| from + (to - from) * (f64::from(k) / f64::from(n)))
    });
    let places: Vec<_> = legs.chain(corners.last().map(|&end| Vector(end))).collect();
    let nodes = places.len() as u32;
    held(0..nodes, sheet((1..nodes).map(|k| vec![k - 1, k]).collect(), places, 0.1))
}

/// Heights over a sheet of the particles of one body that lies on both of its sides, after falling for a time 1: those
/// that were above, and those that were below.
fn halves(gravity: f64, sheet_contact: SheetContact) -> [Vec<f64>; 2] {
    let body = block("both", [6.0, 4.0], [20, 16], 0.5, 1.0, Vector::ZERO);
    let sheet = wall(&[[1.0, 8.0], [23.0, 8.0]], 22);
    let gravity = [Signal::ZERO, Signal::Constant(gravity)];
    let setup = setup([24, 16], vec![body], vec![sheet], Friction::Slip(0.0));
    let mut world = World::new(Setup { gravity, sheet_contact, ..setup });
    let start: Vec<Vector<2>> = world.by_identity("both", "position");
    (0..100).for_each(|_| world.step(0.01));
    assert_eq!(world.crossed(), 0, "{sheet_contact:?}");
    let end: Vec<Vector<2>> = world.by_identity("both", "position");
    let half = |sign: f64| -> Vec<f64> {
        let all = end.iter().zip(&start);
        all.filter(|(_, start)| (start[1] - 8.0) * sign > 0.0).map(|(x, _)| (x[1] - 8.0) * sign).collect()
    };
    [half(1.0), half(-1.0)]
}

/// The half that gravity presses against the sheet stays on its side, and the other one falls away from it, in both
/// directions alike: to rounding with contact at nodes. Contact at particles sweeps over them in an order that the
/// mirror image doesn't share, and stops where impulses change by 10⁻⁴: on average by as much of the way of a free
/// fall.
#[test]
fn both_halves_of_a_body_keep_their_sides() {
    for (place, tolerance) in PLACES.into_iter().zip([1e-11, 1e-4 * 0.5]) {
        let [above, below] = halves(-1.0, place);
        assert!(above.iter().chain(&below).all(|&height| height > 0.0), "{place:?}");
        let farthest = below.iter().copied().fold(0.0, f64::max);
        assert!((farthest - (3.75 + 0.5)).abs() < 0.01, "{place:?}: free fall: {farthest}");
        let [mirrored_below, mirrored_above] = halves(1.0, place);
        let mean = |heights: &[f64]| heights.iter().sum::<f64>() / heights.len() as f64;
        for (half, mirrored) in [(&above, &mirrored_above), (&below, &mirrored_below)] {
            let difference = (mean(half) - mean(mirrored)).abs();
            assert!(difference < tolerance, "{place:?}: {difference:e}");
        }
    }
}

/// A sheet that is folded back on itself, so that its vector areas cancel on the grid, stops a block from either side.
#[test]
fn a_folded_sheet_stops_what_falls_on_it() {
    for sheet_contact in PLACES {
        for (from, speed) in [(8.6, -1.0), (4.6, 1.0)] {
            let block = block("block", [8.0, from], [12, 6], 0.5, 1.0, Vector([0.0, speed]));
            let sheet = wall(&[[4.0, 8.0], [18.0, 8.0], [18.0, 8.2], [4.0, 8.2]], 14);
            let setup = setup([24, 16], vec![block], vec![sheet], Friction::Slip(0.0));
            let mut world = World::new(Setup { sheet_contact, ..setup }).with_rigid(&["block"]);
            (0..200).for_each(|_| world.step(0.01));
            let v = world.mean_velocity("block")[1];
            assert!((-0.2..0.01).contains(&(v * speed)), "{sheet_contact:?} {from}: stopped or thrown back: {v}");
            let beyond = |x: &Vector<2>| (x[1] - 8.1) * speed > 0.0;
            let places: Vec<Vector<2>> = world.by_identity("block", "position");
            assert!(!places.iter().any(beyond), "{sheet_contact:?} {from}");
            assert_eq!(world.crossed(), 0);
        }
    }
}

/// Crossings are told of once: a run that goes on from a checkpoint after the notice says nothing of them.
#[test]
fn crossings_from_before_a_checkpoint_are_not_said_again() {
    let world = || {
        let body = block("block", [6.0, 9.0], [4, 4], 0.5, 1.0, Vector::ZERO);
        let sheet = wall(&[[1.0, 8.0], [23.0, 8.0]], 22);
        World::new(setup([24, 16], vec![body], vec![sheet], Friction::Slip(0.0)))
    };
    let mut first = world();
    first.mpm.columns(&mut |name, column| {
        if name == "contact.crossed" {
            assert!(column.data.replace(&3_u64.to_le_bytes()));
        }
    });
    assert!(first.mpm.notices()[0].starts_with("particles have crossed the membrane `sheet`"));
    assert_eq!(first.mpm.notices(), Vec::<String>::new());
    let mut saved = Vec::new();
    first.mpm.columns(&mut |_, column| saved.push(column.data.bytes().to_vec()));
    let (mut second, mut next) = (world(), saved.iter());
    second.mpm.columns(&mut |_, column| assert!(column.data.replace(next.next().unwrap())));
    second.mpm.restored();
    assert_eq!((second.mpm.misfit(), second.mpm.notices()), (None, Vec::new()));
}
