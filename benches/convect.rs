//! Particles that PFEM-2 moves, projects and corrects per second:
//! `RAYON_NUM_THREADS=1 cargo bench --bench convect -- 163000 [steps]`, or without a number for all sizes in 2D.
//!
//! A vortex in the unit square (turned about the z axis in the unit cube) carries 15 particles per triangle or 20 per
//! tetrahedron; the fastest of them cross `COURANT` elements in a step. Every stage shows its best processor time,
//! because other work on the machine only ever adds to it.

use lateen::math::Vector;
use lateen::mesh::Mesh;
use lateen::pfem2::boundary::BoundaryKind;
use lateen::pfem2::particles::Particles;
use lateen::pfem2::particles::convect::{Flow, Streamlines};
use lateen::pfem2::particles::correct::Correction;
use lateen::pfem2::particles::project::{AveragingKernel, project};
use std::f64::consts::PI;

/// Elements that the fastest particles cross in a step.
const COURANT: f64 = 1.0;

fn vortex<const D: usize>(x: Vector<D>) -> Vector<D> {
    let (sx, cx, sy, cy) = ((PI * x[0]).sin(), (PI * x[0]).cos(), (PI * x[1]).sin(), (PI * x[1]).cos());
    let mut v = Vector::ZERO;
    (v[0], v[1]) = (-sx * cy, cx * sy);
    v
}

/// Processor time of all threads [s], as Linux counts it.
fn processor_time() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("this bench reads the times of Linux");
    let times = tasks.flatten().filter_map(|task| std::fs::read_to_string(task.path().join("schedstat")).ok());
    times.filter_map(|text| text.split_whitespace().next()?.parse::<f64>().ok()).sum::<f64>() * 1e-9
}

/// Best seconds of moving, projecting and correcting, and the number of particles.
fn measure<const D: usize, const N: usize>(cells: usize, per_edge: usize, steps: usize) {
    let mesh = Mesh::<D, N>::block(Vector::ZERO, Vector::splat(1.0), [cells; D]).expect("a block");
    let velocity: Vec<Vector<D>> = mesh.nodes().iter().map(|&x| vortex(x)).collect();
    let boundary = vec![BoundaryKind::Slip; mesh.boundary().len()];
    let mut particles = Particles::seed(&mesh, per_edge, |x| Some(u8::from(x[1] > 0.5)), vortex);
    let increment: Vec<Vector<D>> = velocity.iter().map(|&v| v * 1e-3).collect();
    let dt = COURANT / cells as f64;
    let mut best = [f64::INFINITY; 3];
    for _ in 0..steps {
        let flow = Flow { velocity: &velocity, boundary: &boundary, projectiles: None };
        let start = processor_time();
        particles.convect(&Streamlines::new(&mesh, &flow), dt);
        let moved = processor_time() - start;
        let volume = |e: usize| mesh.simplex(e).volume;
        let projected = project(&mesh, &particles, &[3.0, 1.0], AveragingKernel::Linear, &velocity, &volume);
        let seen = processor_time() - start;
        let correction = Correction {
            increment: &[&increment, &increment],
            velocity: &projected.velocity.mean,
            filter: 0.01,
            projectiles: None,
        };
        particles.correct(&mesh, &correction);
        let all = processor_time() - start;
        let stages = [moved, seen - moved, all - seen];
        best.iter_mut().zip(stages).for_each(|(best, stage)| *best = best.min(stage));
    }
    let (count, elements) = (particles.len() as f64, mesh.elements().len());
    let each = best.map(|seconds| 1e9 * seconds / count);
    let all: f64 = each.iter().sum();
    println!(
        "{D}D {elements:8} elements {count:10} particles: move {:5.1}, project {:5.1}, correct {:5.1} ns each; {:5.2} M/s",
        each[0],
        each[1],
        each[2],
        1e3 / all
    );
}

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|word| word.parse::<usize>().ok());
    let (wanted, steps) = (numbers.next(), numbers.next().unwrap_or(8));
    println!("{} threads, Courant number {COURANT}, best of {steps} steps", rayon::current_num_threads());
    let near = |elements: usize| wanted.is_none_or(|wanted| wanted.abs_diff(elements) * 5 < elements);
    for (cells, elements) in [(100, 20_000), (285, 163_000), (570, 650_000)] {
        if near(elements) {
            measure::<2, 3>(cells, 5, steps);
        }
    }
    for (cells, elements) in [(20, 48_000), (37, 304_000), (55, 1_000_000)] {
        if wanted.is_some() && near(elements) {
            measure::<3, 4>(cells, 4, steps);
        }
    }
}
