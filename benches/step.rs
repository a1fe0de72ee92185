//! Particle-steps per second of the collapsing water column: 1 × 0.5 × 0.5 m in a tank of 2 × 1 × 0.5 m, eight
//! particles per cell.
//!
//! `cargo bench --bench step -- [thousands of particles] [steps] [a kernel|lian-2014|recommended]`; by
//! default 128 and 1024 thousand with all of them. With the name of a kernel the step is the shortest that the method
//! has (FLIP, stress last, no averaging against locking: two sweeps); the presets are what a case of an inviscid liquid
//! gets. `RAYON_NUM_THREADS=1` gives the rate of one core. The step is all that a run does: sorting, transfers,
//! equation of state, walls, ledger, health check. The column is measured as it begins to fall, and while it flows (a
//! stagnation flow of up to 3 m/s, as in the middle of a collapse), when particles must be sorted again and again.
//!
//! The same process then runs a plain loop over the same column (dense grid, one particle at a time, no sorting, no
//! ledger, one thread) as a yardstick, so that a busy machine still gives a ratio. Its particles lie in an order that
//! has nothing to do with their places, which is what a code that never sorts ends with (*unsorted*, the ratio that
//! counts), or row by row, as the lattice was made: a sorted order.
//!
//! Stages are compared with the time in which the memory of this machine could move what they must read and write of
//! the particles (triad in the same process).

mod stream;
mod yardstick;

use lateen::material::eos::{EquationsOfState, LinearLiquid};
use lateen::material::{BulkViscosity, Fluid, StartState};
use lateen::math::{Signal, Vector};
use lateen::mpm::{
    BodySetup, Dissipation, Friction, GridSetup, KernelKind, Locking, Mpm, Setup, SheetContact, StressUpdate, Transfer,
    Wall, WallKind,
};
use lateen::simulation::Solver;
use std::process::Command;
use std::time::Instant;
use yardstick::{Column, Order};

/// Density [kg/m³] and speed of sound [m/s] of the water: ten times the speed of the front.
const WATER: (f64, f64) = (1000.0, 44.0);
const GRAVITY: f64 = -9.81;

/// The choices of a step.
#[derive(Debug, Clone)]
struct Choice {
    name: String,
    kernel: KernelKind,
    transfer: Transfer,
    stress_update: StressUpdate,
    locking: Locking,
}

const FLIP: Transfer = Transfer::Flip { relaxation: 0.05, filter_order: 0, filter_interval: 0 };

/// The shortest step with each kernel.
fn short(name: &str, kernel: KernelKind) -> Choice {
    Choice { name: name.to_owned(), kernel, transfer: FLIP, stress_update: StressUpdate::Last, locking: Locking::None }
}

/// The measured steps: the shortest one with each kernel, then the presets for liquids.
fn choices() -> Vec<Choice> {
    let kernels = KernelKind::ALL.iter().map(|&kernel| short(&format!("{kernel:?}").to_lowercase(), kernel));
    let presets = [
        Choice { stress_update: StressUpdate::First, ..short("lian-2014", KernelKind::Linear) },
        Choice {
            transfer: Transfer::Apic,
            stress_update: StressUpdate::Average,
            locking: Locking::Average { blend: 1.0 },
            ..short("recommended", KernelKind::Quadratic)
        },
    ];
    kernels.chain(presets).collect()
}

/// Bytes of a particle's columns that a stage reads or writes (a write of what was not read counts twice): position,
/// velocity, mass, volume and pressure for the scatter; these and the energy, back again without the mass, with the
/// wave speed and the volume ratio, for the gather.
const BYTES: [(&str, f64); 2] = [("p2g", 72.0), ("g2p", 80.0 + 72.0 + 32.0)];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let sizes = arguments.first().and_then(|a| a.parse().ok()).map_or(vec![128, 1024], |size: usize| vec![size]);
    let steps: usize = arguments.get(1).and_then(|a| a.parse().ok()).unwrap_or(30);
    if let Some(only) = arguments.get(2) {
        let choice = choices().into_iter().find(|choice| choice.name == *only).expect("a kernel or a preset");
        return measure(sizes[0], steps, &choice);
    }
    println!("{} threads", rayon::current_num_threads());
    println!("triad: {:.1} GB per processor second of one core", stream::triad() * 1e-9);
    for size in sizes {
        for Choice { name, .. } in choices() {
            // A process of its own: memory that an earlier measurement has freed would hide that of this one.
            let program = std::env::current_exe().expect("this program");
            let run = Command::new(program).args([size.to_string(), steps.to_string(), name.clone()]).status();
            assert!(run.is_ok_and(|status| status.success()), "{name} failed");
        }
    }
}

/// Cells along the height of half a metre for so many thousand particles: 4 h³ cells of 8 particles.
fn cells(thousands: usize) -> usize {
    (thousands as f64 * 1000.0 / 16.0).cbrt().round() as usize
}

fn measure(thousands: usize, steps: usize, choice: &Choice) {
    let (name, kernel) = (&choice.name, choice.kernel);
    let n = cells(thousands);
    let before = resident_bytes();
    let (mpm, still) = run(setup(n, choice, 0.0), steps);
    let count = mpm.particle_count();
    let bytes = (resident_bytes() - before) / count as f64;
    println!("{name}, {count} particles, {bytes:.0} bytes each");
    println!("  begins to fall: {still}");
    let limit = 1e9 / stream::triad();
    let total: f64 = still.stages.iter().map(|(_, s)| s).sum();
    for &(stage, seconds) in still.stages.iter().filter(|(_, seconds)| *seconds > 0.001 * total) {
        let fraction = seconds / total;
        let ns = fraction * 1e3 / still.per_processor;
        let moved = BYTES.iter().find(|entry| entry.0 == stage).map(|(_, bytes)| (bytes, ns / (bytes * limit)));
        let moved = moved
            .map_or(String::new(), |(bytes, times)| format!("  {bytes:3.0} bytes, {times:.1} times the memory limit"));
        println!("    {stage:10} {ns:6.1} ns  {:4.1} %{moved}", 100.0 * fraction);
    }
    let dt = mpm.stable_dt();
    drop(mpm);
    println!("  flows: {}", run(setup(n, choice, 3.0), 2 * steps).1);
    if !["linear", "quadratic"].contains(&name.as_str()) {
        return;
    }
    for (name, order) in [("unsorted", Order::Mixed), ("row by row", Order::RowByRow)] {
        let mut column = Column::new(n, kernel, (WATER, GRAVITY), order);
        column.step(dt);
        let (idle, plain) = (processor_seconds(), (steps / 3).max(2));
        (0..plain).for_each(|_| column.step(dt));
        let plain = (count * plain) as f64 / (processor_seconds() - idle) * 1e-6;
        println!("  plain loop, {name}: {plain:.2} per processor second; ratio {:.2}", still.per_processor / plain);
    }
}

/// Million particle-steps per second and per processor second, and the time of each stage [s].
struct Rate {
    per_second: f64,
    per_processor: f64,
    stages: Vec<(&'static str, f64)>,
}

impl std::fmt::Display for Rate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { per_second, per_processor, .. } = self;
        write!(f, "{per_second:.2} million particle-steps/s ({per_processor:.2} per processor second)")
    }
}

/// Runs a few steps to warm up (the first one sorts), then measures.
fn run(setup: Setup<3>, steps: usize) -> (Mpm<3>, Rate) {
    let mut mpm = Mpm::new(setup).expect("a valid column");
    let dt = mpm.stable_dt();
    let mut t = 0.0;
    let mut advance = |mpm: &mut Mpm<3>, steps: usize| {
        for _ in 0..steps {
            mpm.step(t, dt).expect("a sound step");
            t += dt;
        }
    };
    advance(&mut mpm, 3);
    let (start, idle, warm) = (Instant::now(), processor_seconds(), mpm.stage_times());
    advance(&mut mpm, steps);
    let (wall, busy) = (start.elapsed().as_secs_f64(), processor_seconds() - idle);
    let rate = |seconds: f64| (mpm.particle_count() * steps) as f64 / seconds * 1e-6;
    let stages = mpm.stage_times().into_iter().zip(warm).map(|((name, after), (_, before))| (name, after - before));
    let rate = Rate { per_second: rate(wall), per_processor: rate(busy), stages: stages.collect() };
    (mpm, rate)
}

/// The column, with cells of 0.5/n m, spreading at `speed` [m/s] at its foot and sinking as fast as it spreads.
fn setup(n: usize, choice: &Choice, speed: f64) -> Setup<3> {
    let &Choice { kernel, transfer, stress_update, locking, .. } = choice;
    let cell = 0.5 / n as f64;
    let position = lattice(n);
    let law = Fluid {
        density: WATER.0,
        viscosity: 0.0,
        bulk_viscosity: BulkViscosity([0.0, 0.0]),
        eos: EquationsOfState::LinearLiquid(LinearLiquid { sound_speed: WATER.1, tensile_strength: 0.0 }),
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
        transfer,
        dissipation: Dissipation::Lost,
        stress_update,
        locking,
        safety: 0.3,
        membrane_safety: 0.8,
        max_substeps: 1,
        contact_passes: 2,
        gravity: [Signal::ZERO, Signal::ZERO, Signal::Constant(GRAVITY)],
        bodies: vec![BodySetup {
            name: "water".into(),
            law: Box::new(law),
            group: 0,
            skin: Vec::new(),
            depth: Vec::new(),
            volume: vec![(0.5 * cell).powi(3); position.len()],
            velocity: position.iter().map(|x| Vector([speed * x[0], 0.0, -speed * x[2]])).collect(),
            velocity_gradient: Vec::new(),
            state: vec![StartState::default(); position.len()],
            traction: Vec::new(),
            ambient: 0.0,
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
