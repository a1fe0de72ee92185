//! The energy ledger against closed forms.

use super::*;
use crate::material::{Elastic, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, PrescribedMotion, SolidSetup, SurfaceCondition};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;
use std::f64::consts::PI;

fn term(pfem: &Pfem2<2, 3>, name: &str) -> f64 {
    pfem.snapshot().ledger.terms.iter().find(|term| term.name == name).unwrap().value
}

/// The vortices v = (sin x cos y, −cos x sin y) between slip walls, of viscosity ν: they keep their shape and decay as
/// e^(−2νt). Steps are `long` decay times 1/2ν, in which the fluid moves by 0.02, a sixth of a cell, at most. Returns
/// the kinetic energy at the start and at the end, and the viscous and the numerical dissipation.
fn decaying(long: f64, steps: u32) -> [f64; 4] {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(PI), [24; 2]).unwrap();
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let vortices = |x: Vector<2>| Vector([x[0].sin() * x[1].cos(), -x[0].cos() * x[1].sin()]);
    let dt = 0.02;
    let viscosity = long / (2.0 * dt);
    let setup = setup(mesh, sets, physics(vec![fluid("oil", 1.0, viscosity)], weightless()), |_| 0, vortices);
    let mut pfem = Pfem2::new(setup);
    let start = term(&pfem, "kinetic energy");
    (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
    let [left, viscous, numerical] =
        ["kinetic energy", "viscous dissipation", "numerical dissipation"].map(|name| term(&pfem, name));
    [start, left, viscous, numerical]
}

/// Nothing but viscosity takes their energy, however long the steps are for it.
#[test]
fn viscous_dissipation_is_the_energy_that_vortices_lose_also_in_long_steps() {
    for (long, steps) in [(0.05, 20), (0.5, 8), (2.0, 6), (10.0, 6)] {
        let [start, left, viscous, numerical] = decaying(long, steps);
        assert!((start / (PI * PI / 4.0) - 1.0).abs() < 0.01, "{start}");
        assert!((viscous / (start - left) - 1.0).abs() < 0.02, "{long}: {viscous} of {}", start - left);
        assert!(numerical.abs() < 0.02 * start, "{long}: {numerical} of {start}");
    }
}

/// A channel that narrows to half its height, between slip walls: what comes in at 1 leaves at 2, ½ρv² four times as
/// much per volume, and the pressure behind it does that work (Bernoulli). Two volumes of the channel go through.
#[test]
fn fluid_that_leaves_takes_its_energy_along() {
    let height = |x: f64| 0.75 + 0.25 * (PI * x.clamp(0.5, 1.5) - 0.5 * PI).cos();
    let block = Mesh::<2, 3>::block(Vector::ZERO, Vector([2.0, 1.0]), [32, 16]).unwrap();
    let mesh = bent(&block, |x| Vector([x[0], x[1] * height(x[0])]));
    let sets = vec![
        set(&mesh, "in", Condition::Inlet([1.0.into(), 0.0.into()]), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Outlet, |x| x[0] == 2.0),
        set(&mesh, "floor", Condition::Slip, |x| x[1] == 0.0),
        set(&mesh, "roof", Condition::Slip, move |x| (x[1] - height(x[0])).abs() < 1e-9),
    ];
    let through = move |x: Vector<2>| Vector([1.0 / height(x[0]), 0.0]);
    let setup = setup(mesh, sets, physics(vec![fluid("water", 1000.0, 1e-3)], weightless()), |_| 0, through);
    let mut pfem = Pfem2::new(setup);
    (0..60).for_each(|k| pfem.step(f64::from(k) * 0.05, 0.05).unwrap());
    // 500 J come in and 2000 J leave per second.
    let [carried, work] = ["energy through openings", "work of boundaries"].map(|name| term(&pfem, name));
    assert!((carried / -4500.0 - 1.0).abs() < 0.02, "{carried}");
    assert!((work / 4500.0 - 1.0).abs() < 0.05, "{work}");
    let numerical = term(&pfem, "numerical dissipation");
    assert!(numerical.abs() < 0.03 * 4500.0, "{numerical}");
    // 1000 N of momentum come in, 2000 N leave, and the walls' and the inlet's pressures make the difference.
    let [out, impulse] = ["momentum through openings x", "external impulse x"].map(|name| term(&pfem, name));
    assert!((out / -3000.0 - 1.0).abs() < 0.02, "{out}");
    assert!((impulse / 3000.0 - 1.0).abs() < 0.05, "{impulse}");
    assert_eq!(pfem.notices(), Vec::<String>::new());
}

/// Vortices that turn in elements as long as a fifth of the box, without viscosity.
fn coarse_vortices() -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(PI), [5; 2]).unwrap();
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let vortices = |x: Vector<2>| Vector([x[0].sin() * x[1].cos(), -x[0].cos() * x[1].sin()]);
    Pfem2::new(setup(mesh, sets, physics(vec![fluid("water", 1.0, 1e-9)], weightless()), |_| 0, vortices))
}

/// Takes steps of 0.2; returns what they have to say.
fn said(pfem: &mut Pfem2<2, 3>, steps: std::ops::Range<u32>) -> Vec<String> {
    let mut said = Vec::new();
    for k in steps {
        pfem.step(f64::from(k) * 0.2, 0.2).unwrap();
        said.extend(pfem.notices());
    }
    said
}

/// Vortices that turn twice lose a part of their energy to a coarse mesh: the run says so, and if it is resumed, not
/// again.
#[test]
fn the_notice_of_numerical_dissipation_comes_once_also_in_a_resumed_run() {
    let mut pfem = coarse_vortices();
    let told = said(&mut pfem, 0..60);
    let part = pfem.snapshot().ledger.remainder(0.0).unwrap();
    assert!(part > 0.06, "{part}");
    let taken = told.iter().filter(|text| text.contains("errors have taken")).count();
    assert!(taken == 1, "{told:?}");
    let mut saved = Vec::new();
    pfem.columns(&mut |_, column| saved.push(column.data.bytes().to_vec()));
    let (mut resumed, mut next) = (coarse_vortices(), saved.iter());
    resumed.columns(&mut |_, column| assert!(column.data.replace(next.next().unwrap())));
    assert_eq!(resumed.misfit(), None);
    resumed.restored();
    assert_eq!(said(&mut resumed, 60..70), Vec::<String>::new());
    assert!(resumed.snapshot().ledger.remainder(0.0).unwrap() > 0.06, "errors still take as much");
}

/// A block that supports draw through a box of oil at a steady speed, three and a half elements of the mesh thick, off
/// its lines: a fluid that sticks to it loses all of the work of the supports to viscosity, most of it in elements that
/// the block cuts.
#[test]
fn the_work_that_draws_a_solid_through_oil_is_viscous_dissipation() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [16; 2]).unwrap();
    let lower = Vector([0.391, 0.387]);
    let block = SolidMesh::block(lower, lower + Vector::splat(0.22), [4; 2]).unwrap();
    let nodes = (0..block.nodes.len() as u32).collect();
    let held = vec![HeldNodes { nodes, velocity: [Some(1e-3.into()), Some(Signal::ZERO)] }];
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1.0, 1e6, 0.3) });
    let oil = Physics { stabilisation: Stabilisation::Dynamic, ..physics(vec![fluid("oil", 1.0, 1.0)], weightless()) };
    let sets = vec![set(&mesh, "walls", Condition::wall(), |_| true)];
    let mut setup = setup(mesh, sets, oil, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![SolidSetup { held, ..SolidSetup::free("block", block, law) }]).unwrap());
    let mut pfem = Pfem2::new(setup);
    // The flow is steady after some times L²/ν = 1 s.
    let steps = |pfem: &mut Pfem2<2, 3>, range: std::ops::Range<u32>| {
        range.for_each(|k| pfem.step(f64::from(k) * 0.1, 0.1).unwrap());
        ["work of supports", "viscous dissipation", "numerical dissipation"].map(|name| term(pfem, name))
    };
    let before = steps(&mut pfem, 0..20);
    let after = steps(&mut pfem, 20..40);
    let [work, viscous, numerical] = std::array::from_fn(|k| after[k] - before[k]);
    assert!((viscous / work - 1.0).abs() < 0.03, "{viscous} of {work} J, {numerical} J lost to errors");
}

/// A rigid block that is drawn downward through a closed box of oil, off the lines of the mesh: the pressure at rest is
/// linear, as the pressure of the mesh is, so that gravity changes neither the flow nor what errors take. It does the
/// fluid minus the work of Archimedes' force, which the support and gravity on the block have between them.
#[test]
fn gravity_does_not_change_the_numerical_dissipation_beside_a_solid() {
    let drawn = |gravity: f64, surface: SurfaceCondition| -> [f64; 4] {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [16; 2]).unwrap();
        let lower = Vector([0.391, 0.487]);
        let block = SolidMesh::block(lower, lower + Vector::splat(0.22), [4; 2]).unwrap();
        let motion = PrescribedMotion {
            velocity: [Some(0.02.into()), Some((-0.03).into()), None],
            spin: [None, None, Some(Signal::ZERO)],
        };
        let own = SolidSetup::free("block", block, Box::new(Rigid { density: 2.0 }));
        let pull = [Signal::ZERO, gravity.into()];
        let oil = Physics { stabilisation: Stabilisation::Dynamic, ..physics(vec![fluid("oil", 1.0, 0.1)], pull) };
        let sets = vec![set(&mesh, "walls", Condition::wall(), |_| true)];
        let mut setup = setup(mesh, sets, oil, |_| 0, |_| Vector::ZERO);
        setup.solids = Some(Structure::new(vec![SolidSetup { motion, surface, ..own }]).unwrap());
        let mut pfem = Pfem2::new(setup);
        pfem.begin(0.0, 0.1).unwrap();
        let mut steps = |range: std::ops::Range<u32>| {
            range.for_each(|k| pfem.step(f64::from(k) * 0.1, 0.1).unwrap());
            ["numerical dissipation", "work of gravity", "work of gravity on solids", "viscous dissipation"]
                .map(|name| term(&pfem, name))
        };
        // The fluid has no power at the start of the first step.
        let (before, after) = (steps(0..5), steps(5..20));
        std::array::from_fn(|k| after[k] - before[k])
    };
    for surface in [SurfaceCondition::NoSlip, SurfaceCondition::Slip] {
        let ([errors, .., viscous], [own, fluid, solid, own_viscous]) = (drawn(0.0, surface), drawn(-10.0, surface));
        assert!((own_viscous / viscous - 1.0).abs() < 1e-6, "{own_viscous} {viscous}");
        assert!((fluid / solid + 0.5).abs() < 1e-4, "{fluid} of {solid}");
        assert!((own - errors).abs() < 1e-5 * solid, "{own} instead of {errors}, of {solid}");
    }
}
