//! Points of the surface in the plane: those of facets between cut points, with their nearest places on chords (theory
//! J.3).

use super::TracePoint;
use crate::geometry::closest_on_triangle;
use crate::math::Vector;
use crate::mesh::{Location, Locator};
use crate::parallel;
use crate::pfem2::solid::cut::{Chords, SolidCut};
use crate::pfem2::solid::surface::{FacetPoint, SolidSurface};

/// Facets per piece of a parallel loop.
const PIECE: usize = 8;

/// Distance of the end of the mesh from the surface, over the size of an element, within which no fluid is between.
const BEYOND: f64 = 0.05;

/// Distance of the surface from a chord in its own element, over the size of an element, above which another chord may
/// be nearer.
const BESIDE: f64 = 1e-3;

/// A place on a chord.
struct ChordPlace<const D: usize> {
    /// Square of its distance [m²].
    away: f64,
    /// Position [m].
    position: Vector<D>,
    /// Weights of cut points, by their places in the list of the element.
    chord: Vec<(usize, f64)>,
}

/// The points of each facet of elastic solids, with the places of their cut elements.
pub fn points<const D: usize, const N: usize>(
    chords: &Chords<'_, D, N>,
    locator: &Locator<D>,
    surface: &SolidSurface<D>,
    is_elastic: impl Fn(u32) -> bool + Sync,
) -> Vec<Vec<(usize, TracePoint<D, N>)>> {
    let tracer = Tracer { chords, locator, surface };
    let breaks = breaks(surface, chords.cut);
    parallel::collect(surface.facet_count(), PIECE, |facet| match is_elastic(facet as u32) {
        true => tracer.points(facet as u32, &breaks[facet]),
        false => Vec::new(),
    })
}

/// Places where the surface goes from one element to the next: coordinates of cut points on each facet, ascending, with
/// its ends.
fn breaks<const D: usize, const N: usize>(surface: &SolidSurface<D>, cut: &SolidCut<D, N>) -> Vec<Vec<f64>> {
    let mut all = vec![vec![-1.0, 1.0]; surface.facet_count()];
    let feet = parallel::collect(cut.points.len(), PIECE, |point| surface.facet_at(cut.points[point].position));
    feet.into_iter().flatten().for_each(|(facet, local)| all[facet as usize].push(local[0]));
    for own in &mut all {
        own.sort_by(f64::total_cmp);
        own.dedup();
    }
    all
}

/// A surface in a mesh with its chords.
struct Tracer<'a, const D: usize, const N: usize> {
    chords: &'a Chords<'a, D, N>,
    locator: &'a Locator<D>,
    surface: &'a SolidSurface<D>,
}

impl<const D: usize, const N: usize> Tracer<'_, D, N> {
    /// The points of a facet, with the places of their cut elements; `breaks` are the coordinates between which they
    /// lie.
    fn points(&self, facet: u32, breaks: &[f64]) -> Vec<(usize, TracePoint<D, N>)> {
        let &Self { chords: &Chords { mesh, cut, .. }, locator, surface } = self;
        let Some(mut guess) = surface.places(facet).find_map(|x| locator.search(mesh, x)?.element()) else {
            return Vec::new();
        };
        let size = (2.0 * mesh.simplex(guess).volume).sqrt();
        let mut points = Vec::new();
        surface.visit_points(facet, breaks, |point| {
            let FacetPoint { position: x, area, local, quadrature_weight, weights } = point;
            let Location::Inside { element, .. } = locator.locate(mesh, x, guess) else { return };
            guess = element;
            let outwards = area.normalized().unwrap_or_default();
            if locator.search(mesh, x + outwards * (BEYOND * size)).is_none() {
                return;
            }
            let Some((place, ChordPlace { position, chord, .. })) = self.chord_place(element, x, size) else { return };
            let shape = mesh.shape_functions(cut.elements[place].element as usize, position);
            points.push((place, TracePoint { facet, local, quadrature_weight, area, shape, weights, chord }));
        });
        points
    }

    /// The nearest place of the chords to a place of an element, with its cut element; `size` of the elements there
    /// [m].
    fn chord_place(&self, element: usize, x: Vector<D>, size: f64) -> Option<(usize, ChordPlace<D>)> {
        let own = |place: usize| Some((place, self.nearest(place, x)?));
        let beside = |found: &(usize, ChordPlace<D>)| found.1.away <= (BESIDE * size).powi(2);
        let nearer = |best: (usize, ChordPlace<D>), next: (usize, ChordPlace<D>)| {
            if next.1.away < best.1.away { next } else { best }
        };
        let found = self.chords.place_of(element).and_then(own).filter(beside);
        found.or_else(|| self.around(element).into_iter().filter_map(own).reduce(nearer))
    }

    /// Places of the cut elements that share a node with an element: its surface may belong to one of them, where it
    /// bulges or lies along a side.
    fn around(&self, element: usize) -> Vec<usize> {
        let mesh = self.chords.mesh;
        let beside = mesh.elements()[element].iter().flat_map(|&node| mesh.elements_around(node as usize));
        let mut all: Vec<usize> = beside.filter_map(|&e| self.chords.place_of(e as usize)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The nearest place of the chords of a cut element.
    fn nearest(&self, place: usize, x: Vector<D>) -> Option<ChordPlace<D>> {
        let element = &self.chords.cut.elements[place];
        let on = |chord: &[usize; D]| {
            let [start, end] = [chord[0], chord[1]].map(|point| self.chords.position(element, point));
            let weights = closest_on_triangle([start, end, end], x);
            let weights = [weights[0], weights[1] + weights[2]];
            let position = start * weights[0] + end * weights[1];
            let chord = chord.iter().copied().zip(weights).collect();
            ChordPlace { away: (x - position).norm_squared(), position, chord }
        };
        let all = self.chords.of_elements[place].iter().map(on);
        all.reduce(|best, next| if next.away < best.away { next } else { best })
    }
}
