//! The direct factorisation: S A S = L D Lᵀ, supernodal, by `faer` (theory F.15).
//!
//! ```text
//! A = [ K  G ; Gᵀ  −C ] is quasi-definite: L D Lᵀ exists for every order of elimination (Vanderbei 1995), so the
//! order is free to keep the fill small, and no pivoting is needed. The signs of D are those of A's diagonal.
//! ```
//! The order and the structure of L depend on the pattern alone and are kept; a new matrix costs the numbers only.
//! Of a matrix that isn't symmetric the symmetric part of R A is factorised, whose rows of continuity have been
//! multiplied so that they are nearly the transposed of the columns of pressure ([`BlockMatrix::row_balance`]): as a
//! preconditioner that is enough.

use super::dissection::nested_dissection;
use super::matrix::BlockMatrix;
use super::pattern::Pattern;
use dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::simplicial::{
    prefactorize_symbolic_cholesky, prefactorize_symbolic_cholesky_scratch,
};
use faer::sparse::linalg::cholesky::supernodal::{
    SupernodalLdltRef, SymbolicSupernodalCholesky, factorize_supernodal_numeric_ldlt,
    factorize_supernodal_numeric_ldlt_scratch, factorize_supernodal_symbolic_cholesky,
    factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

/// A pivot of a matrix scaled to a diagonal of ±1 that is smaller than this, or has the wrong sign, is replaced by the
/// square root of this with the sign that it should have.
const SMALLEST_PIVOT: f64 = 1e-12;

/// The precision in which a factor is kept.
///
/// The methods that call `faer` are compiled here for each of the two types, once, rather than in the crates that use
/// a solver.
pub(super) trait Precision: Copy + Send {
    /// Zero.
    const ZERO: Self;
    /// Rounds.
    fn round(value: f64) -> Self;
    /// Widens.
    fn widen(self) -> f64;
    /// Room for [`Precision::factorize`].
    fn scratch(symbolic: &SymbolicSupernodalCholesky<u32>) -> StackReq;
    /// Room for [`Precision::solve`] with so many right-hand sides.
    fn solve_scratch(symbolic: &SymbolicSupernodalCholesky<u32>, sides: usize) -> StackReq;
    /// L and D of the matrix with this lower part; returns the number of pivots that were replaced, as they were too
    /// small or had the wrong sign, or `None` where the factor breaks down.
    fn factorize(
        values: &mut [Self],
        lower: SparseColMatRef<'_, u32, Self>,
        signs: &[i8],
        symbolic: &SymbolicSupernodalCholesky<u32>,
        memory: &mut MemBuffer,
    ) -> Option<usize>;
    /// x ← (L D Lᵀ)⁻¹ x for every right-hand side, one after the other in `x`.
    fn solve(values: &[Self], symbolic: &SymbolicSupernodalCholesky<u32>, x: &mut [Self], memory: &mut MemBuffer);
}

/// The methods are the same for both types; `faer` wants them known one by one.
macro_rules! precision {
    ($T:ty) => {
        impl Precision for $T {
            const ZERO: Self = 0.0;

            fn round(value: f64) -> Self {
                value as Self
            }

            fn widen(self) -> f64 {
                f64::from(self)
            }

            fn scratch(symbolic: &SymbolicSupernodalCholesky<u32>) -> StackReq {
                factorize_supernodal_numeric_ldlt_scratch::<u32, $T>(symbolic, Par::Seq, Default::default())
            }

            fn solve_scratch(symbolic: &SymbolicSupernodalCholesky<u32>, sides: usize) -> StackReq {
                symbolic.solve_in_place_scratch::<$T>(sides, Par::Seq)
            }

            fn factorize(
                values: &mut [Self],
                lower: SparseColMatRef<'_, u32, Self>,
                signs: &[i8],
                symbolic: &SymbolicSupernodalCholesky<u32>,
                memory: &mut MemBuffer,
            ) -> Option<usize> {
                let regularization = LdltRegularization {
                    dynamic_regularization_signs: Some(signs),
                    dynamic_regularization_delta: SMALLEST_PIVOT.sqrt() as Self,
                    dynamic_regularization_epsilon: SMALLEST_PIVOT as Self,
                };
                let (stack, params) = (MemStack::new(memory), Default::default());
                factorize_supernodal_numeric_ldlt(values, lower, regularization, symbolic, Par::Seq, stack, params)
                    .ok()
                    .map(|info| info.dynamic_regularization_count)
            }

            fn solve(
                values: &[Self],
                symbolic: &SymbolicSupernodalCholesky<u32>,
                x: &mut [Self],
                memory: &mut MemBuffer,
            ) {
                let rows = symbolic.nrows();
                let sides = x.len().checked_div(rows).unwrap_or(0);
                let x = MatMut::from_column_major_slice_mut(x, rows, sides);
                let factor = SupernodalLdltRef::new(symbolic, values);
                factor.solve_in_place_with_conj(Conj::No, x, Par::Seq, MemStack::new(memory));
            }
        }
    };
}

precision!(f32);
precision!(f64);

/// The order of elimination and the structure of the factor: all that depends on the pattern alone.
pub(super) struct Analysis {
    /// `order[k]` is the node eliminated k-th.
    order: Vec<u32>,
    /// Entries of the matrix on and below the diagonal, by eliminated column: `blocks[first[k]..first[k + 1]]`,
    /// the diagonal first, then by eliminated row.
    first: Vec<u32>,
    blocks: Vec<u32>,
    /// The sparsity pattern as compressed columns of scalar entries.
    columns: ColumnPattern,
    symbolic: SymbolicSupernodalCholesky<u32>,
}

/// The sparsity pattern of a matrix, column by column.
struct ColumnPattern {
    start: Vec<u32>,
    rows: Vec<u32>,
}

impl ColumnPattern {
    fn view(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.start.len() - 1;
        SymbolicSparseColMatRef::new_unsorted_checked(n, n, &self.start, None, &self.rows)
    }

    fn transposed(&self) -> Self {
        let n = self.start.len() - 1;
        let mut start = vec![0; n + 1];
        self.rows.iter().for_each(|&row| start[row as usize + 1] += 1);
        (0..n).for_each(|row| start[row + 1] += start[row]);
        let mut next = start.clone();
        let mut rows = vec![0; self.rows.len()];
        for column in 0..n {
            for &row in &self.rows[self.start[column] as usize..self.start[column + 1] as usize] {
                rows[next[row as usize] as usize] = column as u32;
                next[row as usize] += 1;
            }
        }
        Self { start, rows }
    }
}

impl Analysis {
    /// The analysis for blocks of B = D + 1 unknowns; `None` if the factor would have more entries than 31 bits can
    /// count.
    pub fn new<const B: usize>(pattern: &Pattern, places: &[[f64; 3]]) -> Option<Self> {
        let order = nested_dissection(pattern, places, B - 1);
        let (first, blocks, columns) = lower_part::<B>(pattern, &order);
        // The analysis reads the upper part.
        let symbolic = structure(columns.transposed().view())?;
        Some(Self { order, first, blocks, columns, symbolic })
    }

    /// Numbers in the factor.
    pub fn entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Cost of a new factor, in iterations with a kept one.
    ///
    /// An iteration reads the factor twice, at the speed of memory; a new factor multiplies in cache. The ratio of
    /// the two speeds was measured once: it differs little from machine to machine, and only speed depends on it.
    pub fn price(&self) -> f64 {
        const MULTIPLICATIONS_PER_READ: f64 = 8.0;
        (self.operations() / (2.0 * self.entries() as f64 * MULTIPLICATIONS_PER_READ)).max(1.0)
    }

    /// Multiplications that a new factor takes.
    fn operations(&self) -> f64 {
        let columns = |s: usize| f64::from(self.symbolic.supernode_end()[s] - self.symbolic.supernode_begin()[s]);
        let below = |s: usize| self.symbolic.supernode(s).pattern().len() as f64;
        (0..self.symbolic.n_supernodes())
            .map(|s| columns(s) * (columns(s).powi(2) / 3.0 + below(s) * columns(s) + below(s).powi(2)) * 0.5)
            .sum()
    }
}

/// Blocks on and below the diagonal of the matrix in the order of elimination, and the places of their numbers.
fn lower_part<const B: usize>(pattern: &Pattern, order: &[u32]) -> (Vec<u32>, Vec<u32>, ColumnPattern) {
    let mut rank = vec![0u32; order.len()];
    (0u32..).zip(order).for_each(|(k, &node)| rank[node as usize] = k);
    let (mut first, mut blocks) = (vec![0], Vec::with_capacity(pattern.entries() / 2 + order.len()));
    let mut columns = ColumnPattern { start: vec![0], rows: Vec::new() };
    for (k, &node) in (0u32..).zip(order) {
        // Column k of the lower part, by symmetry of the pattern found in row k.
        let mut below: Vec<(u32, u32)> = pattern
            .row(node as usize)
            .map(|entry| (rank[pattern.columns()[entry] as usize], entry as u32))
            .filter(|&(row, _)| row >= k)
            .collect();
        below.sort_unstable();
        for b in 0..B as u32 {
            columns.rows.extend((b..B as u32).map(|a| k * B as u32 + a));
            columns.rows.extend(below[1..].iter().flat_map(|&(row, _)| (0..B as u32).map(move |a| row * B as u32 + a)));
            columns.start.push(columns.rows.len() as u32);
        }
        blocks.extend(below.iter().map(|&(_, entry)| entry));
        first.push(blocks.len() as u32);
    }
    (first, blocks, columns)
}

/// Elimination tree, counts and supernodes of a matrix given by its upper part.
pub(super) fn structure(upper: SymbolicSparseColMatRef<'_, u32>) -> Option<SymbolicSupernodalCholesky<u32>> {
    let n = upper.nrows();
    let (mut tree, mut counts) = (vec![0i32; n], vec![0u32; n]);
    let scratch = prefactorize_symbolic_cholesky_scratch::<u32>(n, upper.compute_nnz())
        .or(factorize_supernodal_symbolic_cholesky_scratch::<u32>(n));
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    let tree = prefactorize_symbolic_cholesky(&mut tree, &mut counts, upper, MemStack::new(&mut memory));
    let params = SymbolicSupernodalParams::default();
    factorize_supernodal_symbolic_cholesky(upper, tree, &counts, MemStack::new(&mut memory), params).ok()
}

/// The factor of one matrix.
pub(super) struct Factor<T> {
    values: Vec<T>,
    /// Diagonal s of S in S R A S, in the order of elimination.
    scaling: Vec<f64>,
    /// Factor r of each node in R.
    balance: Vec<f64>,
    work: Vec<T>,
    memory: MemBuffer,
}

impl<T: Precision> Factor<T> {
    /// Factorises the symmetric part of S R A S; `None` where it breaks down: a zero or undefined pivot.
    pub fn new<const B: usize>(analysis: &Analysis, a: &BlockMatrix<B>, scaling: &[[f64; B]]) -> Option<Self> {
        let values = vec![T::ZERO; analysis.entries()];
        let n = analysis.order.len() * B;
        let scratch = T::scratch(&analysis.symbolic).or(T::solve_scratch(&analysis.symbolic, 1));
        let memory = MemBuffer::try_new(scratch).ok()?;
        let mut factor = Self { values, scaling: Vec::new(), balance: Vec::new(), work: vec![T::ZERO; n], memory };
        factor.refresh(analysis, a, scaling).then_some(factor)
    }

    /// Replaces the factor by that of another matrix; says whether that went well.
    pub fn refresh<const B: usize>(&mut self, analysis: &Analysis, a: &BlockMatrix<B>, scaling: &[[f64; B]]) -> bool {
        let balance = a.row_balance();
        let numbers = scaled_lower::<B, T>(analysis, a, scaling, &balance);
        let signs = signs(analysis, a);
        self.scaling = analysis.order.iter().flat_map(|&node| scaling[node as usize]).collect();
        self.balance = analysis.order.iter().map(|&node| balance[node as usize]).collect();
        let lower = SparseColMatRef::new(analysis.columns.view(), &numbers[..]);
        T::factorize(&mut self.values, lower, &signs, &analysis.symbolic, &mut self.memory).is_some()
    }

    /// z = S (L D Lᵀ)⁻¹ S R r.
    pub fn solve<const B: usize>(&mut self, analysis: &Analysis, r: &[[f64; B]], z: &mut [[f64; B]]) {
        let scaling = self.scaling.as_chunks::<B>().0;
        let nodes = analysis.order.iter().zip(&self.balance);
        for ((work, s), (&node, &balance)) in self.work.as_chunks_mut::<B>().0.iter_mut().zip(scaling).zip(nodes) {
            let mut r = r[node as usize];
            r[B - 1] *= balance;
            *work = std::array::from_fn(|k| T::round(r[k] * s[k]));
        }
        T::solve(&self.values, &analysis.symbolic, &mut self.work, &mut self.memory);
        for (k, &node) in analysis.order.iter().enumerate() {
            z[node as usize] = std::array::from_fn(|c| self.scaling[k * B + c] * self.work[k * B + c].widen());
        }
    }
}

/// The numbers of the symmetric part of S R A S on and below the diagonal, in the order of [`Analysis::columns`].
fn scaled_lower<const B: usize, T: Precision>(
    analysis: &Analysis,
    a: &BlockMatrix<B>,
    s: &[[f64; B]],
    balance: &[f64],
) -> Vec<T> {
    let mut numbers = Vec::with_capacity(analysis.columns.rows.len());
    for (k, &node) in analysis.order.iter().enumerate() {
        let node = node as usize;
        let blocks = &analysis.blocks[analysis.first[k] as usize..analysis.first[k + 1] as usize];
        // Entry (k, i) of the row gives (i, k) of the column, transposed.
        let scaled: Vec<[[f64; B]; B]> = blocks
            .iter()
            .map(|&entry| {
                let (block, other) =
                    (a.symmetric((node, entry as usize), balance), &s[a.pattern.columns()[entry as usize] as usize]);
                std::array::from_fn(|b| std::array::from_fn(|i| block[b][i] * s[node][b] * other[i]))
            })
            .collect();
        for b in 0..B {
            numbers.extend(scaled[0][b][b..].iter().map(|&v| T::round(v)));
            numbers.extend(scaled[1..].iter().flat_map(|block| block[b]).map(T::round));
        }
    }
    numbers
}

/// The sign of each pivot: that of the diagonal; where it is zero, plus for velocity and minus for pressure.
fn signs<const B: usize>(analysis: &Analysis, a: &BlockMatrix<B>) -> Vec<i8> {
    let sign = |node: u32, k: usize| match a.values[a.pattern.diagonal(node as usize)][k][k] {
        v if v > 0.0 => 1,
        v if v < 0.0 => -1,
        _ if k + 1 < B => 1,
        _ => -1,
    };
    analysis.order.iter().flat_map(|&node| (0..B).map(move |k| sign(node, k))).collect()
}
