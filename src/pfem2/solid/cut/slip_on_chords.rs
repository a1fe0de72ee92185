//! Directions in which the fluid glides along chords (theory (J.6c); Engelman, Sani & Gresho 1982).
//!
//! ```text
//! n_c ∝ Σ_f A_f n_f        over the facets f between the fluid part and the solid at cut point c
//! ```
//!
//! An even pressure acts on c along n_c: with this normal it doesn't push the fluid along the surface. With that
//! of the nearest place of the surface it does wherever chords leave the surface, in proportion to all of the pressure,
//! on curves and beside corners.

use super::slip_at_edges::direction;
use super::{SolidCut, Vertex};
use crate::math::{Tensor, Vector};
use crate::mesh::{Mesh, Simplex};
use crate::pfem2::solid::surface::EDGE_COSINE_SQUARED;

/// Trace of a projection on one direction, and on two, with room for rounding.
const DIRECTIONS: [f64; 2] = [1.5, 2.5];

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Lets the fluid glide at right angles to the normals of the chords. Where they differ much from that
    /// of the surface it glides along neither.
    pub(super) fn glide_along_chords(&mut self, mesh: &Mesh<D, N>) {
        if self.points.iter().all(|point| point.bound_directions.is_none()) {
            return;
        }
        let normals = self.chord_normals(mesh);
        for (point, normal) in self.points.iter_mut().zip(normals) {
            let (Some(across), Some(normal)) = (point.bound_directions, normal.normalized()) else { continue };
            point.bound_directions = along_chords(across, normal);
        }
    }

    /// n_c of the cut points, but for a factor [m²].
    fn chord_normals(&self, mesh: &Mesh<D, N>) -> Vec<Vector<D>> {
        let mut normals = vec![Vector::ZERO; self.points.len()];
        for element in &self.elements {
            for part in &element.parts {
                let Some(simplex) = Simplex::new(self.corners(mesh, element, part)) else { continue };
                let points = part.vertices.map(|vertex| match vertex {
                    Vertex::Point(k) => Some(element.points[usize::from(k)] as usize),
                    Vertex::Node(_) => None,
                });
                // Facets between parts of an element cancel.
                for (k, gradient) in simplex.gradient.iter().enumerate() {
                    let facet = || (0..N).filter(|&i| i != k).map(|i| points[i]);
                    if facet().all(|point| point.is_some()) {
                        facet().flatten().for_each(|point| normals[point] += *gradient * simplex.volume);
                    }
                }
            }
        }
        normals
    }
}

/// The bound directions, given those that the surface has and the normal of the chords; `None` where all are.
fn along_chords<const D: usize>(across: Tensor<D>, normal: Vector<D>) -> Option<Tensor<D>> {
    // The normal of the chords is within 30° of that of the surface, or of the plane across an edge: the fluid may
    // glide as the chords have it.
    let is_alike = normal.dot(across.apply(normal)) > EDGE_COSINE_SQUARED;
    let along = Tensor::identity() - across;
    let line = match across.trace() {
        one if one < DIRECTIONS[0] && is_alike => return Some(Tensor::outer(normal, normal)),
        // Across both, along the line in which they meet; in the plane there is none.
        one if one < DIRECTIONS[0] && D == 3 => direction(&across).to3(),
        two if D == 3 && two < DIRECTIONS[1] && is_alike => {
            let line = direction(&along);
            return (line - normal * normal.dot(line))
                .normalized()
                .map(|line| Tensor::identity() - Tensor::outer(line, line));
        }
        _ => return None,
    };
    let line = Vector::<D>::from3(Vector::<3>(line).cross(Vector(normal.to3())).0).normalized()?;
    Some(Tensor::identity() - Tensor::outer(line, line))
}
