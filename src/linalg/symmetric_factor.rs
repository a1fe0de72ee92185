//! The factorisation of the symmetric part of a sparse matrix: S ½ (A + Aᵀ) S = Pᵀ L D Lᵀ P, by `faer` (theory J.4).
//!
//! The order P of least degree is one for symmetric patterns (Amestoy, Davis & Duff 1996): of solids in space it leaves
//! a fraction of the entries that the factor with row exchanges has ([`SparseFactor`](super::SparseFactor)).
//!
//! As a preconditioner a factor in single precision takes half the time. It is used where its rounding does no harm.
//! With M the inverse of H by the factor, and x = M r for some r, in which the softest motions are largest, |x − M H x|
//! must be small beside |x|.

use super::direct::{Precision, structure};
use super::sparse::{MatrixEntry, SparseFactor, SparseMatrix};
use super::vectors::{norm, start_vector};
use dyn_stack::{MemBuffer, MemStack};
use faer::Side;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::factorize_symbolic_cholesky;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

/// Largest |x − M H x|/|x| with which a factor in single precision is used.
const LARGEST_ROUNDING: f64 = 1e-2;

/// The symbolic factor of a symmetric matrix H.
struct SymbolicFactor {
    /// `order[k]` is the unknown that is eliminated k-th.
    order: Vec<u32>,
    /// Diagonal of S, by unknown.
    scaling: Vec<f64>,
    symbolic: SymbolicSupernodalCholesky<u32>,
}

/// The symmetric part H of a matrix, on its diagonal and below, and its symbolic factor.
struct Analysed {
    structure: SymbolicFactor,
    /// S H S in the order of elimination; rows of this are its columns.
    lower: SparseMatrix,
}

impl Analysed {
    /// The symmetric part of a matrix; `None` if its factor would have more numbers than can be counted.
    fn new(a: &SparseMatrix) -> Option<Self> {
        let (order, scaling) = (least_degree(a)?, a.scaling());
        let lower = lower_part(a, &order, &scaling);
        let symbolic = structure(pattern(&lower.transposed()))?;
        Some(Self { structure: SymbolicFactor { order, scaling, symbolic }, lower })
    }

    /// The factor; `None` where H isn't positive definite.
    fn factor<T: Precision>(&self) -> Option<Vec<T>> {
        let SymbolicFactor { order, symbolic, .. } = &self.structure;
        let mut values = vec![T::ZERO; symbolic.len_val()];
        let numbers: Vec<T> = self.lower.values.iter().map(|&value| T::round(value)).collect();
        let matrix = SparseColMatRef::new(pattern(&self.lower), &numbers[..]);
        let mut memory = MemBuffer::try_new(T::scratch(symbolic)).ok()?;
        let replaced = T::factorize(&mut values, matrix, &vec![1; order.len()], symbolic, &mut memory)?;
        (replaced == 0).then_some(values)
    }

    /// The factor in single precision, where that is enough.
    fn single_factor(&self) -> Option<Vec<f32>> {
        self.factor().filter(|factor| self.rounding(factor) < LARGEST_ROUNDING)
    }

    /// |x − M H x| / |x| with the inverse M by the factor, for x = M r with some r.
    fn rounding<T: Precision>(&self, factor: &[T]) -> f64 {
        let mut soft = [start_vector(0, self.lower.rows())];
        self.structure.solve_all(factor, &mut soft);
        let mut again = [self.multiply(&soft[0])];
        self.structure.solve_all(factor, &mut again);
        let change: Vec<f64> = soft[0].iter().zip(&again[0]).map(|(x, y)| x - y).collect();
        norm(&change) / norm(&soft[0])
    }

    /// H x.
    fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let SymbolicFactor { order, scaling, .. } = &self.structure;
        let mut y = vec![0.0; x.len()];
        for MatrixEntry { row, column, value } in self.lower.triplets() {
            let [k, i] = [row, column].map(|place| order[place as usize] as usize);
            let value = value / (scaling[i] * scaling[k]);
            y[i] += value * x[k];
            y[k] += if i == k { 0.0 } else { value * x[i] };
        }
        y
    }
}

impl SymbolicFactor {
    /// H⁻¹ r in the place of each right-hand side: the factor is read once for all of them.
    fn solve_all<T: Precision>(&self, factor: &[T], sides: &mut [Vec<f64>]) {
        let scaled = |side: &[f64], k: u32| side[k as usize] * self.scaling[k as usize];
        let largest = |side: &Vec<f64>| self.order.iter().map(|&k| scaled(side, k).abs()).fold(0.0, f64::max);
        // Of the size of one, as single precision has a short range.
        let sizes: Vec<f64> = sides.iter().map(largest).map(|size| if size > 0.0 { size } else { 1.0 }).collect();
        let mut all: Vec<T> = Vec::with_capacity(sides.len() * self.order.len());
        for (side, size) in sides.iter().zip(&sizes) {
            all.extend(self.order.iter().map(|&k| T::round(scaled(side, k) / size)));
        }
        let mut memory = MemBuffer::new(T::solve_scratch(&self.symbolic, sides.len()));
        T::solve(factor, &self.symbolic, &mut all, &mut memory);
        let solutions = all.chunks_exact(self.order.len().max(1));
        for ((side, solution), size) in sides.iter_mut().zip(solutions).zip(&sizes) {
            for (&k, x) in self.order.iter().zip(solution) {
                side[k as usize] = size * x.widen() * self.scaling[k as usize];
            }
        }
    }
}

/// The sparsity pattern of a matrix whose rows are taken as columns.
fn pattern(matrix: &SparseMatrix) -> SymbolicSparseColMatRef<'_, u32> {
    SymbolicSparseColMatRef::new_checked(matrix.rows(), matrix.rows(), &matrix.start, None, &matrix.columns)
}

/// The order of least degree for the pattern of A + Aᵀ.
fn least_degree(a: &SparseMatrix) -> Option<Vec<u32>> {
    let (mut order, mut rank) = (vec![0; a.rows()], vec![0; a.rows()]);
    let mut memory = MemBuffer::try_new(amd::order_scratch::<u32>(a.rows(), a.columns.len())).ok()?;
    amd::order(&mut order, &mut rank, pattern(a), Default::default(), MemStack::new(&mut memory)).ok()?;
    Some(order)
}

/// The entries of ½ S (A + Aᵀ) S on its diagonal and below, in an order of elimination, by columns.
fn lower_part(a: &SparseMatrix, order: &[u32], s: &[f64]) -> SparseMatrix {
    let transposed = a.transposed();
    let mut rank = vec![0; order.len()];
    (0..).zip(order).for_each(|(k, &unknown)| rank[unknown as usize] = k);
    let row_of = |matrix: &'_ SparseMatrix, row: usize, entries: &mut Vec<(u32, f64)>| {
        let range = matrix.row(row);
        let scaled = matrix.columns[range.clone()].iter().zip(&matrix.values[range]);
        entries.extend(scaled.map(|(&column, value)| (column, 0.5 * value * s[row] * s[column as usize])));
    };
    SparseMatrix::from_rows(a.rows(), |k, entries| {
        let unknown = order[k] as usize;
        row_of(a, unknown, entries);
        row_of(&transposed, unknown, entries);
        SparseMatrix::sum_alike(entries);
        entries.retain_mut(|(column, _)| {
            *column = rank[*column as usize];
            *column as usize >= k
        });
        entries.sort_unstable_by_key(|&(row, _)| row);
    })
}

/// Entries of the factor of a symmetric matrix with these entries, of which those on its diagonal and below count;
/// `None` where they are too many to be counted.
pub fn factor_numbers(a: &SparseMatrix) -> Option<usize> {
    let upper = SparseMatrix::from_triplets(a.rows(), a.triplets().filter(|entry| entry.column <= entry.row));
    let pattern = SymbolicSparseColMatRef::new_checked(a.rows(), a.rows(), &upper.start, None, &upper.columns);
    let symbolic = factorize_symbolic_cholesky(pattern, Side::Upper, Default::default(), Default::default()).ok()?;
    Some(symbolic.len_val())
}

/// A factor that an iteration is preconditioned with: that of the symmetric part of a matrix where it is positive
/// definite, or else of all of it.
pub struct PreconditioningFactor(FactorKind);

enum FactorKind {
    Single(Box<SymbolicFactor>, Vec<f32>),
    Double(Box<SymbolicFactor>, Vec<f64>),
    General(Box<SparseFactor>),
}

impl PreconditioningFactor {
    /// Factorises; `None` as in [`SparseFactor::new`].
    pub fn new(a: &SparseMatrix) -> Option<Self> {
        let symmetric = Analysed::new(a).and_then(|analysed| match analysed.single_factor() {
            Some(factor) => Some(FactorKind::Single(Box::new(analysed.structure), factor)),
            None => double(analysed),
        });
        symmetric.or_else(|| general(a)).map(Self)
    }

    /// The same in double precision, for iterations whose result is only as good as their factor.
    pub fn double(a: &SparseMatrix) -> Option<Self> {
        Analysed::new(a).and_then(double).or_else(|| general(a)).map(Self)
    }

    /// z ≈ A⁻¹ r in the place of each right-hand side: the factor is read once for all of them.
    pub fn solve_all(&self, sides: &mut [Vec<f64>]) {
        match &self.0 {
            FactorKind::Single(structure, factor) => structure.solve_all(factor, sides),
            FactorKind::Double(structure, factor) => structure.solve_all(factor, sides),
            FactorKind::General(factor) => factor.solve_all(sides),
        }
    }
}

/// The factor of the symmetric part; `None` where that isn't positive definite.
fn double(analysed: Analysed) -> Option<FactorKind> {
    let factor = analysed.factor()?;
    Some(FactorKind::Double(Box::new(analysed.structure), factor))
}

/// The factor with row exchanges.
fn general(a: &SparseMatrix) -> Option<FactorKind> {
    SparseFactor::new(a).map(Box::new).map(FactorKind::General)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix with the symmetric part H and a part that isn't symmetric, as entries.
    fn matrix(h: [[f64; 3]; 3], skew: f64) -> SparseMatrix {
        let entry = |i: usize, j: usize| (i as u32, j as u32, h[i][j] + skew * (j as f64 - i as f64));
        SparseMatrix::from_triplets(3, (0..9).map(|k| entry(k / 3, k % 3)))
    }

    /// H (1, −2, 3)ᵀ is solved for (1, −2, 3), whatever isn't symmetric.
    #[test]
    fn the_symmetric_part_is_solved() {
        let h = [[4e6, 1e6, -2e6], [1e6, 3e6, 5e5], [-2e6, 5e5, 6e6]];
        let x = [1.0, -2.0, 3.0];
        let r: Vec<f64> = h.iter().map(|row| row.iter().zip(&x).map(|(h, x)| h * x).sum()).collect();
        for skew in [0.0, 1e5] {
            let factor = PreconditioningFactor::double(&matrix(h, skew)).unwrap();
            assert!(matches!(factor.0, FactorKind::Double(..)));
            let mut z = [r.clone()];
            factor.solve_all(&mut z);
            let mut sides = [r.clone(), r.iter().map(|r| 2.0 * r).collect()];
            factor.solve_all(&mut sides);
            assert!(z[0].iter().zip(&x).all(|(z, x)| (z - x).abs() < 1e-14), "{z:?}");
            let near = |z: f64, x: f64| (z - x).abs() < 1e-14;
            assert!((0..3).all(|i| near(sides[0][i], x[i]) && near(sides[1][i], 2.0 * x[i])), "{sides:?}");
        }
    }

    /// Single precision serves where it resolves the softest motion, of a weak spring that carries a chain of springs
    /// of 1 N/m: of 1e-3 N/m, not of 1e-9 N/m.
    #[test]
    fn single_precision_serves_where_rounding_is_small() {
        let chain = |weak: f64| {
            let spring = |k: u32| [(k, k, 1.0), (k + 1, k + 1, 1.0), (k, k + 1, -1.0), (k + 1, k, -1.0)];
            SparseMatrix::from_triplets(20, (0..19).flat_map(spring).chain([(0, 0, weak)]))
        };
        let kind = |weak: f64| PreconditioningFactor::new(&chain(weak)).unwrap();
        assert!(matches!(kind(1e-3).0, FactorKind::Single(..)) && matches!(kind(1e-9).0, FactorKind::Double(..)));
        // A force at the end stretches all springs: 1/1e-3 + 19 m per N.
        let mut force = [vec![0.0; 20]];
        force[0][19] = 1.0;
        kind(1e-3).solve_all(&mut force);
        assert!((force[0][19] / 1019.0 - 1.0).abs() < 1e-2, "{}", force[0][19]);
    }

    /// An arrow with its head at the first unknown fills up if that is eliminated first, and has no fill if it is the
    /// last: 2 n − 1 entries.
    #[test]
    fn an_order_of_least_degree_leaves_an_arrow_without_fill() {
        let n = 50;
        let arrow = (1..n).flat_map(|k| [(0, k, -1.0), (k, 0, -1.0), (k, k, n as f64)]).chain([(0, 0, n as f64)]);
        assert_eq!(factor_numbers(&SparseMatrix::from_triplets(n as usize, arrow)), Some(2 * n as usize - 1));
    }

    /// With a symmetric part that isn't definite all of the matrix is factorised.
    #[test]
    fn all_of_an_indefinite_matrix_is_solved() {
        let a = matrix([[1.0, 4.0, 0.0], [4.0, 1.0, 0.0], [0.0, 0.0, 2.0]], 0.5);
        let x = [1.0, -2.0, 3.0];
        let mut r = [0.0; 3];
        a.multiply(&x, &mut r);
        // row 0 by hand
        assert_eq!(r[0], 1.0 - 4.5 * 2.0 + 3.0);
        let factor = PreconditioningFactor::new(&a).unwrap();
        assert!(matches!(factor.0, FactorKind::General(_)));
        let mut z = [r.to_vec()];
        factor.solve_all(&mut z);
        assert!(z[0].iter().zip(&x).all(|(z, x)| (z - x).abs() < 1e-14), "{z:?}");
    }
}
