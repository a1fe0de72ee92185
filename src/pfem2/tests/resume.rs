//! The same bits for any number of threads, and after a restart.

use super::contact::{landing, meeting};
use super::floating::floating_box;
use super::particle_solids::paper_beam;
use super::solids::bar;
use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::solid::setup::SurfaceCondition;
use crate::simulation::{Column, Solver};

/// A falling drop in a box with an inlet and an outlet.
fn drop() -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [12; 2]).unwrap();
    let sets = vec![
        set(&mesh, "in", Condition::Inlet([formula("4*y*(1 - y)"), 0.0.into()]), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Outlet, |x| x[0] == 1.0),
    ];
    let surface = |x: Vector<2>| (x - Vector([0.4, 0.6])).norm() - 0.2;
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let physics = physics(fluids, [0.0.into(), formula("-9.81*(1 + 5*t)")]);
    let mut setup = setup(mesh, sets, physics, |x| u8::from(surface(x) >= 0.0), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, surface, &mut setup.particles));
    setup.projectile_ratio = 10.0;
    Pfem2::new(setup)
}

fn advance(pfem: &mut Pfem2<2, 3>, steps: std::ops::Range<u32>) {
    steps.for_each(|k| pfem.step(f64::from(k) * 0.01, 0.01).unwrap());
}

/// All columns, byte by byte.
fn bytes(pfem: &mut Pfem2<2, 3>) -> Vec<(String, Vec<u8>)> {
    let mut columns = Vec::new();
    pfem.columns(&mut |name, column| columns.push((name.to_owned(), column.data.bytes().to_vec())));
    columns
}

/// Cases: fluids, a fluid with a solid, two with one, two solids that meet, one of them rigid, one that has just
/// landed, and a solid on particles.
const CASES: [fn() -> Pfem2<2, 3>; 6] =
    [drop, || bar(3, 0.02), || floating_box(10, 0.513, 0.02, SurfaceCondition::NoSlip), meeting, landing, paper_beam];

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let run = |case: fn() -> Pfem2<2, 3>, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut pfem = case();
            advance(&mut pfem, 0..8);
            bytes(&mut pfem)
        })
    };
    assert!(CASES.iter().all(|&case| run(case, 1) == run(case, 3)));
}

/// All that is shown, as bits.
fn shown(pfem: &Pfem2<2, 3>) -> Vec<(String, Vec<u64>)> {
    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<u64>>();
    let snapshot = pfem.snapshot();
    let terms = snapshot.ledger.terms.iter().map(|term| (term.name.clone(), bits(&[term.value])));
    let forces = snapshot.forces.iter().map(|(name, force)| (name.clone(), bits(force)));
    let counts = snapshot.counts.iter().map(|(name, count)| (name.clone(), vec![*count]));
    let points = snapshot.points.iter().flat_map(|set| &set.fields);
    let surfaces = snapshot.surfaces.iter().flat_map(|set| set.node_fields.iter().chain(&set.element_fields));
    let fields = points.chain(surfaces).map(|field| (field.name.to_owned(), bits(&field.values())));
    let largest = ("largest energy".to_owned(), bits(&[snapshot.ledger.largest]));
    terms.chain(forces).chain(counts).chain(fields).chain([largest]).collect()
}

#[test]
fn a_restored_run_goes_on_with_the_same_bits() {
    CASES.into_iter().for_each(goes_on_with_the_same_bits);
}

fn goes_on_with_the_same_bits(case: fn() -> Pfem2<2, 3>) {
    let mut whole = case();
    advance(&mut whole, 0..4);
    let (saved, longest) = (bytes(&mut whole), whole.stable_dt());
    advance(&mut whole, 4..8);
    let mut resumed = case();
    let mut next = saved.iter();
    resumed.columns(&mut |name, column: Column<'_>| {
        let (saved, bytes) = next.next().unwrap();
        assert_eq!(saved, name);
        assert!(column.data.replace(bytes));
    });
    resumed.restored();
    assert!(bytes(&mut resumed) == saved);
    let mut whole_then = case();
    advance(&mut whole_then, 0..4);
    for (now, then) in shown(&resumed).into_iter().zip(shown(&whole_then)) {
        assert!(now == then, "{} is shown otherwise after a restore", now.0);
    }
    assert_eq!(resumed.stable_dt(), longest);
    advance(&mut resumed, 4..8);
    let (whole, resumed) = (bytes(&mut whole), bytes(&mut resumed));
    let differing: Vec<&str> = whole.iter().zip(&resumed).filter(|(a, b)| a != b).map(|(a, _)| a.0.as_str()).collect();
    assert!(differing.is_empty(), "{differing:?}");
}
