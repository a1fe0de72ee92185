//! Sample points on a sheet: what a membrane is for the grid (theory D.2).
//!
//! ```text
//! x_q = Σ_K N_K(ξ_q) x_K,    W_qK = N_K(ξ_q) m_K,e n_e/Q,    m_q = Σ_K W_qK,    Σ_q m_q v_q = Σ_K m_K v_K
//! ```
//!
//! An element carries ⌈L/(½h)⌉ samples in each direction, so that elements may be larger or smaller than
//! cells. Each node's lumped mass m_K is shared by its elements in proportion to their area (m_K,e), so
//! that mass and momentum of the samples are exactly those of the nodes.

use crate::math::Vector;
use crate::mpm::Grid;
use crate::mpm::contact::facet::SheetFacet;
use crate::mpm::wall::folded_stencil::{Flips, FoldedStencil};
use crate::parallel;
use std::ops::Range;

/// Most samples along an element's side.
const MOST_SAMPLES: u32 = 64;

/// Samples per parallel task.
const TASK: usize = 256;

impl SheetFacet {
    /// Samples along the two directions of the facet for cells of size `cell` [m].
    fn divisions<const D: usize>(&self, position: &[Vector<D>], cell: f64) -> [u32; 2] {
        let x = self.corners(position);
        let side = |a: usize, b: usize| (x[a] - x[b]).norm();
        let number = |length: f64| ((length / (0.5 * cell) - 1e-9).ceil() as u32).clamp(1, MOST_SAMPLES);
        match self.count {
            2 => [number(side(0, 1)), 1],
            3 => [number(side(0, 1).max(side(1, 2)).max(side(2, 0))); 2],
            _ => [number(side(0, 1).max(side(2, 3))), number(side(1, 2).max(side(3, 0)))],
        }
    }
}

/// Shape functions N_K at the samples of a facet with `count` nodes and `n` samples per direction.
fn shape_functions(count: usize, [n, m]: [u32; 2], mut visit: impl FnMut([f64; 4])) {
    let middle = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    match count {
        2 => (0..n).for_each(|i| visit([1.0 - middle(i, n), middle(i, n), 0.0, 0.0])),
        3 => {
            let third = 1.0 / (3.0 * f64::from(n));
            let at = |i: u32, j: u32, shift: f64| {
                let (a, b) = ((f64::from(3 * i) + shift) * third, (f64::from(3 * j) + shift) * third);
                [1.0 - a - b, a, b, 0.0]
            };
            for j in 0..n {
                for i in 0..n - j {
                    visit(at(i, j, 1.0));
                    if i + j + 1 < n {
                        visit(at(i, j, 2.0));
                    }
                }
            }
        }
        _ => {
            for j in 0..m {
                for i in 0..n {
                    let (a, b) = (middle(i, n), middle(j, m));
                    visit([(1.0 - a) * (1.0 - b), a * (1.0 - b), a * b, (1.0 - a) * b]);
                }
            }
        }
    }
}

/// A grid node that a sample reaches.
#[derive(Debug, Clone, Copy)]
pub struct SampleWeight {
    pub sample: u32,
    pub node: u32,
    pub flips: Flips,
    pub weight: f64,
}

/// The samples of a sheet.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Element of each sample.
    pub element: Vec<u32>,
    /// Shape functions N_K of the element's nodes at each sample.
    pub shape: Vec<[f64; 4]>,
    /// W_qK: the mass [kg] of each sample that belongs to each node of its element.
    pub mass: Vec<[f64; 4]>,
    /// Fraction of the element's area that each sample stands for.
    pub area_fraction: Vec<f64>,
    divisions: Vec<[u32; 2]>,
}

impl Samples {
    /// Lays the samples out anew if an element has stretched into another number of them.
    /// `corner_mass`: the mass [kg] of each element corner, 4 per element.
    pub fn divide<const D: usize>(
        &mut self,
        facets: &[SheetFacet],
        position: &[Vector<D>],
        corner_mass: &[[f64; 4]],
        cell: f64,
    ) {
        let same = self.divisions.len() == facets.len()
            && facets.iter().zip(&self.divisions).all(|(f, &d)| f.divisions(position, cell) == d);
        if same {
            return;
        }
        *self = Self { divisions: facets.iter().map(|f| f.divisions(position, cell)).collect(), ..Self::default() };
        for (e, facet) in facets.iter().enumerate() {
            self.fill(e as u32, facet.count, corner_mass[e]);
        }
    }

    /// x_q [m].
    pub fn position<const D: usize>(&self, facets: &[SheetFacet], position: &[Vector<D>], q: usize) -> Vector<D> {
        let corners = facets[self.element[q] as usize].corners(position);
        corners.iter().zip(self.shape[q]).map(|(&x, n)| x * n).sum()
    }

    /// The part of a sample's mass that is held along each axis [kg], by the fraction that is held of each node.
    pub fn held_mass<const D: usize>(
        &self,
        facets: &[SheetFacet],
        held: impl Fn(usize) -> Vector<D>,
        q: usize,
    ) -> Vector<D> {
        let nodes = facets[self.element[q] as usize].nodes.into_iter().zip(self.mass[q]);
        nodes.map(|(k, mass)| held(k as usize) * mass).sum()
    }

    /// The nodes with bodies that each sample reaches, sample by sample.
    pub fn weights<const D: usize>(
        &self,
        facets: &[SheetFacet],
        position: &[Vector<D>],
        grid: &Grid<D>,
        stencil: &FoldedStencil<D>,
    ) -> Vec<Vec<SampleWeight>> {
        let visit = |samples: Range<usize>| {
            let mut weights = Vec::new();
            for sample in samples {
                stencil.for_each(grid, self.position(facets, position, sample), |node, weight, flips| {
                    if grid.fields.iter().any(|field| field.nodes[node].mass > stencil.cutoff) {
                        weights.push(SampleWeight { sample: sample as u32, node: node as u32, flips, weight });
                    }
                });
            }
            weights
        };
        parallel::map_ranges(self.count(), TASK, visit)
    }

    fn fill(&mut self, element: u32, count: usize, corner_mass: [f64; 4]) {
        let (first, divisions) = (self.shape.len(), self.divisions[element as usize]);
        shape_functions(count, divisions, |shape| self.shape.push(shape));
        let number = self.shape.len() - first;
        let fraction = 1.0 / number as f64;
        self.element.resize(first + number, element);
        self.area_fraction.resize(first + number, fraction);
        self.mass.extend(
            self.shape[first..].iter().map(|shape| -> [f64; 4] {
                std::array::from_fn(|k| shape[k] * corner_mass[k] * count as f64 * fraction)
            }),
        );
    }

    /// Number of samples.
    pub fn count(&self) -> usize {
        self.element.len()
    }
}

/// The mass of each element corner [kg]: a node's mass, shared in proportion to the elements' areas.
pub fn corner_mass<const D: usize>(facets: &[SheetFacet], reference: &[Vector<D>], mass: &[f64]) -> Vec<[f64; 4]> {
    let area: Vec<f64> = facets.iter().map(|f| f.area(reference).norm()).collect();
    let mut around = vec![0.0; mass.len()];
    for (facet, area) in facets.iter().zip(&area) {
        for &k in facet.nodes() {
            around[k as usize] += area;
        }
    }
    let mass_per_area = |k: usize| mass[k] / around[k];
    let corner =
        |f: &SheetFacet, area: f64, k: usize| if k < f.count { area * mass_per_area(f.nodes[k] as usize) } else { 0.0 };
    facets.iter().zip(&area).map(|(f, &area)| std::array::from_fn(|k| corner(f, area, k))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Momentum of the samples is that of the nodes, for every shape and any number of samples.
    #[test]
    fn samples_carry_the_nodes_mass() {
        let position =
            [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [1.2, 1.0, 0.3], [-0.1, 0.9, 0.0], [2.0, 0.2, 0.1]].map(Vector);
        let facets = [SheetFacet::new(&[0, 1, 2, 3]), SheetFacet::new(&[1, 4, 2])];
        let mass = [1.0, 2.0, 3.0, 4.0, 5.0];
        let corners = corner_mass(&facets, &position, &mass);
        for cell in [3.0, 0.5, 0.21] {
            let mut samples = Samples::default();
            samples.divide(&facets, &position, &corners, cell);
            let mut sums = [0.0; 5];
            for q in 0..samples.count() {
                let facet = facets[samples.element[q] as usize];
                for k in 0..4 {
                    sums[facet.nodes[k] as usize] += samples.mass[q][k];
                }
            }
            for (sum, mass) in sums.iter().zip(&mass) {
                assert!((sum - mass).abs() < 1e-13, "{sums:?}");
            }
        }
    }

    /// Samples are at most half a cell apart, and the area fractions of an element sum to one.
    #[test]
    fn samples_are_dense_and_follow_the_stretch() {
        let facets = [SheetFacet::new(&[0, 1])];
        let mut position = [Vector([0.0, 0.0]), Vector([1.0, 0.0])];
        let corners = corner_mass(&facets, &position, &[1.0, 1.0]);
        let mut samples = Samples::default();
        samples.divide(&facets, &position, &corners, 1.0);
        assert_eq!(samples.count(), 2);
        position[1] = Vector([2.2, 0.0]);
        samples.divide(&facets, &position, &corners, 1.0);
        assert_eq!(samples.count(), 5);
        assert!((samples.area_fraction.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert_eq!(facets[0].area(&position), Vector([0.0, -2.2]));
    }
}
