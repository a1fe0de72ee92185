//! Multigrid by smoothed aggregation (Vaněk, Mandel & Brezina 1996) with Krylov cycles (Notay & Vassilevski 2008;
//! theory F.15).
//!
//! ```text
//! P = (I − ω D⁻¹ A_s) P_0,   ω = 4 / (3 ρ(D⁻¹ A_s)),   A_c = Pᵀ A P
//! A_s: the strong part of A; P_0: w_i/w_c on the unknowns i of an aggregate, w_c = (Σ w_i²)^½ on the coarse level
//! ```
//! w is what A hardly sees: the constant before A was scaled. A mesh whose diagonals differ from node to node, as where
//! cells are mirrored, lets it differ as much; without it the coarse levels would be too stiff by a factor that grows
//! with the mesh.
//!
//! A coarse level solves by two steps of a residual-minimising iteration, each preconditioned by its own cycle. This
//! costs little, because levels shrink fast, and keeps the iterations from growing with their number.
//!
//! It preconditions only: it works in single precision, on the matrix scaled to a unit diagonal.

mod aggregate;
mod csr;
mod dense;
mod smoother;

use aggregate::{ALONE, Aggregates, aggregate, strong_part};
pub(super) use csr::Csr;
use dense::Dense;
pub(super) use smoother::block_rows;
use smoother::{backward, forward_from_zero};

/// Coupling below which a neighbour is weak, on the finest level; halved on each coarser one.
const WEAK: f32 = 0.06;

/// A level this small is solved at once.
const COARSEST: usize = 250;

/// A coarse residual reduced to this part needs no second step.
const SUFFICIENT_REDUCTION: f64 = 0.2;

/// Levels from fine to coarse.
pub(super) struct Hierarchy {
    /// 1/√|a_ii| of the finest matrix.
    scaling: Vec<f32>,
    levels: Vec<GridLevel>,
    coarsest: Dense,
}

struct GridLevel {
    a: Csr,
    inverse_diagonal: Vec<f32>,
    /// Prolongation from the next coarser level and restriction to it; empty on the coarsest.
    prolongation: Csr,
    restriction: Csr,
    workspace: LevelVectors,
}

/// Vectors of a level.
#[derive(Default)]
struct LevelVectors {
    right: Vec<f32>,
    x: Vec<f32>,
    residual: Vec<f32>,
    old: Vec<f32>,
    direction: Vec<f32>,
    image: [Vec<f32>; 2],
}

impl LevelVectors {
    fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self {
            right: zeros(),
            x: zeros(),
            residual: zeros(),
            old: zeros(),
            direction: zeros(),
            image: [zeros(), zeros()],
        }
    }
}

impl Hierarchy {
    /// The hierarchy of a matrix that is nearly symmetric and positive definite; rows without couplings may be
    /// anything.
    pub fn new(mut a: Csr) -> Self {
        let scaling = scale(&mut a);
        let mut smooth = smooth(&scaling);
        let mut levels: Vec<GridLevel> = Vec::new();
        let mut threshold = WEAK;
        loop {
            let coarser = if a.rows() > COARSEST { coarsen(&a, &mut smooth, threshold) } else { None };
            let inverse_diagonal = inverses(&a);
            let workspace = LevelVectors::new(a.rows());
            let Some((prolongation, restriction, next)) = coarser else {
                let coarsest = if a.rows() <= 8 * COARSEST { dense(&a) } else { Dense::default() };
                let (prolongation, restriction) = (Csr::default(), Csr::default());
                levels.push(GridLevel { a, inverse_diagonal, prolongation, restriction, workspace });
                return Self { scaling, levels, coarsest };
            };
            levels.push(GridLevel { a, inverse_diagonal, prolongation, restriction, workspace });
            a = next;
            threshold *= 0.5;
        }
    }

    /// Takes a matrix that differs little, or in few rows, in place of the finest; the coarser levels stay.
    pub fn refresh(&mut self, mut a: Csr) {
        if self.levels.len() < 2 || a.rows() != self.scaling.len() {
            *self = Self::new(a);
            return;
        }
        a.scale_by(&self.scaling);
        let finest = &mut self.levels[0];
        finest.inverse_diagonal = inverses(&a);
        finest.a = a;
    }

    /// x ≈ A⁻¹ b by one cycle.
    pub fn apply(&mut self, b: &[f64], x: &mut [f64]) {
        let size = b.iter().zip(&self.scaling).map(|(b, &s)| (b * f64::from(s)).abs()).fold(0.0, f64::max);
        if size == 0.0 || !size.is_finite() {
            x.fill(0.0);
            return;
        }
        let right = &mut self.levels[0].workspace.right;
        for ((right, b), &s) in right.iter_mut().zip(b).zip(&self.scaling) {
            *right = (b / size) as f32 * s;
        }
        cycle(&mut self.levels, &self.coarsest);
        for ((x, &y), &s) in x.iter_mut().zip(&self.levels[0].workspace.x).zip(&self.scaling) {
            *x = f64::from(y * s) * size;
        }
    }
}

/// A ← S A S with a diagonal of ±1; gives S.
fn scale(a: &mut Csr) -> Vec<f32> {
    let scaling: Vec<f32> = a.diagonal().iter().map(|&d| if d == 0.0 { 1.0 } else { d.abs().sqrt().recip() }).collect();
    a.scale_by(&scaling);
    scaling
}

/// 1/a_ii; zero where the diagonal is.
fn inverses(a: &Csr) -> Vec<f32> {
    a.diagonal().iter().map(|&d| if d == 0.0 { 0.0 } else { d.recip() }).collect()
}

/// w: a constant, divided by the scaling of a matrix whose rows add up to about zero.
fn smooth(scaling: &[f32]) -> Vec<f32> {
    let least = scaling.iter().copied().fold(f32::INFINITY, f32::min);
    scaling.iter().map(|s| least / s).collect()
}

/// P, Pᵀ and PᵀAP, with w of this level replaced by that of the next; `None` where nothing is left to group.
fn coarsen(a: &Csr, smooth: &mut Vec<f32>, threshold: f32) -> Option<(Csr, Csr, Csr)> {
    let strong = strong_part(a, &a.diagonal(), smooth, threshold);
    let aggregates = aggregate(&strong);
    if aggregates.count == 0 || aggregates.count * 10 > a.rows() * 9 {
        return None;
    }
    let prolongation = smoothed(&strong, &aggregates, &weights_in_aggregates(&aggregates, smooth));
    let restriction = prolongation.transposed();
    let coarse = restriction.product(&a.product(&prolongation));
    Some((prolongation, restriction, coarse))
}

/// w_i/w_c, zero where there is no aggregate; w becomes w_c.
fn weights_in_aggregates(aggregates: &Aggregates, smooth: &mut Vec<f32>) -> Vec<f32> {
    let mut coarse = vec![0.0f32; aggregates.count];
    for (w, &own) in smooth.iter().zip(&aggregates.of).filter(|(_, own)| **own != ALONE) {
        coarse[own as usize] += w * w;
    }
    coarse.iter_mut().for_each(|w| *w = w.sqrt());
    let fine = std::mem::replace(smooth, coarse);
    let part = |(w, &own): (f32, &u32)| if own == ALONE { 0.0 } else { w / smooth[own as usize] };
    fine.into_iter().zip(&aggregates.of).map(part).collect()
}

/// P = (I − ω D⁻¹ A_s) P_0 with one of the `weights` per row of P_0.
fn smoothed(strong: &Csr, aggregates: &Aggregates, weights: &[f32]) -> Csr {
    let inverse: Vec<f32> = strong.diagonal().iter().map(|d| d.recip()).collect();
    let omega = 4.0 / (3.0 * largest_eigenvalue(strong, &inverse));
    Csr::from_rows(strong.rows(), aggregates.count, |i, row| {
        if aggregates.of[i] == ALONE {
            return;
        }
        row.add(aggregates.of[i] as usize, weights[i]);
        for (j, v) in strong.row(i).filter(|&(j, _)| aggregates.of[j] != ALONE) {
            row.add(aggregates.of[j] as usize, -omega * inverse[i] * v * weights[j]);
        }
    })
}

/// ρ(D⁻¹ A) by some steps of the power method from a rough start, and a little more.
fn largest_eigenvalue(a: &Csr, inverse_diagonal: &[f32]) -> f32 {
    const STEPS: usize = 8;
    let n = a.rows();
    let mut x: Vec<f32> = (0..n).map(|i| if (i * 2654435761) >> 7 & 1 == 0 { 1.0 } else { -1.0 }).collect();
    let mut y = vec![0.0; n];
    let mut value = 1.0;
    for _ in 0..STEPS {
        a.multiply(&x, &mut y, |_, ax| ax);
        y.iter_mut().zip(inverse_diagonal).for_each(|(y, d)| *y *= d);
        let (before, after) = (dot(&x, &x), dot(&y, &y));
        value = (after / before).sqrt();
        let scale = (1.0 / after.sqrt()) as f32;
        x.iter_mut().zip(&y).for_each(|(x, y)| *x = y * scale);
    }
    1.1 * value as f32
}

fn dense(a: &Csr) -> Dense {
    let n = a.rows();
    let mut full = vec![0.0; n * n];
    for i in 0..n {
        a.row(i).for_each(|(j, v)| full[i * n + j] += f64::from(v));
    }
    Dense::new(n, full)
}

/// x ≈ A⁻¹ right on the first of the levels: smooth, correct from the next, smooth.
fn cycle(levels: &mut [GridLevel], coarsest: &Dense) {
    let Some((level, coarser)) = levels.split_first_mut() else { return };
    let GridLevel { a, inverse_diagonal, prolongation, restriction, workspace } = level;
    let Some(next) = coarser.first_mut() else {
        if coarsest.is_empty() {
            forward_from_zero(a, inverse_diagonal, &workspace.right, &mut workspace.x);
            backward(a, inverse_diagonal, &workspace.right, &mut workspace.x, &mut workspace.old);
        } else {
            coarsest.solve(&workspace.right, &mut workspace.x);
        }
        return;
    };
    forward_from_zero(a, inverse_diagonal, &workspace.right, &mut workspace.x);
    workspace.residual.copy_from_slice(&workspace.right);
    a.multiply(&workspace.x, &mut workspace.residual, |b, ax| b - ax);
    restriction.multiply(&workspace.residual, &mut next.workspace.right, |_, rest| rest);
    minimize(coarser, coarsest);
    prolongation.multiply(&coarser[0].workspace.x, &mut workspace.x, |x, correction| x + correction);
    backward(a, inverse_diagonal, &workspace.right, &mut workspace.x, &mut workspace.old);
}

/// x ≈ A⁻¹ right by at most two steps of GCR, each preconditioned by a cycle; one on the coarsest level.
fn minimize(levels: &mut [GridLevel], coarsest: &Dense) {
    cycle(levels, coarsest);
    if levels.len() == 1 {
        return;
    }
    let GridLevel { a, workspace, .. } = &mut levels[0];
    a.multiply(&workspace.x, &mut workspace.image[0], |_, ax| ax);
    let square = dot(&workspace.image[0], &workspace.image[0]);
    let start = dot(&workspace.right, &workspace.right);
    if square == 0.0 || start == 0.0 {
        return;
    }
    let step = (dot(&workspace.image[0], &workspace.right) / square) as f32;
    workspace.right.iter_mut().zip(&workspace.image[0]).for_each(|(r, image)| *r -= step * image);
    workspace.direction.copy_from_slice(&workspace.x);
    if dot(&workspace.right, &workspace.right) <= SUFFICIENT_REDUCTION * SUFFICIENT_REDUCTION * start {
        workspace.x.iter_mut().for_each(|x| *x *= step);
        return;
    }
    cycle(levels, coarsest);
    let GridLevel { a, workspace, .. } = &mut levels[0];
    a.multiply(&workspace.x, &mut workspace.image[1], |_, ax| ax);
    let along = (dot(&workspace.image[1], &workspace.image[0]) / square) as f32;
    let [first, second] = &mut workspace.image;
    second.iter_mut().zip(first).for_each(|(w, v)| *w -= along * *v);
    let square = dot(second, second);
    let second_step = if square == 0.0 { 0.0 } else { (dot(second, &workspace.right) / square) as f32 };
    let first_step = step - along * second_step;
    workspace.x.iter_mut().zip(&workspace.direction).for_each(|(x, d)| *x = first_step * d + second_step * *x);
}

/// a·b in double precision, in a fixed order.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    crate::parallel::sum(a.len(), |i| f64::from(a[i]) * f64::from(b[i]))
}
