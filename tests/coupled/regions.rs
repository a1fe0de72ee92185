//! Gas on both sides of closed sheets: one body, a velocity field on each side (theory D.13).

use crate::bits::{restore, state, step};
use crate::model::*;
use lateen::material::StartState;
use lateen::math::Vector;
use lateen::mpm::{BodySetup, Mpm, Setup, SheetContact, WallKind};
use lateen::simulation::Solver;
use std::collections::BTreeMap;

const CELL: f64 = 0.1;
const SPACING: f64 = 0.5 * CELL;
const PLACES: [SheetContact; 2] = [SheetContact::Nodes, SheetContact::Particles];

/// A closed loop through `corners` with a node every half cell, held everywhere.
fn ring(corners: &[[f64; 2]]) -> lateen::mpm::MembraneSetup<2> {
    let next = corners.iter().cycle().skip(1);
    let side = |(&a, &b): (&[f64; 2], &[f64; 2])| {
        let (a, b) = (Vector(a), Vector(b));
        let n = ((b - a).norm() / SPACING).round() as u32;
        (0..n).map(move |k| a + (b - a) * (f64::from(k) / f64::from(n))).collect::<Vec<_>>()
    };
    let position: Vec<Vector<2>> = corners.iter().zip(next).flat_map(side).collect();
    let n = position.len() as u32;
    let elements = (0..n).map(|k| vec![k, (k + 1) % n]).collect();
    membrane(position, elements, [1000.0, 1.0, 0.0, 1e-3], vec![support((0..n).collect(), [true; 3])])
}

/// Gas that fills a box from the origin, and the loop in it; `prepare` changes the gas by the places of its particles.
fn model(cells: [i32; 2], corners: &[[f64; 2]], place: SheetContact, prepare: impl Fn(&mut BodySetup<2>)) -> Mpm<2> {
    let mut grid = open([0.0; 2], CELL, cells);
    grid.walls.iter_mut().flatten().for_each(|wall| wall.kind = WallKind::Slip);
    let state = StartState { pressure: Some(1.0), ..StartState::default() };
    let count = cells.map(|n| 2 * n as usize);
    let mut gas = body("gas", (gas(0.0), state), ([0.0; 2], count, SPACING), |_| true, Vector::ZERO);
    prepare(&mut gas);
    start(Setup { sheet_contact: place, ..setup(grid, vec![gas], vec![ring(corners)]) })
}

/// True inside of a loop, by the sides above the point.
fn inside(corners: &[[f64; 2]], x: [f64; 3]) -> bool {
    let next = corners.iter().cycle().skip(1);
    let above = |(a, b): &(&[f64; 2], &[f64; 2])| {
        let spans = (a[0] > x[0]) != (b[0] > x[0]);
        spans && a[1] + (b[1] - a[1]) * (x[0] - a[0]) / (b[0] - a[0]) > x[1]
    };
    corners.iter().zip(next).filter(above).count() % 2 == 1
}

/// Places of the particles by identity.
fn places(mpm: &Mpm<2>) -> BTreeMap<u32, [f64; 3]> {
    let snapshot = mpm.snapshot();
    snapshot.points[0].id.iter().copied().zip(snapshot.points[0].position.iter().copied()).collect()
}

/// Gas that streams in a long box through gas at rest, with next to no pressure, for half a cell: at the long sides of
/// the box, too far from its ends to feel them, the inner gas moves with its speed and the outer gas not at all. In one
/// velocity field each would move with a mixture of both: next to the sheet, by a third of the way too little or too
/// much.
#[test]
fn streams_on_both_sides_of_a_closed_sheet_do_not_drag_each_other() {
    let corners = [[0.4, 0.3], [2.0, 0.3], [2.0, 0.9], [0.4, 0.9]];
    for place in PLACES {
        let mut mpm = model([24, 12], &corners, place, |gas| {
            for (x, (v, state)) in gas.position.iter().zip(gas.velocity.iter_mut().zip(&mut gas.state)) {
                *v = Vector([if inside(&corners, x.to3()) { 1.0 } else { 0.0 }, 0.0]);
                state.pressure = Some(1e-9);
            }
        });
        let before = places(&mpm);
        run(&mut mpm, 0.5 * CELL, |_, _| {});
        let after = places(&mpm);
        let middle = before.iter().filter(|(_, x)| (x[0] - 1.2).abs() < 1.5 * CELL);
        let (mut beside, mut moved) = ([0; 2], [0.0_f64; 2]);
        for (id, x) in middle {
            let within = inside(&corners, *x);
            let wanted = if within { 0.5 * CELL } else { 0.0 };
            let off = (after[id][0] - x[0] - wanted).abs();
            moved[usize::from(within)] = moved[usize::from(within)].max(off);
            let height = (x[1] - 0.3).abs().min((x[1] - 0.9).abs());
            beside[usize::from(within)] += usize::from(height < SPACING);
        }
        assert_eq!(beside, [12, 12], "the rows next to both long sides");
        assert!(moved.iter().all(|off| *off < 1e-6), "{place:?}: {moved:?}");
    }
}

/// A loop like a horseshoe in still gas, in and around it: nothing leaves its region, and next to nothing moves.
/// Contact at particles pushes elsewhere than pressure does, at corners and off the nodes of the grid, and leaves the
/// gas less still.
#[test]
fn still_gas_stays_in_the_regions_of_a_folded_loop() {
    let corners = [[0.3, 0.3], [1.2, 0.3], [1.2, 1.2], [0.9, 1.2], [0.9, 0.6], [0.6, 0.6], [0.6, 1.2], [0.3, 1.2]];
    for (place, most) in PLACES.into_iter().zip([1e-4, 1e-2]) {
        let mut mpm = model([15, 15], &corners, place, |_| {});
        let before = places(&mpm);
        run(&mut mpm, 1.0, |_, _| {});
        let after = places(&mpm);
        assert_eq!(crossed(&mpm), 0, "{place:?}");
        let lost = before.iter().filter(|(id, x)| inside(&corners, **x) != inside(&corners, after[*id])).count();
        assert_eq!(lost, 0, "{place:?}");
        let kinetic = term(&mpm, "kinetic energy: gas") / term(&mpm, "stored energy at the start");
        assert!(kinetic < most, "{place:?}: {kinetic}");
        assert!(closure(&mpm).abs() < 1e-12);
    }
}

/// Twice the pressure inside of a box that is held: each side keeps its energy, as next to nothing moves and nothing
/// mixes. The body is one in all outputs: each particle once, one force, one energy.
#[test]
fn a_body_in_two_regions_keeps_two_pressures_and_one_name() {
    let corners = [[0.4, 0.4], [1.0, 0.4], [1.0, 1.0], [0.4, 1.0]];
    for place in PLACES {
        let mut mpm = model([14, 14], &corners, place, |gas| {
            for (x, state) in gas.position.iter().zip(&mut gas.state) {
                state.pressure = Some(if inside(&corners, x.to3()) { 2.0 } else { 1.0 });
            }
        });
        let within: Vec<u32> = places(&mpm).iter().filter(|(_, x)| inside(&corners, **x)).map(|(id, _)| *id).collect();
        assert_eq!(within.len(), 144);
        run(&mut mpm, 1.0, |_, _| {});
        let snapshot = mpm.snapshot();
        let [gas] = &snapshot.points[..] else { panic!("one body") };
        assert_eq!((gas.name, places(&mpm).len(), gas.position.len()), ("gas", 784, 784));
        let forces: Vec<&str> = snapshot.forces.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            forces.iter().filter(|name| name.starts_with("contact:")).collect::<Vec<_>>(),
            [&"contact:gas-sheet"]
        );
        let energy = gas.fields.iter().find(|field| field.name == "internal energy").unwrap().values().into_owned();
        let inner: f64 = gas.id.iter().zip(&energy).filter(|(id, _)| within.contains(id)).map(|(_, e)| e).sum();
        // e = p V/(γ − 1).
        let (start, all) = (2.0 * 0.36 / 0.4, energy.iter().sum::<f64>());
        assert!((inner / start - 1.0).abs() < 0.05, "{place:?}: {inner} of {start}");
        assert!((all - term(&mpm, "internal energy: gas")).abs() < 1e-12 * all);
        assert!(closure(&mpm).abs() < 1e-12);
    }
}

/// The parts of a body are stored apart, each column under a name of its own, and go on with the same bits.
#[test]
fn a_body_in_two_regions_resumes_with_the_same_bits() {
    let corners = [[0.4, 0.4], [1.0, 0.4], [1.0, 1.0], [0.4, 1.0]];
    let model = || {
        model([14, 14], &corners, SheetContact::Nodes, |gas| {
            gas.velocity.iter_mut().zip(&gas.position).for_each(|(v, x)| *v = Vector([0.3 * x[1], 0.1]));
        })
    };
    let mut first = model();
    let mut t = (0..10).fold(0.0, |t, _| step(&mut first, t));
    let saved = state(&mut first);
    let mut names: Vec<&String> = saved.iter().map(|(name, _)| name).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), saved.len());
    let mut second = model();
    restore(&mut second, &saved);
    for _ in 0..10 {
        step(&mut second, t);
        t = step(&mut first, t);
    }
    assert!(state(&mut first) == state(&mut second));
}
