//! Sheets with a body on both sides, and folded ones (theory D.3, D.4).

use crate::world::{Sheet, World, block, mean_velocity};
use lateen::math::Vector;
use lateen::mpm::{Friction, KernelKind, SheetContact};

const PLACES: [SheetContact; 2] = [SheetContact::Nodes, SheetContact::Particles];

/// A chain through these places, `n` segments from each to the next, held everywhere.
fn wall(corners: &[[f64; 2]], n: u32) -> Sheet<2> {
    let legs = corners.windows(2).flat_map(|leg| {
        let (from, to) = (Vector(leg[0]), Vector(leg[1]));
        (0..n).map(move |k| from + (to - from) * (f64::from(k) / f64::from(n)))
    });
    let places: Vec<_> = legs.chain(corners.last().map(|&end| Vector(end))).collect();
    let elements: Vec<_> = (1..places.len() as u32).map(|k| [k - 1, k]).collect();
    let elements: Vec<_> = elements.iter().map(|e| e.as_slice()).collect();
    let mut sheet = Sheet::new(&elements, places, 0.1);
    sheet.held.fill([true; 2]);
    sheet
}

/// Heights over a sheet of the particles of one body that lies on both of its sides, after falling for a time 1: those
/// that were above, and those that were below.
fn halves(gravity: f64, place: SheetContact) -> [Vec<f64>; 2] {
    let body = block("both", 0, [6.0, 4.0], [20, 16], 0.5, 1.0, Vector::ZERO);
    let sheet = wall(&[[1.0, 8.0], [23.0, 8.0]], 22);
    let mut world =
        World::new([24, 16], KernelKind::Quadratic, vec![body], vec![sheet], Friction::Slip(0.0), 1).meeting_at(place);
    world.gravity = Vector([0.0, gravity]);
    let start: Vec<_> = world.bodies[0].particles.position.clone();
    for _ in 0..100 {
        world.step(0.01);
    }
    assert_eq!(world.contact.counts()[0], ("crossed:sheet".to_owned(), 0), "{place:?}");
    let particles = &world.bodies[0].particles;
    let half = |sign: f64| -> Vec<f64> {
        let all = particles.position.iter().zip(&start);
        all.filter(|(_, start)| (start[1] - 8.0) * sign > 0.0).map(|(x, _)| (x[1] - 8.0) * sign).collect()
    };
    [half(1.0), half(-1.0)]
}

/// Whichever half gravity presses against the sheet stays on its side; the other one falls away from it.
#[test]
fn both_halves_of_a_body_keep_their_sides() {
    for place in PLACES {
        let [above, below] = halves(-1.0, place);
        assert!(above.iter().chain(&below).all(|&height| height > 0.0), "{place:?}");
        let farthest = below.iter().copied().fold(0.0, f64::max);
        assert!((farthest - (3.75 + 0.5)).abs() < 0.01, "{place:?}: free fall: {farthest}");
        let [mirrored_below, mirrored_above] = halves(1.0, place);
        let sum = |heights: &[f64]| heights.iter().sum::<f64>();
        assert!((sum(&above) - sum(&mirrored_above)).abs() < 1e-9, "{place:?}");
        assert!((sum(&below) - sum(&mirrored_below)).abs() < 1e-9, "{place:?}");
    }
}

/// A sheet that is folded back on itself, so that its vector areas cancel on the grid, stops a block from either side.
#[test]
fn a_folded_sheet_stops_what_falls_on_it() {
    for place in PLACES {
        for (from, speed) in [(8.6, -1.0), (4.6, 1.0)] {
            let block = block("block", 0, [8.0, from], [12, 6], 0.5, 1.0, Vector([0.0, speed]));
            let sheet = wall(&[[4.0, 8.0], [18.0, 8.0], [18.0, 8.2], [4.0, 8.2]], 14);
            let mut world =
                World::new([24, 16], KernelKind::Quadratic, vec![block], vec![sheet], Friction::Slip(0.0), 1)
                    .meeting_at(place);
            world.rigid = true;
            for _ in 0..200 {
                world.step(0.01);
            }
            let v = mean_velocity(&world.bodies[0])[1];
            assert!((-0.2..0.01).contains(&(v * speed)), "{place:?} {from}: stopped or thrown back: {v}");
            let beyond = |x: &Vector<2>| (x[1] - 8.1) * speed > 0.0;
            assert!(!world.bodies[0].particles.position.iter().any(beyond), "{place:?} {from}");
            assert_eq!(world.contact.counts()[0].1, 0);
        }
    }
}

/// What was counted before a checkpoint was said then: the run that goes on from it is silent, one that finds it is not.
#[test]
fn crossings_from_before_a_checkpoint_are_not_said_again() {
    let said = |resumed: bool| {
        let body = block("block", 0, [6.0, 9.0], [4, 4], 0.5, 1.0, Vector::ZERO);
        let sheet = wall(&[[1.0, 8.0], [23.0, 8.0]], 22);
        let mut world = World::new([24, 16], KernelKind::Quadratic, vec![body], vec![sheet], Friction::Slip(0.0), 1);
        world.contact.columns("", &mut |name, column| {
            let crossed: &[u64] = &[7, 3, 0];
            if name == "counts" {
                assert!(
                    column.data.replace(&crossed.iter().flat_map(|count| count.to_le_bytes()).collect::<Vec<u8>>())
                );
            }
        });
        if resumed {
            world.contact.restored();
        }
        world.contact.notices()
    };
    assert!(said(false)[0].starts_with("particles have crossed the membrane `sheet`"));
    assert_eq!(said(true), Vec::<String>::new());
}
