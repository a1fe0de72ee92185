//! Bodies on walls and obstacles that they may leave: walls at rest give no energy. The bounds above zero are for the
//! exchange between half steps, and for the inelastic first contact.

use crate::model::*;
use lateen::geometry::Region;
use lateen::material::{EquationsOfState, Fluid, PointLaw, eos};
use lateen::math::{Signal, Vector};
use lateen::mpm::{Kernel, KernelKind, Locking, Mpm, Obstacle, Transfer, WallKind};

/// Shape functions whose slopes vanish with them, and the inertia of an affine velocity is one number.
fn smooth() -> impl Iterator<Item = KernelKind> {
    let is_one = |kind: &KernelKind| {
        let kernel = Kernel::new(*kind, 0.25);
        kernel.is_smooth() && kernel.inertia().is_some()
    };
    KernelKind::ALL.iter().copied().filter(is_one)
}

const RADIUS: f64 = 0.04;
const SPEED: f64 = 2.0;
/// The lowest row of particles, which stops at once, has 1 % of the disc's energy.
const CELL: f64 = 0.005;
/// The heights of floors over a row of nodes [cells].
const OFFSETS: [f64; 7] = [0.0, 0.1, 0.25, 0.4, 0.5, 0.7, 0.9];

/// A soft disc that falls on the bottom of its grid, or on an obstacle with its top at `floor` [m].
fn disc(floor: Option<f64>) -> Mpm<2> {
    let mut grid = grid([0.0, 0.0], CELL, [32, 40], WallKind::Open);
    grid.walls[1][0] = wall(WallKind::Separate);
    let mut setup = setup(grid);
    if let Some(floor) = floor {
        setup.obstacles = vec![Obstacle {
            name: "floor".into(),
            region: Region::Box { lower: [-1.0, -1.0, -1.0], upper: [1.0, floor, 1.0] },
            kind: WallKind::Separate,
            velocity: [const { Signal::ZERO }; 3],
        }];
    }
    let center = Vector([0.08, floor.unwrap_or(0.0) + RADIUS + 0.02]);
    let inside = move |x: Vector<2>| (x - center).norm() < RADIUS;
    setup.bodies =
        vec![body(rubber(1000.0, 1e6, 0.3), ([0.0, floor.unwrap_or(0.0)], [64, 60], 0.5 * CELL), inside, |_| {
            Vector([0.0, -SPEED])
        })];
    start(setup)
}

/// An elastic disc keeps its energy when it bounces, wherever the floor lies between rows of nodes. The floor gives
/// none at any time, and takes that of the nodes which it stops, of about 1 %; the exact rebound has the speed of the
/// impact less that of its vibration.
#[test]
fn a_bouncing_disc_gains_no_energy_from_a_floor_at_any_height() {
    for floor in std::iter::once(None).chain(OFFSETS.map(|offset| Some((6.0 + offset) * CELL))) {
        let mut mpm = disc(floor);
        let energy = term(&mpm, "stored energy at the start");
        let mut least = 0.0_f64;
        run(&mut mpm, 0.05, 1.0, |_, _, mpm| least = least.min(term(mpm, "wall dissipation"))).unwrap();
        let velocity = field(&mpm, "velocity");
        let up = velocity.chunks(3).map(|v| v[1]).sum::<f64>() / (velocity.len() / 3) as f64;
        assert!(up > 0.9 * SPEED, "{floor:?}: it bounces with {up}");
        assert!(least > -1e-3 * energy, "{floor:?}: {least} of {energy}");
        for name in ["wall dissipation", "transfer dissipation", "stress update error"] {
            let term = term(&mpm, name) / energy;
            assert!(term.abs() < 0.02, "{floor:?}, {name}: {term}");
        }
    }
}

fn ways() -> impl Iterator<Item = (Transfer, KernelKind)> {
    [Transfer::Apic, FLIP].into_iter().flat_map(|transfer| smooth().map(move |kernel| (transfer, kernel)))
}

/// A liquid without strength whose particles part.
fn water() -> Box<dyn PointLaw> {
    let eos = EquationsOfState::LinearLiquid(eos::LinearLiquid { sound_speed: 90.0, tensile_strength: 0.0 });
    Box::new(Fluid { density: 1000.0, viscosity: 0.0, bulk_viscosity: Default::default(), eos })
}

/// Kinetic energy, that of affine velocities included, and internal energy [J].
fn energy(mpm: &Mpm<2>, transfer: &Transfer) -> f64 {
    let affine = if *transfer == Transfer::Apic { term(mpm, "affine kinetic energy: body") } else { 0.0 };
    term(mpm, "kinetic energy: body") + term(mpm, "internal energy: body") + affine
}

/// Largest energy over that at the start of water of `count` particles, a `spacing` [cells] apart along the floor, with
/// a `velocity` [m/s] in a box of walls.
fn most_energy(
    kind: WallKind,
    (transfer, kernel): (Transfer, KernelKind),
    (count, spacing): (usize, f64),
    velocity: [f64; 2],
) -> f64 {
    let mut setup = setup(grid([0.0, 0.0], 0.02, [8, 16], kind));
    (setup.transfer, setup.kernel, setup.locking) = (transfer, kernel, Locking::Average { blend: 1.0 });
    setup.bodies = vec![body(water(), ([0.06, 0.0], [count, 1], spacing * 0.02), |_| true, |_| Vector(velocity))];
    let mut mpm = start(setup);
    let (before, mut most) = (energy(&mpm, &transfer), 0.0_f64);
    run(&mut mpm, 0.03, 1.0, |_, _, mpm| most = most.max(energy(mpm, &transfer))).unwrap();
    most / before
}

/// Walls of every kind, and a particle half a `spacing` above the floor. Ghost nodes that extrapolate in full put the
/// force of its pressure on a row of nodes with hardly any mass, and multiply its energy.
#[test]
fn a_single_particle_gains_no_energy_in_a_corner() {
    for kind in [WallKind::Separate, WallKind::Friction { coefficient: 0.3 }, WallKind::Fixed, WallKind::Slip] {
        for way in ways() {
            for spacing in [1e-4, 0.005, 0.05, 0.5] {
                let most = most_energy(kind, way, (1, spacing), [15.0, 0.0]);
                assert!(most < 1.02, "{kind:?} {way:?} {spacing}: {most}");
            }
        }
    }
}

/// A film of one row of particles, a quarter of a cell thick, that runs into a corner.
#[test]
fn a_film_of_one_row_of_particles_gains_no_energy_in_a_corner() {
    for way in ways() {
        let most = most_energy(WallKind::Separate, way, (12, 0.25), [15.0, 0.0]);
        assert!(most < 1.02, "{way:?}: {most}");
    }
}

/// A particle that starts next to the floor with a velocity into it stays above it: the run ends without an error, and
/// its energy doesn't grow.
#[test]
fn a_single_particle_does_not_pass_a_floor() {
    for way in ways() {
        for spacing in [1e-4, 0.005, 0.05, 0.5] {
            let most = most_energy(WallKind::Separate, way, (1, spacing), [2.0, -5.0]);
            assert!(most < 1.02, "{way:?} {spacing}: {most}");
        }
    }
}
