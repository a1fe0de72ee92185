//! Solids that meet walls and each other in space, elastic and rigid, against closed forms.

use super::*;
use crate::material::{Elastic, PointLaw, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

/// Elements along a side of the box, and the gap that solids keep from its walls [m].
const CELLS: usize = 4;
const GAP: f64 = 0.5 / CELLS as f64;

/// A block between two corners, of one element, with a modulus [Pa] or rigid (0), a coefficient of friction and
/// a velocity [m/s].
fn block(corners: [[f64; 3]; 2], young: f64, friction: f64, velocity: [f64; 3]) -> SolidSetup<3> {
    let mesh = SolidMesh::block(Vector(corners[0]), Vector(corners[1]), [1; 3]).unwrap();
    let law: Box<dyn PointLaw> = match young == 0.0 {
        true => Box::new(Rigid { density: 1000.0 }),
        false => Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, young, 0.0) }),
    };
    let velocity = vec![Vector(velocity); mesh.nodes.len()];
    SolidSetup { velocity, friction, ..SolidSetup::free("block", mesh, law) }
}

/// Solids in a box of side 1 full of a gas a thousand times lighter, with this gravity [m/s²].
fn in_gas(solids: Vec<SolidSetup<3>>, gravity: [f64; 3]) -> Pfem2<3, 4> {
    let gas = Physics {
        stabilisation: Stabilisation::Dynamic,
        ..physics(vec![fluid("gas", 1.0, 1e-5)], gravity.map(Signal::from))
    };
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0; 3]), [CELLS; 3]).unwrap();
    let mut setup = setup(mesh, Vec::new(), gas, |_| 0, |_| Vector::ZERO);
    setup.linear.tolerance = 1e-12;
    setup.solids = Some(Structure::new(solids).unwrap());
    Pfem2::new(setup)
}

fn structure(pfem: &Pfem2<3, 4>) -> &Structure<3> {
    &pfem.solids.as_ref().unwrap().structure
}

/// Places of the nodes of a solid along an axis [m].
fn places(pfem: &Pfem2<3, 4>, solid: usize, axis: usize) -> Vec<f64> {
    structure(pfem).bodies().nth(solid).unwrap().positions().iter().map(|x| x[axis]).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Blocks on the floor and on each other come to rest half an element above what they stand on, and the floor bears
/// both: rigid ones at once after a fall, elastic ones from a start in touch: after a fall nothing damps their bounces.
/// Rigid ones don't rise after they have landed, but slowly to the gap, and are not pulled. (Takes long: they have to
/// fall, and to rest, in space.)
#[test]
fn blocks_in_space_rest_half_an_element_above_floor_and_block() {
    for (young, drop) in [(1e7, 0.0), (0.0, 0.0), (0.0, 0.005)] {
        let lower = block([[0.2, 0.25, GAP + drop], [0.8, 0.75, 0.43]], young, 0.5, [0.0; 3]);
        let upper = block([[0.3, 0.33, 0.43 + GAP + 2.0 * drop], [0.65, 0.71, 0.8]], young, 0.5, [0.0; 3]);
        let mut pfem = in_gas(vec![lower, upper], [0.0, 0.0, -9.81]);
        let weight = 9.81 * (structure(&pfem).mass() - 0.6 * 0.5 * (0.43 - GAP) - 0.35 * 0.38 * (0.37 - GAP));
        let (dt, mut force) = (0.005, 0.0);
        for k in 0..60 {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            let contact = &pfem.solids.as_ref().unwrap().last.contact_forces.walls;
            let now: f64 = contact.iter().map(|force| force[2]).sum();
            let speed = structure(&pfem).state.velocity.iter().map(|v| v[2]).fold(f64::NEG_INFINITY, f64::max);
            if young == 0.0 {
                eprintln!("{drop} {k} {now} {speed} {}", places(&pfem, 1, 2)[0]);
            }
            force += if k >= 40 { now / 20.0 } else { 0.0 };
        }
        assert!((force / weight - 1.0).abs() < 0.03, "{young} {drop}: {force} {weight}");
        let edge = |solid: usize, pick: fn(f64, f64) -> f64| places(&pfem, solid, 2).into_iter().reduce(pick).unwrap();
        let gaps = [edge(0, f64::min), edge(1, f64::min) - edge(0, f64::max)];
        assert!(gaps.iter().all(|gap| (gap / GAP - 1.0).abs() < 0.05), "{young} {drop}: {gaps:?} {GAP}");
    }
}

/// On an incline a block slides if and only if tan θ > μ, then with g (sin θ − μ cos θ).
#[test]
fn a_block_in_space_slides_only_if_the_incline_is_steeper_than_the_friction() {
    let friction = 0.3;
    for young in [1e7, 0.0] {
        let way = |slope: f64| {
            let (sin, cos) = slope.atan().sin_cos();
            let own = block([[0.2, 0.25, GAP], [0.6, 0.7, GAP + 0.2]], young, friction, [0.0; 3]);
            let mut pfem = in_gas(vec![own], [9.81 * sin, 0.0, -9.81 * cos]);
            let start = mean(&places(&pfem, 0, 0));
            let (dt, steps) = (0.005, 40);
            (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
            let time = dt * f64::from(steps);
            let way = mean(&places(&pfem, 0, 0)) - start;
            (way, 0.5 * 9.81 * (sin - friction * cos).max(0.0) * time * time)
        };
        let (rest, _) = way(0.2);
        assert!(rest.abs() < 0.02 * GAP, "{young}: {rest}");
        let (slid, expected) = way(0.8);
        assert!((slid / expected - 1.0).abs() < 0.07, "{young}: {slid} {expected}");
    }
}

/// Forces of contact add up to nothing over a pair that collides: what the solids gain of momentum is what the fluid
/// gives, to the tolerance of the linear solver.
#[test]
fn contacts_in_space_leave_the_momentum_of_a_pair() {
    let left = block([[0.15, 0.3, 0.3], [0.4, 0.6, 0.6]], 1e6, 0.3, [1.0, 0.0, 0.0]);
    let right = block([[0.4 + GAP + 0.005, 0.35, 0.33], [0.8, 0.67, 0.71]], 1e6, 0.3, [-1.0, 0.2, 0.3]);
    let mut pfem = in_gas(vec![left, right], [0.0; 3]);
    let (dt, mut largest) = (1e-3, 0.0f64);
    for k in 0..20 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        let solids = pfem.solids.as_ref().unwrap();
        let inertia = structure(&pfem).weighted_by_mass(&structure(&pfem).state.acceleration);
        let gained = Vector::<3>::from_fn(|axis| inertia.iter().skip(axis).step_by(3).sum());
        let given: Vector<3> = solids.last.forces.last.iter().copied().sum();
        largest = largest.max(solids.last.contact_forces.solids.iter().map(|force| force.norm()).sum());
        let size: f64 = inertia.iter().map(|force| force.abs()).sum();
        assert!((gained - given).norm() < 1e-9 * size, "{gained:?} {given:?} {largest}");
    }
    assert!(largest > 1e3, "they met: {largest}");
}

/// A bar that meets a wall with its end bounces off after two transits of its wave (St. Venant): the impulse of the
/// wall is what its momentum changes by, and turns it round but for what the mesh keeps as waves. The gas glides along
/// walls.
#[test]
fn a_bar_in_space_bounces_off_a_wall_with_its_speed() {
    let (length, side, young, speed) = (0.3, 0.2, 1e6, 0.5);
    let (lower, transit) = (GAP + 0.01, length / (young / 1000.0_f64).sqrt());
    let mesh = SolidMesh::block(Vector([0.4, 0.4, lower]), Vector([0.4 + side, 0.4 + side, lower + length]), [1, 1, 8])
        .unwrap();
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, young, 0.0) });
    let velocity = vec![Vector([0.0, 0.0, -speed]); mesh.nodes.len()];
    let bar = SolidSetup { velocity, ..SolidSetup::free("bar", mesh, law) };
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0; 3]), [CELLS; 3]).unwrap();
    let gas = Physics { stabilisation: Stabilisation::Dynamic, ..physics(vec![fluid("gas", 1.0, 1e-5)], weightless()) };
    let walls = vec![set(&mesh, "walls", Condition::Slip, |_| true)];
    let mut setup = setup(mesh, walls, gas, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![bar]).unwrap());
    let mut pfem = Pfem2::new(setup);
    let dt = transit / 20.0;
    let steps = ((0.01 / speed + 3.0 * transit) / dt) as usize;
    pfem.begin(0.0, dt).unwrap();
    let (mut touching, mut impulse, mut gas) = (0, 0.0, 0.0);
    for k in 0..steps {
        pfem.step(k as f64 * dt, dt).unwrap();
        let solids = pfem.solids.as_ref().unwrap();
        let push: f64 = solids.last.contact_forces.walls.iter().map(|force| force[2]).sum();
        touching += usize::from(push > 0.0);
        impulse += push * dt;
        gas += solids.last.forces.last[0][2] * dt;
    }
    let mass = structure(&pfem).mass();
    let (contact, end) = (touching as f64 * dt, structure(&pfem).momentum() / mass);
    assert!((contact / (2.0 * transit) - 1.0).abs() < 0.1, "{contact} {transit}");
    assert!((0.93..1.0).contains(&(end[2] / speed)), "{end:?}");
    assert!(end[0].hypot(end[1]) < 1e-3 * speed, "{end:?}");
    let gained = mass * (end[2] + speed);
    assert!(((impulse + gas) / gained - 1.0).abs() < 0.01, "{impulse} {gas} {gained}");
}
