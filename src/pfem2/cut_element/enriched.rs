//! The enriched pressure of a cut element: its rows, condensation and recovery (Becker (29)–(33), theory G.8).

use super::{CutGeometry, Enrichment};
use crate::math::Vector;
use crate::math::dense::inverse_of_semidefinite;
use crate::mesh::Simplex;
use crate::pfem2::element::Block;

/// The enriched pressure of a cut element, ready to be condensed: the blocks of Becker (30), theory (G.14).
#[derive(Debug, Clone)]
pub struct Enriched<const N: usize> {
    /// K_es, a row of nodal blocks per function.
    rows: Vec<[[f64; N]; N]>,
    /// K_se transposed.
    columns: Vec<[[f64; N]; N]>,
    /// (−K_ee)⁻¹.
    inverse: Vec<Vec<f64>>,
    /// f_e.
    load: Vec<f64>,
    /// Terms of slip facets in K_se transposed; empty without them.
    walls: Vec<[[f64; N]; N]>,
}

/// The terms of the residual of momentum in a cut element that don't depend on the solution.
#[derive(Debug, Clone, Copy)]
pub struct ResidualTerms<'a, const D: usize, const N: usize> {
    /// s without v̂/Δ on the negative and the positive side [m/s²].
    pub source: [Vector<D>; 2],
    /// v̂ at the nodes [m/s].
    pub convected: &'a [Vector<D>; N],
    /// τ/Δ with the consistent forms, else 0.
    pub inertia: f64,
}

fn sum<const N: usize>(a: &[[f64; N]; N], b: &[[f64; N]; N]) -> [[f64; N]; N] {
    std::array::from_fn(|j| std::array::from_fn(|s| a[j][s] + b[j][s]))
}

impl<const N: usize> Enriched<N> {
    /// The enrichment of a cut element, with τ [s].
    pub fn new<const D: usize>(
        cut: &CutGeometry<N>,
        enrichment: Enrichment,
        simplex: &Simplex<D, N>,
        tau: f64,
        residual: ResidualTerms<'_, D, N>,
    ) -> Self {
        let ResidualTerms { source, convected, inertia } = residual;
        let count = cut.functions(enrichment);
        let mut columns = vec![[[0.0; N]; N]; count];
        let mut extra = vec![[[0.0; N]; N]; count];
        let mut matrix = vec![vec![0.0; count]; count];
        let mut load = vec![0.0; count];
        // The additional rows and columns of Becker (29), integrated part by part: theory (G.15), (G.16).
        for part in &cut.parts {
            let volume = simplex.volume * part.volume_fraction;
            let weight = tau * volume / cut.medium(part).density;
            let at = |k| cut.function(enrichment, k, part, &simplex.gradient);
            // v̂ and v at the same place: what moves as before leaves no residual.
            let hat: Vector<D> = convected.iter().zip(&part.center).map(|(&hat, &n)| hat * n).sum();
            let own = source[usize::from(!part.negative)];
            for k in 0..count {
                let (value, slope) = at(k);
                load[k] -= tau * volume * slope.dot(own) + inertia * volume * slope.dot(hat);
                for (l, entry) in matrix[k].iter_mut().enumerate() {
                    *entry += weight * slope.dot(at(l).1);
                }
                for j in 0..N {
                    for s in 0..D {
                        columns[k][j][s] -= volume * value * simplex.gradient[j][s];
                        extra[k][j][s] -= inertia * volume * part.center[j] * slope[s];
                    }
                    columns[k][j][D] -= weight * simplex.gradient[j].dot(slope);
                }
            }
        }
        let rows = columns.iter().zip(&extra).map(|(column, extra)| sum(column, extra)).collect();
        Self { rows, columns, inverse: inverse_of_semidefinite(matrix), load, walls: Vec::new() }
    }

    /// The enriched pressure with the terms of slip facets in K_se transposed (see [`crate::pfem2::equations::slip`]).
    pub fn beside(self, walls: Vec<[[f64; N]; N]>) -> Self {
        Self { walls, ..self }
    }

    /// Term of condensation in the block of nodes `i` and `j`.
    pub fn block(&self, i: usize, j: usize) -> Block<N> {
        self.condensed(&self.columns, i, j)
    }

    /// Term of condensation in the right-hand side of node `i`.
    pub fn load(&self, i: usize) -> [f64; N] {
        self.condensed_load(&self.columns, i)
    }

    /// Term of slip facets in that block.
    pub fn wall_block(&self, i: usize, j: usize) -> Block<N> {
        self.condensed(&self.walls, i, j)
    }

    /// Term of slip facets in that right-hand side.
    pub fn wall_load(&self, i: usize) -> [f64; N] {
        self.condensed_load(&self.walls, i)
    }

    fn condensed(&self, columns: &[[[f64; N]; N]], i: usize, j: usize) -> Block<N> {
        let mut block = [[0.0; N]; N];
        // Becker (32): K̂ − K_ss = −K_se K_ee⁻¹ K_es, for the system Becker (31); theory (G.17).
        for (k, column) in columns.iter().enumerate() {
            for (l, row) in self.rows.iter().enumerate() {
                for r in 0..N {
                    for s in 0..N {
                        block[r][s] += column[i][r] * self.inverse[k][l] * row[j][s];
                    }
                }
            }
        }
        block
    }

    fn condensed_load(&self, columns: &[[[f64; N]; N]], i: usize) -> [f64; N] {
        let mut sum = [0.0; N];
        // Becker (33): f̂ − f_s = −K_se K_ee⁻¹ f_e; theory (G.17).
        for (k, column) in columns.iter().enumerate() {
            let amount: f64 = self.load.iter().zip(&self.inverse[k]).map(|(load, entry)| load * entry).sum();
            (0..N).for_each(|r| sum[r] += column[i][r] * amount);
        }
        sum
    }

    /// The condensed pressures q [Pa] that belong to the nodal unknowns of the element.
    pub fn recover(&self, nodal: &[[f64; N]; N]) -> Vec<f64> {
        let rest = |(row, load): (&[[f64; N]; N], &f64)| {
            let sum: f64 = row.iter().zip(nodal).flat_map(|(a, x)| a.iter().zip(x)).map(|(a, x)| a * x).sum();
            sum - load
        };
        // The second row of Becker (30): q = K_ee⁻¹ (f_e − K_es x); theory (G.17).
        let rest: Vec<f64> = self.rows.iter().zip(&self.load).map(rest).collect();
        self.inverse.iter().map(|row| row.iter().zip(&rest).map(|(a, r)| a * r).sum()).collect()
    }
}
