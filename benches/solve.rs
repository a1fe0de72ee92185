//! Time per unknown and step of the linear systems of PFEM-2, memory, and iterations against the mesh.
//!
//! ```text
//! cargo bench --bench solve                     every size up to 1 M unknowns
//! cargo bench --bench solve -- 2 183            one box, 183 cells along each side
//! cargo bench --bench solve -- 3 26 iterative   by hand
//! ```
//! Two fluids of densities 1000 and 1 whose interface moves by a fraction of a cell per step, walls without slip, an
//! open top. The first system includes the analysis; the others are the ones that a run sees.

use lateen::linalg::{BlockMatrix, LinearSolver, Pattern, SolverKind, SolverOptions};
use lateen::math::Vector;
use lateen::mesh::Mesh;
use std::sync::Arc;
use std::time::Instant;

const STEPS: usize = 6;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let kind = match arguments.get(2).map(String::as_str) {
        Some("direct") => SolverKind::Direct,
        Some("iterative") => SolverKind::Iterative,
        _ => SolverKind::Auto,
    };
    println!("dim  unknowns  kind        analysis+first [s]  step [s]  [µs/unknown]  iterations  new/step  peak [MB]");
    match (arguments.first(), arguments.get(1).and_then(|n| n.parse().ok())) {
        (Some(dimension), Some(cells)) if dimension == "2" => measure::<2, 3, 3>(cells, kind),
        (Some(_), Some(cells)) => measure::<3, 4, 4>(cells, kind),
        _ => {
            [46, 91, 183, 366, 577].into_iter().for_each(|cells| measure::<2, 3, 3>(cells, kind));
            [13, 26, 40, 62].into_iter().for_each(|cells| measure::<3, 4, 4>(cells, kind));
        }
    }
}

fn measure<const D: usize, const N: usize, const B: usize>(cells: usize, kind: SolverKind) {
    let mesh = Mesh::<D, N>::block(Vector::ZERO, Vector::splat(1.0), [cells; D]).expect("a box");
    let places: Vec<[f64; 3]> = mesh.nodes().iter().map(|x| x.to3()).collect();
    let pattern = Arc::new(Pattern::new(mesh.nodes().len(), mesh.elements()));
    let unknowns = pattern.rows() * B;
    let mut solver = LinearSolver::new(pattern.clone(), &places, SolverOptions { kind, ..SolverOptions::default() });
    let mut x = vec![[0.0; B]; pattern.rows()];
    let (mut first, mut rest, mut iterations, mut rebuilt) = (0.0, 0.0, 0, 0);
    for step in 0..=STEPS {
        let (a, b) = system::<D, N, B>(&mesh, &pattern, 0.6 + 0.3 * step as f64 / cells as f64);
        let start = seconds();
        let outcome = solver.solve(&a, &b, &mut x).unwrap_or_else(|failure| panic!("{failure}"));
        let spent = seconds() - start;
        if step == 0 {
            first = spent;
        } else {
            rest += spent / STEPS as f64;
            iterations += outcome.iterations;
            rebuilt += usize::from(outcome.rebuilt);
        }
    }
    println!(
        "{D}    {unknowns:>8}  {:<10}  {first:>18.3}  {rest:>8.3}  {:>12.2}  {:>10.1}  {:>8.2}  {:>9.0}",
        format!("{kind:?}"),
        1e6 * rest / unknowns as f64,
        iterations as f64 / STEPS as f64,
        rebuilt as f64 / STEPS as f64,
        peak(),
    );
}

/// [[ρ/Δt M + K, −Dᵀ], [−D, −τ/ρ L]] with gravity on the right.
fn system<const D: usize, const N: usize, const B: usize>(
    mesh: &Mesh<D, N>,
    pattern: &Arc<Pattern>,
    interface: f64,
) -> (BlockMatrix<B>, Vec<[f64; B]>) {
    const DT: f64 = 0.01;
    let mut a = BlockMatrix::zeros(pattern.clone());
    let mut b = vec![[0.0; B]; pattern.rows()];
    for (e, nodes) in mesh.elements().iter().enumerate() {
        let (simplex, h, x) = (mesh.simplex(e), mesh.shortest_edge(e), mesh.center(e));
        let nodal_volume = simplex.volume / N as f64;
        let heavy = x[D - 1] + 0.1 * (6.0 * x[0]).cos() < interface;
        let (density, viscosity) = if heavy { (1000.0, 1e-3) } else { (1.0, 1e-5) };
        let tau = 1.0 / (1.0 / DT + 4.0 * viscosity / (density * h * h));
        for i in 0..N {
            b[nodes[i] as usize][D - 1] -= density * nodal_volume * 9.81;
            b[nodes[i] as usize][D] += tau * simplex.volume * simplex.gradient[i][D - 1] * 9.81;
            for j in 0..N {
                let entry = pattern.entry(nodes[i] as usize, nodes[j] as usize).expect("neighbours");
                let laplace = simplex.volume * simplex.gradient[i].dot(simplex.gradient[j]);
                let block = &mut a.values[entry];
                for k in 0..D {
                    block[k][k] += viscosity * laplace + if i == j { density * nodal_volume / DT } else { 0.0 };
                    block[k][D] -= nodal_volume * simplex.gradient[i][k];
                    block[D][k] -= nodal_volume * simplex.gradient[j][k];
                }
                block[D][D] -= tau / density * laplace;
            }
        }
    }
    for (node, x) in mesh.nodes().iter().enumerate() {
        let wall = x[D - 1] < 1e-9 || (0..D - 1).any(|i| x[i] < 1e-9 || x[i] > 1.0 - 1e-9);
        (0..D).filter(|_| wall).for_each(|k| prescribe(&mut a, &mut b, node, k));
    }
    (a, b)
}

fn prescribe<const B: usize>(a: &mut BlockMatrix<B>, b: &mut [[f64; B]], node: usize, unknown: usize) {
    let pattern = a.pattern.clone();
    for entry in pattern.row(node) {
        a.values[entry][unknown] = [0.0; B];
        a.values[pattern.mirror(entry)].iter_mut().for_each(|row| row[unknown] = 0.0);
    }
    a.values[pattern.diagonal(node)][unknown][unknown] = 1.0;
    b[node][unknown] = 0.0;
}

/// Processor time of this process [s], so that a busy machine doesn't count; wall time where the system doesn't tell.
fn seconds() -> f64 {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    const TICKS: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let mut after_name = text.rsplit(") ").next().unwrap_or_default().split(' ').skip(11);
    let mut ticks = || after_name.next().and_then(|field| field.parse::<f64>().ok());
    match (ticks(), ticks()) {
        (Some(user), Some(system)) => (user + system) / TICKS,
        _ => START.elapsed().as_secs_f64(),
    }
}

/// Most memory that the process has held, matrices and mesh included [MB]; 0 where the system doesn't tell.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|text| text.trim().trim_end_matches(" kB").trim().parse::<f64>().ok()).map_or(0.0, |kb| kb / 1024.0)
}
