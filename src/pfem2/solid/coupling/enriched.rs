//! The enriched pressure of two fluids in an element that a solid cuts, too (theory G.14).
//!
//! ```text
//! p = Σ_k N^e_k p_k + Σ_k F_k q_k          F_k = N^e_k on the side where node k is not, over the fluid part alone
//!
//! (K_se) on v_c   −Σ_t V_t F_k(c_t) g^s_c            c: a vertex of s, that is a node of e or a cut point     theory (G.31)
//! (K_se) on p_j   −τ Σ_t V_t/ρ_t g^e_j·∇F_k
//! K_ee            −τ Σ_t V_t/ρ_t ∇F_k·∇F_l,   f_e = −τ Σ_t V_t ∇F_k·s_±
//! (K_es) on v_c   (K_se) − τ/Δ Σ_t V_t N^s_c(c_t) ∇F_k                                 with the consistent stabilisation
//! ```
//!
//! A cut point moves with nodes of the solid, so that condensation, theory (G.17), reaches the rows and columns
//! of these. A node that has no fluid of its own side in any element, inside the solid, has no pressure of its own:
//! that of the other side is in q.

use super::element::{CoupledElement, Unknown, VelocityMap, VertexVelocities};
use super::fluid_part::{FluidPart, PartGeometry};
use super::walls::part_facets;
use crate::math::Vector;
use crate::math::dense::inverse_of_semidefinite;
use crate::pfem2::element::{Equations, Stabilisation};

/// A row of K_es, or a column of K_se, in the unknowns of an element.
struct EnrichedRow<const D: usize, const N: usize> {
    /// Entries of the unknowns of its nodes.
    nodes: [[f64; N]; N],
    /// Entries of nodes of solids, by their places in the element.
    solid: Vec<Vector<D>>,
}

impl<const D: usize, const N: usize> EnrichedRow<D, N> {
    fn zero(solid: usize) -> Self {
        Self { nodes: [[0.0; N]; N], solid: vec![Vector::ZERO; solid] }
    }

    /// Adds what belongs to the velocity of a vertex.
    fn add(&mut self, vertex: &VelocityMap<D>, value: Vector<D>) {
        for &(unknown, p) in vertex {
            let value = p.transpose().apply(value);
            match unknown {
                Unknown::Node(i) => (0..D).for_each(|r| self.nodes[i][r] += value[r]),
                Unknown::Solid(a) => self.solid[a] += value,
            }
        }
    }
}

/// The additional rows of an element.
struct EnrichedRows<const D: usize, const N: usize> {
    rows: Vec<EnrichedRow<D, N>>,
    columns: Vec<EnrichedRow<D, N>>,
    /// −K_ee.
    matrix: Vec<Vec<f64>>,
    load: Vec<f64>,
}

/// Enriches the pressure of an element, condensed.
pub(in crate::pfem2::solid) fn enrich<const D: usize, const N: usize>(
    element: &mut CoupledElement<D, N>,
    gradient: &[Vector<D>; N],
    parts: &[PartGeometry<D, N>],
    fluid: &FluidPart<D, N>,
    equations: &Equations,
    velocities: &VertexVelocities<D>,
) {
    let solid = element.solid.len();
    let zeros = || (0..N).map(|_| EnrichedRow::zero(solid)).collect();
    let (matrix, load) = (vec![vec![0.0; N]; N], vec![0.0; N]);
    let mut rows = EnrichedRows { rows: zeros(), columns: zeros(), matrix, load };
    parts.iter().for_each(|part| rows.add(gradient, part, fluid, equations, velocities));
    rows.condense(element);
}

impl<const D: usize, const N: usize> EnrichedRows<D, N> {
    /// Adds a part.
    fn add(
        &mut self,
        gradient: &[Vector<D>; N],
        part: &PartGeometry<D, N>,
        fluid: &FluidPart<D, N>,
        equations: &Equations,
        VertexVelocities { maps, hats, .. }: &VertexVelocities<D>,
    ) {
        let delay = match equations.stabilisation {
            Stabilisation::ConsistentPspg | Stabilisation::Dynamic => fluid.tau / equations.delta,
            Stabilisation::Pspg | Stabilisation::Oss => 0.0,
        };
        for facet in part_facets(part, fluid.held) {
            facet.press_enriched(part, &fluid.level, |vertex, k, area| {
                self.columns[k].add(&maps[vertex], area);
                self.rows[k].add(&maps[vertex], area);
            });
        }
        for piece in &part.pieces {
            let volume = part.simplex.volume * piece.volume_fraction;
            let (center, weight) = (part.at(&piece.center), fluid.tau * volume / fluid.medium(piece).density);
            let hat: Vector<D> = piece.center.iter().zip(&part.vertices).map(|(&n, &vertex)| hats[vertex] * n).sum();
            let source = fluid.source(piece) * (fluid.tau * volume) + hat * (delay * volume);
            let is_other = |k: usize| (fluid.level[k] < 0.0) != piece.negative;
            for k in (0..N).filter(|&k| is_other(k)) {
                let slope = gradient[k];
                self.load[k] -= slope.dot(source);
                (0..N).filter(|&l| is_other(l)).for_each(|l| self.matrix[k][l] += weight * slope.dot(gradient[l]));
                for (c, &vertex) in part.vertices.iter().enumerate() {
                    let pressure = part.simplex.gradient[c] * -(volume * center[k]);
                    self.columns[k].add(&maps[vertex], pressure);
                    self.rows[k].add(&maps[vertex], pressure - slope * (delay * volume * piece.center[c]));
                }
                for j in 0..N {
                    self.columns[k].nodes[j][D] -= weight * gradient[j].dot(slope);
                    self.rows[k].nodes[j][D] -= weight * gradient[j].dot(slope);
                }
            }
        }
    }

    /// K̂ = K_ss − K_se K_ee⁻¹ K_es and f̂ = f_s − K_se K_ee⁻¹ f_e (theory (G.17)).
    fn condense(self, element: &mut CoupledElement<D, N>) {
        let inverse = inverse_of_semidefinite(self.matrix);
        for (k, column) in self.columns.iter().enumerate() {
            // f̂, Becker (33).
            let amount: f64 = inverse[k].iter().zip(&self.load).map(|(entry, load)| entry * load).sum();
            element.add_enriched_load(&column.nodes, &column.solid, amount);
            // K̂, Becker (32).
            for (l, row) in self.rows.iter().enumerate().filter(|(l, _)| inverse[k][*l] != 0.0) {
                element.add_product(column, row, inverse[k][l]);
            }
        }
    }
}

impl<const D: usize, const N: usize> CoupledElement<D, N> {
    fn add_enriched_load(&mut self, nodes: &[[f64; N]; N], solid: &[Vector<D>], amount: f64) {
        for (load, own) in self.loads.iter_mut().zip(nodes) {
            (0..N).for_each(|r| load[r] += own[r] * amount);
        }
        self.solid_loads.iter_mut().zip(solid).for_each(|(load, own)| *load += *own * amount);
    }

    /// Adds column · factor · row to all blocks.
    fn add_product(&mut self, column: &EnrichedRow<D, N>, row: &EnrichedRow<D, N>, factor: f64) {
        let count = self.solid.len();
        for i in 0..N {
            for r in 0..N {
                let left = column.nodes[i][r] * factor;
                for j in 0..N {
                    (0..N).for_each(|s| self.blocks[i][j][r][s] += left * row.nodes[j][s]);
                }
                for b in 0..count {
                    (0..D).for_each(|s| self.to_fluid[b][i][r][s] += left * row.solid[b][s]);
                }
            }
        }
        for a in 0..count {
            for r in 0..D {
                let left = column.solid[a][r] * factor;
                for j in 0..N {
                    (0..N).for_each(|s| self.to_solid[a][j][r][s] += left * row.nodes[j][s]);
                }
                for b in 0..count {
                    (0..D).for_each(|s| self.among_solid[a * count + b][r][s] += left * row.solid[b][s]);
                }
            }
        }
    }
}
