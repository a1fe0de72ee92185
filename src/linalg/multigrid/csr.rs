//! Sparse matrices of scalar entries, row by row, in single precision, for preconditioners.

use rayon::prelude::*;

/// Rows per task. Every row is computed in one task: the same bits for any number of threads.
const ROWS: usize = 2048;

/// A sparse matrix; the columns of a row stand in no special order.
#[derive(Debug, Clone, Default)]
pub(in crate::linalg) struct Csr {
    /// Row i is `start[i]..start[i + 1]`.
    pub start: Vec<u32>,
    pub columns: Vec<u32>,
    pub values: Vec<f32>,
    /// Number of columns.
    pub width: usize,
}

impl Csr {
    pub fn rows(&self) -> usize {
        self.start.len() - 1
    }

    /// Columns and values of a row.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let range = self.start[i] as usize..self.start[i + 1] as usize;
        self.columns[range.clone()].iter().map(|&j| j as usize).zip(self.values[range].iter().copied())
    }

    /// A matrix of the rows that `fill` appends, given a row and a scratch row of sums over `width` columns.
    pub fn from_rows(rows: usize, width: usize, fill: impl Fn(usize, &mut SparseRow) + Sync) -> Self {
        let parts: Vec<(Vec<u32>, Vec<u32>, Vec<f32>)> = (0..rows.div_ceil(ROWS))
            .into_par_iter()
            .map_init(
                || SparseRow::new(width),
                |sums, chunk| {
                    let (mut lengths, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
                    for i in chunk * ROWS..((chunk + 1) * ROWS).min(rows) {
                        fill(i, sums);
                        lengths.push(sums.columns.len() as u32);
                        sums.drain_into(&mut columns, &mut values);
                    }
                    (lengths, columns, values)
                },
            )
            .collect();
        let entries = parts.iter().map(|part| part.1.len()).sum();
        let (mut start, mut columns, mut values) = (vec![0], Vec::with_capacity(entries), Vec::with_capacity(entries));
        for (lengths, part_columns, part_values) in parts {
            lengths.iter().for_each(|length| start.push(start[start.len() - 1] + length));
            columns.extend(part_columns);
            values.extend(part_values);
        }
        Self { start, columns, values, width }
    }

    /// A ← S A S with a diagonal S.
    pub fn scale_by(&mut self, scaling: &[f32]) {
        for i in 0..self.rows() {
            for entry in self.start[i] as usize..self.start[i + 1] as usize {
                self.values[entry] *= scaling[i] * scaling[self.columns[entry] as usize];
            }
        }
    }

    /// The product with another matrix.
    pub fn product(&self, other: &Self) -> Self {
        Self::from_rows(self.rows(), other.width, |i, sums| {
            for (k, a) in self.row(i) {
                other.row(k).for_each(|(j, b)| sums.add(j, a * b));
            }
        })
    }

    pub fn transposed(&self) -> Self {
        let mut start = vec![0u32; self.width + 1];
        self.columns.iter().for_each(|&j| start[j as usize + 1] += 1);
        (0..self.width).for_each(|j| start[j + 1] += start[j]);
        let mut next = start.clone();
        let (mut columns, mut values) = (vec![0; self.columns.len()], vec![0.0; self.values.len()]);
        for i in 0..self.rows() {
            for (j, a) in self.row(i) {
                let place = next[j] as usize;
                (columns[place], values[place]) = (i as u32, a);
                next[j] += 1;
            }
        }
        Self { start, columns, values, width: self.rows() }
    }

    pub fn diagonal(&self) -> Vec<f32> {
        (0..self.rows()).map(|i| self.row(i).filter(|&(j, _)| j == i).map(|(_, a)| a).sum()).collect()
    }

    /// y_i ← f(y_i, (A x)_i).
    pub fn multiply(&self, x: &[f32], y: &mut [f32], f: impl Fn(f32, f32) -> f32 + Sync) {
        y.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, y)| {
            for (offset, y) in y.iter_mut().enumerate() {
                *y = f(*y, self.row_product(chunk * ROWS + offset, x));
            }
        });
    }

    fn row_product(&self, i: usize, x: &[f32]) -> f32 {
        self.row(i).map(|(j, a)| a * x[j]).sum()
    }
}

/// Sums by column, of which few are not zero.
pub(in crate::linalg) struct SparseRow {
    place: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f32>,
}

impl SparseRow {
    fn new(width: usize) -> Self {
        Self { place: vec![u32::MAX; width], columns: Vec::new(), values: Vec::new() }
    }

    pub fn add(&mut self, column: usize, value: f32) {
        let place = self.place[column];
        if place == u32::MAX {
            self.place[column] = self.columns.len() as u32;
            self.columns.push(column as u32);
            self.values.push(value);
        } else {
            self.values[place as usize] += value;
        }
    }

    fn drain_into(&mut self, columns: &mut Vec<u32>, values: &mut Vec<f32>) {
        self.columns.iter().for_each(|&column| self.place[column as usize] = u32::MAX);
        columns.append(&mut self.columns);
        values.append(&mut self.values);
    }
}
