//! Elastic solids in fluids against closed forms.

use super::*;
use crate::material::{Elastic, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{Damping, HeldNodes, Plane, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;
use std::f64::consts::PI;

/// A solid of density 1000 kg/m³ with this modulus [Pa] and Poisson's ratio; `held` tells which axes of a node are held.
fn solid(
    mesh: SolidMesh<2>,
    (young, poisson): (f64, f64),
    held: impl Fn(Vector<2>) -> [bool; 2],
    velocity: impl Fn(Vector<2>) -> Vector<2>,
) -> SolidSetup<2> {
    let along = |axis: usize| HeldNodes {
        nodes: (0..mesh.nodes.len() as u32).filter(|&a| held(mesh.nodes[a as usize])[axis]).collect(),
        velocity: std::array::from_fn(|k| (k == axis).then_some(Signal::ZERO)),
    };
    SolidSetup {
        name: "solid".into(),
        law: Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, young, poisson) }),
        plane: Plane::Strain,
        velocity: mesh.nodes.iter().map(|&x| velocity(x)).collect(),
        held: vec![along(0), along(1)],
        tractions: Vec::new(),
        damping: Damping::default(),
        mesh,
    }
}

/// Water with solids in it, with the stabilisation that cases with solids have.
fn water(gravity: [Signal; 2]) -> Physics<2> {
    Physics { stabilisation: Stabilisation::ConsistentPspg, ..physics(vec![fluid("water", 1000.0, 1e-3)], gravity) }
}

/// Length of the bar, of the channel, and width of both [m].
const BAR: [f64; 3] = [0.1, 0.3, 0.05];

/// A bar that is clamped at x = 0 pushes the water of a channel: `cells` elements over its width. The water is a mass at the end of the
/// bar, whose first motion is u = sin(β x/l) sin ωt.
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

/// The frequency of the bar with the water at its end is within 1 % of the exact one at 40 steps per period, and nothing is lost to the
/// coupling: the second swing is 98 % of the first, the ledger closes.
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

/// A solid as heavy as the water around it, under gravity: the water carries its weight, but for the corners that the cut rounds off.
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
    let force = pfem.solids.as_ref().unwrap().last.forces[0];
    assert!((force[1] / weight - 1.0).abs() < 0.01 && force[0].abs() < 0.01 * weight, "{force:?} {weight}");
    let cut = pfem.system.immersed.as_ref().unwrap().cut.volume_inside(&pfem.system.mesh);
    assert!((cut / volume - 1.0).abs() < 0.01, "{cut} {volume}");
    // What the corners lack of buoyancy lets it sink.
    let fall = 9.81 * 0.2 * (1.0 - cut / volume).abs();
    assert!(fastest(&pfem.system.velocity) < 2.0 * fall, "{} {fall}", fastest(&pfem.system.velocity));
}
