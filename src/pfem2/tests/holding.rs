//! Forces on supports and springs, and of contacts: what holds a solid, and what the fluid and gravity do to it, change
//! its momentum.

use super::solids::{CELLS, GAP, solid, water};
use super::*;
use crate::material::Rigid;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{PrescribedMotion, SolidSetup, SpringSupport};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const GRAVITY: [f64; 2] = [3.0, -9.81];

/// A block of 0.3 × 0.2 m and 1000 kg/m³ in the middle of a box of 1 m, with a modulus [Pa] or rigid (0); the side at
/// x = 0.33 m may be held.
fn block(young: f64, is_held: bool, velocity: [f64; 2]) -> SolidSetup<2> {
    let mesh = SolidMesh::block(Vector([0.33, 0.41]), Vector([0.63, 0.61]), [3, 2]).unwrap();
    let setup = solid(mesh, (young.max(1.0), 0.3), |x| [is_held && x[0] < 0.331; 2], |_| Vector(velocity));
    match young == 0.0 {
        true => SolidSetup { law: Box::new(Rigid { density: 1000.0 }), held: Vec::new(), ..setup },
        false => setup,
    }
}

/// Solids in a box of side 1 full of a fluid of some density [kg/m³].
fn within(solids: Vec<SolidSetup<2>>, density: f64) -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap();
    let physics = Physics { fluids: vec![fluid("fluid", density, 1e-3)], ..water(GRAVITY.map(Signal::from)) };
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(solids).unwrap());
    setup.linear = SolverOptions { tolerance: 1e-12, ..SolverOptions::default() };
    Pfem2::new(setup)
}

/// The force of this name in the outputs [N].
fn force(pfem: &Pfem2<2, 3>, name: &str) -> Vector<2> {
    let snapshot = pfem.snapshot();
    let (_, force) = snapshot.forces.iter().find(|(of, _)| of == name).unwrap();
    Vector([force[0], force[1]])
}

/// Impulse of gravity, fluid and all that holds the solid in so many steps, and the change of its momentum [N s].
fn impulse_and_momentum(pfem: &mut Pfem2<2, 3>, holding: &[(&str, f64)], dt: f64, steps: usize) -> [Vector<2>; 2] {
    let momentum = |pfem: &Pfem2<2, 3>| pfem.solids.as_ref().unwrap().structure.momentum();
    let mass = pfem.solids.as_ref().unwrap().structure.mass();
    let start = momentum(pfem);
    let mut impulse = Vector(GRAVITY) * (mass * dt * steps as f64);
    pfem.begin(0.0, dt).unwrap();
    for k in 0..steps {
        pfem.step(k as f64 * dt, dt).unwrap();
        impulse += force(pfem, "solid") * dt;
        holding.iter().for_each(|&(name, sign)| impulse += force(pfem, name) * (sign * dt));
    }
    [impulse, momentum(pfem) - start]
}

/// An elastic block on one held side in water that begins to swing: with the means over the steps to rounding of the
/// solution.
#[test]
fn supports_of_an_elastic_block_close_its_momentum() {
    let holding = [("support:solid[0]", -1.0), ("support:solid[1]", -1.0)];
    let mut pfem = within(vec![block(1e5, true, [0.2, 0.7])], 500.0);
    let [impulse, momentum] = impulse_and_momentum(&mut pfem, &holding, 0.002, 40);
    let scale = 60.0 * 0.7;
    assert!((impulse - momentum).norm() < 1e-6 * scale, "{impulse:?} {momentum:?}");
    assert!(force(&pfem, "support:solid[1]")[1].abs() > 10.0 && force(&pfem, "support:solid[0]")[1] == 0.0);
}

/// The same of an elastic and a rigid one on a spring with a dashpot.
#[test]
fn springs_close_the_momentum_of_solids() {
    for young in [0.0, 1e6] {
        let weights = vec![(0, 0.25), (6, 0.75)];
        let spring = SpringSupport { weights, stiffness: [3e4, 2e4], damping: [50.0, 20.0] };
        let mut pfem = within(vec![SolidSetup { springs: vec![spring], ..block(young, false, [0.3, 0.1]) }], 500.0);
        let [impulse, momentum] = impulse_and_momentum(&mut pfem, &[("spring:solid[0]", -1.0)], 0.002, 40);
        assert!((impulse - momentum).norm() < 1e-6 * 60.0, "{young} {impulse:?} {momentum:?}");
    }
}

/// A rigid block that is shaken: on what drives it the force is its weight and that of the fluid less m a, with m of
/// 60 kg; the moment about a point is that of a force in its middle, as the fluid, next to nothing here, has none.
#[test]
fn the_support_force_of_a_shaken_rigid_block_is_its_weight_less_its_inertia() {
    let (dt, steps) = (0.002, 50);
    let mut shaken = block(0.0, false, [0.0; 2]);
    let velocity = [Some(formula("0.5*t^2")), Some(Signal::ZERO), None];
    shaken.motion = PrescribedMotion { velocity, spin: [None, None, Some(Signal::ZERO)] };
    let mut pfem = within(vec![shaken], 1e-3);
    let about = Vector([0.2, 0.1]);
    pfem.solids.as_mut().unwrap().moment_points = vec![Some(about)];
    pfem.begin(0.0, dt).unwrap();
    (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
    let found = force(&pfem, "support:solid");
    // The mean of a step: a = t, in its middle.
    let expected = Vector([60.0 * (3.0 - (f64::from(steps) - 0.5) * dt), -9.81 * 60.0]);
    assert!((found - expected).norm() < 2e-4 * expected.norm(), "{found:?} {expected:?}");
    let moments = pfem.snapshot().moments;
    let (_, moment) = moments.iter().find(|(of, _)| of == "support:solid").unwrap();
    let middle = Vector([0.48, 0.51]) - about;
    let expected = middle[0] * expected[1] - middle[1] * expected[0];
    assert!((moment[2] / expected - 1.0).abs() < 1e-3, "{moment:?} {expected}");
}

/// Blocks that fall on the floor, elastic and rigid: contacts stop them, and then bear their weight, with friction.
#[test]
fn contacts_stop_blocks_and_bear_their_weight() {
    for young in [0.0, 1e7] {
        let mesh = SolidMesh::block(Vector([0.35, GAP + 0.012]), Vector([0.65, GAP + 0.212]), [3, 2]).unwrap();
        let mut falling = block(young, false, [0.0, -0.5]);
        falling.velocity = vec![Vector([0.0, -0.5]); mesh.nodes.len()];
        (falling.mesh, falling.friction) = (mesh, 0.9);
        let mut pfem = within(vec![falling], 1.0);
        let [impulse, momentum] = impulse_and_momentum(&mut pfem, &[("contacts:solid", 1.0)], 0.0025, 200);
        assert!((impulse - momentum).norm() < 0.01 * 30.0, "{young} {impulse:?} {momentum:?}");
        let (found, weight) = (force(&pfem, "contacts:solid"), Vector(GRAVITY) * -60.0);
        assert!((found - weight).norm() < 0.02 * weight.norm(), "{young} {found:?} {weight:?}");
    }
}
