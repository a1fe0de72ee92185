//! General sparse matrices of scalar entries, and their factorisation with row exchanges: S A S = Pᵀ L U, by `faer`.
//!
//! For parts of a system that have no mesh of simplices, as elastic solids. S scales the diagonal to ±1.

use crate::parallel;
use faer::MatMut;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use std::ops::Range;

/// Rows per piece of a parallel loop.
const ROWS_PER_PIECE: usize = 128;

/// An entry of a matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatrixEntry {
    /// Its row.
    pub row: u32,
    /// Its column.
    pub column: u32,
    /// Its value.
    pub value: f64,
}

impl MatrixEntry {
    /// The entry in a row and a column.
    pub fn new(row: u32, column: u32, value: f64) -> Self {
        Self { row, column, value }
    }
}

impl From<(u32, u32, f64)> for MatrixEntry {
    fn from((row, column, value): (u32, u32, f64)) -> Self {
        Self { row, column, value }
    }
}

/// A square sparse matrix by compressed rows; columns ascend within a row.
///
/// ```
/// use lateen::linalg::{SparseFactor, SparseMatrix};
///
/// let a = SparseMatrix::from_triplets(2, vec![(0, 0, 1.0), (0, 1, 2.0), (1, 0, 3.0), (0, 0, 3.0)]);
/// let mut r = [0.0; 2];
/// a.multiply(&[1.0, 5.0], &mut r);
/// assert_eq!(r, [14.0, 3.0]);
/// let mut z = [0.0; 2];
/// SparseFactor::new(&a).unwrap().solve(&r, &mut z);
/// assert!((z[0] - 1.0).abs() < 1e-15 && (z[1] - 5.0).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SparseMatrix {
    /// Entries of row i are `start[i]..start[i + 1]`.
    pub start: Vec<u32>,
    /// Column of every entry.
    pub columns: Vec<u32>,
    /// Value of every entry.
    pub values: Vec<f64>,
}

/// Entries (column, value) sorted by row, otherwise in their order, and where each row begins.
fn by_row(rows: usize, entries: Vec<MatrixEntry>) -> (Vec<u32>, Vec<(u32, f64)>) {
    let mut first = vec![0u32; rows + 1];
    entries.iter().for_each(|entry| first[entry.row as usize + 1] += 1);
    (0..rows).for_each(|row| first[row + 1] += first[row]);
    let (mut next, mut sorted) = (first.clone(), vec![(0, 0.0); entries.len()]);
    for MatrixEntry { row, column, value } in entries {
        let place = &mut next[row as usize];
        sorted[*place as usize] = (column, value);
        *place += 1;
    }
    (first, sorted)
}

impl SparseMatrix {
    /// A matrix of `rows` rows and columns, from its entries, also as (row, column, value); those at one place are added
    /// in their order.
    pub fn from_triplets(rows: usize, entries: impl IntoIterator<Item = impl Into<MatrixEntry>>) -> Self {
        let (first, sorted) = by_row(rows, entries.into_iter().map(Into::into).collect());
        Self::from_rows(rows, |row, sums| {
            sums.extend(&sorted[first[row] as usize..first[row + 1] as usize]);
            Self::sum_alike(sums);
        })
    }

    /// Orders entries (column, value) of a row, and adds those of one column in their order.
    pub(super) fn sum_alike(entries: &mut Vec<(u32, f64)>) {
        // Stable, so that sums have one order.
        entries.sort_by_key(|&(column, _)| column);
        entries.dedup_by(|next, last| {
            let is_same = next.0 == last.0;
            if is_same {
                last.1 += next.1;
            }
            is_same
        });
    }

    /// A matrix of `rows` rows, of which `entries_of` adds the entries (column, value) to an empty list, columns
    /// ascending.
    pub fn from_rows(rows: usize, entries_of: impl Fn(usize, &mut Vec<(u32, f64)>) + Sync) -> Self {
        let pieces = parallel::map_ranges(rows, ROWS_PER_PIECE, |range| {
            let (mut of_row, mut counts, mut all) = (Vec::new(), Vec::with_capacity(range.len()), Vec::new());
            for row in range {
                of_row.clear();
                entries_of(row, &mut of_row);
                counts.push(of_row.len() as u32);
                all.extend_from_slice(&of_row);
            }
            (counts, all)
        });
        let count = pieces.iter().map(|(_, all)| all.len()).sum();
        let mut start = Vec::with_capacity(rows + 1);
        let (mut columns, mut values) = (Vec::with_capacity(count), Vec::with_capacity(count));
        start.push(0);
        for (counts, all) in pieces {
            for count in counts {
                start.push(start.last().map_or(0, |end| end + count));
            }
            columns.extend(all.iter().map(|(column, _)| column));
            values.extend(all.iter().map(|(_, value)| value));
        }
        Self { start, columns, values }
    }

    /// Aᵀ.
    pub fn transposed(&self) -> Self {
        let mut start = vec![0u32; self.start.len()];
        self.columns.iter().for_each(|&column| start[column as usize + 1] += 1);
        (1..start.len()).for_each(|k| start[k] += start[k - 1]);
        let mut next = start.clone();
        let (mut columns, mut values) = (vec![0; self.columns.len()], vec![0.0; self.columns.len()]);
        for MatrixEntry { row, column, value } in self.triplets() {
            let place = &mut next[column as usize];
            (columns[*place as usize], values[*place as usize]) = (row, value);
            *place += 1;
        }
        Self { start, columns, values }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.start.len() - 1
    }

    /// The entries of a row.
    pub fn row(&self, row: usize) -> Range<usize> {
        self.start[row] as usize..self.start[row + 1] as usize
    }

    /// The entry at (`row`, `column`), if there is one.
    pub fn entry(&self, row: usize, column: usize) -> Option<usize> {
        let range = self.row(row);
        self.columns[range.clone()].binary_search(&(column as u32)).ok().map(|place| range.start + place)
    }

    /// All entries, by rows.
    pub fn triplets(&self) -> impl Iterator<Item = MatrixEntry> + '_ {
        let entry = move |row: usize, n: usize| MatrixEntry::new(row as u32, self.columns[n], self.values[n]);
        let of_row = move |row: usize| self.row(row).map(move |n| entry(row, n));
        (0..self.rows()).flat_map(of_row)
    }

    /// The entries in these rows and columns, which ascend.
    pub fn of(&self, unknowns: &[u32]) -> Self {
        Self::from_rows(unknowns.len(), |row, entries| {
            let range = self.row(unknowns[row] as usize);
            let all = self.columns[range.clone()].iter().zip(&self.values[range]);
            entries
                .extend(all.filter_map(|(column, value)| Some((unknowns.binary_search(column).ok()? as u32, *value))));
        })
    }

    /// Appends rows and columns with these entries on the diagonal alone.
    pub fn append_diagonal(&mut self, entries: impl Iterator<Item = f64>) {
        for entry in entries {
            self.columns.push(self.rows() as u32);
            self.values.push(entry);
            self.start.push(self.columns.len() as u32);
        }
    }

    /// The matrix with more entries added.
    #[must_use]
    pub fn with(&self, more: &[MatrixEntry]) -> Self {
        Self::from_triplets(self.rows(), self.triplets().chain(more.iter().copied()))
    }

    /// The matrix in which every entry is a full block of `size` rows and columns of zeros.
    #[must_use]
    pub fn zero_blocks(&self, size: usize) -> Self {
        let count = self.columns.len() * size * size;
        let (mut start, mut columns) = (vec![0], Vec::with_capacity(count));
        for row in 0..self.rows() {
            for _ in 0..size {
                let own = &self.columns[self.row(row)];
                columns.extend(own.iter().flat_map(|&column| (0..size).map(move |k| column * size as u32 + k as u32)));
                start.push(columns.len() as u32);
            }
        }
        Self { start, columns, values: vec![0.0; count] }
    }

    /// y = A x.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        for (row, y) in y.iter_mut().enumerate() {
            *y = self.row(row).map(|n| self.values[n] * x[self.columns[n] as usize]).sum();
        }
    }

    /// 1/√|a_ii|; 1 where that is zero.
    pub fn scaling(&self) -> Vec<f64> {
        let diagonal = |row: usize| self.entry(row, row).map_or(0.0, |n| self.values[n].abs());
        (0..self.rows()).map(|row| if diagonal(row) > 0.0 { 1.0 / diagonal(row).sqrt() } else { 1.0 }).collect()
    }
}

/// The factor of a sparse matrix.
pub struct SparseFactor {
    factor: Lu<u32, f64>,
    symbolic: SymbolicLu<u32>,
    columns: CompressedColumns,
    scaling: Vec<f64>,
    work: Vec<f64>,
}

/// A matrix by compressed columns.
#[derive(Default)]
struct CompressedColumns {
    start: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl CompressedColumns {
    /// S A S.
    fn scaled(a: &SparseMatrix, s: &[f64]) -> Self {
        let n = a.rows();
        let mut start = vec![0; n + 1];
        a.columns.iter().for_each(|&column| start[column as usize + 1] += 1);
        (0..n).for_each(|column| start[column + 1] += start[column]);
        let mut next = start.clone();
        let (mut rows, mut values) = (vec![0; a.columns.len()], vec![0.0; a.columns.len()]);
        for MatrixEntry { row, column, value } in a.triplets() {
            let place = &mut next[column as usize];
            rows[*place as usize] = row;
            values[*place as usize] = value * s[row as usize] * s[column as usize];
            *place += 1;
        }
        Self { start, rows, values }
    }

    fn pattern(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.start.len() - 1;
        SymbolicSparseColMatRef::new_checked(n, n, &self.start, None, &self.rows)
    }

    fn factor(&self, symbolic: &SymbolicLu<u32>) -> Option<Lu<u32, f64>> {
        Lu::try_new_with_symbolic(symbolic.clone(), SparseColMatRef::new(self.pattern(), &self.values[..])).ok()
    }
}

/// z = S (S A S)⁻¹ S r with the factor of S A S; `work` is workspace for a vector.
pub(super) fn solve_scaled(factor: &impl Solve<f64>, scaling: &[f64], work: &mut [f64], r: &[f64], z: &mut [f64]) {
    work.iter_mut().zip(r).zip(scaling).for_each(|((work, r), s)| *work = r * s);
    let rows = work.len();
    factor.solve_in_place(MatMut::from_column_major_slice_mut(work, rows, 1));
    z.iter_mut().zip(&*work).zip(scaling).for_each(|((z, work), s)| *z = work * s);
}

/// The same for several right-hand sides, each in its place.
pub(super) fn solve_all_scaled(factor: &impl Solve<f64>, scaling: &[f64], sides: &mut [Vec<f64>]) {
    let rows = scaling.len();
    let scaled = |side: &Vec<f64>| side.iter().zip(scaling).map(|(r, s)| r * s).collect::<Vec<_>>();
    let mut work: Vec<f64> = sides.iter().flat_map(scaled).collect();
    factor.solve_in_place(MatMut::from_column_major_slice_mut(&mut work, rows, sides.len()));
    for (side, solution) in sides.iter_mut().zip(work.chunks_exact(rows)) {
        side.iter_mut().zip(solution).zip(scaling).for_each(|((z, work), s)| *z = work * s);
    }
}

impl SparseFactor {
    /// Factorises; `None` where the structure makes the matrix singular, or it has more entries than 31 bits can count.
    pub fn new(a: &SparseMatrix) -> Option<Self> {
        if a.columns.len() > i32::MAX as usize {
            return None;
        }
        let scaling = a.scaling();
        let columns = CompressedColumns::scaled(a, &scaling);
        let symbolic = SymbolicLu::try_new(columns.pattern()).ok()?;
        let factor = columns.factor(&symbolic)?;
        Some(Self { factor, symbolic, columns, work: vec![0.0; scaling.len()], scaling })
    }

    /// The factor of another matrix in place of this; the order of elimination is kept if the sparsity pattern is the
    /// same. `None` as in [`SparseFactor::new`].
    #[must_use]
    pub fn renewed(self, a: &SparseMatrix) -> Option<Self> {
        let scaling = a.scaling();
        let columns = CompressedColumns::scaled(a, &scaling);
        if columns.start != self.columns.start || columns.rows != self.columns.rows {
            return Self::new(a);
        }
        let factor = columns.factor(&self.symbolic)?;
        Some(Self { factor, columns, scaling, ..self })
    }

    /// z = A⁻¹ r; not finite where A is singular.
    pub fn solve(&mut self, r: &[f64], z: &mut [f64]) {
        solve_scaled(&self.factor, &self.scaling, &mut self.work, r, z);
    }

    /// A⁻¹ r in the place of each right-hand side: the factor is read once for all of them.
    pub fn solve_all(&self, sides: &mut [Vec<f64>]) {
        solve_all_scaled(&self.factor, &self.scaling, sides);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// −u'' on a line with a skew part and a zero on the diagonal: the solution is put in.
    fn unsymmetric(n: usize) -> SparseMatrix {
        let row = |i: usize| {
            let near = [i.checked_sub(1), Some(i), (i + 1 < n).then_some(i + 1)].into_iter().flatten();
            near.map(move |j| {
                let value = match (i, j) {
                    (5, 5) => 0.0,
                    (i, j) if i == j => 2.0 + i as f64,
                    (i, j) => -1.0 + 0.5 * (i as f64 - j as f64),
                };
                (i as u32, j as u32, 1e6 * value)
            })
        };
        SparseMatrix::from_triplets(n, (0..n).flat_map(row))
    }

    #[test]
    fn solves_what_was_multiplied() {
        let a = unsymmetric(40);
        let x: Vec<f64> = (0..40).map(|i| (1.0 + i as f64).sin()).collect();
        let (mut r, mut z) = (vec![0.0; 40], vec![0.0; 40]);
        a.multiply(&x, &mut r);
        // row 7 by hand
        assert!((r[7] - 1e6 * (-0.5 * x[6] + 9.0 * x[7] - 1.5 * x[8])).abs() < 1e-9);
        let mut factor = SparseFactor::new(&a).unwrap();
        factor.solve(&r, &mut z);
        assert!(x.iter().zip(&z).all(|(x, z)| (x - z).abs() < 1e-12));
        let mut sides = [r.clone(), r.iter().map(|r| -2.0 * r).collect()];
        factor.solve_all(&mut sides);
        assert!(x.iter().zip(&sides[0]).zip(&sides[1]).all(|((x, a), b)| (x - a).abs() + (2.0 * x + b).abs() < 1e-12));
        let more = a.with(&[4e6, 5e6].map(|value| MatrixEntry::new(3, 3, value)));
        more.multiply(&x, &mut r);
        let mut factor = factor.renewed(&more).unwrap();
        factor.solve(&r, &mut z);
        assert!(x.iter().zip(&z).all(|(x, z)| (x - z).abs() < 1e-12));
        let wider = more.with(&[MatrixEntry::new(0, 39, 1e6)]);
        wider.multiply(&x, &mut r);
        factor.renewed(&wider).unwrap().solve(&r, &mut z);
        assert!(x.iter().zip(&z).all(|(x, z)| (x - z).abs() < 1e-12));
    }

    #[test]
    fn a_singular_matrix_gives_no_finite_solution() {
        let a = SparseMatrix::from_triplets(2, vec![(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0)]);
        let mut z = [0.0; 2];
        let solved = SparseFactor::new(&a).is_some_and(|mut factor| {
            factor.solve(&[1.0, 2.0], &mut z);
            z.iter().all(|z| z.is_finite())
        });
        assert!(!solved, "{z:?}");
    }

    #[test]
    fn blocks_of_zeros_have_the_pattern_of_the_entries() {
        let a = SparseMatrix::from_triplets(2, vec![(0, 1, 1.0), (1, 1, 1.0)]).zero_blocks(2);
        assert_eq!((&a.start[..], &a.columns[..]), (&[0, 2, 4, 6, 8][..], &[2, 3, 2, 3, 2, 3, 2, 3][..]));
    }
}
