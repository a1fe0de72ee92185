//! The surface of elastic solids in the cut elements, point by point: what flows through it, and where the pressure
//! acts (theory (J.9a)).
//!
//! ```text
//! q_k = −∫_Γ N_k(x_h) n·(v_S − v_h) dA,      v_S = Σ_a N_a(ξ) v_a,      v_h = Σ_c φ_c P_s v_c      rows p_k;  their transpose: forces
//! ```
//!
//! Γ is the surface of the solid, n its normal, v_h the velocity of the fluid at the nearest place x_h of its own
//! boundary: the chords, or triangles, between cut points c. Between these the surface moves otherwise, and bulges
//! where its nodes lie closer than the nodes of the mesh. Without q the pressure would act on the nodes that happen to
//! be near cut points.

use crate::geometry::closest_on_triangle;
use crate::math::Vector;
use crate::mesh::{Location, Locator, Mesh};
use crate::parallel;
use crate::pfem2::solid::cut::{CutBySolid, ElementState, SolidCut, Vertex};
use crate::pfem2::solid::surface::{FacetPoint, NodeWeights, SolidSurface};
use std::collections::BTreeMap;

/// Facets per piece of a parallel loop.
const PIECE: usize = 8;

/// Parts of a facet along an axis in three dimensions, over its size in elements of the mesh.
const FINENESS: f64 = 2.0;

/// Distance of the end of the mesh from the surface, over the size of an element, within which no fluid is between.
const BEYOND: f64 = 0.05;

/// Distance of the surface from a chord in its own element, over the size of an element, above which another chord may
/// be nearer.
const BESIDE: f64 = 1e-3;

/// A point of the surface in a cut element.
#[derive(Debug, Clone, PartialEq)]
pub struct TracePoint<const D: usize, const N: usize> {
    /// Its facet, among those of all solids.
    pub facet: u32,
    /// Its coordinates there, in −1..=1.
    pub local: [f64; 2],
    /// Its weight among the points of the facet, 2 per axis in sum.
    pub share: f64,
    /// n dA [m²], away from the solid.
    pub area: Vector<D>,
    /// Shape functions of the element at the nearest place of the boundary of its fluid part: beyond that they may
    /// belong to a node that hardly any fluid has, and whose pressure nothing else would bound.
    pub shape: [f64; N],
    /// Shape functions of the solids' nodes at it, by global node.
    pub weights: NodeWeights,
    /// φ_c of cut points, by their places in the list of the element.
    pub chord: Vec<(usize, f64)>,
}

/// A place of the boundary of the fluid part of an element.
struct ChordPlace<const D: usize> {
    /// Square of its distance [m²].
    away: f64,
    /// Position [m].
    position: Vector<D>,
    /// Shares of cut points, by their places in the list of the element.
    chord: Vec<(usize, f64)>,
}

/// The points of all facets of elastic solids, each with the place of its cut element.
#[derive(Debug, Clone, Default)]
pub struct SurfaceTrace<const D: usize, const N: usize> {
    /// Points of each facet, with the places of their cut elements.
    pub facets: Vec<Vec<(usize, TracePoint<D, N>)>>,
}

/// The mesh of the fluid, cut at the surface of solids.
#[derive(Debug, Clone)]
pub struct CutMesh<const D: usize, const N: usize> {
    /// The cut elements.
    pub cut: SolidCut<D, N>,
    /// Points of the surface in them.
    pub trace: SurfaceTrace<D, N>,
}

impl<const D: usize, const N: usize> SurfaceTrace<D, N> {
    /// The points of a surface in a mesh that it cuts. Rigid solids move between cut points as at these, and need none.
    pub fn new(
        mesh: &Mesh<D, N>,
        locator: &Locator<D>,
        surface: &SolidSurface<D>,
        cut: &SolidCut<D, N>,
        is_elastic: impl Fn(u32) -> bool + Sync,
    ) -> Self {
        let boundaries = parallel::collect(cut.elements.len(), PIECE, |place| boundary(&cut.elements[place]));
        let tracer = Tracer { mesh, locator, surface, cut, boundaries };
        let breaks = breaks(surface, cut);
        let facets = parallel::collect(surface.facet_count(), PIECE, |facet| {
            match is_elastic(surface.nodes_of(facet as u32)[0]) {
                true => tracer.points(facet as u32, breaks.get(facet)),
                false => Vec::new(),
            }
        });
        Self { facets }
    }

    /// The points in each of `count` cut elements, in their order.
    pub fn by_element(self, count: usize) -> Vec<Vec<TracePoint<D, N>>> {
        let mut all = vec![Vec::new(); count];
        self.facets.into_iter().flatten().for_each(|(place, point)| all[place].push(point));
        all
    }
}

/// Places where the surface goes from one element to the next in two dimensions: coordinates of cut points on each
/// facet, ascending, with its ends.
fn breaks<const D: usize, const N: usize>(surface: &SolidSurface<D>, cut: &SolidCut<D, N>) -> Vec<Vec<f64>> {
    if D != 2 {
        return Vec::new();
    }
    let mut all = vec![vec![-1.0, 1.0]; surface.facet_count()];
    let feet = parallel::collect(cut.points.len(), PIECE, |point| surface.facet_at(cut.points[point].position));
    feet.into_iter().flatten().for_each(|(facet, local)| all[facet as usize].push(local[0]));
    for own in &mut all {
        own.sort_by(f64::total_cmp);
        own.dedup();
    }
    all
}

/// A surface in a mesh, and the boundaries of the fluid parts of its cut elements.
struct Tracer<'a, const D: usize, const N: usize> {
    mesh: &'a Mesh<D, N>,
    locator: &'a Locator<D>,
    surface: &'a SolidSurface<D>,
    cut: &'a SolidCut<D, N>,
    /// Facets of each cut element between cut points.
    boundaries: Vec<Vec<[usize; D]>>,
}

impl<const D: usize, const N: usize> Tracer<'_, D, N> {
    /// The points of a facet, with the places of their cut elements; `breaks` are the coordinates between which they
    /// lie, equally spaced without them.
    fn points(&self, facet: u32, breaks: Option<&Vec<f64>>) -> Vec<(usize, TracePoint<D, N>)> {
        let &Self { mesh, locator, surface, cut, .. } = self;
        let Some(mut guess) = surface.places(facet).find_map(|x| locator.search(mesh, x)?.element()) else {
            return Vec::new();
        };
        let factorial: f64 = (1..=D).map(|k| k as f64).product();
        let size = (factorial * mesh.simplex(guess).volume).powf(1.0 / D as f64);
        let parts = (FINENESS * surface.size_and_middle(facet).0 / size).ceil().max(1.0);
        let equal = || (0..=parts as usize).map(|k| 2.0 * k as f64 / parts - 1.0).collect();
        let breaks = breaks.cloned().unwrap_or_else(equal);
        let mut points = Vec::new();
        surface.visit_points(facet, &breaks, |point| {
            let FacetPoint { position: x, area, local, share, weights } = point;
            let Location::Inside { element, .. } = locator.locate(mesh, x, guess) else { return };
            guess = element;
            let outwards = area.normalized().unwrap_or_default();
            if locator.search(mesh, x + outwards * (BEYOND * size)).is_none() {
                return;
            }
            let Some((place, ChordPlace { position, chord, .. })) = self.chord_place(element, x, size) else { return };
            let shape = mesh.shape_functions(cut.elements[place].element as usize, position);
            points.push((place, TracePoint { facet, local, share, area, shape, weights, chord }));
        });
        points
    }

    /// The nearest place of the chords to a place of an element, with its cut element; `size` of the elements there
    /// [m].
    fn chord_place(&self, element: usize, x: Vector<D>, size: f64) -> Option<(usize, ChordPlace<D>)> {
        let cut = self.cut;
        let own = |place: usize| Some((place, nearest(cut, &cut.elements[place], &self.boundaries[place], x)?));
        let beside = |found: &(usize, ChordPlace<D>)| found.1.away <= (BESIDE * size).powi(2);
        let nearer = |best: (usize, ChordPlace<D>), next: (usize, ChordPlace<D>)| {
            if next.1.away < best.1.away { next } else { best }
        };
        let found = place_of(cut, element).and_then(own).filter(beside);
        found.or_else(|| around(self.mesh, cut, element).into_iter().filter_map(own).reduce(nearer))
    }
}

/// The place of an element among those that are cut.
fn place_of<const D: usize, const N: usize>(cut: &SolidCut<D, N>, element: usize) -> Option<usize> {
    match cut.state[element] {
        ElementState::Cut(place) => Some(place as usize),
        _ => None,
    }
}

/// Places of the cut elements that share a node with an element: its surface may belong to one of them, where it bulges
/// or lies along a side.
fn around<const D: usize, const N: usize>(mesh: &Mesh<D, N>, cut: &SolidCut<D, N>, element: usize) -> Vec<usize> {
    let beside = mesh.elements()[element].iter().flat_map(|&node| mesh.elements_around(node as usize));
    let mut all: Vec<usize> = beside.filter_map(|&e| place_of(cut, e as usize)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The facets of the fluid part of an element that are its boundary to solids: those between cut points, which one part
/// has.
fn boundary<const D: usize, const N: usize>(element: &CutBySolid<N>) -> Vec<[usize; D]> {
    let mut counts: BTreeMap<[usize; D], u32> = BTreeMap::new();
    for part in &element.parts {
        for left_out in 0..N {
            let points = (0..N).filter(|k| *k != left_out).map(|k| match part.vertices[k] {
                Vertex::Point(point) => Some(usize::from(point)),
                Vertex::Node(_) => None,
            });
            let Some(mut points) = points.collect::<Option<Vec<usize>>>() else { continue };
            points.sort_unstable();
            *counts.entry(std::array::from_fn(|k| points[k])).or_insert(0) += 1;
        }
    }
    counts.into_iter().filter(|(_, count)| *count == 1).map(|(facet, _)| facet).collect()
}

/// The nearest place of the boundary of the fluid part of an element.
fn nearest<const D: usize, const N: usize>(
    cut: &SolidCut<D, N>,
    element: &CutBySolid<N>,
    boundary: &[[usize; D]],
    x: Vector<D>,
) -> Option<ChordPlace<D>> {
    let position = |point: usize| cut.points[element.points[point] as usize].position;
    let on = |facet: &[usize; D]| {
        let corners = facet.map(position);
        let last = corners[D - 1];
        let shares = closest_on_triangle([corners[0], corners[1], last], x);
        // In the plane the third corner is the second again.
        let shares: [f64; D] =
            std::array::from_fn(|k| if D == 2 && k == 1 { shares[1] + shares[2] } else { shares[k] });
        let position: Vector<D> = corners.iter().zip(shares).map(|(x, share)| *x * share).sum();
        let chord = facet.iter().copied().zip(shares).collect();
        ChordPlace { away: (x - position).norm_squared(), position, chord }
    };
    let all = boundary.iter().map(on);
    all.reduce(|best, next| if next.away < best.away { next } else { best })
}
