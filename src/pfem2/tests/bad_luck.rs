//! Surfaces in places where a cut can go wrong, and solids that go where they can't: they work as in other places, or
//! the run stops with a reason and a place.

use super::solids::{solid, water};
use super::*;
use crate::error::Place;
use crate::material::Rigid;
use crate::pfem2::Pfem2;
use crate::pfem2::element::Stabilisation;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, PrescribedMotion, SolidSetup, SurfaceCondition};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// Elements along a side of the box of side 1, and their size [m].
const CELLS: usize = 16;
const SIZE: f64 = 1.0 / CELLS as f64;

/// Water, and air above a height [m], in a box of squares that are halved along their diagonals, with solids.
fn tank(height: Option<f64>, solids: Vec<SolidSetup<2>>) -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap();
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let mut physics = water([Signal::ZERO, (-GRAVITY).into()]);
    if height.is_some() {
        physics.fluids.push(fluid("air", 1.0, 1e-5));
    }
    let level = height.unwrap_or(f64::INFINITY);
    let mut setup = setup(mesh, sets, physics, |x| u8::from(x[1] > level), |_| Vector::ZERO);
    if height.is_some() {
        setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |x| x[1] - level, &mut setup.particles));
    }
    setup.linear = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    setup.solids = Some(Structure::new(solids).unwrap());
    Pfem2::new(setup)
}

fn block(corners: [[f64; 2]; 2]) -> SolidMesh<2> {
    SolidMesh::block(Vector(corners[0]), Vector(corners[1]), [3, 2]).unwrap()
}

/// A square with its corners in the middle of its sides, at these half diagonals [m] about a place.
fn tilted(half: f64, middle: Vector<2>) -> SolidMesh<2> {
    let mut mesh = SolidMesh::block(Vector::splat(-0.5), Vector::splat(0.5), [2, 2]).unwrap();
    mesh.nodes.iter_mut().for_each(|x| *x = Vector([x[0] - x[1], x[0] + x[1]]) * half + middle);
    mesh
}

fn held(mesh: SolidMesh<2>) -> SolidSetup<2> {
    solid(mesh, (1e8, 0.3), |_| [true; 2], |_| Vector::ZERO)
}

fn moved(mut mesh: SolidMesh<2>, by: Vector<2>) -> SolidMesh<2> {
    mesh.nodes.iter_mut().for_each(|x| *x += by);
    mesh
}

/// A state after some steps of 0.01 s from rest.
struct Rest {
    /// The largest speed of the fluid, over that of free fall.
    speed: f64,
    /// Forces on the solids [N].
    forces: Vec<Vector<2>>,
    /// Area of the solids as the mesh shows it [m²].
    shown: f64,
    notices: Vec<String>,
}

fn rest(mut pfem: Pfem2<2, 3>) -> Rest {
    let (dt, steps) = (0.01, 3);
    (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
    let speed = fastest(&pfem.system.velocity) / (GRAVITY * dt * f64::from(steps));
    let shown = pfem.system.immersed.as_ref().unwrap().cut.volume_inside(&pfem.system.mesh);
    let notices = pfem.notices();
    Rest { speed, forces: pfem.solids.unwrap().last.forces.last, shown, notices }
}

/// Sides along edges of the mesh, through its nodes along and across its diagonals, and parts of an element beside them
/// from a millionth to rounding: water stays at rest to rounding and carries the weight of what the mesh shows
/// of the solid, to rounding. That is the solid itself but for 0.001 of an element along its sides, and but for corners
/// on edges of the mesh or next to them, which may be cut off: half a square at most.
#[test]
fn water_rests_at_surfaces_on_nodes_and_edges_of_the_mesh_and_slivers_beside_them() {
    let along = block([[4.0 * SIZE, 4.0 * SIZE], [8.0 * SIZE, 10.0 * SIZE]]);
    let across = tilted(3.0 * SIZE, Vector([7.0 * SIZE, 6.0 * SIZE]));
    let half = tilted(3.5 * SIZE, Vector([7.5 * SIZE, 6.0 * SIZE]));
    for (shape, squares) in [(along, 24.0), (across, 18.0), (half, 24.5)] {
        for shift in [[0.0, 0.0], [1e-6, 1e-6], [-1e-6, 1e-6], [1e-9, -1e-9], [1e-14, 0.0], [0.0, -1e-6], [0.3, 0.3]] {
            let rest = rest(tank(None, vec![held(moved(shape.clone(), Vector(shift) * SIZE))]));
            assert!(rest.speed < 1e-10, "{shift:?}: {:e}", rest.speed);
            let weight = GRAVITY * 1000.0 * rest.shown;
            let off = (rest.forces[0] - Vector([0.0, weight])).norm() / weight;
            assert!(off < 1e-10, "{shift:?} {squares}: {off:e}");
            let lost = squares - rest.shown / (SIZE * SIZE);
            assert!(lost.abs() < 0.5 + 0.001 * 20.0, "{shift:?} {squares}: {lost}");
        }
    }
}

/// The same where the water glides, with corners of the solid on nodes and edges of the mesh, beside them, and inside
/// of elements: where corners are kept as they are it rests to rounding; where one is cut off, on an edge, to less than
/// a thousandth of free fall.
#[test]
fn water_that_glides_rests_at_corners_on_nodes_and_edges_of_the_mesh() {
    let along = block([[4.0 * SIZE, 4.0 * SIZE], [8.0 * SIZE, 10.0 * SIZE]]);
    let across = tilted(3.0 * SIZE, Vector([7.0 * SIZE, 6.0 * SIZE]));
    let shifts = [
        [0.0, 0.0],
        [1e-6, 1e-6],
        [-1e-6, 1e-6],
        [1e-9, -1e-9],
        [0.0, -1e-3],
        [5e-3, 5e-3],
        [0.3, 0.0],
        [0.3, 0.3],
        [0.6, 0.2],
        [0.2, 0.6],
        [0.999, 0.4],
        [0.99999, 0.4],
        [0.05, 0.04],
    ];
    let kept = [("along", [0.6, 0.2]), ("along", [0.05, 0.04]), ("across", [0.6, 0.2]), ("across", [0.2, 0.6])];
    for (name, shape) in [("along", along), ("across", across)] {
        for shift in shifts {
            let moved = moved(shape.clone(), Vector(shift) * SIZE);
            let solid = SolidSetup { surface: SurfaceCondition::Slip, ..held(moved) };
            let speed = rest(tank(None, vec![solid])).speed;
            let bound = if kept.contains(&(name, shift)) { 1e-10 } else { 5e-4 };
            assert!(speed < bound, "{name} {shift:?}: {speed:e}");
        }
    }
}

/// Water in a box of side 1, with a rigid block in space that is held.
fn tank_in_space(block: SolidMesh<3>, surface: SurfaceCondition) -> Pfem2<3, 4> {
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [10; 3]).unwrap();
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let gravity = [Signal::ZERO, Signal::ZERO, (-GRAVITY).into()];
    let water = physics(vec![fluid("water", 1000.0, 1e-3)], gravity);
    let water = Physics { stabilisation: Stabilisation::Dynamic, ..water };
    let mut setup = setup(mesh, sets, water, |_| 0, |_| Vector::ZERO);
    setup.linear = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    let nodes = (0..block.nodes.len() as u32).collect();
    let held = vec![HeldNodes { nodes, velocity: [Some(Signal::ZERO), Some(Signal::ZERO), Some(Signal::ZERO)] }];
    let block = SolidSetup { held, surface, ..SolidSetup::free("block", block, Box::new(Rigid { density: 1000.0 })) };
    setup.solids = Some(Structure::new(vec![block]).unwrap());
    Pfem2::new(setup)
}

/// Elements keep the edges of a block, on lines, planes and diagonals of the mesh, and off them: it bears the weight
/// of the water that it displaces, and water that glides rests beside it to a fiftieth of free fall, where two edges
/// pass an element beside the corner in which they meet; elsewhere to a thousandth.
#[test]
fn a_block_in_space_keeps_its_edges_in_water_that_glides() {
    let size = 0.1;
    for (shift, lost, rests) in [
        ([0.37, 0.37, 0.37], 1e-4, 1e-3),
        ([0.0, 0.0, 0.0], 2e-3, 1e-6),
        ([0.6, 0.6, 0.6], 1e-4, 1e-3),
        ([0.2, 0.3, 0.4], 2e-3, 2e-2),
    ] {
        let lower = Vector([3.0; 3]) + Vector(shift);
        let block = SolidMesh::<3>::block(lower * size, (lower + Vector([4.0, 4.0, 3.0])) * size, [1, 1, 1]).unwrap();
        let mut pfem = tank_in_space(block, SurfaceCondition::Slip);
        (0..3).for_each(|k| pfem.step(f64::from(k) * 0.01, 0.01).unwrap());
        let speed = fastest(&pfem.system.velocity) / (GRAVITY * 0.03);
        let volume = pfem.system.immersed.as_ref().unwrap().cut.volume_inside(&pfem.system.mesh);
        let full = 48.0 * size.powi(3);
        let weight = GRAVITY * 1000.0 * volume;
        let off = (pfem.solids.unwrap().last.forces.last[0] - Vector([0.0, 0.0, weight])).norm() / weight;
        assert!((volume / full - 1.0).abs() < lost, "{shift:?}: {volume} {full}");
        assert!(speed < rests && off < 5e-4, "{shift:?}: {speed:e} {off:e}");
    }
}

/// The surface of the water on the upper side of a solid that lies on a line of the mesh, a millionth of an element
/// above and below it, and cut by both: nothing moves, and the fluids carry their weights (of water as much as
/// the solid displaces, to half a square at its corners).
#[test]
fn two_fluids_rest_at_a_solid_that_ends_where_their_interface_is() {
    for shift in [0.0, 1e-6, -1e-6, 0.3] {
        let shape = block([[4.0 * SIZE, 4.0 * SIZE], [8.0 * SIZE, 8.0 * SIZE]]);
        let rest = rest(tank(Some(8.0 * SIZE), vec![held(moved(shape, Vector([0.0, shift * SIZE])))]));
        assert!(rest.speed < 1e-10, "{shift}: {:e}", rest.speed);
        let squares = rest.forces[0] * (1.0 / (GRAVITY * 1000.0 * SIZE * SIZE));
        let expected = 4.0 * (4.0 - f64::max(shift, 0.0)) + 0.004 * f64::max(shift, 0.0);
        assert!((squares[1] - expected).abs() < 0.5 + 0.001 * 16.0, "{shift}: {squares:?} {expected}");
        assert!(squares[0].abs() < 1e-9, "{shift}: {squares:?}");
    }
}

/// Two solids with a third of an element of water between them, and a plate as thin: water stays at rest.
#[test]
fn water_rests_in_a_gap_and_at_a_plate_thinner_than_an_element() {
    let [left, right] = [[[0.2, 0.3], [0.5, 0.7]], [[0.5 + 0.3 * SIZE, 0.33], [0.8, 0.72]]].map(block);
    let beside = rest(tank(None, vec![held(left), held(right)]));
    assert!(beside.speed < 1e-9, "{:e}", beside.speed);
    let weight = GRAVITY * 1000.0 * (0.3 * 0.4 + (0.3 - 0.3 * SIZE) * 0.39);
    let up: f64 = beside.forces.iter().map(|force| force[1]).sum();
    assert!((up / weight - 1.0).abs() < 0.1, "{up} {weight}");
    let plate = block([[0.21, 0.52], [0.83, 0.52 + 0.3 * SIZE]]);
    let Rest { speed, notices, .. } = rest(tank(None, vec![held(plate)]));
    assert!(speed < 1e-9, "{speed:e}");
    assert!(notices.iter().any(|notice| notice.contains("thinner than elements")), "{notices:?}");
}

/// A solid as heavy as the fluid goes with an even flow and doesn't disturb it, until it comes to the outlet: there
/// the run stops, and says where.
#[test]
fn a_solid_drifts_with_an_even_flow_up_to_the_outlet_which_stops_the_run() {
    let speed = Vector([1.0, 0.0]);
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 0.5]), [16, 8]).unwrap();
    let sets = vec![
        set(&mesh, "in", Condition::Inlet([1.0.into(), 0.0.into()]), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Outlet, |x| x[0] == 1.0),
        set(&mesh, "sides", Condition::Slip, |x| x[1] == 0.0 || x[1] == 0.5),
    ];
    let own = solid(block([[0.3, 0.15], [0.55, 0.3]]), (1e6, 0.3), |_| [false; 2], |_| speed);
    let mut setup = setup(mesh, sets, water(weightless()), |_| 0, |_| speed);
    setup.solids = Some(Structure::new(vec![own]).unwrap());
    setup.linear = SolverOptions { tolerance: 1e-12, ..SolverOptions::default() };
    let mut pfem = Pfem2::new(setup);
    let dt = 0.02;
    let front = |pfem: &Pfem2<2, 3>| {
        let structure = &pfem.solids.as_ref().unwrap().structure;
        structure.positions(&structure.state.displacement).iter().map(|x| x[0]).fold(0.0, f64::max)
    };
    let mut steps = 0;
    let stopped = loop {
        if let Err(error) = pfem.step(f64::from(steps) * dt, dt) {
            break error;
        }
        steps += 1;
        let off = pfem.system.velocity.iter().map(|v| (*v - speed).norm()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{steps}: {off:e}");
        assert!((front(&pfem) - 0.55 - dt * f64::from(steps)).abs() < 1e-9, "{steps}: {}", front(&pfem));
        assert!(steps < 100, "the run goes on");
    };
    assert!(front(&pfem) > 1.0 - 2.0 * dt, "{}", front(&pfem));
    let place = stopped.place.position().unwrap();
    assert!(place[0] == 1.0 && (0.15..=0.3).contains(&place[1]), "{place:?}");
    let told = stopped.to_string();
    assert!(told.contains("reached the boundary") && told.contains("can't leave through an opening"), "{told}");
    assert!(!matches!(stopped.place, Place::Everywhere));
}

/// Nearly incompressible solids under the pressure of a fluid around them: a block gets smaller by 2 p (1 + ν)(1 −
/// 2ν)/E of its size (plane strain), whatever ν.
#[test]
fn a_block_of_nearly_constant_volume_is_pressed_evenly() {
    let (pressure, young, side) = (1e4, 1e6, 0.4);
    for poisson in [0.3, 0.499] {
        let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap(), SIZE);
        let sets = vec![set(&mesh, "top", Condition::Pressure(pressure.into()), |x| x[1] == 1.0)];
        let shape = block([[0.5 - 0.5 * side, 0.31], [0.5 + 0.5 * side, 0.31 + side]]);
        let own = solid(shape, (young, poisson), |_| [false; 2], |_| Vector::ZERO);
        let mut setup = setup(mesh, sets, water(weightless()), |_| 0, |_| Vector::ZERO);
        setup.solids = Some(Structure::new(vec![own]).unwrap());
        setup.start = InitialState::Equilibrium;
        let mut pfem = Pfem2::new(setup);
        pfem.begin(0.0, 1e-3).unwrap();
        let structure = &pfem.solids.as_ref().unwrap().structure;
        let way: Vector<2> = structure.state.displacement.iter().copied().sum();
        let way = way.norm() / structure.state.displacement.len() as f64;
        assert!(way < 0.01 * SIZE, "{poisson}: it goes by {way:e}");
        let found = 1.0 - structure.volume(&structure.positions(&structure.state.displacement)) / (side * side);
        let expected = 2.0 * pressure * (1.0 + poisson) * (1.0 - 2.0 * poisson) / young;
        assert!((found / expected - 1.0).abs() < 0.03, "{poisson}: {found:e} {expected:e}");
    }
}

/// A slab across a box whose left side is open, under one pressure below it and another above, and a block that ends
/// there under an even pressure: both lie off the lines of the mesh, in elements that the opening and they share, and
/// the water stays at rest. Each takes the pressure on its two long sides.
#[test]
fn water_under_pressure_rests_beside_solids_that_end_at_an_opening() {
    let speed = |corners: [[f64; 2]; 2], surface: SurfaceCondition, pressure: &str, force: f64| {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap();
        let sets = vec![
            set(&mesh, "open", Condition::Pressure(formula(pressure)), |x| x[0] == 0.0),
            set(&mesh, "rest", Condition::Slip, |_| true),
        ];
        let mut setup = setup(mesh, sets, water(weightless()), |_| 0, |_| Vector::ZERO);
        setup.linear = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
        setup.solids = Some(Structure::new(vec![SolidSetup { surface, ..held(block(corners)) }]).unwrap());
        let mut pfem = Pfem2::new(setup);
        (0..3).for_each(|k| pfem.step(f64::from(k) * 0.01, 0.01).unwrap());
        let across = pfem.solids.as_ref().unwrap().last.forces.last[0][1];
        assert!((across - force).abs() < 1e-3 * 1000.0, "{corners:?} {surface:?}: {across} N, {force} N");
        fastest(&pfem.system.velocity)
    };
    for surface in [SurfaceCondition::NoSlip, SurfaceCondition::Slip] {
        let slab = speed([[0.0, 0.43], [1.0, 0.585]], surface, "1000*(1 - step(y - 0.5))", 1000.0);
        let block = speed([[0.0, 0.43], [0.61, 0.585]], surface, "1000", 0.0);
        // Under 1000 Pa water would have 1 m/s within the first two steps.
        assert!(slab.max(block) < 1e-3, "{surface:?}: {slab} {block}");
    }
}

/// A rigid slab that parts water from air in a box with an open side, and is drawn towards the air: the volume of the
/// water is what the slab leaves it, without a shift of the interface, which lies amid the slab.
#[test]
fn fluids_that_a_solid_parts_have_the_volume_that_it_leaves_them() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap();
    let sets = vec![
        set(&mesh, "open", Condition::Pressure(Signal::ZERO), |x| x[0] == 0.0),
        set(&mesh, "rest", Condition::Slip, |_| true),
    ];
    let mut physics = water(weightless());
    physics.fluids.push(fluid("air", 1.0, 1e-5));
    let mut setup = setup(mesh, sets, physics, |x| u8::from(x[1] > 0.5), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |x| x[1] - 0.5, &mut setup.particles));
    let slab = SolidSetup::free("slab", block([[0.0, 0.42], [1.0, 0.58]]), Box::new(Rigid { density: 1000.0 }));
    let motion = PrescribedMotion {
        velocity: [Some(Signal::ZERO), Some(0.05.into()), None],
        spin: [None, None, Some(Signal::ZERO)],
    };
    setup.solids = Some(Structure::new(vec![SolidSetup { motion, surface: SurfaceCondition::Slip, ..slab }]).unwrap());
    let mut pfem = Pfem2::new(setup);
    for k in 0..20 {
        pfem.step(f64::from(k) * 0.02, 0.02).unwrap();
        let left = 0.42 + 0.05 * 0.02 * f64::from(k + 1);
        let volume = pfem.system.contents.volumes[0];
        assert!((volume - left).abs() < 1e-7, "{volume} {left}");
        assert_eq!(pfem.interface.shift, 0.0);
    }
    let told = pfem.notices();
    assert!(told.iter().all(|text| !text.contains("could not be kept")), "{told:?}");
}

/// A free strip a fifth of an element thick stays at rest in water at rest, however short its own elements are: its
/// two sides, which are nearer to each other than the gap of contacts, don't meet.
#[test]
fn a_strip_far_thinner_than_elements_rests() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 0.5]), [20, 10]).unwrap();
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    for count in [12, 30, 60] {
        let shape = SolidMesh::block(Vector([0.2, 0.245]), Vector([0.8, 0.255]), [count, 2]).unwrap();
        let own = solid(shape, (1e6, 0.3), |_| [false; 2], |_| Vector::ZERO);
        let mut setup = setup(mesh.clone(), sets.clone(), water(weightless()), |_| 0, |_| Vector::ZERO);
        setup.solids = Some(Structure::new(vec![own]).unwrap());
        let mut pfem = Pfem2::new(setup);
        (0..3).for_each(|k| pfem.step(f64::from(k) * 1e-3, 1e-3).unwrap());
        let structure = &pfem.solids.as_ref().unwrap().structure;
        let most = structure.state.displacement.iter().map(|u| u.norm()).fold(0.0, f64::max);
        assert!(most < 1e-12, "{count}: {most:e}");
    }
}
