//! Bodies, a membrane and contact together: the same bits for any number of threads, and after a resumed run.

use crate::impact::impact;
use crate::model::*;
use lateen::mpm::{Friction, Mpm, SheetContact, Transfer};
use lateen::simulation::Solver;

const STEPS: usize = 30;

/// A ball that meets a sheet after some ten steps.
fn model(place: SheetContact) -> Mpm<3> {
    let transfer = Transfer::Flip { relaxation: f64::INFINITY, filter_order: 2, filter_interval: 5 };
    let mut setup = impact(transfer, Friction::Slip(0.3), 7);
    setup.sheet_contact = place;
    start(setup)
}

fn step(mpm: &mut Mpm<3>, t: f64) -> f64 {
    let dt = mpm.stable_dt();
    mpm.step(t, dt).unwrap();
    t + dt
}

/// Everything that a checkpoint holds.
fn state(mpm: &mut Mpm<3>) -> Vec<(String, Vec<u8>)> {
    let mut columns = Vec::new();
    mpm.columns(&mut |name, column| columns.push((name.to_owned(), column.data.bytes().to_vec())));
    columns
}

#[test]
fn threads_do_not_change_a_bit() {
    for place in [SheetContact::Nodes, SheetContact::Particles] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut mpm = model(place);
                (0..STEPS).fold(0.0, |t, _| step(&mut mpm, t));
                assert!(term(&mpm, "contact dissipation") > 0.0, "ball and sheet have met");
                state(&mut mpm)
            })
        };
        let one = run(1);
        assert!(one == run(2) && one == run(3), "{place:?}");
    }
}

#[test]
fn a_resumed_run_goes_on_with_the_same_bits() {
    for place in [SheetContact::Nodes, SheetContact::Particles] {
        let mut first = model(place);
        let mut t = (0..STEPS / 2).fold(0.0, |t, _| step(&mut first, t));
        let saved = state(&mut first);
        let mut second = model(place);
        let mut stored = saved.iter();
        second.columns(&mut |name, column| {
            let (expected, bytes) = stored.next().unwrap();
            assert_eq!(name, expected);
            assert!(column.data.replace(bytes));
        });
        second.restored();
        for _ in 0..STEPS / 2 {
            step(&mut second, t);
            t = step(&mut first, t);
        }
        assert!(term(&first, "contact dissipation") > 0.0, "ball and sheet have met");
        assert!(state(&mut first) == state(&mut second), "{place:?}");
    }
}
