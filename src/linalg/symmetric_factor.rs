//! The factorisation of a symmetric positive definite sparse matrix: S A S = Pᵀ L Lᵀ P, by `faer`.
//!
//! The order P of least degree is one for symmetric places (Amestoy, Davis & Duff 1996): of solids in space it leaves a fraction of the
//! numbers that the factor with row exchanges has ([`SparseFactor`](super::SparseFactor)).

use super::sparse::{SparseFactor, SparseMatrix, solve_all_scaled, solve_scaled};
use faer::Side;
use faer::sparse::linalg::cholesky::factorize_symbolic_cholesky;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

/// The factor of the symmetric part of a matrix.
struct SymmetricFactor {
    factor: Llt<u32, f64>,
    scaling: Vec<f64>,
    work: Vec<f64>,
}

impl SymmetricFactor {
    /// Factorises ½ (A + Aᵀ); `None` where that isn't positive definite.
    fn new(a: &SparseMatrix) -> Option<Self> {
        let s = a.scaling();
        // The lower part by rows is the upper one by columns.
        let lower = |(row, column, value): (u32, u32, f64)| {
            let part = if row == column { 1.0 } else { 0.5 };
            (row.max(column), row.min(column), part * value * s[row as usize] * s[column as usize])
        };
        let upper = SparseMatrix::from_triplets(a.rows(), a.triplets().map(lower).collect());
        let places = SymbolicSparseColMatRef::new_checked(a.rows(), a.rows(), &upper.start, None, &upper.columns);
        let symbolic = SymbolicLlt::try_new(places, Side::Upper).ok()?;
        let matrix = SparseColMatRef::new(places, &upper.values[..]);
        let factor = Llt::try_new_with_symbolic(symbolic, matrix, Side::Upper).ok()?;
        Some(Self { factor, work: vec![0.0; s.len()], scaling: s })
    }

    /// z = (½ (A + Aᵀ))⁻¹ r.
    fn solve(&mut self, r: &[f64], z: &mut [f64]) {
        solve_scaled(&self.factor, &self.scaling, &mut self.work, r, z);
    }
}

/// Numbers in the factor of a symmetric matrix with these entries, of which those above its diagonal and on it count; `None` where they
/// are too many to be counted.
pub fn factor_numbers(a: &SparseMatrix) -> Option<usize> {
    let lower: Vec<_> = a.triplets().filter(|(row, column, _)| column >= row).map(|(r, c, v)| (c, r, v)).collect();
    let upper = SparseMatrix::from_triplets(a.rows(), lower);
    let places = SymbolicSparseColMatRef::new_checked(a.rows(), a.rows(), &upper.start, None, &upper.columns);
    let symbolic = factorize_symbolic_cholesky(places, Side::Upper, Default::default(), Default::default()).ok()?;
    Some(symbolic.len_val())
}

/// A factor that an iteration is preconditioned with: that of the symmetric part of a matrix where it is positive definite, or else of all
/// of it.
pub struct PreconditioningFactor(FactorKind);

enum FactorKind {
    Symmetric(SymmetricFactor),
    General(Box<SparseFactor>),
}

impl PreconditioningFactor {
    /// Factorises; `None` as in [`SparseFactor::new`].
    pub fn new(a: &SparseMatrix) -> Option<Self> {
        let symmetric = SymmetricFactor::new(a).map(FactorKind::Symmetric);
        symmetric.or_else(|| SparseFactor::new(a).map(Box::new).map(FactorKind::General)).map(Self)
    }

    /// z ≈ A⁻¹ r.
    pub fn solve(&mut self, r: &[f64], z: &mut [f64]) {
        match &mut self.0 {
            FactorKind::Symmetric(factor) => factor.solve(r, z),
            FactorKind::General(factor) => factor.solve(r, z),
        }
    }

    /// z ≈ A⁻¹ r in the place of each right-hand side: the factor is read once for all of them.
    pub fn solve_all(&self, sides: &mut [Vec<f64>]) {
        match &self.0 {
            FactorKind::Symmetric(SymmetricFactor { factor, scaling, .. }) => solve_all_scaled(factor, scaling, sides),
            FactorKind::General(factor) => factor.solve_all(sides),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix with the symmetric part H and a part that isn't symmetric, as entries.
    fn matrix(h: [[f64; 3]; 3], skew: f64) -> SparseMatrix {
        let entry = |i: usize, j: usize| (i as u32, j as u32, h[i][j] + skew * (j as f64 - i as f64));
        SparseMatrix::from_triplets(3, (0..9).map(|k| entry(k / 3, k % 3)).collect())
    }

    /// H (1, −2, 3)ᵀ is solved for (1, −2, 3), whatever isn't symmetric.
    #[test]
    fn the_symmetric_part_is_solved() {
        let h = [[4e6, 1e6, -2e6], [1e6, 3e6, 5e5], [-2e6, 5e5, 6e6]];
        let x = [1.0, -2.0, 3.0];
        let r: Vec<f64> = h.iter().map(|row| row.iter().zip(&x).map(|(h, x)| h * x).sum()).collect();
        for skew in [0.0, 1e5] {
            let mut factor = PreconditioningFactor::new(&matrix(h, skew)).unwrap();
            assert!(matches!(factor.0, FactorKind::Symmetric(_)));
            let mut z = [0.0; 3];
            factor.solve(&r, &mut z);
            let mut sides = [r.clone(), r.iter().map(|r| 2.0 * r).collect()];
            factor.solve_all(&mut sides);
            assert!(z.iter().zip(&x).all(|(z, x)| (z - x).abs() < 1e-14), "{z:?}");
            let near = |z: f64, x: f64| (z - x).abs() < 1e-14;
            assert!((0..3).all(|i| near(sides[0][i], x[i]) && near(sides[1][i], 2.0 * x[i])), "{sides:?}");
        }
    }

    /// An arrow with its head at the first unknown fills up if that is eliminated first, and has no fill if it is the last: 2 n − 1 numbers.
    #[test]
    fn an_order_of_least_degree_leaves_an_arrow_without_fill() {
        let n = 50;
        let arrow = (1..n).flat_map(|k| [(0, k, -1.0), (k, 0, -1.0), (k, k, n as f64)]).chain([(0, 0, n as f64)]);
        assert_eq!(factor_numbers(&SparseMatrix::from_triplets(n as usize, arrow.collect())), Some(2 * n as usize - 1));
    }

    /// With a symmetric part that isn't definite all of the matrix is factorised.
    #[test]
    fn all_of_an_indefinite_matrix_is_solved() {
        let a = matrix([[1.0, 4.0, 0.0], [4.0, 1.0, 0.0], [0.0, 0.0, 2.0]], 0.5);
        let x = [1.0, -2.0, 3.0];
        let (mut r, mut z) = ([0.0; 3], [0.0; 3]);
        a.multiply(&x, &mut r);
        // row 0 by hand
        assert_eq!(r[0], 1.0 - 4.5 * 2.0 + 3.0);
        let mut factor = PreconditioningFactor::new(&a).unwrap();
        assert!(matches!(factor.0, FactorKind::General(_)));
        factor.solve(&r, &mut z);
        assert!(z.iter().zip(&x).all(|(z, x)| (z - x).abs() < 1e-14), "{z:?}");
    }
}
