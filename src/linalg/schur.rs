//! The block-triangular preconditioner.
//!
//! ```text
//! S = C + Q diag(A)⁻¹ G               Q = Gᵀ, but for the consistent stabilisation
//! δp = −Ŝ⁻¹ (r_p − Q diag(A)⁻¹ r_v)   Ŝ⁻¹: one multigrid cycle
//! δv = Â⁻¹ (r_v − G δp)               Â⁻¹: block Gauss–Seidel, or one multigrid cycle per component
//! ```
//! Where mass outweighs viscosity, µΔt/(ρh²) ≪ 1, A is almost its diagonal and both are almost exact. Where
//! viscosity rules, diag(A)⁻¹ no longer resembles A⁻¹: velocity gets multigrid, and the Schur complement the sum of
//! both limits (Cahouet & Chabard 1988),
//! ```text
//! Ŝ⁻¹ = (C + Q M⁻¹ G)⁻¹ + diag(S)⁻¹,  M: the sums of A's rows, in which viscosity cancels
//! ```

use super::matrix::BlockMatrix;
use super::multigrid::{Csr, Hierarchy, block_rows};
use rayon::prelude::*;

/// Rows per task of the products.
const ROWS: usize = 512;

/// Part of A's diagonal that is viscous from which velocity gets multigrid; half means µΔt/(ρh²) of about ¼.
const VISCOUS: f64 = 0.75;

/// Sums of rows below this part of the diagonal count as this part: in steady flow there is no mass.
const LEAST_MASS: f64 = 1e-3;

/// The preconditioner of one matrix, good for those near it.
pub(super) struct BlockTriangular<const B: usize> {
    schur: Hierarchy,
    /// 1/diag(S), where viscosity rules.
    inverse_schur: Option<Vec<f64>>,
    velocity: Vec<Hierarchy>,
    inverse_diagonal: Vec<[f64; B]>,
    /// Room for one number per node.
    right: Vec<f64>,
    pressure: Vec<f64>,
}

impl<const B: usize> BlockTriangular<B> {
    /// For a matrix.
    pub fn new(a: &BlockMatrix<B>) -> Self {
        let nodes = a.pattern.rows();
        let inverse_diagonal = inverses(a);
        let viscous = viscous_part(a) > VISCOUS;
        let velocity = if viscous { (0..B - 1).map(|k| Hierarchy::new(component(a, k))).collect() } else { Vec::new() };
        let inverse_mass = if viscous { inverse_masses(a) } else { inverse_diagonal.clone() };
        let schur = Hierarchy::new(schur_complement(a, &inverse_mass));
        let inverse_schur = viscous.then(|| {
            let diagonal = (0..nodes).map(|i| schur_diagonal(a, &inverse_diagonal, i));
            diagonal.map(|s| if s > 0.0 { s.recip() } else { 0.0 }).collect()
        });
        Self { schur, inverse_schur, velocity, inverse_diagonal, right: vec![0.0; nodes], pressure: vec![0.0; nodes] }
    }

    /// z ≈ A⁻¹ r.
    pub fn apply(&mut self, a: &BlockMatrix<B>, r: &[[f64; B]], z: &mut [[f64; B]]) {
        self.solve_pressure(a, r, z);
        z.iter_mut().zip(&self.pressure).for_each(|(z, &p)| {
            *z = [0.0; B];
            z[B - 1] = p;
        });
        if self.velocity.is_empty() {
            sweep(a, &self.inverse_diagonal, r, z, Direction::Up);
            sweep(a, &self.inverse_diagonal, r, z, Direction::Down);
        } else {
            self.velocity_cycles(a, r, z);
        }
    }

    /// δp into `self.pressure`; `v` is room.
    fn solve_pressure(&mut self, a: &BlockMatrix<B>, r: &[[f64; B]], v: &mut [[f64; B]]) {
        for ((v, r), d) in v.iter_mut().zip(r).zip(&self.inverse_diagonal) {
            *v = std::array::from_fn(|k| if k + 1 < B { r[k] * d[k] } else { 0.0 });
        }
        let (columns, v) = (a.pattern.columns(), &*v);
        self.right.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, right)| {
            for (offset, right) in right.iter_mut().enumerate() {
                let row = chunk * ROWS + offset;
                let taken: f64 = a.pattern.row(row).map(|e| inner(&a.values[e][B - 1], &v[columns[e] as usize])).sum();
                *right = taken - r[row][B - 1];
            }
        });
        self.schur.apply(&self.right, &mut self.pressure);
        if let Some(inverse) = &self.inverse_schur {
            let local = self.right.iter().zip(inverse).map(|(r, s)| r * s);
            self.pressure.iter_mut().zip(local).for_each(|(p, local)| *p += local);
        }
    }

    /// One cycle for each component of r_v − G δp.
    fn velocity_cycles(&mut self, a: &BlockMatrix<B>, r: &[[f64; B]], z: &mut [[f64; B]]) {
        let columns = a.pattern.columns();
        for (k, hierarchy) in self.velocity.iter_mut().enumerate() {
            let pressure = &self.pressure;
            self.right.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, right)| {
                for (offset, right) in right.iter_mut().enumerate() {
                    let row = chunk * ROWS + offset;
                    let gradient: f64 =
                        a.pattern.row(row).map(|e| a.values[e][k][B - 1] * pressure[columns[e] as usize]).sum();
                    *right = r[row][k] - gradient;
                }
            });
            let mut component = vec![0.0; self.right.len()];
            hierarchy.apply(&self.right, &mut component);
            z.iter_mut().zip(component).for_each(|(z, v)| z[k] = v);
        }
    }
}

fn inner<const B: usize>(a: &[f64; B], b: &[f64; B]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
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

/// S = C + Q W G for a diagonal W. What is not coupled, as a pinned pressure, keeps its own diagonal.
fn schur_complement<const B: usize>(a: &BlockMatrix<B>, weights: &[[f64; B]]) -> Csr {
    let columns = a.pattern.columns();
    Csr::from_rows(a.pattern.rows(), a.pattern.rows(), |i, row| {
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

fn schur_diagonal<const B: usize>(a: &BlockMatrix<B>, weights: &[[f64; B]], i: usize) -> f64 {
    let columns = a.pattern.columns();
    let through = |e: usize| {
        let (left, right) = (&a.values[e][B - 1], &a.values[a.pattern.mirror(e)]);
        (0..B - 1).map(|k| left[k] * weights[columns[e] as usize][k] * right[k][B - 1]).sum::<f64>()
    };
    a.pattern.row(i).map(through).sum::<f64>() - a.values[a.pattern.diagonal(i)][B - 1][B - 1]
}

/// The order in which a sweep visits rows.
#[derive(Clone, Copy, PartialEq)]
enum Direction {
    Up,
    Down,
}

/// One Gauss–Seidel sweep over the velocities of r − A z, in blocks of rows; pressures of z stay.
fn sweep<const B: usize>(
    a: &BlockMatrix<B>,
    inverse_diagonal: &[[f64; B]],
    r: &[[f64; B]],
    z: &mut [[f64; B]],
    direction: Direction,
) {
    let old = z.to_vec();
    let columns = a.pattern.columns();
    let size = block_rows(z.len());
    z.par_chunks_mut(size).enumerate().for_each(|(block, z)| {
        let from = block * size;
        let mut visit = |local: usize| {
            let row = from + local;
            let mut rest = r[row];
            for entry in a.pattern.row(row) {
                let column = columns[entry] as usize;
                let x = z.get(column.wrapping_sub(from)).unwrap_or(&old[column]);
                (0..B - 1).for_each(|k| rest[k] -= inner(&a.values[entry][k], x));
            }
            (0..B - 1).for_each(|k| z[local][k] += rest[k] * inverse_diagonal[row][k]);
        };
        match direction {
            Direction::Up => (0..size.min(r.len() - from)).for_each(&mut visit),
            Direction::Down => (0..size.min(r.len() - from)).rev().for_each(&mut visit),
        }
    });
}
