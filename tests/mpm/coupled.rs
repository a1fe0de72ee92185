//! Bodies and membranes together.

use crate::model::*;
use lateen::material::{EquationsOfState, Fluid, StartState, eos, sheet};
use lateen::math::{Signal, Vector};
use lateen::mpm::{Friction, KernelKind, Locking, MembraneSetup, Mpm, StressUpdate, SupportSetup, Transfer, WallKind};
use lateen::simulation::Solver as _;

fn elastic(density: f64, young: f64) -> Box<dyn lateen::material::Sheet> {
    Box::new(sheet::Elastic { density, young, poisson: 0.3, wrinkling: false })
}

fn membrane<const D: usize>(
    sheet: Box<dyn lateen::material::Sheet>,
    thickness: f64,
    position: Vec<Vector<D>>,
    elements: Vec<Vec<u32>>,
) -> MembraneSetup<D> {
    MembraneSetup {
        name: "sheet".into(),
        sheet,
        velocity: vec![Vector::ZERO; position.len()],
        position,
        elements,
        warp: Vec::new(),
        thickness,
        prestress: [0.0; 2],
        hourglass: [0.05, 0.0, 0.01],
        damping: [0.0; 2],
        supports: Vec::new(),
        pressure: Signal::ZERO,
        follower: true,
        contact_thickness: false,
    }
}

/// A rubber ball hits a free sheet; a second block waits below it.
fn impact(transfer: Transfer, friction: Friction, max_substeps: usize) -> Mpm<3> {
    let mut setup = setup(grid([-2.0, -2.0, -1.5], 0.25, [16, 16, 12], WallKind::Open));
    (setup.transfer, setup.default_friction, setup.max_substeps) = (transfer, friction, max_substeps);
    let ball = |x: Vector<3>| (x - Vector([0.0, 0.0, 0.6])).norm() < 0.5;
    let velocity = |x: Vector<3>| Vector([0.5, 0.3 * x[2], -4.0]);
    let mut falling = body(rubber(10.0, 2e3, 0.3), ([-0.5, -0.5, 0.1], [8; 3], 0.125), ball, velocity);
    falling.name = "ball".into();
    let mut waiting = body(rubber(20.0, 2e3, 0.3), ([-0.5, -0.5, -0.7], [8, 8, 4], 0.125), |_| true, |_| Vector::ZERO);
    waiting.group = 1;
    setup.bodies = vec![falling, waiting];
    let n = 9_u32;
    let at = |i: u32| f64::from(i) * 0.25 - 1.0;
    let position = (0..n * n).map(|k| Vector([at(k % n), at(k / n), 0.0])).collect();
    let cell = |k: u32| k / (n - 1) * n + k % (n - 1);
    let elements = (0..(n - 1) * (n - 1)).map(|k| [0, 1, n + 1, n].map(|o| cell(k) + o).to_vec()).collect();
    setup.membranes = vec![membrane(elastic(100.0, 2e5), 0.02, position, elements)];
    start(setup)
}

/// Momentum and energy of ball, sheet and block, with gravity off: theory 14.37.
#[test]
fn coupled_ledger_closes() {
    for (transfer, friction, substeps) in
        [(FLIP, Friction::Slip(0.0), 1), (Transfer::Apic, Friction::Slip(0.3), 50), (FLIP, Friction::Stick, 7)]
    {
        let mut mpm = impact(transfer, friction, substeps);
        let names = ["momentum x", "momentum y", "momentum z"];
        let before = names.map(|name| term(&mpm, name));
        run(&mut mpm, 0.25, 1.0, |_, _, _| {}).unwrap();
        let what = format!("{transfer:?} {friction:?} {substeps}");
        let scale = term(&mpm, "stored energy at the start");
        let closure = closure(&mpm);
        assert!(closure.abs() < 1e-12 * scale, "{what}: closure {closure} of {scale}");
        for (name, before) in names.iter().zip(before) {
            let now = term(&mpm, name);
            assert!((now - before).abs() < 1e-12 * 20.0, "{what}: {name} {before} → {now}");
        }
        let lost = term(&mpm, "contact dissipation");
        assert!(lost > 1e-3 * scale && lost < 0.5 * scale, "{what}: contact lost {lost} of {scale}");
        assert!(
            mpm.snapshot().counts.contains(&("crossed:sheet".to_owned(), 0)),
            "{what}: {:?}",
            mpm.snapshot().counts
        );
    }
}

/// The gas expansion of the paper, section 7.3, as a quarter in 2D (theory 12.4): the membrane is
/// inextensible, so it swings about a circle of perimeter 6 with the period 0.988 of the second ring mode of a
/// gas-filled loop, and about 5 % of the energy are lost.
#[test]
fn gas_blows_the_membrane_round() {
    let mut setup = setup(grid([0.0, 0.0], 0.1, [15, 15], WallKind::Open));
    setup.grid.walls[0][0] = wall(WallKind::Slip);
    setup.grid.walls[1][0] = wall(WallKind::Slip);
    (setup.kernel, setup.stress_update, setup.locking) = (KernelKind::Quadratic, StressUpdate::Average, Locking::None);
    setup.max_substeps = 200;
    let eos = EquationsOfState::IdealGas(eos::IdealGas { gamma: 1.4 });
    let gas = Fluid { density: 1.0, viscosity: 0.1, bulk_viscosity: Default::default(), eos };
    let mut gas = body(Box::new(gas), ([0.0, 0.0], [18, 38], 0.025), |_| true, |_| Vector::ZERO);
    gas.state.fill(StartState { energy: Some(25.0), ..StartState::default() });
    setup.bodies = vec![gas];
    let corner = |k: u32| if k <= 10 { [0.5, 0.1 * f64::from(k)] } else { [0.1 * f64::from(15 - k), 1.0] };
    let position = (0..16).map(|k| Vector(corner(k))).collect();
    let mut chain = membrane(elastic(0.5, 1e6), 0.1, position, (0..15).map(|k| vec![k, k + 1]).collect());
    let hold = |node: u32, axis: usize| SupportSetup {
        nodes: vec![node],
        velocity: std::array::from_fn(|a| (a == axis).then_some(Signal::ZERO)),
    };
    chain.supports = vec![hold(0, 1), hold(15, 0)];
    setup.membranes = vec![chain];
    let mut mpm = start(setup);
    let (mut crossings, mut last) = (Vec::new(), (0.0, 0.0));
    run(&mut mpm, 3.0, 1.0, |t, _, mpm| {
        let surface = &mpm.snapshot().surfaces[0];
        let [right, top] = [surface.position[0][0], surface.position[15][1]];
        if last.0 * (right - top) < 0.0 && t > 0.2 {
            crossings.push(t);
        }
        last = (right - top, t);
    })
    .unwrap();
    let energy = 25.0 * 0.45 * 0.95;
    let lost = ["transfer dissipation", "contact dissipation", "contact mapping loss"].map(|name| term(&mpm, name));
    let loss = (lost.iter().sum::<f64>() - term(&mpm, "stress update error")) / energy;
    let surface = &mpm.snapshot().surfaces[0];
    let radii: Vec<f64> = surface.position.iter().map(|x| x[0].hypot(x[1])).collect();
    let period = 2.0 * (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    assert!(closure(&mpm).abs() < 1e-11 * energy);
    assert!((0.02..0.07).contains(&loss), "lost {loss} of the energy");
    assert!((period / 0.988 - 1.0).abs() < 0.05, "ring mode: {period}, {crossings:?}");
    let mean = radii.iter().sum::<f64>() / radii.len() as f64;
    assert!((mean / 0.9554 - 1.0).abs() < 0.02, "radius {mean}");
}
