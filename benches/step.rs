//! Particle-steps per second of the collapsing water column: 1 × 0.5 × 0.5 m in a tank of 2 × 1 × 0.5 m, eight
//! particles per cell.
//!
//! `cargo bench --bench step -- [thousands of particles] [steps] [linear|quadratic]`; by default 128 and 1024 thousand
//! with both kernels. `RAYON_NUM_THREADS=1` gives the rate of one core. The step is all that a run does: sorting,
//! transfers, equation of state, walls, ledger, health check. The same process then runs a plain loop over the same
//! column (dense grid, one particle at a time, no sorting, no books, one thread) as a yardstick, so that a busy machine
//! still gives a ratio: once in the order in which the lattice was made, which is a sorted one, and once mixed.

mod yardstick;

use lateen::material::eos::{EquationsOfState, Linear};
use lateen::material::{BulkViscosity, Fluid, StartState};
use lateen::math::{Signal, Vector};
use lateen::mpm::{
    BodySetup, Friction, GridSetup, KernelKind, Locking, Mpm, Setup, SheetContact, StressUpdate, Transfer, Wall,
    WallKind,
};
use lateen::simulation::Solver;
use std::time::Instant;
use yardstick::{Column, Order};

/// Density [kg/m³] and speed of sound [m/s] of the water: ten times the speed of the front.
const WATER: (f64, f64) = (1000.0, 44.0);
const GRAVITY: f64 = -9.81;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let sizes = arguments.first().and_then(|a| a.parse().ok()).map_or(vec![128, 1024], |size: usize| vec![size]);
    let steps = arguments.get(1).and_then(|a| a.parse().ok()).unwrap_or(30);
    let only = arguments.get(2).map(String::as_str);
    println!("{} threads", rayon::current_num_threads());
    for size in sizes {
        for (name, kernel) in [("linear", KernelKind::Linear), ("quadratic", KernelKind::Quadratic)] {
            if only.is_none_or(|only| only == name) {
                measure(size, steps, name, kernel);
            }
        }
    }
}

/// Cells along the height of half a metre for so many thousand particles: 4 h³ cells of 8 particles.
fn cells(thousands: usize) -> usize {
    (thousands as f64 * 1000.0 / 16.0).cbrt().round() as usize
}

fn measure(thousands: usize, steps: usize, name: &str, kernel: KernelKind) {
    let n = cells(thousands);
    let before = resident_bytes();
    let mut mpm = Mpm::new(setup(n, kernel)).expect("a valid column");
    let count = mpm.particle_count();
    let dt = mpm.stable_dt();
    let mut t = 0.0;
    let mut advance = |steps: usize| {
        for _ in 0..steps {
            mpm.step(t, dt).expect("a sound step");
            t += dt;
        }
    };
    advance(3);
    let (start, idle) = (Instant::now(), processor_seconds());
    advance(steps);
    let (wall, busy) = (start.elapsed().as_secs_f64(), processor_seconds() - idle);
    let rate = |seconds: f64| (count * steps) as f64 / seconds * 1e-6;
    let bytes = (resident_bytes() - before) / count as f64;
    println!(
        "{name}, {count} particles: {:.2} million particle-steps/s ({:.2} per processor second), {bytes:.0} bytes per particle",
        rate(wall),
        rate(busy)
    );
    let total: f64 = mpm.stage_times().iter().map(|(_, s)| s).sum();
    for (stage, seconds) in mpm.stage_times() {
        let steps = (steps + 3) as f64;
        println!("  {stage:10} {:6.1} ns  {:4.1} %", seconds / (count as f64 * steps) * 1e9, 100.0 * seconds / total);
    }
    for (name, order) in [("rows of the lattice", Order::Lattice), ("mixed order", Order::Mixed)] {
        let mut column = Column::new(n, kernel, (WATER, GRAVITY), order);
        column.step(dt);
        let (idle, plain) = (processor_seconds(), (steps / 3).max(2));
        (0..plain).for_each(|_| column.step(dt));
        let plain = (count * plain) as f64 / (processor_seconds() - idle) * 1e-6;
        println!("  plain loop, {name}: {plain:.2} million per processor second; ratio {:.2}", rate(busy) / plain);
    }
}

/// The column, with cells of 0.5/n m.
fn setup(n: usize, kernel: KernelKind) -> Setup<3> {
    let cell = 0.5 / n as f64;
    let position = lattice(n);
    let law = Fluid {
        density: WATER.0,
        viscosity: 0.0,
        bulk_viscosity: BulkViscosity([0.0, 0.0]),
        eos: EquationsOfState::Linear(Linear { sound_speed: WATER.1, tensile_strength: 0.0 }),
    };
    let wall = || Wall { kind: WallKind::Slip, velocity: Default::default() };
    Setup {
        grid: GridSetup {
            lower: Vector::ZERO,
            cell,
            cells: [4 * n as i32, n as i32, 2 * n as i32],
            walls: std::array::from_fn(|_| [wall(), wall()]),
        },
        kernel,
        transfer: Transfer::Flip { relaxation: 0.05, filter_order: 0, filter_interval: 0 },
        stress_update: StressUpdate::Last,
        locking: Locking::None,
        safety: 0.3,
        membrane_safety: 0.8,
        max_substeps: 1,
        contact_passes: 2,
        gravity: [Signal::ZERO, Signal::ZERO, Signal::Constant(GRAVITY)],
        bodies: vec![BodySetup {
            name: "water".into(),
            law: Box::new(law),
            group: 0,
            depth: Vec::new(),
            volume: vec![(0.5 * cell).powi(3); position.len()],
            velocity: vec![Vector::ZERO; position.len()],
            state: vec![StartState::default(); position.len()],
            traction: Vec::new(),
            position,
        }],
        membranes: Vec::new(),
        obstacles: Vec::new(),
        friction: Vec::new(),
        default_friction: Friction::Slip(0.0),
        sheet_contact: SheetContact::Nodes,
        gap_tolerance: 0.0,
    }
}

/// Particles of the column, two per cell and axis, x fastest.
pub fn lattice(n: usize) -> Vec<Vector<3>> {
    let spacing = 0.25 / n as f64;
    let (nx, ny, nz) = (4 * n, 2 * n, 2 * n);
    let at = |i: usize| (i as f64 + 0.5) * spacing;
    (0..nx * ny * nz).map(|p| Vector([at(p % nx), at(p / nx % ny), at(p / (nx * ny))])).collect()
}

/// Processor time of this process [s].
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}

/// Memory of this process [bytes].
fn resident_bytes() -> f64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    statm.split_whitespace().nth(1).and_then(|pages| pages.parse::<f64>().ok()).unwrap_or(0.0) * 4096.0
}
