//! What `bad_luck` asks, in space.

use super::*;
use crate::material::{Elastic, PointLaw, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::mesh::shapes::hollow;
use crate::pfem2::solid::setup::{HeldNodes, SolidSetup, SurfaceCondition};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// Elements along a side of the box of side 1, and their size [m].
const CELLS: usize = 8;
const SIZE: f64 = 1.0 / CELLS as f64;

/// The law of a solid, rigid where its modulus [Pa] is zero.
fn law(density: f64, young: f64, poisson: f64) -> Box<dyn PointLaw> {
    match young == 0.0 {
        true => Box::new(Rigid { density }),
        false => Box::new(StVenantKirchhoff { elastic: Elastic::new(density, young, poisson) }),
    }
}

fn free(mesh: SolidMesh<3>, density: f64, young: f64, surface: SurfaceCondition) -> SolidSetup<3> {
    SolidSetup { surface, ..SolidSetup::free("solid", mesh, law(density, young, 0.3)) }
}

/// A solid whose nodes are all held.
fn held(mesh: SolidMesh<3>, surface: SurfaceCondition) -> SolidSetup<3> {
    let nodes = (0..mesh.nodes.len() as u32).collect();
    let held = vec![HeldNodes { nodes, velocity: std::array::from_fn(|_| Some(Signal::ZERO)) }];
    SolidSetup { held, ..free(mesh, 1000.0, 1e8, surface) }
}

/// A block between corners in elements of the mesh.
fn block([lower, upper]: [[f64; 3]; 2]) -> SolidMesh<3> {
    SolidMesh::block(Vector(lower) * SIZE, Vector(upper) * SIZE, [1; 3]).unwrap()
}

/// A block whose sides go through the diagonals of the squares of the mesh, with this half diagonal and height in
/// elements.
fn across(half: f64, height: f64, middle: [f64; 3]) -> SolidMesh<3> {
    let mut mesh = SolidMesh::block(Vector::splat(-0.5), Vector::splat(0.5), [2, 2, 1]).unwrap();
    let turned = |x: Vector<3>| Vector([(x[0] - x[1]) * half, (x[0] + x[1]) * half, x[2] * height]);
    mesh.nodes.iter_mut().for_each(|x| *x = (turned(*x) + Vector(middle)) * SIZE);
    mesh
}

fn moved(mut mesh: SolidMesh<3>, by: [f64; 3]) -> SolidMesh<3> {
    mesh.nodes.iter_mut().for_each(|x| *x += Vector(by) * SIZE);
    mesh
}

/// Fluids in the box, the second above a height [m] where there are two, with solids.
fn tank(fluids: Vec<FluidSetup>, height: f64, solids: Vec<SolidSetup<3>>) -> Setup<3, 4> {
    tank_of(CELLS, fluids, height, solids)
}

/// The same with so many elements along a side.
fn tank_of(cells: usize, fluids: Vec<FluidSetup>, height: f64, solids: Vec<SolidSetup<3>>) -> Setup<3, 4> {
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [cells; 3]).unwrap();
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let stabilisation = if fluids.len() == 1 { Stabilisation::Dynamic } else { Stabilisation::ConsistentPspg };
    let two = fluids.len() == 2;
    let physics = Physics { stabilisation, ..physics(fluids, [Signal::ZERO, Signal::ZERO, (-GRAVITY).into()]) };
    let mut setup = setup(mesh, sets, physics, |x| u8::from(two && x[2] > height), |_| Vector::ZERO);
    if two {
        setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |x| x[2] - height, &mut setup.particles));
    }
    setup.linear = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    setup.solids = Some(Structure::new(solids).unwrap());
    setup
}

fn water() -> Vec<FluidSetup> {
    vec![fluid("water", 1000.0, 1e-3)]
}

/// A state after some steps of 0.01 s from rest.
struct Rest {
    /// The largest speed of the fluid, over that of free fall.
    speed: f64,
    /// Force on the first solid [N].
    force: Vector<3>,
    /// Volume of the solids as the mesh shows it [m³].
    shown: f64,
    notices: Vec<String>,
}

fn rest(setup: Setup<3, 4>) -> Rest {
    let mut pfem = Pfem2::new(setup);
    let (dt, steps) = (0.01, 2);
    (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
    let speed = fastest(&pfem.system.velocity) / (GRAVITY * dt * f64::from(steps));
    let shown = pfem.system.immersed.as_ref().unwrap().cut.volume_inside(&pfem.system.mesh);
    let notices = pfem.notices();
    Rest { speed, force: pfem.solids.unwrap().last.forces.last[0], shown, notices }
}

/// Sides in planes of the mesh, through its nodes and across its diagonals, and parts of an element beside them from a
/// millionth to rounding: water stays at rest and carries the weight of what the mesh shows of the solid; that is the
/// solid itself, but for edges on planes of the mesh or next to them, which may be cut off.
#[test]
fn water_rests_at_surfaces_in_planes_of_the_mesh_and_slivers_beside_them() {
    let shapes = [("along", block([[2.0; 3], [5.0; 3]]), 27.0), ("across", across(2.0, 3.0, [4.0, 4.0, 3.5]), 24.0)];
    let shifts = [[0.0; 3], [1e-6; 3], [-1e-6, 1e-6, -1e-6], [1e-9, -1e-9, 1e-9], [1e-14, 0.0, 0.0], [0.0, 0.0, -1e-6]];
    for (name, shape, cubes) in &shapes {
        for shift in shifts {
            let own = held(moved(shape.clone(), shift), SurfaceCondition::NoSlip);
            let rest = rest(tank(water(), 0.0, vec![own]));
            let weight = GRAVITY * 1000.0 * rest.shown;
            let off = (rest.force - Vector([0.0, 0.0, weight])).norm() / weight;
            let lost = 1.0 - rest.shown / (cubes * SIZE.powi(3));
            assert!(rest.speed < 1e-9 && off < 1e-9, "{name} {shift:?}: {:e} {off:e}", rest.speed);
            assert!(lost.abs() < 0.01, "{name} {shift:?}: {lost}");
        }
    }
}

/// The surface of the water on the upper side of a block in a plane of the mesh, a millionth of an element above and
/// below it, and cut by both: nothing moves, and the fluids carry their weights (of water as much as the block
/// displaces, to an eighth of an element along its edges).
#[test]
fn two_fluids_rest_at_a_block_that_ends_where_their_interface_is() {
    for shift in [0.0, 1e-6, -1e-6, 0.3] {
        let own = held(moved(block([[2.0; 3], [5.0; 3]]), [0.0, 0.0, shift]), SurfaceCondition::NoSlip);
        let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
        let Rest { speed, force, .. } = rest(tank(fluids, 5.0 * SIZE, vec![own]));
        let cubes = force * (1.0 / (GRAVITY * 1000.0 * SIZE.powi(3)));
        let expected = 9.0 * (3.0 - f64::max(shift, 0.0) * 0.999);
        assert!(speed < 1e-9, "{shift}: {speed:e}");
        assert!((cubes[2] - expected).abs() < 0.02 * 27.0, "{shift}: {cubes:?} {expected}");
        assert!(cubes[0].abs().max(cubes[1].abs()) < 1e-6, "{shift}: {cubes:?}");
    }
}

/// Water rests at a plate a third of an element thick: with nodes of the mesh in it the plate bears its buoyancy, and
/// amid two planes of nodes a run says that the mesh doesn't show it. In a gas it falls freely.
#[test]
fn a_plate_thinner_than_an_element_rests_in_water_and_falls_in_a_gas() {
    let plate = |lower: f64| block([[1.7, 1.6, lower], [6.6, 6.4, lower + 0.3]]);
    let Rest { speed, force, shown, .. } = rest(tank(water(), 0.0, vec![held(plate(3.84), SurfaceCondition::NoSlip)]));
    let weight = GRAVITY * 1000.0 * shown;
    let lost = 1.0 - shown / (4.9 * 4.8 * 0.3 * SIZE.powi(3));
    assert!(
        speed < 1e-9 && (force - Vector([0.0, 0.0, weight])).norm() < 1e-9 * weight,
        "{speed:e} {force:?} {weight}"
    );
    assert!((0.0..0.1).contains(&lost), "{lost}");
    let Rest { speed, notices, .. } = rest(tank(water(), 0.0, vec![held(plate(4.2), SurfaceCondition::NoSlip)]));
    assert!(speed < 1e-9, "{speed:e}");
    assert!(notices.iter().any(|notice| notice.contains("thinner than elements")), "{notices:?}");
    for young in [0.0, 1e9] {
        let own = free(plate(3.84), 1000.0, young, SurfaceCondition::NoSlip);
        let fall = fall(tank(vec![fluid("gas", 1.0, 1e-5)], 0.0, vec![own]), 0.005, 10);
        assert!((0.97..1.0).contains(&fall), "{young}: {fall}");
    }
}

/// Downward velocity of the solid after some steps, over that of free fall.
fn fall(mut setup: Setup<3, 4>, dt: f64, steps: u32) -> f64 {
    setup.linear.tolerance = 1e-9;
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, dt).unwrap();
    (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
    let structure = &pfem.solids.as_ref().unwrap().structure;
    -structure.momentum()[2] / structure.mass() / (GRAVITY * dt * f64::from(steps))
}

/// A modulus of 1e12 Pa in air, and ten thousand times the density of a fluid and a ten-thousandth. What falls in air
/// falls freely, but for the part of air. What rises in water does so with g (ρ_f − ρ)/(ρ + C ρ_f), and C belongs to its
/// shape alone: that of a solid half as heavy as water; and so does what sinks in it with ten thousand times its
/// density.
#[test]
fn solids_of_extreme_stiffness_and_density_fall_and_rise_in_space() {
    let own = |density: f64, young: f64| {
        free(block([[2.6, 2.7, 3.2], [5.3, 5.4, 5.7]]), density, young, SurfaceCondition::Slip)
    };
    for (density, young) in [(1000.0, 1e12), (1e4, 1e7), (1e4, 0.0)] {
        let part = fall(tank(vec![fluid("air", 1.0, 1e-5)], 0.0, vec![own(density, young)]), 0.005, 5);
        let least = 1.0 - 2.5 / density;
        assert!((least..1.0).contains(&part), "{density} {young}: {part}");
    }
    let added = |density: f64, young: f64| {
        let rise = -fall(tank(water(), 0.0, vec![own(density, young)]), 0.001, 4);
        (1.0 - density / 1000.0) / rise - density / 1000.0
    };
    let half = added(500.0, 0.0);
    // 0.67 far from walls, and more near to them.
    assert!((0.6..1.2).contains(&half), "{half}");
    for young in [0.0, 1e9] {
        let light = added(0.1, young);
        assert!((light / half - 1.0).abs() < 0.02, "{young}: {light} {half}");
    }
    let heavy = fall(tank(water(), 0.0, vec![own(1e7, 0.0)]), 0.001, 4);
    let heavy = 1e4 * (1.0 - heavy) - 1.0;
    assert!((heavy / half - 1.0).abs() < 0.05, "{heavy} {half}");
}

/// A light and stiff box full of water, its walls two elements thick: the water in it and around it is more than ten
/// times as heavy, and it moves as a full one of the mass of the box and the water in it, rigid and elastic.
#[test]
fn a_light_box_full_of_water_moves_as_a_full_one_of_that_mass() {
    let (cells, outer, inner, density) = (12, 9.2 / 12.0, 4.8 / 12.0, 50.0);
    let center = Vector([0.51, 0.49, 0.505]);
    let [whole, full] = [outer, inner].map(|side: f64| side.powi(3));
    let own = density * (whole - full);
    assert!(1000.0 * full + 600.0 * whole > 10.0 * own);
    let half = Vector::splat(0.5 * outer);
    let one = SolidMesh::block(center - half, center + half, [3; 3]).unwrap();
    let falls = |solid: SolidSetup<3>| fall(tank_of(cells, water(), 0.0, vec![solid]), 0.001, 2);
    let expected = falls(free(one, (own + 1000.0 * full) / whole, 0.0, SurfaceCondition::Slip));
    for young in [0.0, 1e10] {
        let found = falls(free(hollow([outer, inner], center), density, young, SurfaceCondition::Slip));
        assert!((found / expected - 1.0).abs() < 0.02, "{young}: {found} {expected}");
    }
}

/// A block as heavy as the fluid goes with an even flow and doesn't disturb it, until it comes to the outlet: there
/// the run stops, and says where.
#[test]
fn a_block_drifts_with_an_even_flow_up_to_the_outlet_which_stops_the_run_in_space() {
    let (speed, dt) = (Vector([1.0, 0.0, 0.0]), 0.04);
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0, 0.5, 0.5]), [8, 4, 4]).unwrap();
    let sets = vec![
        set(&mesh, "in", Condition::Inlet([1.0.into(), 0.0.into(), 0.0.into()]), |x| x[0] == 0.0),
        set(&mesh, "out", Condition::Outlet, |x| x[0] == 1.0),
        set(&mesh, "sides", Condition::Slip, |_| true),
    ];
    let block = SolidMesh::block(Vector([0.3, 0.15, 0.17]), Vector([0.6, 0.33, 0.36]), [1; 3]).unwrap();
    let own =
        SolidSetup { velocity: vec![speed; block.nodes.len()], ..free(block, 1000.0, 1e6, SurfaceCondition::NoSlip) };
    let physics = Physics { stabilisation: Stabilisation::Dynamic, ..physics(water(), weightless()) };
    let mut setup = setup(mesh, sets, physics, |_| 0, |_| speed);
    setup.solids = Some(Structure::new(vec![own]).unwrap());
    setup.linear = SolverOptions { tolerance: 1e-12, ..SolverOptions::default() };
    let mut pfem = Pfem2::new(setup);
    for steps in 0..30 {
        let front = 0.6 + dt * f64::from(steps);
        if let Err(stopped) = pfem.step(f64::from(steps) * dt, dt) {
            let place = stopped.place.position().unwrap();
            let told = stopped.to_string();
            assert!(front > 1.0 - 2.0 * dt, "{front}");
            assert!(
                place[0] == 1.0 && (0.15..=0.33).contains(&place[1]) && (0.17..=0.36).contains(&place[2]),
                "{place:?}"
            );
            assert!(told.contains("reached the boundary") && told.contains("can't leave through an opening"), "{told}");
            return;
        }
        let off = pfem.system.velocity.iter().map(|v| (*v - speed).norm()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{steps}: {off:e}");
    }
    panic!("the run goes on");
}

/// Under a pressure from above a block in weightless water gets smaller by p/K of its volume, whatever ν; K = E/(3 (1 −
/// 2ν)), and 10⁴ G for ν = ½ (J.18); but for a millionth, the square of strains by what cut edges lack, a tenth of p/G.
#[test]
fn a_block_of_nearly_constant_volume_is_pressed_evenly_in_space() {
    let (pressure, young) = (1e4, 1e6);
    for poisson in [0.3, 0.499, 0.5] {
        let corners = [[2.3, 2.6, 2.4], [5.2, 5.7, 5.1]].map(|corner| Vector(corner) * SIZE);
        let shape = SolidMesh::block(corners[0], corners[1], [2; 3]).unwrap();
        let own = SolidSetup::free("solid", shape.clone(), law(1000.0, young, poisson));
        let mut setup = tank(water(), 0.0, vec![own]);
        setup.gravity = weightless();
        setup.boundaries = vec![set(&setup.mesh, "top", Condition::Pressure(pressure.into()), |x| x[2] == 1.0)];
        setup.start = InitialState::Equilibrium;
        setup.linear.tolerance = 1e-10;
        let mut pfem = Pfem2::new(setup);
        pfem.begin(0.0, 1e-3).unwrap();
        let structure = &pfem.solids.as_ref().unwrap().structure;
        let start = structure.volume(&shape.nodes);
        let found = 1.0 - structure.volume(&structure.positions(&structure.state.displacement)) / start;
        let bulk = if poisson == 0.5 { 1e4 * young / 3.0 } else { young / (3.0 * (1.0 - 2.0 * poisson)) };
        let expected = pressure / bulk;
        assert!((found - expected).abs() < 0.03 * expected + 1e-6, "{poisson}: {found:e} {expected:e}");
    }
}
