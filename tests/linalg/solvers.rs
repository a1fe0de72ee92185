//! Linear systems with known solutions: against dense factorisations, manufactured fields and the continuum.
//!
//! Bounds on numbers of iterations have no reference outside of this program. They guard that a preconditioner stays
//! effective: one that is wrong takes many times as many, or fails.

use lateen::linalg::{BlockMatrix, LinearSolver, Pattern, SolverKind, SolverOptions};
use lateen::math::Vector;
use lateen::mesh::{CellCut, Mesh};
use std::sync::Arc;

/// A P1–P1 system [[ρ/Δt M + K, −Dᵀ], [−D, −C]] as theory has it: lumped mass, K = µ Laplacian per component,
/// C = τ/ρ L with τ = (1/Δt + 4µ/(ρh²))⁻¹.
struct Stokes {
    density: fn([f64; 3]) -> f64,
    viscosity: f64,
    dt: f64,
    /// Adds −τ/Δt ∫ ∇q·v: the consistent form, not symmetric.
    consistent: bool,
}

impl Stokes {
    fn assemble<const D: usize, const N: usize, const B: usize>(&self, mesh: &Mesh<D, N>) -> BlockMatrix<B> {
        let pattern = Arc::new(Pattern::new(mesh.nodes().len(), mesh.elements()));
        let mut a = BlockMatrix::zeros(pattern.clone());
        for (e, nodes) in mesh.elements().iter().enumerate() {
            let (simplex, h) = (mesh.simplex(e), mesh.shortest_edge(e));
            let (volume, nodal_volume) = (simplex.volume, simplex.volume / N as f64);
            let density = (self.density)(mesh.center(e).to3());
            let tau = 1.0 / (1.0 / self.dt + 4.0 * self.viscosity / (density * h * h));
            for i in 0..N {
                for j in 0..N {
                    let entry = pattern.entry(nodes[i] as usize, nodes[j] as usize).unwrap();
                    let (gi, gj) = (simplex.gradient[i], simplex.gradient[j]);
                    let laplace = volume * gi.dot(gj);
                    let block = &mut a.values[entry];
                    for k in 0..D {
                        block[k][k] +=
                            self.viscosity * laplace + if i == j { density * nodal_volume / self.dt } else { 0.0 };
                        block[k][D] -= nodal_volume * gi[k];
                        block[D][k] -= nodal_volume * gj[k];
                        if self.consistent {
                            block[D][k] -= tau / self.dt * nodal_volume * gi[k];
                        }
                    }
                    block[D][D] -= tau / density * laplace;
                }
            }
        }
        a
    }
}

/// Makes an unknown's row and column those of the identity.
fn prescribe<const B: usize>(a: &mut BlockMatrix<B>, node: usize, unknown: usize) {
    let pattern = a.pattern.clone();
    for entry in pattern.row(node) {
        a.values[entry][unknown] = [0.0; B];
        a.values[pattern.mirror(entry)].iter_mut().for_each(|row| row[unknown] = 0.0);
    }
    a.values[pattern.diagonal(node)][unknown][unknown] = 1.0;
}

/// No velocity on the walls of the unit box; with an open top the pressure there is zero, without one it is pinned.
fn walls<const D: usize, const N: usize, const B: usize>(a: &mut BlockMatrix<B>, mesh: &Mesh<D, N>, open_top: bool) {
    for (node, x) in mesh.nodes().iter().enumerate() {
        let on = |axis: usize, at: f64| (x[axis] - at).abs() < 1e-12;
        let top = on(D - 1, 1.0);
        let wall = (0..D).any(|axis| on(axis, 0.0) || (on(axis, 1.0) && axis + 1 < D));
        if wall || (top && !open_top) {
            (0..D).for_each(|k| prescribe(a, node, k));
        }
    }
    if !open_top {
        prescribe(a, 0, D);
    }
}

fn unit_box<const D: usize, const N: usize>(cells: usize) -> Mesh<D, N> {
    let even = Mesh::<D, N>::block(Vector::ZERO, Vector::splat(1.0), [cells; D]).unwrap();
    let inside = |x: &Vector<D>| (0..D).all(|i| x[i] > 1e-9 && x[i] < 1.0 - 1e-9);
    let mut seed = 1u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    };
    let nodes = even.nodes().iter().map(|x| {
        let shift = Vector::from_fn(|_| 0.3 / cells as f64 * random());
        if inside(x) { *x + shift } else { *x }
    });
    Mesh::new(nodes.collect(), even.elements().to_vec()).unwrap()
}

fn places<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Vec<[f64; 3]> {
    mesh.nodes().iter().map(|x| x.to3()).collect()
}

/// A field of no special shape.
fn some_field<const B: usize>(nodes: usize) -> Vec<[f64; B]> {
    (0..nodes).map(|i| std::array::from_fn(|k| ((i * B + k) as f64 * 0.7391).sin())).collect()
}

fn largest_error<const B: usize>(a: &[[f64; B]], b: &[[f64; B]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Solves A x = A x_0 and gives the largest error and the iterations.
fn recover<const D: usize, const N: usize, const B: usize>(
    mesh: &Mesh<D, N>,
    a: &BlockMatrix<B>,
    options: SolverOptions,
) -> (f64, usize) {
    let exact = some_field::<B>(mesh.nodes().len());
    let mut b = vec![[0.0; B]; exact.len()];
    a.multiply(&exact, &mut b);
    let mut x = vec![[0.0; B]; exact.len()];
    let mut solver = LinearSolver::new(a.pattern.clone(), &places(mesh), options);
    let outcome = solver.solve(a, &b, &mut x).unwrap();
    (largest_error(&x, &exact), outcome.iterations)
}

const TWO_FLUIDS: Stokes = Stokes {
    density: |x| if x[0] + 0.3 * x[1] < 0.6 { 1000.0 } else { 1.0 },
    viscosity: 1e-3,
    dt: 0.01,
    consistent: false,
};

#[test]
fn the_direct_solver_recovers_a_field_of_two_fluids_in_2d_and_3d() {
    let options = SolverOptions { kind: SolverKind::Direct, tolerance: 1e-12, ..SolverOptions::default() };
    let plane = unit_box::<2, 3>(24);
    let mut a = TWO_FLUIDS.assemble::<2, 3, 3>(&plane);
    walls(&mut a, &plane, true);
    let (error, iterations) = recover(&plane, &a, options);
    assert!(error < 1e-7 && iterations <= 12, "{error} in {iterations}");
    let space = unit_box::<3, 4>(7);
    let mut a = TWO_FLUIDS.assemble::<3, 4, 4>(&space);
    walls(&mut a, &space, true);
    let (error, iterations) = recover(&space, &a, options);
    assert!(error < 1e-7 && iterations <= 12, "{error} in {iterations}");
}

/// The largest relative error over a few systems whose matrices change from one to the next.
fn over_steps<const D: usize, const N: usize, const B: usize>(
    mesh: &Mesh<D, N>,
    kind: SolverKind,
) -> (f64, usize, usize) {
    let options = SolverOptions { kind, tolerance: 1e-10, ..SolverOptions::default() };
    let exact = some_field::<B>(mesh.nodes().len());
    let (mut worst, mut iterations, mut rebuilt) = (0.0f64, 0, 0);
    let mut solver: Option<LinearSolver<B>> = None;
    for step in 0..6 {
        let stokes = Stokes { dt: 0.01 * (1.0 + 0.05 * f64::from(step)), ..TWO_FLUIDS };
        let mut a = stokes.assemble::<D, N, B>(mesh);
        walls(&mut a, mesh, true);
        let solver = solver.get_or_insert_with(|| LinearSolver::new(a.pattern.clone(), &places(mesh), options));
        let mut b = vec![[0.0; B]; exact.len()];
        a.multiply(&exact, &mut b);
        let mut x = vec![[0.0; B]; exact.len()];
        let outcome = solver.solve(&a, &b, &mut x).unwrap();
        assert!(outcome.residual <= 1e-10);
        worst = worst.max(largest_error(&x, &exact));
        iterations += outcome.iterations;
        rebuilt += usize::from(outcome.rebuilt);
    }
    (worst, iterations, rebuilt)
}

#[test]
fn preconditioners_are_reused_for_matrices_that_change_little() {
    let (error, iterations, rebuilt) = over_steps::<2, 3, 3>(&unit_box(20), SolverKind::Direct);
    assert!(error < 1e-5 && rebuilt < 6, "{error}, {iterations} iterations, {rebuilt} factors");
    let (error, iterations, rebuilt) = over_steps::<3, 4, 4>(&unit_box(8), SolverKind::Iterative);
    assert!(error < 1e-5 && rebuilt < 6, "{error}, {iterations} iterations, {rebuilt} hierarchies");
}

/// Iterations of the multigrid solver on a box of `cells` cells along each side.
fn iterations<const D: usize, const N: usize, const B: usize>(stokes: &Stokes, cells: usize, open: bool) -> usize {
    iterations_on::<D, N, B>(&unit_box::<D, N>(cells), stokes, open)
}

/// The same on a mesh of the unit box.
fn iterations_on<const D: usize, const N: usize, const B: usize>(
    mesh: &Mesh<D, N>,
    stokes: &Stokes,
    open: bool,
) -> usize {
    let mut a = stokes.assemble::<D, N, B>(mesh);
    walls(&mut a, mesh, open);
    let (error, iterations) =
        recover(mesh, &a, SolverOptions { kind: SolverKind::Iterative, ..SolverOptions::default() });
    assert!(error < 1e-2, "{error}");
    iterations
}

#[test]
fn iterations_of_multigrid_grow_little_with_the_mesh() {
    let counts = [32, 64, 128].map(|cells| iterations::<2, 3, 3>(&TWO_FLUIDS, cells, true));
    assert!(counts[2] as f64 <= 1.25 * counts[0] as f64 + 1.0, "{counts:?} in 2D");
    let counts = [8, 16, 24].map(|cells| iterations::<3, 4, 4>(&TWO_FLUIDS, cells, true));
    assert!(counts[2] as f64 <= 1.25 * counts[0] as f64 + 1.0, "{counts:?} in 3D");
}

/// Four and eight triangles, or eight to forty-eight tetrahedra, around nodes side by side: the diagonals differ as
/// much.
#[test]
fn iterations_of_multigrid_do_not_grow_where_cells_are_mirrored() {
    fn mirrored<const D: usize, const N: usize>(cells: usize) -> Mesh<D, N> {
        let line: Vec<f64> = (0..=cells).map(|i| i as f64 / cells as f64).collect();
        Mesh::lattice(&std::array::from_fn(|_| line.clone()), CellCut::Mirrored).unwrap()
    }
    let thin = Stokes { density: |_| 1.0, viscosity: 1e-6, dt: 0.01, consistent: false };
    let counts = [48, 192].map(|cells| iterations_on::<2, 3, 3>(&mirrored(cells), &thin, false));
    assert!(counts[1] <= counts[0] + 1, "{counts:?} in 2D");
    let counts = [8, 24].map(|cells| iterations_on::<3, 4, 4>(&mirrored(cells), &thin, false));
    assert!(counts[1] <= counts[0] + 1, "{counts:?} in 3D");
}

#[test]
fn multigrid_converges_for_closed_viscous_and_unsymmetric_systems() {
    let water = Stokes { density: |_| 1.0, viscosity: 1e-3, dt: 0.01, consistent: false };
    let closed = iterations::<3, 4, 4>(&water, 12, false);
    let consistent = iterations::<3, 4, 4>(&Stokes { consistent: true, ..water }, 12, true);
    let viscous = iterations::<3, 4, 4>(&Stokes { viscosity: 10.0, ..water }, 12, true);
    assert!(closed <= 40 && consistent <= 40 && viscous <= 120, "{closed} {consistent} {viscous}");
}

#[test]
fn a_factor_of_the_symmetric_part_preconditions_the_unsymmetric_form() {
    let mesh = unit_box::<2, 3>(24);
    let mut a = Stokes { consistent: true, ..TWO_FLUIDS }.assemble::<2, 3, 3>(&mesh);
    walls(&mut a, &mesh, true);
    let (error, iterations) =
        recover(&mesh, &a, SolverOptions { kind: SolverKind::Direct, tolerance: 1e-11, ..SolverOptions::default() });
    assert!(error < 1e-6 && iterations <= 40, "{error} in {iterations}");
}

/// Rows of continuity times factors above one half make the matrix unsymmetric and change nothing of its solution:
/// balanced, it takes hardly more iterations than the symmetric one. (The consistent form is that with 1 − τ/Δ, up to
/// what τ changes from element to element.)
#[test]
fn factors_of_the_rows_of_continuity_cost_no_iterations() {
    let mesh = unit_box::<2, 3>(24);
    let mut a = TWO_FLUIDS.assemble::<2, 3, 3>(&mesh);
    walls(&mut a, &mesh, true);
    let options = SolverOptions { kind: SolverKind::Direct, tolerance: 1e-11, ..SolverOptions::default() };
    let (_, symmetric) = recover(&mesh, &a, options);
    assert!(a.row_balance().iter().all(|&factor| factor == 1.0));
    let factor = |row: usize| 0.55 + 0.4 * ((row * 37 % 101) as f64 / 101.0);
    for row in 0..mesh.nodes().len() {
        for entry in a.pattern.row(row) {
            a.values[entry][2].iter_mut().for_each(|value| *value *= factor(row));
        }
    }
    for (row, balance) in a.row_balance().into_iter().enumerate() {
        assert!(balance == 1.0 || (balance * factor(row) - 1.0).abs() < 1e-12, "{row}: {balance}");
    }
    let (error, iterations) = recover(&mesh, &a, options);
    assert!(error < 1e-6 && iterations <= 2 * symmetric, "{error} in {iterations} after {symmetric}");
}

/// Two fluids, and on every node of the top a block [1 c; 0 1] · a_ii, whose symmetric part is indefinite for c > 2.
fn lopsided(mesh: &Mesh<2, 3>, c: f64) -> BlockMatrix<3> {
    let mut a = TWO_FLUIDS.assemble::<2, 3, 3>(mesh);
    walls(&mut a, mesh, true);
    for node in (0..mesh.nodes().len()).filter(|&node| mesh.nodes()[node][1] > 0.9) {
        let diagonal = a.pattern.diagonal(node);
        let block = &mut a.values[diagonal];
        block[0][1] += c * block[0][0];
    }
    a
}

#[test]
fn the_direct_solver_recovers_a_field_where_the_symmetric_part_is_indefinite() {
    let mesh = unit_box::<2, 3>(24);
    let a = lopsided(&mesh, 40.0);
    for kind in [SolverKind::Direct, SolverKind::Auto] {
        let (error, _) = recover(&mesh, &a, SolverOptions { kind, tolerance: 1e-11, ..SolverOptions::default() });
        assert!(error < 1e-6, "{kind:?}: {error}");
    }
}

#[test]
fn the_first_preconditioner_returns_after_systems_that_needed_another() {
    let mesh = unit_box::<2, 3>(24);
    let (hard, easy) = (lopsided(&mesh, 40.0), lopsided(&mesh, 0.0));
    let b = some_field::<3>(mesh.nodes().len());
    let mut solver = LinearSolver::new(easy.pattern.clone(), &places(&mesh), SolverOptions::default());
    let mut solve = |a: &BlockMatrix<3>| {
        let mut x = vec![[0.0; 3]; b.len()];
        solver.solve(a, &b, &mut x).unwrap();
        solver.state().counters.method_number
    };
    let usual = solve(&easy);
    assert!(solve(&hard) != usual);
    assert!(solve(&hard) != usual);
    assert_eq!([&easy, &easy].map(&mut solve)[1], usual);
    // The number of systems before the usual method is tried again doubles with every failure in a row, and a success
    // resets it.
    assert!((0..2).all(|_| solve(&hard) != usual));
    assert_eq!(solve(&easy), usual);
}

/// Gauss with pivots.
fn eliminate(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            (k..n).for_each(|j| a[i][j] -= factor * a[k][j]);
            b[i] -= factor * b[k];
        }
    }
    for i in (0..n).rev() {
        b[i] = (b[i] - (i + 1..n).map(|j| a[i][j] * b[j]).sum::<f64>()) / a[i][i];
    }
    b
}

#[test]
fn both_solvers_agree_with_a_dense_factorisation() {
    let mesh = unit_box::<2, 3>(4);
    let mut a = TWO_FLUIDS.assemble::<2, 3, 3>(&mesh);
    walls(&mut a, &mesh, false);
    let n = mesh.nodes().len();
    let mut dense = vec![vec![0.0; 3 * n]; 3 * n];
    for i in 0..n {
        for entry in a.pattern.row(i) {
            let j = a.pattern.columns()[entry] as usize;
            for (r, row) in a.values[entry].iter().enumerate() {
                row.iter().enumerate().for_each(|(c, &v)| dense[3 * i + r][3 * j + c] = v);
            }
        }
    }
    let b: Vec<[f64; 3]> = some_field(n);
    let expected = eliminate(dense, b.as_flattened().to_vec());
    for kind in [SolverKind::Direct, SolverKind::Iterative] {
        let options = SolverOptions { kind, tolerance: 1e-13, ..SolverOptions::default() };
        let mut x = vec![[0.0; 3]; n];
        LinearSolver::new(a.pattern.clone(), &places(&mesh), options).solve(&a, &b, &mut x).unwrap();
        let scale = expected.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let error = x.as_flattened().iter().zip(expected.iter()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(error < 1e-9 * scale, "{kind:?}: {error} of {scale}");
    }
}

#[test]
fn the_pressure_of_a_poisson_problem_converges_at_second_order() {
    // Without velocity the system is −C p = f: a Laplacian, whose exact solution is known.
    use std::f64::consts::PI;
    let error = |cells: usize| {
        let mesh = unit_box::<2, 3>(cells);
        let stokes = Stokes { density: |_| 1.0, viscosity: 0.0, dt: 1.0, consistent: false };
        let mut a = stokes.assemble::<2, 3, 3>(&mesh);
        (0..mesh.nodes().len()).for_each(|node| (0..2).for_each(|k| prescribe(&mut a, node, k)));
        let exact = |x: Vector<2>| (PI * x[0]).sin() * (PI * x[1]).sin();
        let mut b = vec![[0.0; 3]; mesh.nodes().len()];
        for (e, nodes) in mesh.elements().iter().enumerate() {
            let nodal_volume = mesh.simplex(e).volume / 3.0;
            nodes
                .iter()
                .for_each(|&n| b[n as usize][2] -= nodal_volume * 2.0 * PI * PI * exact(mesh.nodes()[n as usize]));
        }
        for facet in mesh.boundary() {
            for node in mesh.facet_nodes(*facet) {
                prescribe(&mut a, node as usize, 2);
                b[node as usize][2] = 0.0;
            }
        }
        let mut x = vec![[0.0; 3]; b.len()];
        let options = SolverOptions { kind: SolverKind::Iterative, ..SolverOptions::default() };
        LinearSolver::new(a.pattern.clone(), &places(&mesh), options).solve(&a, &b, &mut x).unwrap();
        mesh.nodes().iter().zip(&x).map(|(&at, p)| (p[2] - exact(at)).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(32), error(64));
    assert!((coarse / fine).log2() > 1.7, "{coarse} {fine}");
}

#[test]
fn failures_to_converge_name_the_worst_node() {
    let mesh = unit_box::<3, 4>(6);
    let mut a = TWO_FLUIDS.assemble::<3, 4, 4>(&mesh);
    walls(&mut a, &mesh, true);
    let options =
        SolverOptions { kind: SolverKind::Iterative, tolerance: 1e-12, max_iterations: 2, ..SolverOptions::default() };
    let mut b = vec![[0.0; 4]; mesh.nodes().len()];
    b[171] = [1.0, 2.0, 3.0, 0.0];
    let mut x = vec![[0.0; 4]; b.len()];
    let failure = LinearSolver::new(a.pattern.clone(), &places(&mesh), options).solve(&a, &b, &mut x).unwrap_err();
    assert!(failure.history.len() == 3 && failure.residual > 1e-12 && failure.worst_node < b.len());
    assert!(failure.to_string().ends_with("after 2 iterations"), "{failure}");
    a.values[a.pattern.diagonal(171)][0][0] = f64::NAN;
    let mut x = vec![[0.0; 4]; b.len()];
    let failure = LinearSolver::new(a.pattern.clone(), &places(&mesh), SolverOptions::default()).solve(&a, &b, &mut x);
    assert_eq!(failure.unwrap_err().worst_node, 171);
}

/// Two iterations with the kept preconditioner and two with a fresh one are four.
#[test]
fn failures_to_converge_count_the_iterations_of_all_attempts() {
    let mesh = unit_box::<3, 4>(6);
    let mut a = TWO_FLUIDS.assemble::<3, 4, 4>(&mesh);
    walls(&mut a, &mesh, true);
    let (mut b, mut x) = (vec![[0.0; 4]; mesh.nodes().len()], vec![[0.0; 4]; mesh.nodes().len()]);
    b[171] = [1.0, 2.0, 3.0, 0.0];
    let loose = SolverOptions { kind: SolverKind::Iterative, tolerance: 1e-2, ..SolverOptions::default() };
    let mut first = LinearSolver::new(a.pattern.clone(), &places(&mesh), loose);
    first.solve(&a, &b, &mut x).unwrap();
    let strict = SolverOptions { tolerance: 1e-12, max_iterations: 2, ..loose };
    let mut second = LinearSolver::new(a.pattern.clone(), &places(&mesh), strict);
    second.restore(&first.state()).unwrap();
    x.as_flattened_mut().fill(0.0);
    let failure = second.solve(&a, &b, &mut x).unwrap_err();
    assert_eq!((failure.iterations(), failure.history.len()), (4, 5));
    assert!(failure.to_string().ends_with("after 4 iterations"), "{failure}");
}

#[test]
fn a_restored_solver_and_any_number_of_threads_give_the_same_bits() {
    let mesh = unit_box::<3, 4>(10);
    let systems: Vec<BlockMatrix<4>> = (0..4)
        .map(|step| {
            let stokes = Stokes { dt: 0.01 * (1.0 + 0.02 * f64::from(step)), ..TWO_FLUIDS };
            let mut a = stokes.assemble::<3, 4, 4>(&mesh);
            walls(&mut a, &mesh, true);
            a
        })
        .collect();
    let b: Vec<[f64; 4]> = some_field(mesh.nodes().len());
    for kind in [SolverKind::Direct, SolverKind::Iterative] {
        let options = SolverOptions { kind, ..SolverOptions::default() };
        let new = || LinearSolver::new(systems[0].pattern.clone(), &places(&mesh), options);
        let run = |solver: &mut LinearSolver<4>, steps: std::ops::Range<usize>| {
            let mut x = vec![[0.0; 4]; b.len()];
            for a in &systems[steps] {
                x.fill([0.0; 4]);
                solver.solve(a, &b, &mut x).unwrap();
            }
            x.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<u64>>()
        };
        let whole = run(&mut new(), 0..4);
        let mut first = new();
        run(&mut first, 0..2);
        let mut second = new();
        second.restore(&first.state()).unwrap();
        assert!(run(&mut second, 2..4) == whole, "{kind:?} after a resumption");
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| run(&mut new(), 0..4)) == whole, "{kind:?} on {threads} threads");
        }
    }
}
