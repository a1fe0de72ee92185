//! Bodies, a membrane and contact together: the same bits for any number of threads, and after a resumed run.

use crate::bits::{restore, state, step};
use crate::impact::impact;
use crate::model::*;
use lateen::mpm::{Friction, Mpm, SheetContact, Transfer};

const STEPS: usize = 30;

/// A ball that meets a sheet after some ten steps.
fn model(place: SheetContact) -> Mpm<3> {
    let transfer = Transfer::Flip { relaxation: f64::INFINITY, filter_order: 2, filter_interval: 5 };
    let mut setup = impact(transfer, Friction::Slip(0.3), 7);
    setup.sheet_contact = place;
    start(setup)
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
        restore(&mut second, &saved);
        for _ in 0..STEPS / 2 {
            step(&mut second, t);
            t = step(&mut first, t);
        }
        assert!(term(&first, "contact dissipation") > 0.0, "ball and sheet have met");
        assert!(state(&mut first) == state(&mut second), "{place:?}");
    }
}
