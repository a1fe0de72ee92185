//! Cut points beside curved surfaces of rigid solids, off these by as much as keeps the volume (theory (J.6e)).
//!
//! ```text
//! f, a chord (a triangle in space) between cut points on the surface, its middle at the distance d_f
//! mean distance of f        2/3 d_f  (3/4 d_f in space)                                 of a paraboloid
//! c goes along its edge by  δ_c/(n_c·e),     δ_c = −Σ_f A_f (mean distance)_f / Σ_f A_f,     n_c ∝ Σ_f A_f n_f,   f at c
//! ```
//!
//! There it moves as the solid would: Σ N_a(ξ_c) x_a = x_c, so that a rigid solid that turns drives no fluid through its
//! chords. Solids without elements keep their cut points on the surface. Chords of a convex solid lie within it: without this it would have less buoyancy and less drag, in second order of
//! the size of elements.

use super::chords::{Chords, area};
use super::{CutPoint, PIECE, SolidCut};
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::solid::surface::SolidSurface;

/// Differences between normals at the ends of a chord and their mean, below which the surface is plane there, and above
/// which it is curved.
const CURVED: [f64; 2] = [1e-3, 2e-3];

/// A cut point goes no less far than this part of its edge, or stays.
const NEAREST: f64 = 3e-4;

/// Cosine of the angle between an edge and the normal that counts at least: edges along the surface carry a point far.
const LEAST_COSINE: f64 = 0.3;

/// Difference between the normal at the middle of a chord and the mean of those at its ends, over the largest
/// of these with that mean, above which an edge of the solid is between.
const SMOOTH: f64 = 0.3;

/// Sums over the chords at a cut point, for the volume between them and the surface.
#[derive(Clone, Copy)]
struct AtPoint<const D: usize> {
    /// Σ_f A_f times the mean distance of f [m³]; [m²] in 2D.
    volume: f64,
    /// Σ_f A_f [m²].
    size: f64,
    /// Σ_f A_f n_f [m²], away from the solid.
    area: Vector<D>,
}

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Moves cut points off curved surfaces of rigid solids until the volume between chords and surface is none in sum.
    pub(super) fn keep_volume(&mut self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>) {
        if !surface.has_rigid() {
            return;
        }
        let at_points = self.beside_chords(mesh, surface);
        let moved = parallel::collect_some(self.points.len(), PIECE, |c| {
            let position = self.moved(mesh, c, &at_points[c])?;
            let foot = surface.foot(position).filter(|foot| surface.is_rigid(foot.solid))?;
            let (normal, weights) = (surface.normal(&foot)?, surface.weights_beyond(position, &foot)?);
            let own = &self.points[c];
            let bound_directions = own.bound_directions.map(|_| Tensor::outer(normal, normal));
            Some((c, CutPoint { position, weights, normal: Some(normal), bound_directions, ..own.clone() }))
        });
        moved.into_iter().for_each(|(c, point)| self.points[c] = point);
    }

    /// The sums over the chords at each cut point.
    fn beside_chords(&self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>) -> Vec<AtPoint<D>> {
        let fraction = if D == 2 { 2.0 / 3.0 } else { 0.75 };
        let chords = Chords::new(mesh, self);
        let all = parallel::collect(self.elements.len(), PIECE, |place| {
            let element = &self.elements[place];
            let of = |chord: &[usize; D]| {
                let corners = chord.map(|point| chords.position(element, point));
                let middle = corners.iter().copied().sum::<Vector<D>>() / D as f64;
                let normal = area(corners);
                let size = normal.norm();
                let normals = chord.map(|point| self.points[element.points[point] as usize].normal);
                let distance = distance_of_smooth_side(surface, middle, normals).unwrap_or(0.0);
                let volume = fraction * distance * size;
                (chord.map(|point| element.points[point] as usize), AtPoint { volume, size, area: normal })
            };
            chords.of_elements[place].iter().map(of).collect::<Vec<_>>()
        });
        let mut at_points = vec![AtPoint { volume: 0.0, size: 0.0, area: Vector::ZERO }; self.points.len()];
        for (corners, chord) in all.into_iter().flatten() {
            for c in corners {
                at_points[c].volume += chord.volume;
                at_points[c].size += chord.size;
                at_points[c].area += chord.area;
            }
        }
        at_points
    }

    /// The new place of a cut point of an edge of the mesh; `None` if it stays.
    fn moved(&self, mesh: &Mesh<D, N>, c: usize, at_point: &AtPoint<D>) -> Option<Vector<D>> {
        let point = &self.points[c];
        let [outside, inside] = point.edge?.map(|node| mesh.nodes()[node as usize]);
        let length = (outside - inside).norm();
        let along = (outside - inside) / length;
        let delta = -at_point.volume / at_point.size;
        if !delta.is_finite() {
            return None;
        }
        let cosine = at_point.area.normalized()?.dot(along).max(LEAST_COSINE);
        // No farther than half the way to the nearer node: beside it cut points of several edges lie together.
        let from_outside = (point.position - outside).norm();
        let most = 0.5 * from_outside.min(length - from_outside);
        let way = (delta / cosine).clamp(-most, most);
        (way.abs() >= NEAREST * length).then(|| point.position + along * way)
    }
}

/// Distance of the middle of a chord from the surface [m], given the normals at its ends; `None` where an edge of the
/// solid is between them.
fn distance_of_smooth_side<const D: usize>(
    surface: &SolidSurface<D>,
    middle: Vector<D>,
    normals: [Option<Vector<D>>; D],
) -> Option<f64> {
    let mut mean = Vector::ZERO;
    for normal in normals {
        mean += normal?;
    }
    let mean = mean.normalized()?;
    let spread = normals.iter().flatten().map(|normal| (*normal - mean).norm()).fold(0.0, f64::max);
    let foot = surface.foot(middle)?;
    let own = surface.normal(&foot)?;
    let part = ((spread - CURVED[0]) / (CURVED[1] - CURVED[0])).clamp(0.0, 1.0);
    ((own - mean).norm() < SMOOTH * spread).then_some(part * foot.distance)
}
