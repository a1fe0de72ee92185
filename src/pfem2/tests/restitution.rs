//! Rigid solids that bounce with a coefficient of restitution, against closed forms.

use super::solids::{CELLS, GAP, solid};
use super::*;
use crate::material::Rigid;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::surface::tests::disc;
use crate::simulation::Solver;

/// A rigid solid with a coefficient of restitution and a velocity [m/s].
fn rigid(mesh: SolidMesh<2>, restitution: f64, velocity: [f64; 2]) -> SolidSetup<2> {
    let mut own = solid(mesh, (1.0, 0.0), |_| [false; 2], |_| Vector(velocity));
    (own.law, own.restitution) = (Box::new(Rigid { density: 1000.0 }), restitution);
    own
}

/// Solids in a box of side 1 full of a gas ten thousand times lighter, with this gravity [m/s²]: what moves of it takes
/// from solids, and gives back when they bounce, less than the bounds on their energy below.
fn in_gas(solids: Vec<SolidSetup<2>>, gravity: [f64; 2]) -> Pfem2<2, 3> {
    let gas = Physics {
        stabilisation: Stabilisation::Dynamic,
        ..physics(vec![fluid("gas", 0.1, 1e-6)], gravity.map(Signal::from))
    };
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap();
    let mut setup = setup(mesh, Vec::new(), gas, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(solids).unwrap());
    Pfem2::new(setup)
}

/// Velocity of the centre of mass of a rigid solid [m/s].
fn velocity(pfem: &Pfem2<2, 3>, solid: usize) -> Vector<2> {
    Vector::from3(pfem.solids.as_ref().unwrap().structure.state.rigid[solid].velocity[0].0)
}

/// A ball that falls from h comes back to e² h. What it loses of its energy then is in the work of supports, to 0.2 %
/// of m g h; the gas only takes.
#[test]
fn a_ball_that_falls_bounces_to_the_square_of_its_restitution() {
    let (restitution, height, radius) = (0.7, 0.2, 0.15);
    let mut round = disc(3);
    round.nodes.iter_mut().for_each(|x| *x = *x * radius + Vector([0.5, radius + GAP + height]));
    let mut pfem = in_gas(vec![rigid(round, restitution, [0.0; 2])], [0.0, -9.81]);
    let mass = pfem.solids.as_ref().unwrap().structure.mass();
    let (dt, mut has_bounced, mut bounce) = (0.002, false, 0);
    let (mut last, mut gained) = (0.0, Vec::new());
    for k in 0..220 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        let now = velocity(&pfem, 0)[1];
        gained.push(pfem.balance.solids.unwrap().gained() / (mass * 9.81 * height));
        if !has_bounced && now > 0.0 {
            (has_bounced, bounce) = (true, gained.len() - 1);
            assert!((-now / last / restitution - 1.0).abs() < 0.01, "{now} {last}");
        }
        last = now;
        if has_bounced && now < 0.0 {
            break;
        }
    }
    let risen = pfem.solids.as_ref().unwrap().structure.state.displacement[0][1] + height;
    let expected = restitution * restitution * height;
    assert!((risen / expected - 1.0).abs() < 0.06, "{risen} {expected}");
    // The work of a step is complete after two more, which take their parts of its powers.
    let [before, after] = [gained[bounce - 1], gained[bounce + 3]];
    assert!((after - before).abs() < 0.002 && gained.iter().all(|gained| *gained < 0.0), "{before} {after}");
}

/// Of two equal balls that meet in a straight line one has (1 − e)/2 of the speed afterwards and the other (1 + e)/2.
#[test]
fn two_equal_rigid_blocks_share_their_speed_by_restitution() {
    let (restitution, speed) = (0.6, 1.0);
    let mesh = |x: f64| SolidMesh::block(Vector([x, 0.4]), Vector([x + 0.2, 0.6]), [2, 2]).unwrap();
    let own = rigid(mesh(0.15), restitution, [speed, 0.0]);
    let other = rigid(mesh(0.35 + GAP + 0.02), restitution, [0.0; 2]);
    let mut pfem = in_gas(vec![own, other], [0.0; 2]);
    (0..20).for_each(|k| pfem.step(f64::from(k) * 0.004, 0.004).unwrap());
    let [own, other] = [0, 1].map(|solid| velocity(&pfem, solid)[0] / speed);
    let expected = [0.5 * (1.0 - restitution), 0.5 * (1.0 + restitution)];
    assert!((own - expected[0]).abs() < 0.02 && (other - expected[1]).abs() < 0.02, "{own} {other} {expected:?}");
}

/// A ball that bounces comes to rest on the floor, and lies there half an element above it.
#[test]
fn a_ball_that_bounces_comes_to_rest() {
    let mesh = SolidMesh::block(Vector([0.3, GAP + 0.02]), Vector([0.6, GAP + 0.2]), [3, 2]).unwrap();
    let mut pfem = in_gas(vec![rigid(mesh, 0.4, [0.0; 2])], [0.0, -9.81]);
    (0..100).for_each(|k| pfem.step(f64::from(k) * 0.004, 0.004).unwrap());
    let solids = pfem.solids.as_ref().unwrap();
    let lowest = solids.structure.state.displacement[0][1] + GAP + 0.02;
    assert!((lowest / GAP - 1.0).abs() < 0.02 && velocity(&pfem, 0).norm() < 2e-3, "{lowest} {:?}", velocity(&pfem, 0));
}

/// A disc without spin that hits the floor obliquely and slides through the collision loses μ (1 + e) of its normal
/// speed along the floor, and turns with twice of it over its radius (Coulomb, Newton).
#[test]
fn friction_acts_in_a_collision() {
    let (restitution, friction, radius) = (0.5, 0.1, 0.15);
    let mut round = disc(3);
    round.nodes.iter_mut().for_each(|x| *x = *x * radius + Vector([0.4, radius + GAP + 0.01]));
    let mut own = rigid(round, restitution, [1.0, -1.0]);
    own.friction = friction;
    let mut pfem = in_gas(vec![own], [0.0; 2]);
    (0..10).for_each(|k| pfem.step(f64::from(k) * 0.004, 0.004).unwrap());
    let state = pfem.solids.as_ref().unwrap().structure.state.rigid[0];
    let lost = friction * (1.0 + restitution);
    let [along, normal, spin] = [state.velocity[0][0], state.velocity[0][1], state.spin[0][2]];
    assert!((normal - restitution).abs() < 0.01, "{normal}");
    assert!(
        (1.0 - along - lost).abs() < 0.04 * lost && (-spin * radius - 2.0 * lost).abs() < 0.04 * lost,
        "{along} {spin}"
    );
}
