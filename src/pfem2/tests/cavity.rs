//! The lid-driven cavity at Re = 100.

use super::*;
use crate::pfem2::Pfem2;
use crate::simulation::{Solver, TermKind};

/// Cells that are finer at both ends: x ↦ ½(1 + tanh(a(2x − 1))/tanh a).
fn graded(mesh: &Mesh<2, 3>) -> Mesh<2, 3> {
    const STRETCH: f64 = 1.2;
    let place = |x: f64| 0.5 * (1.0 + (STRETCH * (2.0 * x - 1.0)).tanh() / STRETCH.tanh());
    Mesh::new(mesh.nodes().iter().map(|x| x.map(place)).collect(), mesh.elements().to_vec()).unwrap()
}

/// Extremes of u on the vertical and v on the horizontal centre line, against a solution of second-order differences,
/// extrapolated, at the places of the published extremes. Ghia, Ghia &
/// Shin 1982 themselves print −0.21090, 0.17527 and −0.24533.
#[test]
fn the_velocities_on_the_centre_lines_of_the_cavity_have_the_published_extremes() {
    let mesh = graded(&Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [32; 2]).unwrap());
    let lid = Condition::Wall([1.0.into(), 0.0.into()]);
    let sets = vec![set(&mesh, "lid", lid, |x| x[1] > 1.0 - 1e-12)];
    let setup = setup(mesh, sets, physics(vec![fluid("fluid", 1.0, 0.01)], weightless()), |_| 0, |_| Vector::ZERO);
    let mut pfem = Pfem2::new(setup);
    let dt = 0.05;
    for k in 0..260 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
    }
    let line = |axis: usize| {
        let nodes = pfem.system.mesh.nodes().iter().zip(&pfem.system.velocity);
        nodes.filter(move |(x, _)| (x[axis] - 0.5).abs() < 1e-9).map(move |(_, v)| v[axis])
    };
    let [u, v] = [line(0), line(1)].map(|values| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    });
    for (found, exact) in [(u.0, -0.21398), (v.1, 0.17957), (v.0, -0.25355)] {
        assert!((found / exact - 1.0).abs() < 0.01, "{found} instead of {exact}");
    }
}

/// A lid that starts at once takes the fluid at its nodes along: ½ ρ U² times half a row of cells, 1/16. The ledger
/// begins with it; without, they would show as much energy from nothing as the flow has.
#[test]
fn the_ledger_counts_the_energy_of_a_lid_that_starts_impulsively() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [8; 2]).unwrap();
    let lid = Condition::Wall([1.0.into(), 0.0.into()]);
    let sets = vec![set(&mesh, "lid", lid, |x| x[1] > 1.0 - 1e-12)];
    let setup = setup(mesh, sets, physics(vec![fluid("fluid", 1.0, 1e-4)], weightless()), |_| 0, |_| Vector::ZERO);
    let mut pfem = Pfem2::new(setup);
    // The corners belong to the walls beside the lid and to it: what is slower holds.
    let row = 0.5 * (1.0 - 1.0 / 8.0) / 16.0;
    assert!((pfem.balance.ledger.begun() / row - 1.0).abs() < 0.1, "{}", pfem.balance.ledger.begun());
    // Nothing has happened at t = 0, and all that follows is explained from there on.
    let ledger = pfem.snapshot().ledger;
    let start = ledger.stored();
    assert_eq!([start, ledger.total(TermKind::Gain), ledger.lost()], [0.0; 3]);
    for k in 0..20 {
        pfem.step(f64::from(k) * 0.05, 0.05).unwrap();
        let ledger = pfem.snapshot().ledger;
        assert!(ledger.closure(start).abs() < 1e-12 * ledger.scale(start), "{}", ledger.closure(start));
        // 8 cells are few: errors take some of the energy, which gives a notice, but they add none.
        assert!(!pfem.notices().iter().any(|text| text.contains("given")));
    }
    let given = pfem.snapshot().ledger.terms.iter().find(|term| term.name == "work of boundaries").unwrap().value;
    assert!(given > row, "{given}");
}
