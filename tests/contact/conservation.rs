//! Contact conserves momentum, and says where the energy went (theory D.15, D.16).

use crate::world::{Sheet, World, block};
use lateen::math::Vector;
use lateen::mpm::{Friction, KernelKind, SheetContact};

const PLACES: [SheetContact; 2] = [SheetContact::Nodes, SheetContact::Particles];

/// A 10 × 10 sheet of quadrilaterals (every other one cut into triangles) around (10, 10, z), slightly wavy.
fn sheet_3d(z: f64, divisions: u32) -> Sheet<3> {
    let n = divisions + 1;
    let at = |i: u32| 5.0 + 10.0 * f64::from(i) / f64::from(divisions);
    let node = |i: u32, j: u32| i + n * j;
    let position = (0..n * n)
        .map(|k| {
            let (x, y) = (at(k % n), at(k / n));
            Vector([x, y, z + 0.1 * (x + 0.3 * y).sin()])
        })
        .collect();
    let mut elements: Vec<Vec<u32>> = Vec::new();
    for j in 0..divisions {
        for i in 0..divisions {
            let corner = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            if (i + j) % 2 == 0 {
                elements.push(corner.to_vec());
            } else {
                elements.push(vec![corner[0], corner[1], corner[2]]);
                elements.push(vec![corner[0], corner[2], corner[3]]);
            }
        }
    }
    Sheet::new(&elements.iter().map(Vec::as_slice).collect::<Vec<_>>(), position, 0.3)
}

fn drop_on_sheet(kind: KernelKind, divisions: u32, friction: Friction, substeps: usize) -> World<3> {
    let body = block("drop", 0, [8.0, 8.2, 10.6], [8, 7, 6], 0.5, 1.0, Vector([1.0, 0.3, -2.0]));
    let mut sheet = sheet_3d(10.0, divisions);
    sheet.velocity.fill(Vector([0.0, 0.1, 0.5]));
    World::new([20, 20, 20], kind, vec![body], vec![sheet], friction, substeps)
}

/// Momentum of body and sheet together: to 1e-12, for sheets coarser and finer than the grid, with and
/// without friction and sub-steps. The energy that is missing is exactly what contact and FLIP report.
#[test]
fn momentum_is_conserved_and_the_ledger_closes() {
    for (kind, divisions, friction, substeps) in [
        (KernelKind::Linear, 10, Friction::Slip(0.0), 1),
        (KernelKind::Quadratic, 3, Friction::Slip(0.4), 3),
        (KernelKind::Gimp, 20, Friction::Stick, 2),
        (KernelKind::Cubic, 7, Friction::Slip(0.1), 7),
    ] {
        for place in PLACES {
            let mut world = drop_on_sheet(kind, divisions, friction, substeps).meeting_at(place);
            let start = world.totals();
            for _ in 0..60 {
                world.step(0.02);
            }
            let (end, name) = (world.totals(), format!("{kind:?} {place:?}"));
            let scale = 40.0 * 2.0;
            assert!(
                (end.momentum - start.momentum).norm() < 1e-12 * scale,
                "{name} {:?}",
                end.momentum - start.momentum
            );
            let losses = world.contact.losses();
            let lost = losses.normal + losses.friction + losses.mapping + world.flip_loss;
            let closure = end.kinetic - start.kinetic + lost;
            assert!(closure.abs() < 1e-11 * start.kinetic, "{name}: {closure:e}");
            assert!(losses.normal > 0.03 * start.kinetic, "{name}: nothing happened: {losses:?}");
            assert!(losses.mapping >= 0.0 && world.flip_loss >= 0.0);
            assert_eq!(losses.friction > 0.0, friction != Friction::Slip(0.0), "{losses:?}");
            // Only impulses along the line between foot and particle leave angular momentum alone (theory (D.28)).
            let aligned = place == SheetContact::Particles && friction == Friction::Slip(0.0);
            assert_eq!(Vector(losses.spin).norm() < 1e-12 * scale, aligned, "{name}: {losses:?}");
            assert_eq!(world.contact.counts()[0].1, 0);
        }
    }
}

/// A body that starts somewhat inside of a sheet is at rest and stays so, however short the step: nothing pushes them together,
/// so there is nothing that contact may give back.
#[test]
fn an_overlap_is_no_source_of_energy() {
    for dt in [0.02, 0.0002] {
        let body = block("drop", 0, [8.0, 8.2, 10.0], [8, 7, 6], 0.5, 1.0, Vector::ZERO);
        let sheets = vec![sheet_3d(10.0, 10)];
        let world = World::new([20, 20, 20], KernelKind::Quadratic, vec![body], sheets, Friction::Slip(0.0), 1);
        let mut world = world.meeting_at(SheetContact::Particles);
        for _ in 0..20 {
            world.step(dt);
        }
        assert!(world.totals().kinetic < 1e-24, "{:e}", world.totals().kinetic);
    }
}

/// With gravity the work of gravity joins the balance.
#[test]
fn the_ledger_closes_under_gravity() {
    PLACES.into_iter().for_each(closes_under_gravity);
}

fn closes_under_gravity(place: SheetContact) {
    let mut world = drop_on_sheet(KernelKind::Quadratic, 8, Friction::Slip(0.3), 4).meeting_at(place);
    world.gravity = Vector([0.2, 0.0, -3.0]);
    for k in [0, 8, 72, 80] {
        world.sheets[0].held[k] = [true; 3];
        world.sheets[0].velocity[k] = Vector::ZERO;
    }
    let start = world.totals();
    for _ in 0..60 {
        world.step(0.02);
    }
    let losses = world.contact.losses();
    let lost = losses.normal + losses.friction + losses.mapping + world.flip_loss;
    let closure = world.totals().kinetic - start.kinetic + lost - world.work;
    assert!(closure.abs() < 1e-11 * start.kinetic, "{closure:e}");
}

/// The force on a body that the histories report is its change of momentum over the step.
#[test]
fn reported_forces_are_changes_of_momentum() {
    PLACES.into_iter().for_each(forces_change_momentum);
}

fn forces_change_momentum(place: SheetContact) {
    let mut world = drop_on_sheet(KernelKind::Quadratic, 5, Friction::Slip(0.2), 3).meeting_at(place);
    let momentum = |world: &World<3>| -> Vector<3> {
        let p = &world.bodies[0].particles;
        p.mass.iter().zip(&p.velocity).map(|(&m, &v)| v * m).sum()
    };
    let (mut total, start) = (Vector::ZERO, momentum(&world));
    for _ in 0..40 {
        world.step(0.02);
        let (name, force) = world.contact.forces().next().unwrap();
        assert_eq!(name, "contact:drop-sheet");
        total += Vector(force) * 0.02;
    }
    let change = momentum(&world) - start;
    assert!((change - total).norm() < 1e-12 * start.norm(), "{change:?} {total:?}");
    assert!(change.norm() > 0.1 * start.norm());
}

/// Two bodies of dust: what contact and FLIP report is what is missing.
#[test]
fn bodies_conserve_momentum_with_each_other() {
    for friction in [Friction::Slip(0.0), Friction::Slip(0.3), Friction::Stick] {
        let a = block("a", 0, [4.0, 5.0], [8, 8], 0.5, 1.0, Vector([0.5, 0.2]));
        let b = block("b", 1, [8.5, 5.3], [6, 8], 0.5, 3.0, Vector([-0.7, 0.0]));
        let mut world = World::new([24, 16], KernelKind::Quadratic, vec![a, b], Vec::new(), friction, 1);
        let start = world.totals();
        for _ in 0..200 {
            world.step(0.02);
        }
        let end = world.totals();
        assert!((end.momentum - start.momentum).norm() < 1e-12 * start.momentum.norm());
        let losses = world.contact.losses();
        let closure = end.kinetic - start.kinetic + losses.normal + losses.friction + world.flip_loss;
        assert!(closure.abs() < 1e-11 * start.kinetic, "{closure:e}");
        assert!(losses.normal > 0.05 * start.kinetic);
        assert_eq!(losses.friction.abs() > 1e-6 * start.kinetic, friction != Friction::Slip(0.0), "{losses:?}");
    }
}
