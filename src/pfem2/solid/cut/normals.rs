//! Directions in which the fluid glides along chords (theory (J.6c); Engelman, Sani & Gresho 1982).
//!
//! ```text
//! n_c ∝ Σ_s ∫ ∇N^s_c dV        over the simplices s of the fluid part at cut point c
//! ```
//!
//! An even pressure acts on c along n_c: with this normal it doesn't push the fluid along the surface. With that of the nearest place of the surface it
//! does wherever chords leave the surface, in proportion to all of the pressure, on curves and beside corners.

use super::{SolidCut, Vertex};
use crate::math::{Tensor, Vector};
use crate::mesh::{Mesh, Simplex};

/// Square of the product with the normal of the surface below which what cut points have around them says nothing about it.
const ALIKE: f64 = 0.75;

/// Trace of a projection on one direction, with room for rounding.
const ONE_DIRECTION: f64 = 1.5;

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Lets the fluid glide at right angles to the normals of the chords, where one direction is across.
    pub(super) fn glide_along_chords(&mut self, mesh: &Mesh<D, N>) {
        if self.points.iter().all(|point| point.glides_across.is_none()) {
            return;
        }
        let normals = self.chord_normals(mesh);
        for (point, normal) in self.points.iter_mut().zip(normals) {
            let (Some(across), Some(normal)) = (&mut point.glides_across, normal.normalized()) else { continue };
            if across.trace() < ONE_DIRECTION && normal.dot(across.apply(normal)) > ALIKE {
                *across = Tensor::outer(normal, normal);
            }
        }
    }

    /// Σ_s ∫ ∇N^s_c dV of the cut points [m²].
    fn chord_normals(&self, mesh: &Mesh<D, N>) -> Vec<Vector<D>> {
        let mut normals = vec![Vector::ZERO; self.points.len()];
        for element in &self.elements {
            for part in &element.parts {
                let Some(simplex) = Simplex::new(self.corners(mesh, element, part)) else { continue };
                for (vertex, gradient) in part.vertices.iter().zip(&simplex.gradient) {
                    if let Vertex::Point(k) = vertex {
                        normals[element.points[usize::from(*k)] as usize] += *gradient * simplex.volume;
                    }
                }
            }
        }
        normals
    }
}
