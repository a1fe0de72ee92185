//! Element-steps per second of a membrane alone: a clamped, pressurised square sheet of quadrilaterals.
//!
//! `cargo bench --bench membrane -- [elements per side] [steps] [law]`, by default 1000 × 1000 elements (one million),
//! 20 steps, `elastic` (or `wrinkling`, `neo-hookean`). One thread per core; set `RAYON_NUM_THREADS=1` for the rate of
//! one core. A fourth argument is the pressure [Pa], 0 by default.

use lateen::material::Sheet;
use lateen::material::sheet::{Elastic, NeoHookean};
use lateen::math::{Signal, Vector};
use lateen::mpm::{Membrane, MembraneSetup, SupportSetup};
use std::time::{Duration, Instant};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let number = |i: usize, default: usize| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (n, steps) = (number(0, 1000), number(1, 20));
    let law = arguments.get(2).map_or("elastic", String::as_str);
    let mut membrane = sheet(n, law, number(3, 0) as f64);
    let dt = 0.8 * membrane.stable_dt();
    let mut stages = [Duration::ZERO; 3];
    let (mut t, idle) = (0.0, processor_time());
    for _ in 0..steps {
        let start = Instant::now();
        membrane.internal_force(t).expect("a sound step");
        let forces = Instant::now();
        membrane.advance_velocity(t, dt);
        let velocity = Instant::now();
        membrane.move_nodes(t, dt);
        t += dt;
        stages[0] += forces - start;
        stages[1] += velocity - forces;
        stages[2] += velocity.elapsed();
    }
    report(n * n * steps, law, stages);
    if let (Some(before), Some(after)) = (idle, processor_time()) {
        println!("  processor time    {:5.1} ns", (after - before) / (n * n * steps) as f64 * 1e9);
    }
    println!("deflection of the centre {:.9e} m", membrane.position[(n + 1) * n / 2 + n / 2][2]);
}

/// Processor time of this process [s], where the system tells: on a busy machine it says more than the clock.
fn processor_time() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let user: f64 = stat.rsplit(')').next()?.split_whitespace().nth(11)?.parse().ok()?;
    Some(user / 100.0)
}

/// Prints the rate and where the time went.
fn report(element_steps: usize, law: &str, stages: [Duration; 3]) {
    let seconds: f64 = stages.iter().map(Duration::as_secs_f64).sum();
    let (rate, threads) = (element_steps as f64 / seconds, rayon::current_num_threads());
    println!("{law}: {:.2} million element-steps/s on {threads} threads, {:.1} ns each", rate * 1e-6, 1e9 / rate);
    for (name, stage) in ["forces", "velocity", "ledger and motion"].iter().zip(stages) {
        println!("  {name:17} {:5.1} ns", stage.as_secs_f64() / element_steps as f64 * 1e9);
    }
}

/// A square sheet of n × n elements with clamped edges under a follower pressure.
fn sheet(n: usize, law: &str, pressure: f64) -> Membrane<3> {
    let side = n + 1;
    let at = |i: usize, j: usize| (j * side + i) as u32;
    let position: Vec<_> =
        (0..side * side).map(|k| Vector([(k % side) as f64 * 1e-3, (k / side) as f64 * 1e-3, 0.0])).collect();
    let cell = |k: usize| (k % n, k / n);
    let corners = |(i, j): (usize, usize)| vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
    let edge = (0..side * side).filter(|k| [0, n].contains(&(k % side)) || [0, n].contains(&(k / side)));
    let velocity = std::array::from_fn(|_| Some(Signal::ZERO));
    let sheet: Box<dyn Sheet> = match law {
        "neo-hookean" => Box::new(NeoHookean { density: 1000.0, shear: 1e6, poisson: 0.5, wrinkling: false }),
        law => Box::new(Elastic { density: 1000.0, young: 1e9, poisson: 0.3, wrinkling: law == "wrinkling" }),
    };
    let setup = MembraneSetup {
        name: "sheet".into(),
        sheet,
        velocity: vec![Vector([0.0, 0.0, 1.0]); position.len()],
        position,
        elements: (0..n * n).map(|k| corners(cell(k))).collect(),
        warp: Vec::new(),
        thickness: 1e-4,
        prestress: [1e6; 2],
        hourglass: [0.05, 0.0, 0.01],
        damping: [0.0; 2],
        supports: vec![SupportSetup { nodes: edge.map(|k| k as u32).collect(), velocity }],
        pressure: Signal::Constant(pressure),
        follower: true,
        contact_thickness: true,
    };
    Membrane::new(setup).expect("a valid sheet")
}
