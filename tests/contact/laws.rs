//! Rigid blocks against the laws of impact and friction, and the time of first contact.

use crate::model::*;
use lateen::math::{Signal, Vector};
use lateen::mpm::{BodySetup, Friction, KernelKind, MembraneSetup, Setup, SheetContact};

/// A chain of `n` segments along x at the height `y` from `from` to `to`.
fn chain([from, to]: [f64; 2], y: f64, n: u32) -> MembraneSetup<2> {
    let at = |k: u32| from + (to - from) * f64::from(k) / f64::from(n);
    sheet((0..n).map(|k| vec![k, k + 1]).collect(), (0..=n).map(|k| Vector([at(k), y])).collect(), 0.1)
}

/// Two rigid blocks head-on move on with (m₁v₁ + m₂v₂)/(m₁ + m₂).
#[test]
fn rigid_blocks_go_on_together() {
    let a = block("a", [4.0, 5.0], [8, 8], 0.5, 1.0, Vector([0.5, 0.0]));
    let b = block("b", [8.5, 5.0], [6, 8], 0.5, 3.0, Vector([-0.7, 0.0]));
    let setup = setup([24, 16], vec![a, b], Vec::new(), Friction::Slip(0.0));
    let mut world = World::new(Setup { kernel: KernelKind::Linear, ..setup }).with_rigid(&["a", "b"]);
    (0..200).for_each(|_| world.step(0.02));
    let common = (16.0 * 0.5 - 36.0 * 0.7) / (16.0 + 36.0);
    for name in ["a", "b"] {
        let v = world.mean_velocity(name)[0];
        assert!((v - common).abs() < 1e-3, "{name}: {v}");
    }
}

/// A wide rigid block (its corners, where normals tilt, matter little) on a support, on a membrane or on another body,
/// that is pulled along it by `pull` under gravity 1.
fn pulled(on_sheet: Option<SheetContact>, friction: Friction, pull: f64) -> World<2> {
    let gravity = [Signal::Constant(pull), Signal::Constant(-1.0)];
    let slider = block("block", [6.0, 5.0], [20, 4], 0.5, 1.0, Vector::ZERO);
    if let Some(sheet_contact) = on_sheet {
        let sheet = with_substeps(2, 1.0, 0.004, held(0..23, chain([1.0, 23.0], 5.0, 22)));
        let setup = setup([24, 16], vec![slider], vec![sheet], friction);
        World::new(Setup { gravity, sheet_contact, ..setup }).with_rigid(&["block"])
    } else {
        let floor = block("floor", [1.0, 3.0], [44, 4], 0.5, 1e9, Vector::ZERO);
        let setup = setup([24, 16], vec![slider, floor], Vec::new(), friction);
        World::new(Setup { gravity, ..setup }).with_rigid(&["block"]).with_fixed("floor")
    }
}

/// Coulomb: a block stays while the pull is below μ times its weight, and slides with a = pull − μ g above,
/// on a body and on a membrane.
#[test]
fn a_pulled_block_sticks_or_slides() {
    for on_sheet in [None, Some(SheetContact::Nodes), Some(SheetContact::Particles)] {
        for (friction, pull, expected) in [
            (Friction::Slip(0.3), 0.25, 0.0),
            (Friction::Slip(0.3), 0.5, 0.2),
            (Friction::Slip(0.0), 0.5, 0.5),
            (Friction::Stick, 0.9, 0.0),
        ] {
            let mut world = pulled(on_sheet, friction, pull);
            let [before, after] = [0; 2].map(|_| {
                (0..250).for_each(|_| world.step(0.004));
                world.mean_velocity("block")
            });
            assert!(after[1].abs() < 0.02, "rests: {after:?}");
            let a = after[0] - before[0];
            assert!((a - expected).abs() < 0.01, "sheet {on_sheet:?}, {friction:?}, {pull}: {a}");
        }
    }
}

/// The time at which a contact force first acts, after steps of `dt` [s].
fn first_contact<const D: usize>(setup: Setup<D>, dt: f64) -> f64 {
    let mut world = World::new(setup);
    let acts = |_: &u32| {
        world.step(dt);
        world.contact_force().1 != Vector::ZERO
    };
    f64::from((1..1000).find(acts).expect("they meet")) * dt
}

/// Contact of a block that comes down at speed 1 with a chain below it begins when the faces meet, not when the
/// supports do, whatever the kernel and with sub-steps.
#[test]
fn contact_begins_when_the_faces_meet() {
    let dt = 0.01;
    for &kernel in KernelKind::ALL {
        for sheet_contact in PLACES {
            for (gap, half_thickness) in [(1.0, 0.0), (0.305, 0.0), (1.0, 0.05)] {
                let block = block("block", [6.0, 5.0 + gap], [8, 6], 0.5, 1.0, Vector([0.0, -1.0]));
                let chain = chain([3.0, 13.0], 5.0, 13);
                let chain = if half_thickness > 0.0 { with_half_thickness(half_thickness, chain) } else { chain };
                let chain = with_substeps(3, 10.0 / 13.0, dt, chain);
                let setup = setup([24, 16], vec![block], vec![chain], Friction::Slip(0.0));
                let t = first_contact(Setup { kernel, sheet_contact, ..setup }, dt);
                let expected = gap - half_thickness;
                assert!((t - expected).abs() <= 1.01 * dt, "{kernel:?} {sheet_contact:?}: {t} instead of {expected}");
            }
        }
    }
}

/// The particles of a ball of radius `r` around `centre`, on a lattice of spacing ½ that it is centred on.
fn ball(centre: [f64; 3], r: f64, velocity: Vector<3>, keep: impl Fn(Vector<3>) -> bool) -> BodySetup<3> {
    let half = (2.0 * r).ceil();
    let mut body = block("ball", centre.map(|c| c - 0.5 * half), [2 * half as usize; 3], 0.5, 1.0, velocity);
    body.position.retain(|&x| (x - Vector(centre)).norm() <= r && keep(x));
    let n = body.position.len();
    body.velocity.truncate(n);
    body.volume.truncate(n);
    body.state.truncate(n);
    body
}

/// A flat 20 × 20 sheet of unit quadrilaterals around (12, 12, z).
fn flat(z: f64, velocity: f64) -> MembraneSetup<3> {
    let node = |i: u32, j: u32| i + 21 * j;
    let quad = |n: u32| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| node(n % 20 + i, n / 20 + j)).to_vec();
    let at = |k: u32| Vector([2.0 + f64::from(k % 21), 2.0 + f64::from(k / 21), z]);
    let mut sheet = sheet((0..400).map(quad).collect(), (0..441).map(at).collect(), 7.5e-5);
    sheet.velocity.fill(Vector([0.0, 0.0, velocity]));
    sheet
}

/// The paper's examples 7.1 in mm and ms: a sheet at 50 mm/ms one millimetre above a sphere (its upper cap),
/// and a sphere at 10 mm/ms one millimetre above a sheet. Contact at 0.020 ms and 0.100 ms, with half the
/// sheet's thickness at 0.019 and 0.095, to within a step.
#[test]
fn contact_of_the_papers_spheres_begins_on_time() {
    let centre = [12.0, 12.0, 0.0];
    for sheet_contact in PLACES {
        for (falling, half_thickness, expected) in
            [(true, 0.0, 0.02), (false, 0.0, 0.1), (true, 0.05, 0.019), (false, 0.05, 0.095)]
        {
            let (body, sheet) = if falling {
                (ball(centre, 15.0, Vector::ZERO, |x| x[2] > 10.0), flat(16.0, -50.0))
            } else {
                (ball([12.0, 12.0, 15.5], 4.5, Vector([0.0, 0.0, -10.0]), |_| true), flat(10.0, 0.0))
            };
            let dt = expected / 40.0;
            let sheet = if half_thickness > 0.0 { with_half_thickness(half_thickness, sheet) } else { sheet };
            let sheet = with_substeps(2, 1.0, dt, sheet);
            let setup = setup([24, 24, 24], vec![body], vec![sheet], Friction::Slip(0.0));
            let first = first_contact(Setup { sheet_contact, ..setup }, dt);
            assert!((first - expected).abs() <= 1.01 * dt, "{sheet_contact:?} {falling} {half_thickness}: {first}");
        }
    }
}

/// The body may come from either side of the sheet, whichever way its elements run.
#[test]
fn the_side_of_the_normal_does_not_matter() {
    let speed = |mirror: bool, sheet_contact: SheetContact| {
        let block = block("block", [6.0, 5.5], [8, 6], 0.5, 1.0, Vector([0.0, -1.0]));
        let mut sheet = chain(if mirror { [13.0, 3.0] } else { [3.0, 13.0] }, 5.0, 20);
        sheet.velocity.fill(Vector([0.0, 1.0]));
        let setup = setup([24, 16], vec![block], vec![sheet], Friction::Slip(0.0));
        let mut world = World::new(Setup { sheet_contact, ..setup });
        (0..100).for_each(|_| world.step(0.01));
        assert_eq!(world.crossed(), 0);
        world.mean_velocity("block")[1]
    };
    for place in PLACES {
        assert!((speed(true, place) - speed(false, place)).abs() < 1e-12);
        assert!(speed(false, place) > -0.99);
    }
}
