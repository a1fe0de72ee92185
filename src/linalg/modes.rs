//! The lowest modes of a pair of symmetric matrices, by subspace iteration (Bathe & Wilson 1972; theory J.15).
//!
//! ```text
//! K x = λ M x;      X ← (K + σ M)⁻¹ M X,   X made orthonormal in M,   Xᵀ K X = V Λ Vᵀ,   X ← X V
//! ```
//!
//! σ is far below the modes that matter and keeps the factor regular where some motions have no stiffness: their λ are
//! zero to rounding.

use super::sparse::{MatrixEntry, SparseMatrix};
use super::symmetric_factor::PreconditioningFactor;
use super::vectors::start_vector;

/// σ over the largest ratio of the diagonals of K and M.
const SHIFT: f64 = 1e-11;

/// Vectors beyond those that are asked for.
const SPARE: usize = 4;

/// Iterations at most.
const ITERATIONS: usize = 60;

/// Relative change of the eigenvalues that ends the iteration.
const TOLERANCE: f64 = 1e-7;

/// Sweeps of Jacobi's method, which converges quadratically.
const SWEEPS: usize = 30;

/// A mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// λ.
    pub eigenvalue: f64,
    /// x, with xᵀ M x = 1.
    pub vector: Vec<f64>,
}

/// The lowest modes of K x = λ M x, in ascending order: `count`, or as many as there are unknowns. `None` where no
/// factor is found.
///
/// ```
/// use lateen::linalg::{SparseMatrix, lowest_modes};
///
/// // Two masses on springs between walls: λ = 1 and 3.
/// let k = SparseMatrix::from_triplets(2, vec![(0, 0, 2.0), (0, 1, -1.0), (1, 0, -1.0), (1, 1, 2.0)]);
/// let m = SparseMatrix::from_triplets(2, vec![(0, 0, 1.0), (1, 1, 1.0)]);
/// let modes = lowest_modes(&k, &m, 2).unwrap();
/// assert!((modes[0].eigenvalue - 1.0).abs() < 1e-9 && (modes[1].eigenvalue - 3.0).abs() < 1e-9);
/// ```
pub fn lowest_modes(stiffness: &SparseMatrix, mass: &SparseMatrix, count: usize) -> Option<Vec<Mode>> {
    let n = stiffness.rows();
    let count = count.min(n);
    let shift = SHIFT * largest_ratio(stiffness, mass);
    let shifted = |entry: MatrixEntry| MatrixEntry { value: shift * entry.value, ..entry };
    let shifted: Vec<_> = mass.triplets().map(shifted).collect();
    let factor = PreconditioningFactor::double(&stiffness.with(&shifted))?;
    let mut vectors: Vec<Vec<f64>> = (0..(count + SPARE).min(n)).map(|k| start_vector(k, n)).collect();
    let mut last = vec![f64::INFINITY; count];
    let mut values = Vec::new();
    for _ in 0..ITERATIONS {
        vectors.iter_mut().for_each(|x| *x = product(mass, x));
        factor.solve_all(&mut vectors);
        orthonormalise(mass, &mut vectors)?;
        values = rotate(stiffness, &mut vectors);
        let scale = values.iter().take(count).fold(shift, |most: f64, value| most.max(value.abs()));
        let still = last
            .iter()
            .zip(&values)
            .all(|(last, value)| (last - value).abs() <= TOLERANCE * scale.min(value.abs() + shift));
        if still {
            break;
        }
        last.copy_from_slice(&values[..count]);
    }
    let modes = values.into_iter().zip(vectors).take(count);
    Some(modes.map(|(eigenvalue, vector)| Mode { eigenvalue, vector }).collect())
}

fn largest_ratio(stiffness: &SparseMatrix, mass: &SparseMatrix) -> f64 {
    let diagonal = |a: &SparseMatrix, row: usize| a.entry(row, row).map_or(0.0, |entry| a.values[entry]);
    let ratio = |row: usize| diagonal(stiffness, row) / diagonal(mass, row);
    (0..mass.rows()).map(ratio).filter(|ratio| ratio.is_finite()).fold(f64::MIN_POSITIVE, f64::max)
}

fn product(a: &SparseMatrix, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    a.multiply(x, &mut y);
    y
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Gram–Schmidt in M, each vector twice; `None` where one is no number.
fn orthonormalise(mass: &SparseMatrix, vectors: &mut [Vec<f64>]) -> Option<()> {
    let mut weighted: Vec<Vec<f64>> = Vec::with_capacity(vectors.len());
    for k in 0..vectors.len() {
        let (before, rest) = vectors.split_at_mut(k);
        let (own, mut image) = (&mut rest[0], Vec::new());
        for _ in 0..2 {
            for (other, weighted) in before.iter().zip(&weighted) {
                let part = dot(own, weighted);
                own.iter_mut().zip(other).for_each(|(x, y)| *x -= part * y);
            }
            image = product(mass, own);
            let norm = dot(own, &image).sqrt();
            if !(norm.is_finite() && norm > 0.0) {
                return None;
            }
            own.iter_mut().chain(&mut image).for_each(|x| *x /= norm);
        }
        weighted.push(image);
    }
    Some(())
}

/// Turns the vectors into the modes of K in their span; returns the eigenvalues, ascending.
fn rotate(stiffness: &SparseMatrix, vectors: &mut Vec<Vec<f64>>) -> Vec<f64> {
    let images: Vec<Vec<f64>> = vectors.iter().map(|x| product(stiffness, x)).collect();
    let mut a: Vec<Vec<f64>> = vectors.iter().map(|x| images.iter().map(|y| dot(x, y)).collect()).collect();
    diagonalise(&mut a, vectors);
    let mut order: Vec<usize> = (0..a.len()).collect();
    order.sort_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    *vectors = order.iter().map(|&k| std::mem::take(&mut vectors[k])).collect();
    order.into_iter().map(|k| a[k][k]).collect()
}

/// Turns vectors x_i, with a symmetric matrix of products a_ij of them, so that it becomes diagonal.
pub(super) fn diagonalise(a: &mut [Vec<f64>], vectors: &mut [Vec<f64>]) {
    for _ in 0..SWEEPS {
        for p in 0..a.len() {
            for q in p + 1..a.len() {
                jacobi(a, vectors, p, q);
            }
        }
    }
}

/// The rotation of rows, columns and vectors p and q that makes a_pq vanish.
fn jacobi(a: &mut [Vec<f64>], vectors: &mut [Vec<f64>], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let (c, s) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
    let turn = |x: f64, y: f64| (c * x - s * y, s * x + c * y);
    for row in a.iter_mut() {
        (row[p], row[q]) = turn(row[p], row[q]);
    }
    let (upper, lower) = a.split_at_mut(q);
    for (x, y) in upper[p].iter_mut().zip(&mut lower[0]) {
        (*x, *y) = turn(*x, *y);
    }
    let (upper, lower) = vectors.split_at_mut(q);
    for (x, y) in upper[p].iter_mut().zip(&mut lower[0]) {
        (*x, *y) = turn(*x, *y);
    }
    (a[p][q], a[q][p]) = (0.0, 0.0);
}
