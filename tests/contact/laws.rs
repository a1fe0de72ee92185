//! Rigid blocks against the laws of impact and friction, and the time of first contact.

use crate::world::{Sheet, World, block, mean_velocity};
use lateen::math::Vector;
use lateen::mpm::{Body, Friction, KernelKind, SheetContact};

const PLACES: [SheetContact; 2] = [SheetContact::Nodes, SheetContact::Particles];

/// A chain of `n` segments along x at the height `y` from `from` to `to`.
fn chain([from, to]: [f64; 2], y: f64, n: u32, held: bool) -> Sheet<2> {
    let at = |k: u32| from + (to - from) * f64::from(k) / f64::from(n);
    let elements: Vec<_> = (0..n).map(|k| [k, k + 1]).collect();
    let elements: Vec<_> = elements.iter().map(|e| e.as_slice()).collect();
    let mut sheet = Sheet::new(&elements, (0..=n).map(|k| Vector([at(k), y])).collect(), 0.1);
    sheet.held.fill([held; 2]);
    sheet
}

/// Two rigid blocks head-on move on with (m₁v₁ + m₂v₂)/(m₁ + m₂).
#[test]
fn rigid_blocks_go_on_together() {
    let a = block("a", 0, [4.0, 5.0], [8, 8], 0.5, 1.0, Vector([0.5, 0.0]));
    let b = block("b", 1, [8.5, 5.0], [6, 8], 0.5, 3.0, Vector([-0.7, 0.0]));
    let mut world = World::new([24, 16], KernelKind::Linear, vec![a, b], Vec::new(), Friction::Slip(0.0), 1);
    world.rigid = true;
    for _ in 0..200 {
        world.step(0.02);
    }
    let common = (16.0 * 0.5 - 36.0 * 0.7) / (16.0 + 36.0);
    for body in &world.bodies {
        assert!((mean_velocity(body)[0] - common).abs() < 1e-3, "{}: {}", body.name, mean_velocity(body)[0]);
    }
}

/// The acceleration along x of a wide rigid block (its corners, where normals tilt, matter little) that is pulled along its support by `pull` under gravity 1.
fn acceleration(on_sheet: Option<SheetContact>, friction: Friction, pull: f64) -> f64 {
    let slider = block("block", 0, [6.0, 5.0], [20, 4], 0.5, 1.0, Vector::ZERO);
    let mut world = if let Some(place) = on_sheet {
        World::new([24, 16], KernelKind::Quadratic, vec![slider], vec![chain([1.0, 23.0], 5.0, 22, true)], friction, 2)
            .meeting_at(place)
    } else {
        let floor = block("floor", 1, [1.0, 3.0], [44, 4], 0.5, 1e9, Vector::ZERO);
        World::new([24, 16], KernelKind::Quadratic, vec![slider, floor], Vec::new(), friction, 1)
    };
    (world.rigid, world.gravity, world.fixed) = (true, Vector([pull, -1.0]), vec![1]);
    for _ in 0..250 {
        world.step(0.004);
    }
    let before = mean_velocity(&world.bodies[0]);
    for _ in 0..250 {
        world.step(0.004);
    }
    let after = mean_velocity(&world.bodies[0]);
    assert!(after[1].abs() < 0.02, "rests: {after:?}");
    after[0] - before[0]
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
            let a = acceleration(on_sheet, friction, pull);
            assert!((a - expected).abs() < 0.01, "sheet {on_sheet:?}, {friction:?}, {pull}: {a}");
        }
    }
}

/// The step in which a force first acts between a block that comes down at speed 1 and a chain `gap` below it.
fn first_contact(kind: KernelKind, place: SheetContact, gap: f64, offset: f64, substeps: usize) -> f64 {
    let block = block("block", 0, [6.0, 5.0 + gap], [8, 6], 0.5, 1.0, Vector([0.0, -1.0]));
    let mut sheet = chain([3.0, 13.0], 5.0, 13, false);
    sheet.offset = vec![offset; 13];
    let mut world =
        World::new([24, 16], kind, vec![block], vec![sheet], Friction::Slip(0.0), substeps).meeting_at(place);
    for step in 1..1000 {
        world.step(0.01);
        if world.contact.forces().next().unwrap().1 != [0.0; 3] {
            return 0.01 * f64::from(step);
        }
    }
    f64::INFINITY
}

/// Contact begins when the faces meet, not when the supports do, whatever the kernel and the sub-steps.
#[test]
fn contact_begins_when_the_faces_meet() {
    for kind in [KernelKind::Linear, KernelKind::Gimp, KernelKind::Quadratic, KernelKind::Cubic] {
        for (place, gap, offset) in
            PLACES.into_iter().flat_map(|place| [(place, 1.0, 0.0), (place, 0.305, 0.0), (place, 1.0, 0.05)])
        {
            let t = first_contact(kind, place, gap, offset, 3);
            assert!((t - (gap - offset)).abs() <= 0.0101, "{kind:?} {place:?}: gap {gap}, offset {offset}: {t}");
        }
    }
}

/// The particles of a ball of radius `r` around `centre`, on a lattice of spacing ½ that it is centred on.
fn ball(centre: [f64; 3], r: f64, velocity: Vector<3>, keep: impl Fn(Vector<3>) -> bool) -> Body<3> {
    let half = (2.0 * r).ceil();
    let mut body = block("ball", 0, centre.map(|c| c - 0.5 * half), [2 * half as usize; 3], 0.5, 1.0, velocity);
    let p = &mut body.particles;
    p.position.retain(|&x| (x - Vector(centre)).norm() <= r && keep(x));
    let n = p.position.len();
    (p.id, p.velocity, p.mass, p.volume) = ((0..n as u32).collect(), vec![velocity; n], vec![0.125; n], vec![0.125; n]);
    body
}

/// A flat 20 × 20 sheet of unit quadrilaterals around (12, 12, z).
fn flat(z: f64, velocity: f64) -> Sheet<3> {
    let node = |i: u32, j: u32| i + 21 * j;
    let quad = |n: u32| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| node(n % 20 + i, n / 20 + j));
    let elements: Vec<_> = (0..400).map(quad).collect();
    let at = |k: u32| Vector([2.0 + f64::from(k % 21), 2.0 + f64::from(k / 21), z]);
    let elements: Vec<_> = elements.iter().map(|e| e.as_slice()).collect();
    let mut sheet = Sheet::new(&elements, (0..441).map(at).collect(), 7.5e-5);
    sheet.velocity.fill(Vector([0.0, 0.0, velocity]));
    sheet
}

/// The paper's examples 7.1 in mm and ms: a sheet at 50 mm/ms one millimetre above a sphere (its upper cap),
/// and a sphere at 10 mm/ms one millimetre above a sheet. Contact at 0.020 ms and 0.100 ms, with half the
/// sheet's thickness at 0.019 and 0.095, to within a step.
#[test]
fn contact_of_the_papers_spheres_begins_on_time() {
    let centre = [12.0, 12.0, 0.0];
    let cases = [(true, 0.0, 0.02), (false, 0.0, 0.1), (true, 0.05, 0.019), (false, 0.05, 0.095)];
    for (place, (falling, half_thickness, expected)) in
        PLACES.into_iter().flat_map(|place| cases.map(|case| (place, case)))
    {
        let (body, mut sheet) = if falling {
            (ball(centre, 15.0, Vector::ZERO, |x| x[2] > 10.0), flat(16.0, -50.0))
        } else {
            (ball([12.0, 12.0, 15.5], 4.5, Vector([0.0, 0.0, -10.0]), |_| true), flat(10.0, 0.0))
        };
        sheet.offset = vec![half_thickness; 400];
        let mut world =
            World::new([24, 24, 24], KernelKind::Quadratic, vec![body], vec![sheet], Friction::Slip(0.0), 2)
                .meeting_at(place);
        let dt = expected / 40.0;
        let first = (1..100).find(|_| {
            world.step(dt);
            world.contact.forces().next().unwrap().1 != [0.0; 3]
        });
        let first = f64::from(first.expect("they meet")) * dt;
        assert!((first - expected).abs() <= 1.01 * dt, "{place:?} {falling} {half_thickness}: {first}");
    }
}

/// The body may come from either side of the sheet, whichever way its elements run.
#[test]
fn the_side_of_the_normal_does_not_matter() {
    let speed = |mirror: bool, place: SheetContact| {
        let block = block("block", 0, [6.0, 5.5], [8, 6], 0.5, 1.0, Vector([0.0, -1.0]));
        let mut sheet = chain(if mirror { [13.0, 3.0] } else { [3.0, 13.0] }, 5.0, 20, false);
        sheet.velocity.fill(Vector([0.0, 1.0]));
        let mut world = World::new([24, 16], KernelKind::Quadratic, vec![block], vec![sheet], Friction::Slip(0.0), 1)
            .meeting_at(place);
        for _ in 0..100 {
            world.step(0.01);
        }
        assert_eq!(world.contact.counts()[0], ("crossed:sheet".to_owned(), 0));
        mean_velocity(&world.bodies[0])[1]
    };
    for place in PLACES {
        assert!((speed(true, place) - speed(false, place)).abs() < 1e-12);
        assert!(speed(false, place) > -0.99);
    }
}
