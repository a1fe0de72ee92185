//! The whole step of PFEM-2 for two fluids: what the particles cost, what the mesh costs, and memory.
//!
//! ```text
//! cargo bench --bench flow                         every size, each in a process of its own
//! cargo bench --bench flow -- 2 285 [steps]        285 × 285 squares, 162,450 triangles
//! cargo bench --bench flow -- solid                one fluid with and without an elastic block
//! cargo bench --bench flow -- solid 2 100 [steps]  the same on 100 × 100 squares
//! RAYON_NUM_THREADS=1 cargo bench --bench flow     one core
//! ```
//! A vortex in a unit box with slip walls stirs a heavy fluid (density 3) under a light one; the fastest particles
//! cross two elements per step. Everything that a run does between two outputs is in it: streamlines, reseeding, the
//! level set, assembly, the linear solver, the ledger. The stage *particles* is what `correct`, `convect`,
//! `interface` and `project` take, *mesh* is `solve` and `account`. Times are of the clock.
//!
//! With *solid* the box is full of one fluid, in which an elastic block of a third of its side moves along in the
//! middle of the vortex or doesn't; both have the defaults. The first step, in which patterns are analysed, is told
//! apart. The last line has two ratios: of the steps after the third, and of all steps.

use lateen::case::{Case, Source};
use std::process::Command;
use std::time::Instant;

/// Dimension and cells along each side.
const SIZES: [(usize, usize); 6] = [(2, 100), (2, 285), (2, 570), (3, 20), (3, 37), (3, 55)];

/// The same with and without a solid.
const SOLID_SIZES: [(usize, usize); 4] = [(2, 100), (2, 200), (3, 20), (3, 37)];

/// Sides of the block, off the lines of the mesh.
const SOLID: [f64; 2] = [0.335, 0.665];

/// Elements that the fastest particles cross in a step.
const COURANT: f64 = 2.0;

/// Stages that work on particles; the others work on the mesh.
const PARTICLES: [&str; 4] = ["correct", "convect", "interface", "project"];

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|word| word.parse::<usize>().ok());
    let solid = std::env::args().any(|word| word == "solid");
    match (numbers.next(), numbers.next()) {
        (Some(dimension), Some(cells)) if solid => compare(dimension, cells, numbers.next().unwrap_or(10)),
        (Some(dimension), Some(cells)) => {
            measure(&case(dimension, cells), (dimension, cells), numbers.next().unwrap_or(10));
        }
        _ if solid => SOLID_SIZES.into_iter().for_each(|(dimension, cells)| compare(dimension, cells, 10)),
        _ => {
            println!("{} threads, Courant number {COURANT}", rayon::current_num_threads());
            SIZES.into_iter().for_each(|(dimension, cells)| {
                // A process of its own: the peak of memory is that of one size.
                let program = std::env::current_exe().expect("this program");
                let run = Command::new(program).args([dimension.to_string(), cells.to_string()]).status();
                assert!(run.is_ok_and(|status| status.success()), "{dimension}D with {cells} cells failed");
            });
        }
    }
}

/// Steps with and without a solid.
fn compare(dimension: usize, cells: usize, steps: usize) {
    let [without, with] =
        [false, true].map(|solid| measure(&case_of_one(dimension, cells, solid), (dimension, cells), steps));
    let [later, all] = [with.later / without.later, with.all / without.all];
    println!("    with a solid {later:.2} of the time without; {all:.2} with the first steps");
}

/// Seconds per step.
struct StepTimes {
    /// After the third.
    later: f64,
    /// Of all, with what the first ones prepare.
    all: f64,
}

fn measure(text: &str, (dimension, cells): (usize, usize), steps: usize) -> StepTimes {
    let case = Case::read(Source::new("flow.toml", "", text), &[]).unwrap_or_else(|error| panic!("{error:?}"));
    let model = case.model().unwrap_or_else(|error| panic!("{error:?}"));
    let (elements, unknowns) = (model.summary.cells, model.summary.unknowns as f64);
    let mut solver = model.solver;
    let dt = COURANT / cells as f64;
    // The first steps sort the particles, analyse the pattern and start the second-order step.
    let begin = Instant::now();
    solver.step(0.0, dt).expect("a sound step");
    let first = begin.elapsed().as_secs_f64();
    (1..3).for_each(|step| solver.step(step as f64 * dt, dt).expect("a sound step"));
    let before = solver.stage_times();
    let start = Instant::now();
    let mut iterations = 0;
    for step in 3..3 + steps {
        solver.step(step as f64 * dt, dt).expect("a sound step");
        let counts = solver.snapshot().counts;
        iterations += counts.iter().find(|(name, _)| name == "solver: iterations").map_or(0, |(_, count)| *count);
    }
    let later = start.elapsed().as_secs_f64() / steps as f64;
    let all = begin.elapsed().as_secs_f64() / (3 + steps) as f64;
    let spent = |name: &str, times: &[(&str, f64)]| times.iter().find(|stage| stage.0 == name).map_or(0.0, |s| s.1);
    let after = solver.stage_times();
    let stage = |name: &str| (spent(name, &after) - spent(name, &before)) / steps as f64;
    let particles: f64 = PARTICLES.iter().map(|name| stage(name)).sum();
    let count = solver.particle_count() as f64;
    println!(
        "{dimension}D {elements:8} elements {count:9} particles {unknowns:8} unknowns: particles {:5.0} ns each \
         ({:4.2} M/s), mesh {:5.2} µs per unknown, {:4.1} iterations, {later:6.3} s per step, {first:6.3} s for the first, \
         {:5.0} MB",
        1e9 * particles / count,
        1e-6 * count / particles,
        1e6 * (later - particles) / unknowns,
        iterations as f64 / steps as f64,
        peak(),
    );
    for (name, _) in &after {
        println!("    {name:10} {:8.3} s", stage(name));
    }
    StepTimes { later, all }
}

/// The case file of one fluid, with or without an elastic block in the middle.
fn case_of_one(dimension: usize, cells: usize, solid: bool) -> String {
    let (text, heavy, light) = (case(dimension, cells), "[[body]]\nname = \"heavy\"", "[[body]]\nname = \"light\"");
    let (begin, end) = (text.find(heavy).expect("the first body"), text.find(light).expect("the second"));
    let point = |value: f64| format!("[{}]", vec![value.to_string(); dimension].join(", "));
    let block = format!(
        r#"[[body]]
name = "block"
region = {{ shape = "box", lower = {lower}, upper = {upper} }}
material = {{ law = "st-venant-kirchhoff", density = 1.5, young = 100.0, poisson = 0.3 }}
mesh = {{ cell = {cell} }}
velocity = {vortex}
"#,
        lower = point(SOLID[0]),
        upper = point(SOLID[1]),
        cell = 3.0 / cells as f64,
        vortex = vortex(dimension),
    );
    format!("{}{}{}", &text[..begin], if solid { block.as_str() } else { "" }, &text[end..])
}

/// The case file.
fn case(dimension: usize, cells: usize) -> String {
    let point = |value: &str| format!("[{}]", vec![value; dimension].join(", "));
    let vortex = vortex(dimension);
    let sides = ["\"left\", \"right\", \"bottom\", \"top\"", "\"front\", \"back\", "];
    let below = format!("[{}]", ["2.0", "0.5", "2.0"][..dimension].join(", "));
    format!(
        r#"
name = "flow"
title = "Two fluids in a vortex"
method = "pfem2"
dimension = {dimension}
units = "none"
[time]
end = 1
step = {step}
[mesh]
shape = "box"
lower = {lower}
upper = {upper}
cell = {cell}
[pfem2]
courant = 20
[[body]]
name = "heavy"
region = {{ shape = "box", lower = {minus}, upper = {below} }}
material = {{ law = "newtonian", density = 3.0, viscosity = 1e-3 }}
velocity = {vortex}
[[body]]
name = "light"
region = {{ shape = "box", lower = {minus}, upper = {two} }}
material = {{ law = "newtonian", density = 1.0, viscosity = 1e-3 }}
velocity = {vortex}
[[boundary]]
on = [{third_sides}{first_sides}]
kind = "slip"
"#,
        step = COURANT / cells as f64,
        lower = point("0.0"),
        upper = point("1.0"),
        minus = point("-1.0"),
        two = point("2.0"),
        cell = 1.0 / cells as f64,
        first_sides = sides[0],
        third_sides = if dimension == 3 { sides[1] } else { "" },
    )
}

/// Components of the velocity at the start.
fn vortex(dimension: usize) -> String {
    let third = if dimension == 3 { ", 0" } else { "" };
    format!("[\"-sin(pi*x)*cos(pi*y)\", \"cos(pi*x)*sin(pi*y)\"{third}]")
}

/// Most memory that the process has held [MB]; 0 where the system doesn't tell.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|text| text.trim().trim_end_matches(" kB").trim().parse::<f64>().ok()).map_or(0.0, |kb| kb / 1024.0)
}
