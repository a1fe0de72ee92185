//! Elastic solids in fluids against closed forms.

use super::*;
use crate::material::{Elastic, Prestressed, StVenantKirchhoff};
use crate::math::SymTensor;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, Inertia, SolidSetup, SurfaceCondition, SurfaceTraction};
use crate::pfem2::solid::step_results::SolidStep;
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;
use std::f64::consts::PI;

/// A solid of density 1000 kg/m³ with this modulus [Pa] and Poisson's ratio; `held` tells which axes of a node are
/// held.
pub fn solid(
    mesh: SolidMesh<2>,
    (young, poisson): (f64, f64),
    held: impl Fn(Vector<2>) -> [bool; 2],
    velocity: impl Fn(Vector<2>) -> Vector<2>,
) -> SolidSetup<2> {
    let along = |axis: usize| HeldNodes {
        nodes: (0..mesh.nodes.len() as u32).filter(|&a| held(mesh.nodes[a as usize])[axis]).collect(),
        velocity: std::array::from_fn(|k| (k == axis).then_some(Signal::ZERO)),
    };
    let velocity = mesh.nodes.iter().map(|&x| velocity(x)).collect();
    let held = vec![along(0), along(1)];
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, young, poisson) });
    SolidSetup { velocity, held, ..SolidSetup::free("solid", mesh, law) }
}

/// Water with solids in it, with the stabilisation that cases with solids have.
pub fn water(gravity: [Signal; 2]) -> Physics<2> {
    Physics { stabilisation: Stabilisation::Dynamic, ..physics(vec![fluid("water", 1000.0, 1e-3)], gravity) }
}

/// Length of the bar, of the channel, and width of both [m].
const BAR: [f64; 3] = [0.1, 0.3, 0.05];

/// A bar that is clamped at x = 0 pushes the water of a channel: `cells` elements over its width. The water is a mass
/// at the end of the bar, whose first motion is u = sin(β x/l) sin ωt.
pub fn bar(cells: usize, speed: f64) -> Pfem2<2, 3> {
    let [length, channel, width] = BAR;
    let counts = [cells * 6, cells];
    let mesh =
        shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([channel, width]), counts).unwrap(), width / cells as f64);
    let sides = |y: f64| y < 1e-9 || y > width - 1e-9;
    let sets = vec![
        set(&mesh, "end", Condition::Outlet, |x| x[0] > channel - 1e-9),
        set(&mesh, "start", Condition::wall(), |x| x[0] < 1e-9),
        set(&mesh, "sides", Condition::Slip, |x| sides(x[1])),
    ];
    let blocks = SolidMesh::block(Vector::ZERO, Vector([length, width]), [3, 1]).unwrap();
    let held = |x: Vector<2>| [x[0] < 1e-9, x[0] < 1e-9 || sides(x[1])];
    let start = |x: Vector<2>| Vector([speed * (beta() * x[0] / length).sin() / beta().sin(), 0.0]);
    let bar = solid(blocks, (1e6, 0.0), held, start);
    // The water is as fast as the end of the bar: no impact at the start.
    let mut setup = setup(mesh, sets, water(weightless()), |_| 0, |_| Vector([speed, 0.0]));
    setup.solids = Some(Structure::new(vec![bar]).unwrap());
    Pfem2::new(setup)
}

/// β tan β = mass of the bar over that of the water: the first motion of a bar with a mass at its end.
fn beta() -> f64 {
    let ratio = BAR[0] / (BAR[1] - BAR[0]);
    (0..100).fold(0.6, |b: f64, _| b - (b * b.tan() - ratio) / (b.tan() + b / b.cos().powi(2)))
}

/// Displacement of the end of the bar [m] after each step.
fn ends(pfem: &mut Pfem2<2, 3>, dt: f64, steps: usize) -> Vec<f64> {
    let tip = |pfem: &Pfem2<2, 3>| {
        let structure = &pfem.solids.as_ref().unwrap().structure;
        let end = structure.setups()[0].mesh.nodes.iter().position(|x| (x[0] - BAR[0]).abs() < 1e-9).unwrap();
        structure.state.displacement[end][0]
    };
    let end = |k: usize| {
        pfem.step(k as f64 * dt, dt).unwrap();
        tip(pfem)
    };
    (0..steps).map(end).collect()
}

/// The frequency of the bar with the water at its end is within 1 % of the exact one at 40 steps per period, and
/// nothing is lost to the coupling: the second swing is 98 % of the first, the ledger closes.
#[test]
fn a_bar_that_pushes_a_column_of_water_has_the_frequency_of_a_bar_with_a_mass() {
    let omega = beta() * (1e6_f64 / 1000.0).sqrt() / BAR[0];
    let (period, speed) = (2.0 * PI / omega, 0.01);
    let dt = period / 40.0;
    let mut pfem = bar(4, speed);
    let x = ends(&mut pfem, dt, 84);
    let zero = |from: usize| {
        let k = (from..x.len() - 1).find(|&k| x[k] * x[k + 1] <= 0.0).unwrap();
        (k as f64 + 1.0 + x[k] / (x[k] - x[k + 1])) * dt
    };
    let measured = zero(50) - zero(10);
    assert!((measured / period - 1.0).abs() < 0.01, "{measured} {period}");
    let largest = |range: std::ops::Range<usize>| x[range].iter().copied().fold(0.0, |most: f64, u| most.max(u.abs()));
    let (first, last) = (largest(0..20), largest(60..80));
    assert!((first / (speed / omega) - 1.0).abs() < 0.03, "{first} {}", speed / omega);
    assert!((0.98..1.0).contains(&(last / first)), "{last} {first}");
    let gained = pfem.balance.gained(&pfem.system);
    let energy = pfem.balance.solids.unwrap().stored + pfem.balance.ledger.stored;
    assert!(gained < 1e-3 * energy && gained > -0.05 * energy, "{gained} {energy}");
}

/// A solid as heavy as the water around it, under gravity: the water carries its weight, but for the corners that
/// the cut rounds off.
#[test]
fn a_solid_as_heavy_as_the_water_hovers() {
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [24, 24]).unwrap(), 1.0 / 24.0);
    let block = SolidMesh::block(Vector([0.33, 0.41]), Vector([0.71, 0.64]), [3, 2]).unwrap();
    let solid = solid(block, (1e9, 0.3), |_| [false; 2], |_| Vector::ZERO);
    let mut setup = setup(mesh, Vec::new(), water([Signal::ZERO, (-9.81).into()]), |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![solid]).unwrap());
    let mut pfem = Pfem2::new(setup);
    for k in 0..20 {
        pfem.step(0.01 * f64::from(k), 0.01).unwrap();
    }
    let (volume, weight) = (0.38 * 0.23, 9.81 * 1000.0 * 0.38 * 0.23);
    let force = pfem.solids.as_ref().unwrap().last.forces.last[0];
    assert!((force[1] / weight - 1.0).abs() < 0.01 && force[0].abs() < 0.01 * weight, "{force:?} {weight}");
    let cut = pfem.system.immersed.as_ref().unwrap().cut.volume_inside(&pfem.system.mesh);
    assert!((cut / volume - 1.0).abs() < 0.01, "{cut} {volume}");
    // It sinks by the buoyancy that the corners lack.
    let fall = 9.81 * 0.2 * (1.0 - cut / volume).abs();
    assert!(fastest(&pfem.system.velocity) < 2.0 * fall, "{} {fall}", fastest(&pfem.system.velocity));
}

/// A block under tension between held ends, in water that nothing moves: it stays at rest, and so does the water, to
/// rounding of the stress over the density. Without its ends it would spring back by a tenth of its length.
#[test]
fn a_block_under_tension_between_held_ends_leaves_water_at_rest() {
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [10, 10]).unwrap(), 0.1);
    let block = SolidMesh::block(Vector([0.33, 0.41]), Vector([0.71, 0.64]), [3, 2]).unwrap();
    let ends = |x: Vector<2>| x[0] < 0.33 + 1e-9 || x[0] > 0.71 - 1e-9;
    let mut solid = solid(block, (1e6, 0.0), |x| [ends(x); 2], |_| Vector::ZERO);
    let law = StVenantKirchhoff { elastic: Elastic::new(1000.0, 1e6, 0.0) };
    solid.law = Box::new(Prestressed::new(Box::new(law), SymTensor([1e5, 0.0, 0.0, 0.0, 0.0, 0.0])).unwrap());
    let mut setup = setup(mesh, Vec::new(), water(weightless()), |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![solid]).unwrap());
    let mut pfem = Pfem2::new(setup);
    for k in 0..10 {
        pfem.step(0.01 * f64::from(k), 0.01).unwrap();
    }
    // Of √(g H) with 10 m/s² and the height of the box.
    let wave = 10.0f64.sqrt();
    let solids = pfem.solids.as_ref().unwrap();
    let (fluid, solid) = (fastest(&pfem.system.velocity), fastest(&solids.structure.state.velocity));
    assert!(fluid < 1e-10 * wave && solid < 1e-10 * wave, "{fluid:e} {solid:e}");
}

/// Elements along a side of the box of the contact tests, and the gap that solids keep from its walls [m].
pub const CELLS: usize = 16;
pub const GAP: f64 = 0.5 / CELLS as f64;

/// A block between two corners in a box of side 1 full of a gas a thousand times lighter, with this gravity [m/s²] and
/// speed [m/s].
fn in_gas(
    corners: [[f64; 2]; 2],
    counts: [usize; 2],
    young: f64,
    friction: f64,
    gravity: [f64; 2],
    speed: [f64; 2],
) -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap();
    let block = SolidMesh::block(Vector(corners[0]), Vector(corners[1]), counts).unwrap();
    let mut block = solid(block, (young, 0.0), |_| [false; 2], |_| Vector(speed));
    block.friction = friction;
    let gas = Physics {
        stabilisation: Stabilisation::Dynamic,
        ..physics(vec![fluid("gas", 1.0, 1e-5)], gravity.map(Signal::from))
    };
    let mut setup = setup(mesh, Vec::new(), gas, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![block]).unwrap());
    Pfem2::new(setup)
}

/// Place of the centre of the solid [m], its velocity [m/s], and the force of the walls on it [N].
fn centre(pfem: &Pfem2<2, 3>) -> (Vector<2>, Vector<2>, f64) {
    let solids = pfem.solids.as_ref().unwrap();
    let structure = &solids.structure;
    let places = structure.positions(&structure.state.displacement);
    let middle = places.iter().copied().sum::<Vector<2>>() / places.len() as f64;
    (
        middle,
        structure.momentum() / structure.mass(),
        solids.last.contact_forces.walls.iter().map(|force| force.norm()).sum(),
    )
}

/// A block that falls on the floor comes to rest half an element above it, and the floor bears its weight.
#[test]
fn a_block_that_falls_rests_half_an_element_above_the_floor() {
    let mut pfem = in_gas([[0.33, 0.1], [0.63, 0.3]], [3, 2], 1e7, 0.0, [0.0, -9.81], [0.0; 2]);
    let mut force = 0.0;
    for k in 0..160 {
        pfem.step(0.005 * f64::from(k), 0.005).unwrap();
        force += if k >= 120 { centre(&pfem).2 / 40.0 } else { 0.0 };
    }
    let weight = 9.81 * 1000.0 * 0.3 * 0.2;
    let (place, velocity, _) = centre(&pfem);
    assert!((force / weight - 1.0).abs() < 0.01, "{force} {weight}");
    assert!((place[1] - 0.1 - GAP).abs() < 0.02 * GAP && velocity.norm() < 1e-3, "{place:?} {velocity:?}");
}

/// A bar that meets a wall with its end comes back after two transits of its wave, as fast as it came (St. Venant), and
/// the contact gives back what it took. The gas glides along the wall: between a bar and a wall at which it sticks no
/// node is free to let it out.
#[test]
fn a_bar_bounces_off_a_wall_with_its_speed() {
    let (length, young, speed) = (0.3, 1e6, 0.5);
    let transit = length / (young / 1000.0_f64).sqrt();
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap();
    let start = GAP + 0.01;
    let bar = SolidMesh::block(Vector([start, 0.4]), Vector([start + length, 0.6]), [12, 2]).unwrap();
    let gas = Physics { fluids: vec![fluid("gas", 1.0, 1e-5)], ..water(weightless()) };
    let walls = vec![set(&mesh, "walls", Condition::Slip, |_| true)];
    let mut setup = setup(mesh, walls, gas, |_| 0, |_| Vector::ZERO);
    let bar = solid(bar, (young, 0.0), |_| [false; 2], |_| Vector([-speed, 0.0]));
    setup.solids = Some(Structure::new(vec![bar]).unwrap());
    let mut pfem = Pfem2::new(setup);
    let dt = transit / 40.0;
    let steps = ((0.01 / speed + 4.0 * transit) / dt) as usize;
    let touching = (0..steps).filter(|&k| {
        pfem.step(k as f64 * dt, dt).unwrap();
        centre(&pfem).2 > 0.0
    });
    let contact = touching.count() as f64 * dt;
    let (_, velocity, _) = centre(&pfem);
    assert!((contact / (2.0 * transit) - 1.0).abs() < 0.1, "{contact} {transit}");
    assert!((0.95..1.0).contains(&(velocity[0] / speed)), "{velocity:?}");
    let terms = pfem.balance.solids.unwrap().terms();
    let work = terms.iter().find(|term| term.name == "work of supports").unwrap().value;
    let energy = 0.5 * 1000.0 * length * 0.2 * speed * speed;
    assert!(work.abs() < 0.01 * energy, "{work} {energy}");
}

/// On an incline a block slides if and only if tan θ > μ, then with g (sin θ − μ cos θ).
#[test]
fn a_block_slides_on_an_incline_only_if_it_is_steeper_than_the_friction() {
    let friction = 0.3;
    let way = |slope: f64| {
        let (sin, cos) = slope.atan().sin_cos();
        let gravity = [9.81 * sin, -9.81 * cos];
        let mut pfem = in_gas([[0.2, GAP], [0.5, GAP + 0.15]], [3, 2], 1e7, friction, gravity, [0.0; 2]);
        let start = centre(&pfem).0;
        let (dt, steps) = (0.004, 60);
        (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
        let time = dt * f64::from(steps);
        ((centre(&pfem).0 - start)[0], 0.5 * 9.81 * (sin - friction * cos).max(0.0) * time * time)
    };
    let (rest, _) = way(0.25);
    assert!(rest.abs() < 0.02 * GAP, "{rest}");
    let (slid, expected) = way(0.6);
    assert!((slid / expected - 1.0).abs() < 0.05, "{slid} {expected}");
}

/// A slab that moves along its plane top under a viscous fluid at rest: where the fluid glides it stays at rest, where
/// it sticks it is dragged along.
#[test]
fn a_fluid_that_glides_is_not_dragged_along() {
    let speed = 0.1;
    let dragged = |surface: SurfaceCondition| {
        let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 0.5]), [16, 8]).unwrap(), 1.0 / 16.0);
        let block = SolidMesh::block(Vector([-0.2, -0.1]), Vector([1.2, 0.21]), [7, 2]).unwrap();
        let mut slab = solid(block, (1e6, 0.3), |_| [true; 2], |_| Vector([speed, 0.0]));
        slab.held[0].velocity[0] = Some(speed.into());
        slab.surface = surface;
        let oil = Physics {
            stabilisation: Stabilisation::Dynamic,
            ..physics(vec![fluid("oil", 1000.0, 10.0)], weightless())
        };
        let mut setup = setup(mesh, Vec::new(), oil, |_| 0, |_| Vector::ZERO);
        setup.solids = Some(Structure::new(vec![slab]).unwrap());
        let mut pfem = Pfem2::new(setup);
        (0..5).for_each(|k| pfem.step(0.01 * f64::from(k), 0.01).unwrap());
        let cut = &pfem.system.immersed.as_ref().unwrap().cut;
        let outside = |i: &usize| cut.distance[*i] > 0.0;
        (0..cut.distance.len()).filter(outside).map(|i| pfem.system.velocity[i].norm()).fold(0.0, f64::max)
    };
    let (glides, sticks) = (dragged(SurfaceCondition::Slip), dragged(SurfaceCondition::NoSlip));
    assert!(glides < 1e-9 * speed, "{glides}");
    assert!(sticks > 0.1 * speed, "{sticks}");
}

/// A bar of length l = 0.5 m that hangs from the top of a box of water: it begins at rest, with the end at u = (ρ/2 −
/// ρ_f) g l²/E, where the pressure counts from the top; and stays there.
#[test]
fn a_hanging_bar_begins_at_rest_with_its_weight_and_the_pressure_below() {
    let (length, young, density) = (0.5, 1e6, 200.0);
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [16, 16]).unwrap(), 1.0 / 16.0);
    let block = SolidMesh::block(Vector([0.41, 1.0 - length]), Vector([0.62, 1.0]), [2, 4]).unwrap();
    let bar = solid(block, (young, 0.0), |x| [x[1] > 1.0 - 1e-9; 2], |_| Vector::ZERO);
    let mut physics = water([Signal::ZERO, (-9.81).into()]);
    physics.fluids = vec![fluid("fluid", density, 1e-3)];
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![bar]).unwrap());
    setup.start = InitialState::Equilibrium;
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, 1e-3).unwrap();
    let end = |pfem: &Pfem2<2, 3>| {
        let structure = &pfem.solids.as_ref().unwrap().structure;
        let lowest = structure.setups()[0].mesh.nodes.iter().position(|x| x[1] < 1.0 - length + 1e-9).unwrap();
        structure.state.displacement[lowest][1]
    };
    let expected = -(1000.0 / 2.0 - density) * 9.81 * length * length / young;
    let found = end(&pfem);
    assert!((found / expected - 1.0).abs() < 0.02, "{found:e} {expected:e}");
    (0..10).for_each(|k| pfem.step(1e-3 * f64::from(k), 1e-3).unwrap());
    assert!((end(&pfem) - found).abs() < 1e-5 * found.abs(), "{:e} {found:e}", end(&pfem));
    assert!(pfem.solids.as_ref().unwrap().last.energies.kinetic < 1e-9 * expected.abs() * 9.81 * 100.0);
}

/// A traction that grows on the end of a bar without inertia, in a gas: at every time u = σ l/E, however fast it grows.
#[test]
fn a_bar_without_inertia_follows_its_load() {
    let (length, young) = (0.5, 1e5);
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [12, 12]).unwrap(), 1.0 / 12.0);
    let block = SolidMesh::block(Vector([0.0, 0.41]), Vector([length, 0.62]), [3, 2]).unwrap();
    let at_end =
        |facet: &u32| block.facets[*facet as usize].nodes.iter().all(|&a| block.nodes[a as usize][0] == length);
    let facets = (0..block.facets.len() as u32).filter(at_end).collect();
    let load = SurfaceTraction { facets, traction: [formula("100*sin(20*t)"), Signal::ZERO] };
    let bar = solid(block.clone(), (young, 0.0), |x| [x[0] < 1e-9; 2], |_| Vector::ZERO);
    let bar = SolidSetup { inertia: Inertia::QuasiStatic, tractions: vec![load], ..bar };
    let mut physics = water(weightless());
    physics.fluids = vec![fluid("gas", 1e-4, 1e-8)];
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![bar]).unwrap());
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, 0.01).unwrap();
    for k in 1..=20 {
        let t = 0.01 * f64::from(k);
        pfem.step(t - 0.01, 0.01).unwrap();
        let solids = pfem.solids.as_ref().unwrap();
        let end = block.nodes.iter().position(|x| x[0] == length).unwrap();
        let (found, expected) =
            (solids.structure.state.displacement[end][0], 100.0 * (20.0 * t).sin() * length / young);
        assert!((found - expected).abs() < 2e-3 * 100.0 * length / young, "{t}: {found:e} {expected:e}");
        assert!(solids.last.imbalance < 1e-3, "{:e}", solids.last.imbalance);
        assert_eq!(solids.last.energies.kinetic, 0.0);
    }
}

/// A beam without inertia under a force that comes at once on its end, in a gas: after the one step its end is where
/// Bisshopp & Drucker (1945) have that of the elastica with P l²/(E I) = 1, to 0.3 %. Equations that are linear about
/// the straight beam would bend it by a tenth more, and not shorten it.
#[test]
fn a_beam_bends_in_one_step_as_the_elastica() {
    let (length, thickness, young) = (0.6, 0.03, 1e6);
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [20, 20]).unwrap(), 0.05);
    let beam = SolidMesh::block(Vector([0.0, 0.31]), Vector([length, 0.31 + thickness]), [12, 1]).unwrap();
    let at_end = |facet: &u32| beam.facets[*facet as usize].nodes.iter().all(|&a| beam.nodes[a as usize][0] == length);
    let facets = (0..beam.facets.len() as u32).filter(at_end).collect();
    let traction = young * thickness.powi(2) / 12.0 / length.powi(2);
    let load = SurfaceTraction { facets, traction: [Signal::ZERO, traction.into()] };
    let setup_of_beam = solid(beam.clone(), (young, 0.0), |x| [x[0] < 1e-9; 2], |_| Vector::ZERO);
    let setup_of_beam = SolidSetup { inertia: Inertia::QuasiStatic, tractions: vec![load], ..setup_of_beam };
    let mut physics = water(weightless());
    physics.fluids = vec![fluid("gas", 1e-6, 1e-8)];
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![setup_of_beam]).unwrap());
    let mut pfem = Pfem2::new(setup);
    pfem.step(0.0, 0.01).unwrap();
    let solids = pfem.solids.as_ref().unwrap();
    let middle = Vector([length, 0.31 + 0.5 * thickness]);
    let end = beam.nodes.iter().position(|x| (*x - middle).norm() < 1e-9).unwrap();
    let way = solids.structure.state.displacement[end];
    let elastica = Vector([0.94357 - 1.0, 0.30172]) * length;
    assert!((way - elastica).norm() < 3e-3 * elastica.norm(), "{way:?} {elastica:?}");
    let SolidStep { imbalance, last_correction, .. } = solids.last;
    assert!(imbalance < 1e-3 && last_correction == 0.0, "{imbalance:e} {last_correction}");
}

/// An even pressure all around compresses a soft block evenly, to the closed form, although its nodes lie three times
/// closer than those of the mesh: E_11 = −p/(2 (λ + μ)) in the plane. Moved by an even pressure alone, the block keeps
/// its shape in a step, too.
#[test]
fn an_even_pressure_of_the_fluid_compresses_a_soft_block_evenly() {
    let (young, poisson, pressure) = (1e4, 0.3, 1e3);
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [10, 10]).unwrap(), 0.1);
    let blocks = SolidMesh::block(Vector([0.33, 0.41]), Vector([0.71, 0.64]), [6, 4]).unwrap();
    let center = Vector([0.52, 0.525]);
    let soft =
        solid(blocks.clone(), (young, poisson), |x| [0, 1].map(|k| (x[k] - center[k]).abs() < 1e-9), |_| Vector::ZERO);
    let side = set(&mesh, "side", Condition::Traction([(-pressure).into(), Signal::ZERO]), |x| x[0] > 1.0 - 1e-9);
    let mut setup = setup(mesh, vec![side], water(weightless()), |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![soft]).unwrap());
    setup.start = InitialState::Equilibrium;
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, 1e-3).unwrap();
    let [lambda, mu] = [young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 + 2.0 * poisson)];
    let stretch = (1.0 - pressure / (lambda + mu)).sqrt();
    let off = |pfem: &Pfem2<2, 3>| {
        let moved = &pfem.solids.as_ref().unwrap().structure.state.displacement;
        let error = |(x, u): (&Vector<2>, &Vector<2>)| (*u - (*x - center) * (stretch - 1.0)).norm();
        blocks.nodes.iter().zip(moved).map(error).fold(0.0, f64::max)
    };
    let most = 0.222 * (1.0 - stretch);
    assert!(off(&pfem) < 1e-3 * most, "{:e} {most:e}", off(&pfem));
    (0..20).for_each(|k| pfem.step(0.01 * f64::from(k), 0.01).unwrap());
    assert!(off(&pfem) < 1e-3 * most, "{:e} {most:e}", off(&pfem));
}

/// Forces of an even pressure on the nodes of a block of `parts` elements in a shaken mesh of ten cells along a side,
/// less ∫ N_a n dA by Simpson's rule on its sides, over the largest of these; in space for nodes that are near to fewer
/// sides at once than `sides`.
fn error_of_an_even_pressure<const D: usize, const N: usize>(
    [lower, upper]: [Vector<D>; 2],
    parts: [usize; D],
    law: Box<dyn crate::material::PointLaw>,
    sides: usize,
) -> f64 {
    let mesh = shaken(&Mesh::<D, N>::block(Vector::ZERO, Vector::splat(1.0), [10; D]).unwrap(), 0.1);
    let block = SolidMesh::block(lower, upper, parts).unwrap();
    let nodes = block.nodes.clone();
    let physics =
        Physics { stabilisation: Stabilisation::Dynamic, ..physics(vec![fluid("water", 1000.0, 1e-3)], weightless()) };
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![SolidSetup::free("solid", block, law)]).unwrap());
    let mut pfem = Pfem2::new(setup);
    pfem.step(0.0, 0.01).unwrap();
    let mut push = vec![Vector::<D>::ZERO; nodes.len()];
    for element in &pfem.system.immersed.as_ref().unwrap().elements {
        for (rows, &a) in element.to_solid.iter().zip(&element.solid) {
            push[a as usize] += Vector::from_fn(|r| rows.iter().map(|row| row[r][D]).sum());
        }
    }
    let size = |k: usize| (upper[k] - lower[k]) / parts[k] as f64;
    let weight = |x: f64, k: usize| {
        let n = ((x - lower[k]) / size(k) * 2.0).round() as usize;
        size(k) / 6.0 * if n % 2 == 1 { 4.0 } else { 2.0 - f64::from(u8::from(n == 0 || n == 2 * parts[k])) }
    };
    let exact = |x: &Vector<D>| {
        Vector::<D>::from_fn(|axis| {
            let side =
                f64::from(u8::from(x[axis] > upper[axis] - 1e-9)) - f64::from(u8::from(x[axis] < lower[axis] + 1e-9));
            side * (0..D).filter(|k| *k != axis).map(|k| weight(x[k], k)).product::<f64>()
        })
    };
    let most = nodes.iter().map(|x| exact(x).norm()).fold(0.0, f64::max);
    // In space the mesh cuts corners off, and what is up to an element and a half beside them.
    let near = |x: &Vector<D>, k: usize| x[k] > upper[k] - 0.15 || x[k] < lower[k] + 0.15;
    let counts = |x: &Vector<D>| D == 2 || (0..D).filter(|&k| near(x, k)).count() < sides;
    let all = nodes.iter().zip(&push).filter(|(x, _)| counts(x));
    all.map(|(x, push)| (exact(x) - *push).norm()).fold(0.0, f64::max) / most
}

/// An even pressure acts on each node of a solid with ∫ N_a n dA, whatever lies closer, its nodes or those of the mesh:
/// to rounding in the plane, and in space to 4 % of the largest away from edges and 10 % at edges away from corners,
/// since triangles between cut points aren't divided along the sides of facets. From cut points alone it would be off
/// by three times that part.
#[test]
fn an_even_pressure_pushes_each_node_with_its_part_of_the_surface() {
    let law = || Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, 1e6, 0.3) });
    let corners = [Vector([0.33, 0.41]), Vector([0.71, 0.64])];
    for counts in [[1, 1], [3, 2], [8, 5]] {
        let error = error_of_an_even_pressure::<2, 3>(corners, counts, law(), 3);
        assert!(error < 1e-12, "{counts:?}: {error:e}");
    }
    let corners = [Vector([0.33, 0.41, 0.22]), Vector([0.71, 0.64, 0.57])];
    let [edges, inside] = [3, 2].map(|sides| error_of_an_even_pressure::<3, 4>(corners, [5, 4, 5], law(), sides));
    assert!(edges < 0.1 && inside < 0.04, "{edges:e} {inside:e}");
}
