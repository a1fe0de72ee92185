//! Contact conserves momentum, and says where the energy went (theory D.15, D.16).

use crate::model::*;
use lateen::math::{Signal, Vector};
use lateen::mpm::{Friction, KernelKind, MembraneSetup, Setup, SheetContact};
use lateen::simulation::Solver;

const DT: f64 = 0.02;

/// A 10 × 10 sheet of quadrilaterals (every other one cut into triangles) around (10, 10, z), slightly wavy.
fn sheet_3d(z: f64, divisions: u32) -> MembraneSetup<3> {
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
    sheet(elements, position, 0.3)
}

/// A block that falls on the sheet, which comes towards it.
fn drop_on_sheet(kernel: KernelKind, divisions: u32, friction: Friction, substeps: u32) -> Setup<3> {
    let body = block("drop", [8.0, 8.2, 10.6], [8, 7, 6], 0.5, 1.0, Vector([1.0, 0.3, -2.0]));
    let mut sheet = with_substeps(substeps, 10.0 / f64::from(divisions), DT, sheet_3d(10.0, divisions));
    sheet.velocity.fill(Vector([0.0, 0.1, 0.5]));
    Setup { kernel, ..setup([20, 20, 20], vec![body], vec![sheet], friction) }
}

/// Momentum of body and sheet together: to 1e-12, for sheets coarser and finer than the grid, with and without friction
/// and sub-steps. The energy that is missing is exactly what contact and FLIP report.
#[test]
fn momentum_is_conserved_and_the_ledger_closes() {
    for (kernel, divisions, friction, substeps) in [
        (KernelKind::Linear, 10, Friction::Slip(0.0), 1),
        (KernelKind::Quadratic, 3, Friction::Slip(0.4), 3),
        (KernelKind::Gimp, 20, Friction::Stick, 2),
        (KernelKind::Cubic, 7, Friction::Slip(0.1), 7),
    ] {
        for sheet_contact in PLACES {
            let mut world = World::new(Setup { sheet_contact, ..drop_on_sheet(kernel, divisions, friction, substeps) });
            let (start, kinetic) = (world.total_momentum(), world.term("stored energy at the start"));
            (0..60).for_each(|_| world.step(DT));
            let name = format!("{kernel:?} {sheet_contact:?}");
            assert_eq!(world.mpm.substeps(DT) > 1, substeps > 1, "{name}: {} sub-steps", world.mpm.substeps(DT));
            let scale = 40.0 * 2.0;
            let gained = world.total_momentum() - start;
            assert!(gained.norm() < 1e-12 * scale, "{name} {gained:?}");
            assert!(world.closure().abs() < 1e-11, "{name}: {:e}", world.closure());
            let [normal, rubbed, mapping, flip] =
                ["contact dissipation", "friction dissipation", "contact mapping loss", "transfer dissipation"]
                    .map(|name| world.term(name));
            assert!(normal > 0.03 * kinetic, "{name}: they have met: {normal}");
            assert!(mapping >= 0.0 && flip >= 0.0, "{name}: {mapping} {flip}");
            assert_eq!(rubbed > 0.0, friction != Friction::Slip(0.0), "{name}: {rubbed}");
            // Only impulses along the line between foot and particle leave angular momentum alone (theory (D.28)).
            let aligned = sheet_contact == SheetContact::Particles && friction == Friction::Slip(0.0);
            let spin = Vector(["x", "y", "z"].map(|axis| world.term(&format!("angular momentum of contact {axis}"))));
            assert_eq!(spin.norm() < 1e-12 * scale, aligned, "{name}: {spin:?}");
            assert_eq!(world.crossed(), 0);
        }
    }
}

/// A body that starts somewhat inside of a sheet is at rest and stays so, however short the step: nothing pushes them
/// together, so there is nothing that contact may give back.
#[test]
fn an_overlap_is_no_source_of_energy() {
    for dt in [0.02, 0.0002] {
        let body = block("drop", [8.0, 8.2, 10.0], [8, 7, 6], 0.5, 1.0, Vector::ZERO);
        let setup = setup([20, 20, 20], vec![body], vec![sheet_3d(10.0, 10)], Friction::Slip(0.0));
        let mut world = World::new(Setup { sheet_contact: SheetContact::Particles, ..setup });
        (0..20).for_each(|_| world.step(dt));
        let kinetic = world.term("kinetic energy: drop") + world.term("kinetic energy: sheet");
        assert!(kinetic < 1e-24, "{kinetic:e}");
    }
}

/// With gravity its work on body and sheet, and that of supports, join the balance.
#[test]
fn the_ledger_closes_under_gravity() {
    for sheet_contact in PLACES {
        let mut setup = drop_on_sheet(KernelKind::Quadratic, 8, Friction::Slip(0.3), 4);
        setup.gravity = [0.2, 0.0, -3.0].map(Signal::Constant);
        setup.membranes = setup.membranes.into_iter().map(|sheet| held([0, 8, 72, 80].into_iter(), sheet)).collect();
        let mut world = World::new(Setup { sheet_contact, ..setup });
        (0..60).for_each(|_| world.step(DT));
        assert!(world.closure().abs() < 1e-11, "{sheet_contact:?}: {:e}", world.closure());
        assert!(world.term("contact dissipation") > 0.0, "{sheet_contact:?}: they have met");
    }
}

/// The force on a body that the histories report is its change of momentum over the step of the momentum, which is half
/// as long at the start.
#[test]
fn reported_forces_are_changes_of_momentum() {
    for sheet_contact in PLACES {
        let setup = drop_on_sheet(KernelKind::Quadratic, 5, Friction::Slip(0.2), 3);
        let mut world = World::new(Setup { sheet_contact, ..setup });
        let (mut total, start) = (Vector::ZERO, world.momentum("drop"));
        for step in 0..40 {
            world.step(DT);
            let (name, force) = world.contact_force();
            assert_eq!(name, "contact:drop-sheet");
            total += force * if step == 0 { 0.5 * DT } else { DT };
        }
        let change = world.momentum("drop") - start;
        assert!((change - total).norm() < 1e-12 * start.norm(), "{sheet_contact:?}: {change:?} {total:?}");
        assert!(change.norm() > 0.1 * start.norm());
    }
}

/// Two bodies of dust that meet askew: what contact and FLIP report is what is missing.
#[test]
fn two_bodies_conserve_momentum_and_the_ledger_closes() {
    for friction in [Friction::Slip(0.0), Friction::Slip(0.3), Friction::Stick] {
        let a = block("a", [4.0, 5.0], [8, 8], 0.5, 1.0, Vector([0.5, 0.2]));
        let b = block("b", [8.5, 5.3], [6, 8], 0.5, 3.0, Vector([-0.7, 0.0]));
        let mut world = World::new(setup([24, 16], vec![a, b], Vec::new(), friction));
        let (start, kinetic) = (world.total_momentum(), world.term("stored energy at the start"));
        (0..200).for_each(|_| world.step(DT));
        assert!((world.total_momentum() - start).norm() < 1e-12 * start.norm());
        assert!(world.closure().abs() < 1e-11, "{:e}", world.closure());
        assert!(world.term("contact dissipation") > 0.05 * kinetic);
        let rubbed = world.term("friction dissipation").abs() > 1e-6 * kinetic;
        assert_eq!(rubbed, friction != Friction::Slip(0.0), "{friction:?}");
    }
}
