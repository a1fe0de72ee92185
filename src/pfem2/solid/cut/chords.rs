//! The boundary of the fluid parts of cut elements to solids: chords in the plane, triangles in space (theory J.2).

use super::{CutBySolid, ElementState, FluidSimplex, SolidCut, Vertex};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use std::collections::{BTreeMap, BTreeSet};

/// Elements per piece of a parallel loop.
const PIECE: usize = 16;

/// Chords of all cut elements of a mesh.
pub struct Chords<'a, const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// Its cut elements.
    pub cut: &'a SolidCut<D, N>,
    /// Those of each cut element: cut points, by their places in the list of the element, in order around the normal
    /// that points away from the solid.
    pub of_elements: Vec<Vec<[usize; D]>>,
}

impl<'a, const D: usize, const N: usize> Chords<'a, D, N> {
    /// The chords of a mesh that solids cut.
    pub fn new(mesh: &'a Mesh<D, N>, cut: &'a SolidCut<D, N>) -> Self {
        let of = |place: usize| chords(mesh, cut, &cut.elements[place]);
        Self { mesh, cut, of_elements: parallel::collect(cut.elements.len(), PIECE, of) }
    }

    /// Position of a cut point of an element [m].
    pub fn position(&self, element: &CutBySolid<N>, point: usize) -> Vector<D> {
        self.cut.points[element.points[point] as usize].position
    }

    /// The place of an element among those that are cut.
    pub fn place_of(&self, element: usize) -> Option<usize> {
        match self.cut.state[element] {
            ElementState::Cut(place) => Some(place as usize),
            _ => None,
        }
    }
}

/// The facets of the fluid part of an element between cut points that only one of its simplices has, but for those
/// on its sides, where a film goes on in the next element.
fn chords<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    cut: &SolidCut<D, N>,
    element: &CutBySolid<N>,
) -> Vec<[usize; D]> {
    let mut found: BTreeMap<[usize; D], Option<(&FluidSimplex<N>, usize)>> = BTreeMap::new();
    for part in &element.parts {
        for left_out in 0..N {
            let points = (0..N).filter(|k| *k != left_out).map(|k| match part.vertices[k] {
                Vertex::Point(point) => Some(usize::from(point)),
                Vertex::Node(_) => None,
            });
            let Some(mut points) = points.collect::<Option<Vec<usize>>>() else { continue };
            points.sort_unstable();
            let first = Some((part, left_out));
            found.entry(std::array::from_fn(|k| points[k])).and_modify(|own| *own = None).or_insert(first);
        }
    }
    let outwards = |(mut chord, own): ([usize; D], Option<(&FluidSimplex<N>, usize)>)| {
        let (part, left_out) = own?;
        if is_on_side(cut, element, &chord) {
            return None;
        }
        let position = |point: usize| cut.points[element.points[point] as usize].position;
        let fluid = cut.corners(mesh, element, part)[left_out];
        if area(chord.map(position)).dot(fluid - position(chord[0])) < 0.0 {
            chord.swap(0, 1);
        }
        Some(chord)
    };
    found.into_iter().filter_map(outwards).collect()
}

/// True for cut points on edges of one side of an element.
fn is_on_side<const D: usize, const N: usize>(
    cut: &SolidCut<D, N>,
    element: &CutBySolid<N>,
    chord: &[usize; D],
) -> bool {
    let points = chord.iter().map(|&k| &cut.points[element.points[k] as usize]);
    let edges: Option<Vec<[u32; 2]>> = points.map(|point| point.edge.or(point.film_edge)).collect();
    let nodes: BTreeSet<u32> = edges.into_iter().flatten().flatten().collect();
    (1..=D).contains(&nodes.len())
}

/// n A of a chord in the plane, turned clockwise, or of a triangle in space [m], [m²].
pub(super) fn area<const D: usize>(corners: [Vector<D>; D]) -> Vector<D> {
    let along = Vector((corners[1] - corners[0]).to3());
    let across = if D == 3 { Vector((corners[D - 1] - corners[0]).to3()) * 0.5 } else { Vector::unit(2) };
    Vector::from3(along.cross(across).0)
}
