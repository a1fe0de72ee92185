//! Fluid that glides at edges of solids in elements that cut them off, in three dimensions (theory (J.6b)).
//!
//! ```text
//! v_c = P_s Σ_a N_a(ξ_c) v_a + (1 − P_s) v_i,   P_s: projection on the normals of cut points of the
//!                                               same elements that differ by more than 30°
//! ```
//!
//! Elements cut an edge off, from a cut point on one side of the solid to one on the other. A fluid that glides along
//! one side at one end and along the other at the other end would flow through the solid there: it glides along
//! the edge alone, and at a corner of three sides not at all.

use super::SolidCut;
use crate::math::{Tensor, Vector};
use crate::pfem2::solid::surface::EDGE_COSINE_SQUARED;

/// Length of a part of a unit vector that is rounding.
const ROUNDING: f64 = 1e-6;

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Lets the fluid glide along edges of solids alone.
    pub(super) fn glide_along_edges(&mut self) {
        if D != 3 {
            return;
        }
        let normals: Vec<Option<Vector<D>>> =
            self.points.iter().map(|point| point.bound_directions.as_ref().map(direction)).collect();
        let is_whole: Vec<bool> = self.points.iter().map(|point| point.edge.is_some()).collect();
        for element in &self.elements {
            if !element.points.iter().all(|&point| is_whole[point as usize]) {
                continue;
            }
            for &point in &element.points {
                for other in element.points.iter().filter_map(|&other| normals[other as usize]) {
                    let Some(own) = normals[point as usize].filter(|own| own.dot(other).powi(2) < EDGE_COSINE_SQUARED)
                    else {
                        continue;
                    };
                    let across = &mut self.points[point as usize].bound_directions;
                    *across = Some(extended(across.unwrap_or_else(|| Tensor::outer(own, own)), other));
                }
            }
        }
    }
}

/// The direction on which a tensor n ⊗ n projects.
pub(super) fn direction<const D: usize>(across: &Tensor<D>) -> Vector<D> {
    let columns = (0..D).map(|j| Vector::from_fn(|i| across[i][j]));
    let longest = columns.max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    longest.and_then(|column| column.normalized()).unwrap_or_default()
}

/// A projection with one more direction.
fn extended<const D: usize>(across: Tensor<D>, direction: Vector<D>) -> Tensor<D> {
    let rest = direction - across.apply(direction);
    match rest.normalized() {
        Some(more) if rest.norm() > ROUNDING => across + Tensor::outer(more, more),
        _ => across,
    }
}
