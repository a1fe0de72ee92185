//! Flexible GMRES with restarts (Saad 1993), preconditioned from the right, in the scaled norm (theory F.15).
//!
//! ```text
//! minimise |S (b − A x)| over x ∈ x_0 + span{z_1 … z_m},   z_j = P(v_j)
//! S A z_j = Σ_i h_ij v_i   (Arnoldi; Gram–Schmidt by passes over all v, repeated where cancellation asks for it)
//! ```
//! P may change from one application to the next. The history holds the norm at the start and after every iteration;
//! restarts compute the true residual, so that convergence is never claimed by recurrence alone.

use super::vectors::{add_multiples, dot, dots, norm, update};

/// Number of last iterations by whose rate the number of further iterations is predicted.
const PACE: usize = 5;

/// A second pass of Gram–Schmidt follows where the first left less than this part of a vector.
const CANCELLED: f64 = 0.1;

/// The system as FGMRES sees it; all vectors are flat.
pub(super) trait System {
    /// y = S A x.
    fn multiply(&self, x: &[f64], y: &mut [f64]);
    /// r = S (b − A x).
    fn residual(&self, x: &[f64], r: &mut [f64]);
    /// z = P(r), an approximate solution of S A z = r.
    fn precondition(&mut self, r: &[f64], z: &mut [f64]);
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// |S (b − A x)| to reach.
    pub target: f64,
    /// Vectors kept before a restart.
    pub restart: usize,
    /// Iterations in all.
    pub iterations: usize,
    /// Iterations beyond which it is given up as soon as the last ones show that there will be more; `None`: never.
    pub patience: Option<usize>,
}

/// The vectors of FGMRES, kept from one solution to the next.
#[derive(Debug, Default)]
pub(super) struct Krylov {
    v: Vec<Vec<f64>>,
    z: Vec<Vec<f64>>,
}

/// Result of an attempt.
pub(super) struct Attempt {
    /// The norm at the start and after every iteration.
    pub history: Vec<f64>,
    /// True if the true residual reached the target.
    pub converged: bool,
}

impl Krylov {
    /// Improves `x` until the limits are reached. On return `residual` holds S (b − A x).
    pub fn solve(&mut self, system: &mut impl System, x: &mut [f64], residual: &mut [f64], limits: Limits) -> Attempt {
        system.residual(x, residual);
        let mut history = vec![norm(residual)];
        loop {
            let start = norm(residual);
            if start <= limits.target {
                return Attempt { history, converged: true };
            }
            let spent = history.len() - 1;
            if !start.is_finite() || spent >= limits.iterations {
                return Attempt { history, converged: false };
            }
            let steps = limits.restart.min(limits.iterations - spent);
            self.cycle(system, x, residual, Limits { iterations: steps, ..limits }, &mut history);
            system.residual(x, residual);
            // A cycle that gains nothing never will.
            let idle = norm(residual) > 0.999 * start;
            if (idle || falls_behind(&history, limits)) && norm(residual) > limits.target {
                return Attempt { history, converged: false };
            }
        }
    }

    /// One cycle between restarts.
    fn cycle(&mut self, system: &mut impl System, x: &mut [f64], r: &[f64], limits: Limits, history: &mut Vec<f64>) {
        let mut least_squares = LeastSquares::new(norm(r));
        self.reserve(0, r.len());
        self.v[0].copy_from_slice(r);
        let scale = least_squares.residual().recip();
        update(&mut self.v[0], |_, v| v * scale);
        for j in 0..limits.iterations {
            self.reserve(j + 1, r.len());
            system.precondition(&self.v[j], &mut self.z[j]);
            let (basis, next) = self.v.split_at_mut(j + 1);
            let w = &mut next[0];
            system.multiply(&self.z[j], w);
            let column = orthogonalize(w, basis);
            least_squares.append(column);
            let residual = least_squares.residual();
            history.push(residual);
            if residual <= limits.target || !residual.is_finite() || falls_behind(history, limits) {
                break;
            }
        }
        let weights = least_squares.solution();
        add_multiples(x, &weights, &self.z[..weights.len()]);
    }

    /// Room for v_j and z_j; the system may have another border than the last one.
    fn reserve(&mut self, j: usize, len: usize) {
        for set in [&mut self.v, &mut self.z] {
            set.resize_with(set.len().max(j + 1), Vec::new);
            set[j].resize(len, 0.0);
        }
    }
}

/// True if the rate of the last iterations predicts more iterations than allowed.
fn falls_behind(history: &[f64], limits: Limits) -> bool {
    let done = history.len() - 1;
    let (Some(patience), Some(before)) = (limits.patience, done.checked_sub(PACE)) else { return false };
    let gain = (history[before] / history[done]).ln() / PACE as f64;
    let rest = (history[done] / limits.target).ln().max(0.0);
    rest > gain * patience.saturating_sub(done) as f64
}

/// Makes `w` a unit vector orthogonal to the basis; gives its coefficients along the basis and its norm.
fn orthogonalize(w: &mut [f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let before = norm(w);
    let mut column = dots(w, basis);
    subtract(w, &column, basis);
    let mut after = norm(w);
    if after < CANCELLED * before {
        let correction = dots(w, basis);
        subtract(w, &correction, basis);
        column.iter_mut().zip(correction).for_each(|(h, c)| *h += c);
        after = dot(w, w).sqrt();
    }
    if after > 0.0 {
        let scale = after.recip();
        update(w, |_, w| w * scale);
    }
    column.push(after);
    column
}

fn subtract(w: &mut [f64], coefficients: &[f64], basis: &[Vec<f64>]) {
    let negative: Vec<f64> = coefficients.iter().map(|c| -c).collect();
    add_multiples(w, &negative, basis);
}

/// min |β e_1 − H y| by Givens rotations, column by column.
struct LeastSquares {
    /// Columns of R.
    columns: Vec<Vec<f64>>,
    rotations: Vec<[f64; 2]>,
    right: Vec<f64>,
}

impl LeastSquares {
    fn new(beta: f64) -> Self {
        Self { columns: Vec::new(), rotations: Vec::new(), right: vec![beta] }
    }

    /// Appends column j of H, with j + 2 numbers.
    fn append(&mut self, mut column: Vec<f64>) {
        for (k, &[c, s]) in self.rotations.iter().enumerate() {
            let (above, below) = (column[k], column[k + 1]);
            column[k] = c * above + s * below;
            column[k + 1] = c * below - s * above;
        }
        let last = column.len() - 2;
        let length = column[last].hypot(column[last + 1]);
        let rotation = if length == 0.0 { [1.0, 0.0] } else { [column[last] / length, column[last + 1] / length] };
        column[last] = length;
        column.pop();
        self.columns.push(column);
        self.rotations.push(rotation);
        let above = self.right[last];
        self.right[last] = rotation[0] * above;
        self.right.push(-rotation[1] * above);
    }

    fn residual(&self) -> f64 {
        self.right[self.right.len() - 1].abs()
    }

    /// y by back substitution; directions that gave nothing get no weight.
    fn solution(&self) -> Vec<f64> {
        let n = self.columns.len();
        let mut y = vec![0.0; n];
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| self.columns[j][i] * y[j]).sum();
            let pivot = self.columns[i][i];
            y[i] = if pivot == 0.0 { 0.0 } else { (self.right[i] - known) / pivot };
        }
        y
    }
}
