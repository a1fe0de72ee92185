//! A body, a sheet and another body meet: momentum and energy are accounted for to round-off.

use crate::model::*;
use lateen::material::{Elastic, NeoHookean, StartState};
use lateen::math::Vector;
use lateen::mpm::{BodySetup, Friction, Setup, Transfer};
use lateen::simulation::Solver;

/// A block of rubber of density `density` on a lattice of eighths from `lower`.
fn rubber(name: &str, density: f64, lower: [f64; 3], count: [usize; 3], inside: fn(Vector<3>) -> bool) -> BodySetup<3> {
    let law = Box::new(NeoHookean { elastic: Elastic::new(density, 2e3, 0.3) });
    body(name, (law, StartState::default()), (lower, count, 0.125), inside, Vector::ZERO)
}

/// A rubber ball hits a free sheet; a second block waits below it.
pub fn impact(transfer: Transfer, friction: Friction, max_substeps: usize) -> Setup<3> {
    let in_ball = |x: Vector<3>| (x - Vector([0.0, 0.0, 0.6])).norm() < 0.5;
    let mut ball = rubber("ball", 10.0, [-0.5, -0.5, 0.1], [8; 3], in_ball);
    ball.velocity = ball.position.iter().map(|x| Vector([0.5, 0.3 * x[2], -4.0])).collect();
    let waiting = rubber("body", 20.0, [-0.5, -0.5, -0.7], [8, 8, 4], |_| true);
    let n = 9_u32;
    let at = |i: u32| f64::from(i) * 0.25 - 1.0;
    let position = (0..n * n).map(|k| Vector([at(k % n), at(k / n), 0.0])).collect();
    let cell = |k: u32| k / (n - 1) * n + k % (n - 1);
    let elements = (0..(n - 1) * (n - 1)).map(|k| [0, 1, n + 1, n].map(|o| cell(k) + o).to_vec()).collect();
    let sheet = membrane(position, elements, [100.0, 2e5, 0.3, 0.02], Vec::new());
    let mut setup = setup(open([-2.0, -2.0, -1.5], 0.25, [16, 16, 12]), vec![ball, waiting], vec![sheet]);
    (setup.transfer, setup.default_friction, setup.max_substeps) = (transfer, friction, max_substeps);
    setup
}

/// Momentum and energy of ball, sheet and block, with gravity off: theory D.15, D.16.
#[test]
fn coupled_ledger_closes() {
    for (transfer, friction, substeps) in
        [(FLIP, Friction::Slip(0.0), 1), (Transfer::Apic, Friction::Slip(0.3), 50), (FLIP, Friction::Stick, 7)]
    {
        let mut mpm = start(impact(transfer, friction, substeps));
        let names = ["momentum x", "momentum y", "momentum z"];
        let before = names.map(|name| term(&mpm, name));
        run(&mut mpm, 0.25, |_, _| {});
        let what = format!("{transfer:?} {friction:?} {substeps}");
        assert!(closure(&mpm).abs() < 1e-12, "{what}: closure {}", closure(&mpm));
        for (name, before) in names.iter().zip(before) {
            let now = term(&mpm, name);
            assert!((now - before).abs() < 1e-12 * 20.0, "{what}: {name} {before} → {now}");
        }
        let lost = term(&mpm, "contact dissipation") / term(&mpm, "stored energy at the start");
        assert!(lost > 1e-3 && lost < 0.5, "{what}: contact lost {lost}");
        let counts = &mpm.snapshot().counts;
        assert!(counts.contains(&("crossed:sheet".to_owned(), 0)), "{what}: {counts:?}");
    }
}
