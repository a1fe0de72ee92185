//! Points of the surface in space: those of triangles between cut points, with their nearest places on the surface
//! (theory J.3).
//!
//! ```text
//! x(b) = Σ_i b_i (2 b_i − 1) f_i + Σ_{i<j} 4 b_i b_j f_ij,      n dA = ½ ∂x/∂b_1 × ∂x/∂b_2 / 3      f: feet on the surface
//! ```
//!
//! of the corners and of the middles of the sides of a triangle, at each of three points. Triangles whose points have
//! their feet on several facets are divided: N_a has kinks there.

use super::TracePoint;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::solid::cut::Chords;
use crate::pfem2::solid::surface::{FacetPoint, NearestPoint, SolidSurface};

/// Elements per piece of a parallel loop.
const PIECE: usize = 8;

/// A triangle is divided into four at most this often.
const DIVISIONS: u32 = 2;

/// Cosine of the angle between a triangle and the surface above which it cuts an edge off, and its own area acts.
const ALONG_COSINE: f64 = 0.866;

/// Points of a triangle with a third of its area each, by its corners.
const POINTS: [[f64; 3]; 3] =
    [[2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]];

/// The points of each facet of elastic solids, with the places of their cut elements.
pub fn points<const D: usize, const N: usize>(
    chords: &Chords<'_, D, N>,
    surface: &SolidSurface<D>,
    is_elastic: impl Fn(u32) -> bool + Sync,
) -> Vec<Vec<(usize, TracePoint<D, N>)>> {
    let found = parallel::collect(chords.of_elements.len(), PIECE, |place| {
        let mut points = Vec::new();
        for chord in &chords.of_elements[place] {
            let triangle = ChordTriangle {
                chords,
                surface,
                place,
                chord,
                corners: [Vector::unit(0), Vector::unit(1), Vector::unit(2)],
            };
            triangle.visit(0, &mut |point: TracePoint<D, N>| {
                if is_elastic(point.facet) {
                    points.push(point);
                }
            });
        }
        points
    });
    let mut facets = vec![Vec::new(); surface.facet_count()];
    for (place, points) in found.into_iter().enumerate() {
        points.into_iter().for_each(|point| facets[point.facet as usize].push((place, point)));
    }
    facets
}

/// A triangle between cut points of an element, or a part of it.
struct ChordTriangle<'a, const D: usize, const N: usize> {
    chords: &'a Chords<'a, D, N>,
    surface: &'a SolidSurface<D>,
    /// The cut element.
    place: usize,
    /// The cut points, by their places in the list of the element.
    chord: &'a [usize; D],
    /// Its corners, by the weights of the cut points.
    corners: [Vector<3>; 3],
}

impl<const D: usize, const N: usize> ChordTriangle<'_, D, N> {
    /// Weights of the cut points at a place.
    fn chord_weights(&self, place: &[f64; 3]) -> Vector<3> {
        self.corners.iter().zip(place).map(|(&corner, &b)| corner * b).sum()
    }

    /// Position of a place [m].
    fn position(&self, place: &[f64; 3]) -> Vector<D> {
        let element = &self.chords.cut.elements[self.place];
        let weights = self.chord_weights(place);
        self.chord.iter().zip(weights.0).map(|(&point, weight)| self.chords.position(element, point) * weight).sum()
    }

    /// Calls `found` with its points.
    fn visit(&self, divisions: u32, found: &mut impl FnMut(TracePoint<D, N>)) {
        let Some(feet) = self.feet(POINTS) else { return };
        if divisions < DIVISIONS && feet.iter().any(|foot| foot.facet != feet[0].facet) {
            self.quarters().for_each(|quarter| quarter.visit(divisions + 1, found));
            return;
        }
        let Some(places) = self.feet(CORNERS_AND_MIDDLES) else { return };
        let places = places.map(|foot| foot.position);
        let chord = CORNERS_AND_MIDDLES.map(|b| self.position(&b));
        for (b, foot) in POINTS.iter().zip(feet) {
            let [own, of_surface] = [&chord, &places].map(|places| area(places, b) * (1.0 / 3.0));
            let is_along = own.dot(of_surface) > ALONG_COSINE * own.norm() * of_surface.norm();
            let point = self.surface.point_at(&foot, if is_along { of_surface } else { own });
            found(self.trace_point(b, foot.facet, point));
        }
    }

    fn trace_point(&self, place: &[f64; 3], facet: u32, point: FacetPoint<D>) -> TracePoint<D, N> {
        let FacetPoint { area, local, quadrature_weight, weights, .. } = point;
        let Chords { mesh, cut, .. } = self.chords;
        let shape = mesh.shape_functions(cut.elements[self.place].element as usize, self.position(place));
        let chord = self.chord.iter().copied().zip(self.chord_weights(place).0).collect();
        TracePoint { facet, local, quadrature_weight, area, shape, weights, chord }
    }

    /// Nearest places of the surface to places of the triangle.
    fn feet<const P: usize>(&self, places: [[f64; 3]; P]) -> Option<[NearestPoint<D>; P]> {
        let feet: Option<Vec<NearestPoint<D>>> =
            places.iter().map(|place| self.surface.foot(self.position(place))).collect();
        feet?.try_into().ok()
    }

    /// Its four quarters.
    fn quarters(&self) -> impl Iterator<Item = Self> {
        let [a, b, c] = self.corners;
        let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].into_iter().map(|corners| Self { corners, ..*self })
    }
}

/// Corners of a triangle, and the middles of its sides.
const CORNERS_AND_MIDDLES: [[f64; 3]; 6] =
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];

/// n dA of a patch through `places` of corners and middles, at a place of its triangle, for a weight of one [m²].
fn area<const D: usize>([a, b, c, ab, bc, ca]: &[Vector<D>; 6], place: &[f64; 3]) -> Vector<D> {
    let [s, t, u] = *place;
    let from = *a * (4.0 * s - 1.0);
    let first = *b * (4.0 * t - 1.0) - from + (*ab * (s - t) + (*bc - *ca) * u) * 4.0;
    let second = *c * (4.0 * u - 1.0) - from + (*ca * (s - u) + (*bc - *ab) * t) * 4.0;
    Vector::from3((Vector(first.to3()).cross(Vector(second.to3())) * 0.5).0)
}
