//! Ledger, determinism, resume, supports, bad input.

use super::*;
use crate::simulation::ColumnData;

/// A sheet with everything at once: mixed elements, moving supports, pressure, gravity, damping, wrinkling, prestress.
fn busy_sheet() -> Membrane<3> {
    let (mut position, mut elements) = rectangle([9, 7], [0.9, 0.7]);
    let mut seed = 3;
    position.iter_mut().for_each(|x| *x += Vector([0.01, 0.01, 0.02]).map(|a| a * noise(&mut seed)));
    let last = elements.split_off(50);
    elements.extend(last.iter().flat_map(|q| [vec![q[0], q[1], q[2]], vec![q[0], q[2], q[3]]]));
    let law = sheet::Elastic { density: 900.0, young: 1e7, poisson: 0.4, wrinkling: true };
    let mut setup = MembraneSetup {
        prestress: [1e4, 2e4],
        damping: [0.03, 2.0],
        hourglass: [0.05, 0.02, 0.02],
        supports: vec![support(0..10, [Some(0.0), Some(0.0), Some(0.3)]), support(70..80, [None, Some(-0.2), None])],
        pressure: Signal::Constant(150.0),
        ..setup(law, position, elements, 2e-3)
    };
    setup.velocity.iter_mut().for_each(|v| *v = Vector([1.0; 3]).map(|a: f64| 2.0 * a * noise(&mut seed)));
    let g = [Signal::Constant(1.0), Signal::ZERO, Signal::Constant(-9.81)];
    Membrane::new(setup).unwrap().with_gravity(g)
}

/// Steps with varying Δt and a contact force on some nodes.
fn run(membrane: &mut Membrane<3>, steps: std::ops::Range<u32>) {
    let dt = |n: u32| 1.5e-4 * (1.0 + 0.2 * f64::from(n % 5));
    let mut t: f64 = (0..steps.start).map(dt).sum();
    for n in steps {
        assert!(dt(n) < membrane.stable_dt());
        membrane.internal_force(t).unwrap();
        membrane.advance_velocity(t, dt(n));
        let contact: Vec<_> =
            (0..membrane.mass.len()).map(|k| Vector([0.1, 0.0, if k % 7 == 0 { 2.0 } else { 0.0 }])).collect();
        membrane.apply_contact(&contact, t, dt(n));
        membrane.move_nodes(t, dt(n));
        t += dt(n);
    }
}

#[test]
fn the_ledger_of_energy_and_momentum_closes() {
    let mut membrane = busy_sheet();
    let start = membrane.momentum();
    run(&mut membrane, 0..300);
    let b = membrane.balance();
    let scale =
        [b.kinetic_start, b.pressure, b.gravity, b.supports, b.contact, b.damping].map(f64::abs).iter().sum::<f64>();
    assert!(b.closure().abs() < 1e-12 * scale, "closure {:e} of {scale:e}", b.closure());
    assert!(
        [b.pressure, b.gravity, b.supports, b.contact, b.damping, b.hourglass].iter().all(|w| w.abs() > 1e-4 * scale)
    );
    assert!(b.mismatch.abs() < 0.02 * scale, "mismatch {:e} of {scale:e}", b.mismatch);
    let [external, contact, supports] = membrane.impulses();
    let change = membrane.momentum() - start;
    let error = (change - external - contact - supports).norm();
    assert!(error < 1e-12 * (change.norm() + supports.norm()), "momentum {error:e}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut membrane = busy_sheet();
            run(&mut membrane, 0..40);
            bytemuck::cast_slice::<_, u64>(&membrane.position).to_vec()
        })
    };
    assert_eq!(bits(1), bits(3));
}

#[test]
fn a_resumed_sheet_goes_on_bit_by_bit() {
    let (mut one, mut other) = (busy_sheet(), busy_sheet());
    run(&mut one, 0..30);
    let mut stored: Vec<(String, Vec<u8>)> = Vec::new();
    one.columns("sheet.", &mut |name, column| stored.push((name.into(), column.data.bytes().to_vec())));
    let mut next = stored.into_iter();
    other.columns("sheet.", &mut |name, column| {
        let (stored, bytes) = next.next().unwrap();
        assert_eq!(name, stored);
        assert!(column.data.replace(&bytes));
    });
    run(&mut one, 30..60);
    run(&mut other, 30..60);
    assert_eq!(one.position.bytes(), other.position.bytes());
    assert_eq!(one.velocity.bytes(), other.velocity.bytes());
    assert_eq!(one.balance(), other.balance());
}

#[test]
fn supports_hold_and_react() {
    // A sheet hanging from one edge in its own plane: the reaction carries its weight on average.
    let (position, elements) = rectangle([4, 4], [0.1, 0.1]);
    let law = elastic(1000.0, 1e6, 0.3);
    let setup = MembraneSetup {
        supports: vec![support(20..25, FIXED)],
        damping: [0.0, 400.0],
        ..setup(law, position, elements, 1e-3)
    };
    let mut membrane =
        Membrane::new(setup).unwrap().with_gravity([Signal::ZERO, Signal::Constant(-9.81), Signal::ZERO]);
    assert_eq!(membrane.constrained(20), [true; 3]);
    assert_eq!(membrane.constrained(0), [false; 3]);
    let dt = 0.8 * membrane.stable_dt();
    (0..4000).for_each(|n| step(&mut membrane, f64::from(n) * dt, dt));
    let weight = membrane.total_mass() * 9.81;
    assert!((membrane.total_mass() / 0.01 - 1.0).abs() < 1e-12);
    assert!((membrane.reactions()[0][1] / weight - 1.0).abs() < 1e-3, "{:?} N", membrane.reactions()[0]);
    assert!((20..25).all(|k| membrane.position[k] == membrane.reference[k]));
}

#[test]
fn a_wrinkling_sheet_carries_no_compression() {
    // Pushed together by 10 % along x while pulled along y: only tension along y is left.
    let (position, elements) = rectangle([1, 1], [1.0, 1.0]);
    let law = sheet::NeoHookean { density: 1000.0, shear: 1e6, poisson: 0.5, wrinkling: true };
    let mut membrane = Membrane::new(setup(law, position, elements, 1e-3)).unwrap();
    membrane.position.iter_mut().for_each(|x| *x = Vector([0.8 * x[0], 1.1 * x[1], 0.0]));
    membrane.internal_force(0.0).unwrap();
    let [s1, s2] = membrane.principal_stress(0);
    assert!((s1 / 1e6 - (1.21 - 1.0 / 1.1)).abs() < 1e-12 && s2.abs() < 1e-6, "{s1} {s2}");
    assert!(membrane.element_force.iter().all(|f| f[0].abs() < 1e-6));
}

#[test]
fn bad_sheets_are_refused_with_every_finding() {
    let (position, elements) = rectangle([2, 1], [1.0, 1.0]);
    let messages = |change: &dyn Fn(&mut MembraneSetup<3>)| {
        let mut setup = setup(elastic(1000.0, 1e6, 0.3), position.clone(), elements.clone(), 1e-3);
        change(&mut setup);
        Membrane::new(setup)
            .err()
            .map(|findings| findings.iter().map(|d| d.message.clone()).collect::<Vec<_>>().join("; "))
    };
    let refused = |change: &dyn Fn(&mut MembraneSetup<3>), word: &str| {
        let message = messages(change).expect("refused");
        assert!(message.contains(word), "{message}");
    };
    assert_eq!(messages(&|_| ()), None);
    refused(&|s| s.thickness = 0.0, "thickness");
    refused(&|s| s.elements[0][2] = 99, "names node 99");
    refused(&|s| s.elements[0].swap(1, 2), "no area");
    refused(&|s| s.position[4] = Vector([0.2, 0.2, 0.0]), "folded over");
    refused(&|s| s.elements[1] = vec![1, 2], "2 nodes");
    refused(&|s| s.position[0] = s.position[3], "element 0");
    refused(&|s| s.position[4][1] = f64::NAN, "infinity");
    refused(&|s| s.elements.truncate(1), "belong to no element");
    refused(&|s| s.elements.clear(), "no elements");
    let both = messages(&|s| (s.thickness, s.elements[0][2]) = (-1.0, 99)).unwrap();
    assert!(both.contains("thickness") && both.contains("node 99"));
}

#[test]
fn a_collapsed_element_is_reported_with_its_place() {
    let (position, elements) = rectangle([2, 1], [1.0, 1.0]);
    let mut membrane = Membrane::new(setup(elastic(1000.0, 1e6, 0.3), position, elements, 1e-3)).unwrap();
    membrane.position[2] = membrane.position[1];
    membrane.position[5] = membrane.position[4];
    let error = membrane.internal_force(0.5).unwrap_err();
    assert!(error.to_string().contains("element 1 of `sheet`"), "{error}");
    membrane.position[0][0] = f64::NAN;
    let error = membrane.internal_force(0.5).unwrap_err();
    assert!(error.to_string().contains("node 0 of `sheet`"), "{error}");
}
