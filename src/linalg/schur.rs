//! The block-triangular preconditioner (theory (F.43), (F.44)).
//!
//! ```text
//! S = C + Q diag(A)⁻¹ G + Z           Q = Gᵀ, but for the consistent stabilisation; Z: of solids at the border (theory (J.10c))
//! δp = −Ŝ⁻¹ (r_p − Q diag(A)⁻¹ r_v)   Ŝ⁻¹: one multigrid cycle
//! δv = Â⁻¹ (r_v − G δp)               Â⁻¹: symmetric Gauss–Seidel, or multigrid, component by component
//! ```
//! If mass outweighs viscosity, µΔt/(ρh²) ≪ 1, A is almost its diagonal and both are almost exact. If
//! viscosity rules, diag(A)⁻¹ no longer resembles A⁻¹: velocity gets multigrid, and the Schur complement the sum of
//! both limits (Cahouet & Chabard 1988),
//! ```text
//! Ŝ⁻¹ = (C + Q M⁻¹ G)⁻¹ + diag(S)⁻¹,  M: the sums of A's rows, in which viscosity cancels
//! ```
//! The parts of the matrix that it reads are kept in single precision, without the coupling of velocity components: a
//! third of the memory traffic, which is what an iteration costs.

use super::border::PressureCompliance;
use super::matrix::BlockMatrix;
use super::multigrid::{Csr, Hierarchy, block_rows};
use super::pattern::Pattern;
use rayon::prelude::*;
use std::sync::Arc;

/// Rows per task of the products.
const ROWS: usize = 512;

/// Part of A's diagonal that is viscous from which velocity gets multigrid; half means µΔt/(ρh²) of about ¼.
const VISCOUS: f64 = 0.75;

/// Sums of rows below this part of the diagonal count as this part: in steady flow there is no mass.
const LEAST_MASS: f64 = 1e-3;

/// One number per velocity component; the last place is empty, so that four fill a register.
type Components<const B: usize> = [f32; B];

/// The parts of a matrix that the preconditioner reads, entry by entry of the pattern.
struct Parts<const B: usize> {
    pattern: Arc<Pattern>,
    /// a_kk of A.
    velocity: Vec<Components<B>>,
    /// G.
    gradient: Vec<Components<B>>,
    /// Q.
    divergence: Vec<Components<B>>,
    /// diag(A)⁻¹.
    inverse_diagonal: Vec<Components<B>>,
}

/// The preconditioner of one matrix, good for those near it.
pub(super) struct BlockTriangular<const B: usize> {
    parts: Parts<B>,
    schur: Hierarchy,
    /// 1/diag(S), where viscosity rules.
    inverse_schur: Option<Vec<f64>>,
    /// Multigrid for each velocity component, where viscosity rules.
    velocity: Vec<Hierarchy>,
    workspace: Workspace<B>,
}

/// Vectors with one entry per node.
struct Workspace<const B: usize> {
    right: Vec<f64>,
    pressure: Vec<f64>,
    rest: Vec<Components<B>>,
    sweep: Vec<Components<B>>,
    old: Vec<Components<B>>,
}

impl<const B: usize> BlockTriangular<B> {
    /// The preconditioner of a matrix whose border has a compliance to pressure.
    pub fn new(a: &BlockMatrix<B>, border: &PressureCompliance) -> Self {
        let nodes = a.pattern.rows();
        let inverse_diagonal = inverses(a);
        let viscous = viscous_part(a) > VISCOUS;
        let velocity = if viscous { (0..B - 1).map(|k| Hierarchy::new(component(a, k))).collect() } else { Vec::new() };
        let inverse_mass = if viscous { inverse_masses(a) } else { inverse_diagonal.clone() };
        let schur = Hierarchy::new(schur_complement(a, &inverse_mass, border));
        let inverse_schur = viscous.then(|| inverse_schur(a, &inverse_diagonal));
        let zeros = || vec![[0.0; B]; nodes];
        let workspace = Workspace {
            right: vec![0.0; nodes],
            pressure: vec![0.0; nodes],
            rest: zeros(),
            sweep: zeros(),
            old: zeros(),
        };
        Self { parts: Parts::new(a, &inverse_diagonal), schur, inverse_schur, velocity, workspace }
    }

    /// Takes a matrix that differs in few rows; the coarse levels of multigrid stay.
    pub fn refresh(&mut self, a: &BlockMatrix<B>, border: &PressureCompliance) {
        let inverse_diagonal = inverses(a);
        for (k, hierarchy) in self.velocity.iter_mut().enumerate() {
            hierarchy.refresh(component(a, k));
        }
        let is_viscous = self.inverse_schur.is_some();
        let inverse_mass = if is_viscous { inverse_masses(a) } else { inverse_diagonal.clone() };
        self.schur.refresh(schur_complement(a, &inverse_mass, border));
        self.inverse_schur = is_viscous.then(|| inverse_schur(a, &inverse_diagonal));
        self.parts = Parts::new(a, &inverse_diagonal);
    }

    /// z ≈ A⁻¹ r.
    pub fn apply(&mut self, r: &[[f64; B]], z: &mut [[f64; B]]) {
        let size = largest(r);
        if size == 0.0 || !size.is_finite() {
            z.fill([0.0; B]);
            return;
        }
        self.solve_pressure(r, size);
        self.parts.rest(r, size, &self.workspace.pressure, &mut self.workspace.rest);
        if self.velocity.is_empty() {
            let Workspace { rest, sweep, old, .. } = &mut self.workspace;
            self.parts.forward_from_zero(rest, sweep);
            self.parts.backward(rest, sweep, old);
        } else {
            self.velocity_cycles();
        }
        let Workspace { pressure, sweep, .. } = &self.workspace;
        z.par_iter_mut().with_min_len(ROWS).zip(sweep.par_iter().zip(pressure)).for_each(|(z, (v, &p))| {
            *z = std::array::from_fn(|k| size * if k + 1 < B { f64::from(v[k]) } else { p });
        });
    }

    /// δp/size.
    fn solve_pressure(&mut self, r: &[[f64; B]], size: f64) {
        let Workspace { right, pressure, rest, .. } = &mut self.workspace;
        self.parts.divergence_of_scaled(r, size, rest, right);
        self.schur.apply(right, pressure);
        if let Some(inverse) = &self.inverse_schur {
            let local = right.iter().zip(inverse).map(|(r, s)| r * s);
            pressure.iter_mut().zip(local).for_each(|(p, local)| *p += local);
        }
    }

    /// One cycle for each component of r_v − G δp.
    fn velocity_cycles(&mut self) {
        let Workspace { right, rest, sweep, .. } = &mut self.workspace;
        let mut component = vec![0.0; right.len()];
        for (k, hierarchy) in self.velocity.iter_mut().enumerate() {
            right.iter_mut().zip(&*rest).for_each(|(right, rest)| *right = f64::from(rest[k]));
            hierarchy.apply(right, &mut component);
            sweep.iter_mut().zip(&component).for_each(|(z, &v)| z[k] = v as f32);
        }
    }
}

impl<const B: usize> Parts<B> {
    fn new(a: &BlockMatrix<B>, inverse_diagonal: &[[f64; B]]) -> Self {
        let entries = |value: fn(&[[f64; B]; B], usize) -> f64| -> Vec<Components<B>> {
            let part = |block| std::array::from_fn(|k| if k + 1 < B { value(block, k) as f32 } else { 0.0 });
            a.values.par_iter().with_min_len(ROWS).map(part).collect()
        };
        let single = |d: &[f64; B]| std::array::from_fn(|k| if k + 1 < B { d[k] as f32 } else { 0.0 });
        Self {
            pattern: a.pattern.clone(),
            velocity: entries(|block, k| block[k][k]),
            gradient: entries(|block, k| block[k][B - 1]),
            divergence: entries(|block, k| block[B - 1][k]),
            inverse_diagonal: inverse_diagonal.iter().map(single).collect(),
        }
    }

    /// (Q diag(A)⁻¹ r_v − r_p)/size; `scaled` is workspace.
    fn divergence_of_scaled(&self, r: &[[f64; B]], size: f64, scaled: &mut [Components<B>], out: &mut [f64]) {
        scaled.par_iter_mut().with_min_len(ROWS).zip(r.par_iter().zip(&self.inverse_diagonal)).for_each(
            |(scaled, (r, d))| {
                *scaled = std::array::from_fn(|k| (r[k] / size) as f32 * d[k]);
            },
        );
        let (columns, scaled) = (self.pattern.columns(), &*scaled);
        out.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, out)| {
            for (offset, out) in out.iter_mut().enumerate() {
                let row = chunk * ROWS + offset;
                let mut sums = [0.0; B];
                for entry in self.pattern.row(row) {
                    add(&mut sums, &self.divergence[entry], &scaled[columns[entry] as usize]);
                }
                *out = f64::from(sums.iter().sum::<f32>()) - r[row][B - 1] / size;
            }
        });
    }

    /// r_v/size − G p.
    fn rest(&self, r: &[[f64; B]], size: f64, pressure: &[f64], rest: &mut [Components<B>]) {
        let columns = self.pattern.columns();
        rest.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, rest)| {
            for (offset, rest) in rest.iter_mut().enumerate() {
                let row = chunk * ROWS + offset;
                let mut sums = std::array::from_fn(|k| if k + 1 < B { (r[row][k] / size) as f32 } else { 0.0 });
                for entry in self.pattern.row(row) {
                    add(&mut sums, &self.gradient[entry], &[-pressure[columns[entry] as usize] as f32; B]);
                }
                *rest = sums;
            }
        });
    }

    /// One Gauss–Seidel sweep through ascending rows from zero, in blocks of rows.
    fn forward_from_zero(&self, right: &[Components<B>], z: &mut [Components<B>]) {
        let columns = self.pattern.columns();
        let size = block_rows(z.len());
        z.par_chunks_mut(size).enumerate().for_each(|(block, z)| {
            let from = block * size;
            for local in 0..z.len() {
                let row = from + local;
                let mut rest = right[row];
                // Rows behind this one, and other blocks, are still zero.
                for entry in self.pattern.row(row).start..self.pattern.diagonal(row) {
                    if let Some(column) = (columns[entry] as usize).checked_sub(from) {
                        subtract(&mut rest, &self.velocity[entry], &z[column]);
                    }
                }
                z[local] = std::array::from_fn(|k| rest[k] * self.inverse_diagonal[row][k]);
            }
        });
    }

    /// One sweep through descending rows; `old` is workspace for the values before it.
    fn backward(&self, right: &[Components<B>], z: &mut [Components<B>], old: &mut [Components<B>]) {
        old.copy_from_slice(z);
        let (columns, old) = (self.pattern.columns(), &*old);
        let size = block_rows(z.len());
        z.par_chunks_mut(size).enumerate().for_each(|(block, z)| {
            let from = block * size;
            for local in (0..z.len()).rev() {
                let row = from + local;
                let mut rest = right[row];
                for entry in self.pattern.row(row) {
                    let column = columns[entry] as usize;
                    let x = z.get(column.wrapping_sub(from)).unwrap_or(&old[column]);
                    subtract(&mut rest, &self.velocity[entry], x);
                }
                (0..B).for_each(|k| z[local][k] += rest[k] * self.inverse_diagonal[row][k]);
            }
        });
    }
}

/// The largest number in a vector.
fn largest<const B: usize>(r: &[[f64; B]]) -> f64 {
    r.as_flattened().iter().fold(0.0, |largest: f64, r| largest.max(r.abs()))
}

#[inline(always)]
fn add<const B: usize>(sums: &mut Components<B>, a: &Components<B>, x: &Components<B>) {
    (0..B).for_each(|k| sums[k] += a[k] * x[k]);
}

#[inline(always)]
fn subtract<const B: usize>(sums: &mut Components<B>, a: &Components<B>, x: &Components<B>) {
    (0..B).for_each(|k| sums[k] -= a[k] * x[k]);
}

fn inverse(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.recip() }
}

/// 1/a_ii.
fn inverses<const B: usize>(a: &BlockMatrix<B>) -> Vec<[f64; B]> {
    let diagonal = |row: usize| &a.values[a.pattern.diagonal(row)];
    (0..a.pattern.rows()).map(|row| std::array::from_fn(|k| inverse(diagonal(row)[k][k]))).collect()
}

/// One over the sums of the rows of A's diagonal blocks, component by component.
fn inverse_masses<const B: usize>(a: &BlockMatrix<B>) -> Vec<[f64; B]> {
    let mass = |row: usize, k: usize| {
        let sum: f64 = a.pattern.row(row).map(|e| a.values[e][k][k]).sum();
        sum.max(LEAST_MASS * a.values[a.pattern.diagonal(row)][k][k])
    };
    (0..a.pattern.rows()).map(|row| std::array::from_fn(|k| inverse(mass(row, k)))).collect()
}

/// The viscous part of A's diagonal, on average over the unknowns.
fn viscous_part<const B: usize>(a: &BlockMatrix<B>) -> f64 {
    let part = |row: usize| {
        let diagonal = a.values[a.pattern.diagonal(row)][0][0];
        let sum: f64 = a.pattern.row(row).map(|e| a.values[e][0][0]).sum();
        if diagonal > 0.0 { (1.0 - sum / diagonal).clamp(0.0, 1.0) } else { 0.0 }
    };
    crate::parallel::sum(a.pattern.rows(), part) / a.pattern.rows() as f64
}

/// One component of A.
fn component<const B: usize>(a: &BlockMatrix<B>, k: usize) -> Csr {
    let columns = a.pattern.columns();
    Csr::from_rows(a.pattern.rows(), a.pattern.rows(), |i, row| {
        for entry in a.pattern.row(i) {
            let value = a.values[entry][k][k];
            if value != 0.0 {
                row.add(columns[entry] as usize, value as f32);
            }
        }
    })
}

/// S = C + Q W G + Z for a diagonal W. An unknown without couplings, as a pinned pressure, keeps its own diagonal.
fn schur_complement<const B: usize>(a: &BlockMatrix<B>, weights: &[[f64; B]], border: &PressureCompliance) -> Csr {
    let columns = a.pattern.columns();
    Csr::from_rows(a.pattern.rows(), a.pattern.rows(), |i, row| {
        let first = border.entries.partition_point(|entry| (entry.row as usize) < i);
        let own = border.entries[first..].iter().take_while(|entry| entry.row as usize == i);
        own.for_each(|entry| row.add(entry.column as usize, entry.value as f32));
        for first in a.pattern.row(i) {
            let middle = columns[first] as usize;
            let block = &a.values[first][B - 1];
            if block[B - 1] != 0.0 {
                row.add(middle, -block[B - 1] as f32);
            }
            let left: [f64; B] = std::array::from_fn(|k| if k + 1 < B { block[k] * weights[middle][k] } else { 0.0 });
            if left.iter().all(|&l| l == 0.0) {
                continue;
            }
            for second in a.pattern.row(middle) {
                let value: f64 = (0..B - 1).map(|k| left[k] * a.values[second][k][B - 1]).sum();
                if value != 0.0 {
                    row.add(columns[second] as usize, value as f32);
                }
            }
        }
    })
}

/// 1/diag(S), zero where that is not positive.
fn inverse_schur<const B: usize>(a: &BlockMatrix<B>, weights: &[[f64; B]]) -> Vec<f64> {
    let diagonal = (0..a.pattern.rows()).map(|i| schur_diagonal(a, weights, i));
    diagonal.map(|s| if s > 0.0 { s.recip() } else { 0.0 }).collect()
}

fn schur_diagonal<const B: usize>(a: &BlockMatrix<B>, weights: &[[f64; B]], i: usize) -> f64 {
    let columns = a.pattern.columns();
    let through = |e: usize| {
        let (left, right) = (&a.values[e][B - 1], &a.values[a.pattern.mirror(e)]);
        (0..B - 1).map(|k| left[k] * weights[columns[e] as usize][k] * right[k][B - 1]).sum::<f64>()
    };
    a.pattern.row(i).map(through).sum::<f64>() - a.values[a.pattern.diagonal(i)][B - 1][B - 1]
}
