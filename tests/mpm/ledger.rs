//! Ledger and momentum close to round-off, whatever the configuration.

use crate::model::*;
use lateen::geometry::Region;
use lateen::math::{Signal, Tensor, Vector};
use lateen::mpm::{KernelKind, Load, Locking, Mpm, Obstacle, Setup, StressUpdate, Traction, Transfer, WallKind};
use lateen::simulation::Solver;

/// A block thrown into a corner of the box, hard enough to load every wall that it meets.
fn thrown(kernel: KernelKind, transfer: Transfer, stress_update: StressUpdate, kind: WallKind) -> Mpm<2> {
    let mut setup = setup(grid([0.0, 0.0], 0.25, [8, 8], kind));
    (setup.kernel, setup.transfer, setup.stress_update) = (kernel, transfer, stress_update);
    setup.locking = Locking::Average { blend: 0.8 };
    setup.gravity = [Signal::Constant(1.0), Signal::Constant(-10.0)];
    let velocity = |x: Vector<2>| Vector([-1.0 + 0.2 * x[1], -2.0]);
    let mut block = body(rubber(10.0, 1e4, 0.3), ([0.1, 0.4], [8, 8], 0.125), |_| true, velocity);
    let value = [50.0, 20.0, 0.0].map(Signal::Constant);
    block.traction = vec![Traction { particle: 3, load: Load::Dead { value, area: 0.125 } }];
    setup.bodies = vec![block];
    setup.obstacles = vec![step_in_the_corner()];
    start(setup)
}

fn step_in_the_corner() -> Obstacle {
    Obstacle {
        name: "step".into(),
        region: Region::Box { lower: [1.0, -1.0, -1.0], upper: [3.0, 0.3, 1.0] },
        kind: WallKind::Friction { coefficient: 0.3 },
        velocity: [Signal::Constant(-0.2), Signal::ZERO, Signal::ZERO],
    }
}

/// A wedge whose face meets the symmetry plane at the bottom at an angle.
fn wedge(kind: WallKind) -> Obstacle {
    let region = Region::HalfSpace { point: [1.0, 0.0, 0.0], normal: [-0.6, 0.8, 0.0] };
    Obstacle { name: "wedge".into(), region, kind, velocity: [const { Signal::ZERO }; 3] }
}

/// Closure within 1e-12 of the energies that moved; momentum within 1e-12 of the impulses.
fn check(mut mpm: Mpm<2>, momentum_too: bool, what: &str) {
    let names = ["momentum x", "momentum y"];
    let before = names.map(|name| term(&mpm, name));
    run(&mut mpm, 0.25, 0.9, |_, _, _| {}).unwrap_or_else(|error| panic!("{what}: {error}"));
    let scale = term(&mpm, "stored energy at the start");
    let closure = closure(&mpm);
    assert!(closure.abs() < 1e-12 * scale, "{what}: closure {closure} of {scale}");
    for (axis, (name, before)) in names.iter().zip(before).enumerate() {
        let impulse = term(&mpm, ["external impulse x", "external impulse y"][axis]);
        let defect = term(&mpm, name) - before - impulse;
        assert!(!momentum_too || defect.abs() < 1e-12 * 20.0, "{what}: {name} {before} + {impulse}, defect {defect}");
    }
}

const WALLS: [WallKind; 4] =
    [WallKind::Fixed, WallKind::Slip, WallKind::Separate, WallKind::Friction { coefficient: 0.4 }];

#[test]
fn energy_and_momentum_close_for_every_kernel_transfer_and_wall() {
    let damped = Transfer::Flip { relaxation: 0.02, filter_order: 0, filter_interval: 0 };
    for &kernel in KERNELS {
        for transfer in [FLIP, damped, Transfer::Apic] {
            for kind in WALLS {
                let mpm = thrown(kernel, transfer, StressUpdate::Average, kind);
                check(mpm, true, &format!("{kernel:?} {transfer:?} {kind:?}"));
            }
        }
    }
}

/// The face of an obstacle meets a symmetry plane at an angle, which takes a part of its impulses.
#[test]
fn energy_and_momentum_close_where_an_obstacle_meets_a_symmetry_plane() {
    let rough = WallKind::Friction { coefficient: 0.3 };
    for transfer in [FLIP, Transfer::Apic] {
        for kind in [rough, WallKind::Fixed, WallKind::Slip] {
            let mut setup = setup(grid([0.0, 0.0], 0.25, [8, 8], WallKind::Slip));
            setup.transfer = transfer;
            setup.gravity = [Signal::ZERO, Signal::Constant(-10.0)];
            let thrown = |_: Vector<2>| Vector([1.0, -2.0]);
            setup.bodies = vec![body(rubber(10.0, 1e4, 0.3), ([0.0, 0.05], [8, 8], 0.125), |x| x[0] < 0.9, thrown)];
            setup.obstacles = vec![wedge(kind)];
            check(start(setup), true, &format!("{transfer:?} {kind:?}"));
        }
    }
}

#[test]
fn energy_and_momentum_close_for_every_stress_update() {
    for stress_update in [StressUpdate::First, StressUpdate::ModifiedLast, StressUpdate::Average, StressUpdate::Last] {
        for kind in [WallKind::Slip, WallKind::Fixed] {
            let mpm = thrown(KernelKind::Quadratic, FLIP, stress_update, kind);
            check(mpm, true, &format!("{stress_update:?} {kind:?}"));
        }
    }
}

/// A vibrating body in free flight keeps its momentum to rounding. The energy that transfers and stress updates book
/// has no reference but the energy that there is, which it stays below. Rows of particles lie on planes of nodes.
#[test]
fn free_flight_conserves_momentum_and_books_less_than_its_energy() {
    for &kernel in KERNELS {
        for stress_update in [StressUpdate::First, StressUpdate::ModifiedLast, StressUpdate::Average] {
            for lower in [0.75, 0.6875, 0.7] {
                let mut setup = setup(grid([0.0, 0.0], 0.25, [16, 12], WallKind::Open));
                (setup.kernel, setup.stress_update) = (kernel, stress_update);
                let velocity = |x: Vector<2>| Vector([2.0 + (3.0 * x[1]).sin(), 0.5 * (4.0 * x[0]).sin()]);
                let disc = |x: Vector<2>| (x - Vector([1.25, 1.25])).norm() < 0.5;
                let lattice = ([lower; 2], [8, 8], 0.125);
                setup.bodies = vec![body(rubber(10.0, 2e3, 0.3), lattice, disc, velocity)];
                free_flight(setup, &format!("{kernel:?} {stress_update:?} {lower}"));
            }
        }
    }
}

/// Lets a body fly for a second.
fn free_flight(setup: Setup<2>, what: &str) {
    let names = ["momentum x", "momentum y"];
    let mut mpm = start(setup);
    let before = names.map(|name| term(&mpm, name));
    run(&mut mpm, 1.0, 1.0, |_, _, _| {}).unwrap_or_else(|error| panic!("{what}: {error}"));
    for (name, before) in names.iter().zip(before) {
        let change = term(&mpm, name) - before;
        assert!(change.abs() < 1e-12 * 20.0, "{what}: {name} {before} + {change}");
    }
    let energy = term(&mpm, "stored energy at the start");
    assert!(closure(&mpm).abs() < 1e-12 * energy, "{what}: closure {}", closure(&mpm));
    for name in ["transfer dissipation", "stress update error"] {
        let booked = term(&mpm, name);
        assert!(booked.abs() < energy, "{what}: {name} {booked} of {energy}");
    }
}

/// The filter takes energy and, without walls, no momentum.
#[test]
fn the_filter_conserves_momentum_and_its_loss_is_booked() {
    let filtered = Transfer::Flip { relaxation: f64::INFINITY, filter_order: 3, filter_interval: 5 };
    let mut setup = setup(grid([0.0, 0.0], 0.25, [12, 12], WallKind::Open));
    setup.transfer = filtered;
    let velocity = |x: Vector<2>| Vector([0.3 - (7.0 * x[1]).sin(), (9.0 * x[0]).cos()]);
    setup.bodies = vec![body(rubber(10.0, 2e3, 0.3), ([1.0, 1.0], [8, 8], 0.125), |_| true, velocity)];
    let mut mpm = start(setup);
    let before = ["momentum x", "momentum y"].map(|name| term(&mpm, name));
    run(&mut mpm, 0.3, 1.0, |_, _, _| {}).unwrap();
    for (name, before) in ["momentum x", "momentum y"].iter().zip(before) {
        assert!((term(&mpm, name) - before).abs() < 1e-12 * 10.0);
    }
    assert!(term(&mpm, "transfer dissipation") > 0.0);
    assert!(closure(&mpm).abs() < 1e-12 * term(&mpm, "stored energy at the start"));
}

/// The impulses of walls of every kind on filtered velocities are booked, with the work of moving walls; forces times
/// steps add up to them.
#[test]
fn work_and_forces_of_walls_on_filtered_velocities_are_booked() {
    for &kernel in KERNELS {
        for kind in WALLS {
            for (filter_order, speed) in [(1, 0.0), (2, 0.0), (3, 0.4)] {
                let transfer = Transfer::Flip { relaxation: f64::INFINITY, filter_order, filter_interval: 4 };
                let what = format!("{kernel:?} {kind:?} {filter_order} {speed}");
                check(filtered(kernel, transfer, kind, speed), true, &what);
                let mut mpm = filtered(kernel, transfer, kind, speed);
                let (mut impulse, mut before) = (Vector::<3>::ZERO, 0.0);
                run(&mut mpm, 0.25, 0.9, |_, dt, mpm| {
                    let forces = mpm.snapshot().forces;
                    let walls = forces.iter().filter(|(name, _)| !name.starts_with("contact"));
                    impulse -= walls.map(|(_, force)| Vector(*force)).sum::<Vector<3>>() * (0.5 * (before + dt));
                    before = dt;
                })
                .unwrap();
                for (axis, name) in ["external impulse x", "external impulse y"].into_iter().enumerate() {
                    let booked = term(&mpm, name);
                    assert!((impulse[axis] - booked).abs() < 1e-12 * 20.0, "{what}: {} of {booked}", impulse[axis]);
                }
            }
        }
    }
}

/// A block thrown at a step in a corner whose left wall moves, without other forces.
fn filtered(kernel: KernelKind, transfer: Transfer, kind: WallKind, speed: f64) -> Mpm<2> {
    let mut setup = setup(grid([0.0, 0.0], 0.25, [8, 8], kind));
    (setup.kernel, setup.transfer) = (kernel, transfer);
    setup.grid.walls[0][0].velocity[0] = Signal::Constant(speed);
    let velocity = |x: Vector<2>| Vector([-1.0 + (7.0 * x[1]).sin(), -2.0]);
    setup.bodies = vec![body(rubber(10.0, 1e4, 0.3), ([0.1, 0.1], [8, 8], 0.125), |_| true, velocity)];
    setup.obstacles = vec![step_in_the_corner()];
    start(setup)
}

/// A block dragged by a moving floor: the floor's work is energy gained and friction lost.
#[test]
fn a_moving_floor_does_the_work_of_coulombs_friction() {
    let mut setup = setup(grid([0.0, 0.0], 0.25, [16, 8], WallKind::Open));
    setup.grid.walls[1][0] = wall(WallKind::Friction { coefficient: 0.5 });
    setup.grid.walls[1][0].velocity[0] = Signal::Constant(2.0);
    setup.gravity = [Signal::ZERO, Signal::Constant(-10.0)];
    setup.bodies = vec![body(rubber(10.0, 1e4, 0.3), ([1.0, 0.0], [8, 8], 0.125), |_| true, |_| Vector::ZERO)];
    let mut mpm = start(setup);
    run(&mut mpm, 0.3, 1.0, |_, _, _| {}).unwrap();
    let speed = term(&mpm, "momentum x") / term(&mpm, "mass");
    assert!((speed - 0.5 * 10.0 * 0.3).abs() < 0.05, "Coulomb acceleration μ g t: {speed}");
    let (work, lost) = (term(&mpm, "work of walls"), term(&mpm, "wall dissipation"));
    let weight = 10.0 * term(&mpm, "mass");
    assert!((work / (0.5 * weight * 2.0 * 0.3) - 1.0).abs() < 0.05, "work of the floor μ m g v t: {work}");
    assert!(lost > 0.0 && lost < work);
    assert!(closure(&mpm).abs() < 1e-12 * work);
}

/// Spin ω has C:C = 2 ω², and quadratic splines the inertia h²/4: ½ m h²/4 · 2 ω².
#[test]
fn a_spinning_block_of_affine_particles_has_their_kinetic_energy() {
    let (cell, spin, centre) = (0.25, 3.0, Vector([1.0, 1.0]));
    let mut setup = setup(grid([0.0, 0.0], cell, [8, 8], WallKind::Open));
    setup.transfer = Transfer::Apic;
    let turning = |x: Vector<2>| Vector([-(x[1] - centre[1]), x[0] - centre[0]]) * spin;
    let mut block = body(rubber(2.0, 1e3, 0.3), ([0.5, 0.5], [8, 8], 0.125), |_| true, turning);
    block.velocity_gradient = vec![Tensor([[0.0, -spin], [spin, 0.0]]); block.position.len()];
    setup.bodies = vec![block];
    let mpm = start(setup);
    let ledger = mpm.snapshot().ledger;
    let energy = ledger.terms.iter().find(|term| term.name.starts_with("affine kinetic energy")).unwrap().value;
    let exact = term(&mpm, "mass") * (0.5 * cell * spin).powi(2);
    assert!((energy / exact - 1.0).abs() < 1e-9, "{energy} {exact}");
}
