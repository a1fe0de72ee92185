//! Solids that rest in fluids for a long time.

use super::*;
use crate::linalg::SolverKind;
use crate::material::{Elastic, PointLaw, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// A box half as heavy as water and air together, half in each, in a mesh of the unit square.
fn afloat(mesh: Mesh<2, 3>, height: f64, young: f64, start: InitialState) -> Pfem2<2, 3> {
    let half = Vector([0.2, 0.1]);
    let center = Vector([0.5, height]);
    let own = SolidMesh::block(center - half, center + half, [3, 2]).unwrap();
    let law: Box<dyn PointLaw> = match young == 0.0 {
        true => Box::new(Rigid { density: 500.5 }),
        false => Box::new(StVenantKirchhoff { elastic: Elastic::new(500.5, young, 0.3) }),
    };
    let solid = SolidSetup::free("box", own, law);
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let physics =
        Physics { stabilisation: Stabilisation::Dynamic, ..physics(fluids, [Signal::ZERO, (-GRAVITY).into()]) };
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let mut setup = setup(mesh, sets, physics, |x| u8::from(x[1] > height), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |x| x[1] - height, &mut setup.particles));
    setup.linear = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    setup.solids = Some(Structure::new(vec![solid]).unwrap());
    setup.start = start;
    Pfem2::new(setup)
}

fn middle(pfem: &Pfem2<2, 3>) -> Vector<2> {
    let structure = &pfem.solids.as_ref().unwrap().structure;
    let places = structure.positions(&structure.state.displacement);
    places.iter().copied().sum::<Vector<2>>() / places.len() as f64
}

/// The largest speed of the box, and of all, over √(g H), and its way from where it begins over an element, in a
/// thousand steps.
fn floats(young: f64) -> [f64; 3] {
    let (height, dt, cells) = (0.513, 0.01, 20);
    let size = 1.0 / cells as f64;
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap(), size);
    let start = if young == 0.0 { InitialState::AsGiven } else { InitialState::Equilibrium };
    let mut pfem = afloat(mesh, height, young, start);
    pfem.begin(0.0, dt).unwrap();
    let began = middle(&pfem);
    let [mut drift, mut speed, mut fluid] = [0.0f64; 3];
    for k in 0..1000 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        drift = drift.max((middle(&pfem) - began).norm() / size);
        let structure = &pfem.solids.as_ref().unwrap().structure;
        speed = speed.max((structure.momentum() / structure.mass()).norm() / GRAVITY.sqrt());
        fluid = fluid.max(fastest(&pfem.system.velocity) / GRAVITY.sqrt());
    }
    [speed, fluid, drift]
}

/// A rigid box that floats where Archimedes has it stays there to rounding, off the lines of the mesh.
#[test]
fn a_rigid_box_floats_at_rest_for_a_thousand_steps() {
    let [speed, fluid, drift] = floats(0.0);
    assert!(speed < 1e-12 && fluid < 1e-10 && drift < 1e-10, "{speed:e} {fluid:e} {drift:e}");
}

/// An elastic one that begins in equilibrium, compressed by the water, moves with less than a millionth of √(g H), and
/// goes no farther than a ten-thousandth of an element. (What is left is what the search for the equilibrium leaves;
/// water and air don't damp it. Takes long: a drift shows itself only over a thousand steps.)
#[test]
fn an_elastic_box_floats_at_rest_for_a_thousand_steps() {
    let [speed, fluid, drift] = floats(1e8);
    assert!(speed < 1e-6 && drift < 1e-4, "{speed:e} {fluid:e} {drift:e}");
}

/// A block that stands on the floor beside a fluid, clamped there, compressed by its weight and the pressure at its
/// sides and on it: it begins in equilibrium, and neither it nor the fluid moves.
#[test]
fn a_block_under_its_weight_rests_beside_a_fluid() {
    let (young, density, block_density) = (1e7, 1000.0, 2500.0);
    let [left, right, top] = [0.33, 0.72, 0.64];
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [12; 2]).unwrap(), 1.0 / 12.0);
    let own = SolidMesh::block(Vector([left, 0.0]), Vector([right, top]), [4, 6]).unwrap();
    let nodes = own.nodes.clone();
    let is_foot = |a: usize| nodes[a][1] < 1e-9;
    let feet = (0..nodes.len() as u32).filter(|&a| is_foot(a as usize)).collect();
    let held = vec![HeldNodes { nodes: feet, velocity: [Some(Signal::ZERO), Some(Signal::ZERO)] }];
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(block_density, young, 0.3) });
    let block = SolidSetup { held, ..SolidSetup::free("block", own, law) };
    let physics = physics(vec![fluid("water", density, 1e-3)], [Signal::ZERO, (-GRAVITY).into()]);
    let physics = Physics { stabilisation: Stabilisation::Dynamic, ..physics };
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.linear = SolverOptions { kind: SolverKind::Direct, tolerance: 1e-13, ..SolverOptions::default() };
    setup.solids = Some(Structure::new(vec![block]).unwrap());
    setup.start = InitialState::Equilibrium;
    let mut pfem = Pfem2::new(setup);
    let dt = 0.01;
    pfem.begin(0.0, dt).unwrap();
    let (mut of_fluid, mut of_block) = (0.0f64, 0.0f64);
    for k in 0..20 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        of_fluid = of_fluid.max(fastest(&pfem.system.velocity));
        of_block = of_block.max(fastest(&pfem.solids.as_ref().unwrap().structure.state.velocity));
    }
    let wave = GRAVITY.sqrt();
    assert!(of_fluid < 1e-10 * wave && of_block < 1e-10 * wave, "{of_fluid:e} {of_block:e}");
}

/// The forces of fluids at rest on a rigid block that is held on the floor, off the lines of the mesh, and on the walls
/// [N]; `depth` of the water, under air [m].
fn forces_at_floor_block(depth: f64) -> [Vector<2>; 2] {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [12; 2]).unwrap();
    let own = SolidMesh::block(Vector([0.37, 0.0]), Vector([0.72, 0.64]), [2, 3]).unwrap();
    let nodes = (0..own.nodes.len() as u32).collect();
    let held = vec![HeldNodes { nodes, velocity: [Some(Signal::ZERO), Some(Signal::ZERO)] }];
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(2500.0, 1e9, 0.3) });
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let physics =
        Physics { stabilisation: Stabilisation::ConsistentPspg, ..physics(fluids, [Signal::ZERO, (-GRAVITY).into()]) };
    let mut setup = setup(mesh, Vec::new(), physics, |x| u8::from(x[1] > depth), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |x| x[1] - depth, &mut setup.particles));
    setup.linear = SolverOptions { kind: SolverKind::Direct, tolerance: 1e-13, ..SolverOptions::default() };
    setup.solids = Some(Structure::new(vec![SolidSetup { held, ..SolidSetup::free("block", own, law) }]).unwrap());
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, 0.01).unwrap();
    pfem.step(0.0, 0.01).unwrap();
    assert!(fastest(&pfem.system.velocity) < 1e-10);
    [pfem.solids.as_ref().unwrap().last.forces.last[0], pfem.forces.on_parts.last[0]]
}

/// The floor bears the pressure of the fluid up to the feet of a block: on the block weighs what is above it, on the
/// floor what is above the rest, and nothing pushes the block aside; in deep water, and where water and air meet in the
/// elements at its feet.
#[test]
fn the_floor_bears_the_pressure_at_the_feet_of_a_block() {
    for depth in [0.8, 0.03] {
        let pressure = |y: f64| GRAVITY * (1000.0 * (depth - y).max(0.0) + (1.0 - depth.max(y)));
        let [on_block, on_walls] = forces_at_floor_block(depth);
        // The level of the water is that of its volume in triangles.
        let near = 1e-6 * pressure(0.0);
        let block = (on_block + Vector([0.0, 0.35 * pressure(0.64)])).norm();
        // Enriched pressures beside the feet are left out of the force on walls.
        let floor = (on_walls + Vector([0.0, 0.65 * pressure(0.0)])).norm();
        assert!(block < near, "{depth}: {on_block:?} {}", pressure(0.64));
        assert!(floor < if depth < 0.1 { 100.0 } else { 1.0 } * near, "{depth}: {on_walls:?} {}", pressure(0.0));
    }
}

/// Water, oil and air in layers, with or without a block that is held in all three: the largest speed over so many
/// steps over √(g H).
fn stirred_layers(block: bool, steps: u32) -> f64 {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [16; 2]).unwrap();
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("oil", 900.0, 0.1), fluid("air", 1.0, 1e-5)];
    let physics =
        Physics { stabilisation: Stabilisation::ConsistentPspg, ..physics(fluids, [Signal::ZERO, (-GRAVITY).into()]) };
    let at = |x: Vector<2>| match () {
        () if x[1] > 0.6 => 2,
        () => u8::from(x[1] > 0.35),
    };
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let mut setup = setup(mesh, sets, physics, at, |_| Vector::ZERO);
    if block {
        let own = SolidMesh::block(Vector([0.37, 0.21]), Vector([0.66, 0.77]), [2, 4]).unwrap();
        let nodes = (0..own.nodes.len() as u32).collect();
        let held = vec![HeldNodes { nodes, velocity: [Some(Signal::ZERO), Some(Signal::ZERO)] }];
        let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(2000.0, 1e8, 0.3) });
        setup.solids = Some(Structure::new(vec![SolidSetup { held, ..SolidSetup::free("block", own, law) }]).unwrap());
    }
    let mut pfem = Pfem2::new(setup);
    let dt = 0.01;
    pfem.begin(0.0, dt).unwrap();
    let start = pfem.system.contents.volumes.clone();
    let mut most = 0.0f64;
    for k in 0..steps {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        most = most.max(fastest(&pfem.system.velocity));
        assert!(
            pfem.system.contents.volumes.iter().zip(&start).all(|(now, start)| (now / start - 1.0).abs() < 1e-12),
            "{k}"
        );
    }
    most / GRAVITY.sqrt()
}

/// Water, oil and air in layers hold still to what the line between them is noisy by, beside a block that is held in
/// all three as without it; none gains or loses volume.
#[test]
fn three_layers_rest_beside_a_block_as_without_it() {
    let [without, with] = [false, true].map(|block| stirred_layers(block, 60));
    assert!(with < 1.5 * without && with < 0.05, "{without:e} {with:e}");
}
