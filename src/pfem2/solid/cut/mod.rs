//! The fixed mesh cut by the surfaces of solids (theory J.2).
//!
//! ```text
//! node i inside:  d_i ≤ 0,   v_i = Σ_a N_a(ξ_i) v_a                        ξ_i: its place in an element of the solid
//! cut point c of edge (i, j), i outside:  x_c = x_i + t (x_j − x_i),  d(x_c) = 0,  t ∈ (0, 1)
//!                                  v_c = Σ_a N_a(ξ_c) v_a                  ξ_c: the nearest point of the surface
//! where the fluid glides:          v_c = P_s Σ_a N_a(ξ_c) v_a + (1 − P_s) v_i                     theory (J.6a)–(J.6c)
//! ```
//!
//! The root t is that of the linear interpolant of d_i and d_j where the surface is plane; Newton's method starts from
//! it, so that the nearer side of a thin solid doesn't draw the cut points of the other. The part of a cut element
//! outside is made of simplices whose corners are nodes, cut points, and places on corners and edges of the solid.
//! Elements without a node inside are cut, too, where a corner or an edge of the solid reaches into them (`corners.rs`,
//! `solid_edges.rs`).
//!
//! On curved sides cut points go off the surface by as much as keeps the volume of the solid (`curved_sides.rs`). Films
//! between solids nearer than an element have cut points of their own (`films.rs`).
//!
//! P_s projects on the directions in which the fluid is bound to the solid: n ⊗ n with the normal of the surface,
//! (J.6a), of all sides of an edge that an element cuts off, (J.6b, `slip_at_edges.rs`), or of the chords, (J.6c,
//! `slip_on_chords.rs`).

mod chords;
mod cones;
mod corners;
mod corners_beyond_nodes;
mod curved_sides;
mod cut_point;
mod edge_passages;
mod edge_reach;
mod film_parts;
#[cfg(test)]
mod film_tests;
mod films;
mod parts;
mod polygon;
mod several_bodies;
mod slip_at_edges;
mod slip_on_chords;
mod solid_edges;
#[cfg(test)]
mod tests;
mod two_sided;

use super::setup::SurfaceCondition;
use super::surface::{NodeWeights, SolidSurface};
use crate::math::Vector;
use crate::mesh::{Location, Locator, Mesh};
use crate::parallel;
use crate::pfem2::cut_element::volume_fraction;
pub use chords::Chords;
pub use cut_point::{CutPoint, VelocityWeights};
use cut_point::{LEAST_EDGE_FRACTION, cut_point, smallest_element};
use hashbrown::HashMap;
pub use parts::{FluidSimplex, Vertex};
use std::collections::BTreeSet;

/// Nodes this near to the surface, over the size of the smallest element around them, are inside: no slivers
/// of rounding lie along a surface on lines of the mesh, and none that are thinner than what cut points keep.
const ON_SURFACE: f64 = LEAST_EDGE_FRACTION;

/// The same where all nodes of an element lie on the surface but for this, and its middle inside: by a little more or
/// less it would be fluid or solid.
const BESIDE_SURFACE: f64 = 1e-3;

/// Nodes and points per piece of a parallel loop.
const PIECE: usize = 16;

/// The background mesh in the presence of solids.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidCut<const D: usize, const N: usize> {
    /// Signed distance of the background nodes to the surfaces [m], negative inside. Known at nodes of elements that
    /// have a node inside, and at those in boxes around elements of solids; infinite elsewhere.
    pub distance: Vec<f64>,
    /// Background nodes inside, ascending.
    pub inside: Vec<NodeInside>,
    /// State of each background element.
    pub state: Vec<ElementState>,
    /// Cut points: those on edges with a node inside, in the order of cut elements and their edges, and then those at
    /// corners and edges of solids.
    pub points: Vec<CutPoint<D>>,
    /// Cut elements: those with a node inside, ascending, and then those that hold nothing but a tip or an edge
    /// of a solid.
    pub elements: Vec<CutBySolid<N>>,
}

/// A background node inside a solid.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeInside {
    /// The node.
    pub node: u32,
    /// Shape functions of the solids' nodes at it, by global node.
    pub weights: NodeWeights,
}

/// State of a background element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElementState {
    /// No node is inside, and no tip or edge of a solid is kept that reaches into it.
    Fluid,
    /// All nodes are inside, and no film crosses it.
    Solid,
    /// The surface of a solid passes it: some nodes are inside, or none, where it holds only a tip or an edge
    /// of a solid; its place in [`SolidCut::elements`].
    Cut(u32),
}

/// A background element that the surface of a solid passes: with nodes inside and outside, or with none inside, but
/// a tip or an edge of a solid in it.
#[derive(Debug, Clone, PartialEq)]
pub struct CutBySolid<const N: usize> {
    /// The element.
    pub element: u32,
    /// Its nodes.
    pub nodes: [u32; N],
    /// Its cut points, places in [`SolidCut::points`].
    pub points: Vec<u32>,
    /// True for its nodes outside of solids.
    pub outside: [bool; N],
    /// True for its nodes inside with fluid on several sides of the solid (theory J.2b).
    pub two_sided: [bool; N],
    /// The part outside of solids.
    pub parts: Vec<FluidSimplex<N>>,
    /// Shape functions of the element at the corners of each of them.
    pub shapes: Vec<[[f64; N]; N]>,
    /// Their volume over that of the element.
    pub volume_fraction: f64,
}

impl<const N: usize> CutBySolid<N> {
    /// An element with its cut points and its parts outside, whose places are not known yet.
    fn new(element: u32, nodes: [u32; N], points: Vec<u32>, parts: Vec<FluidSimplex<N>>) -> Self {
        let [outside, two_sided] = [[false; N]; 2];
        Self { element, nodes, points, outside, two_sided, parts, shapes: Vec::new(), volume_fraction: 1.0 }
    }

    /// Finds where the corners of its parts are in the element, given the cut points.
    fn place<const D: usize>(&mut self, mesh: &Mesh<D, N>, points: &[CutPoint<D>]) {
        let shape = |vertex: Vertex| match vertex {
            Vertex::Node(k) => std::array::from_fn(|i| if i == usize::from(k) { 1.0 } else { 0.0 }),
            Vertex::Point(k) => {
                let position = points[self.points[usize::from(k)] as usize].position;
                mesh.shape_functions(self.element as usize, position)
            }
        };
        self.shapes = self.parts.iter().map(|part| part.vertices.map(shape)).collect();
        self.volume_fraction = self.shapes.iter().map(volume_fraction).sum();
    }
}

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// The background mesh cut by the surface of all solids, with the condition on each.
    pub fn new(mesh: &Mesh<D, N>, surface: &SolidSurface<D>, conditions: &[SurfaceCondition]) -> Self {
        let (distance, nodes) = distances(mesh, surface);
        let mut cut = Self {
            inside: extensions(mesh, surface, &nodes),
            state: vec![ElementState::Fluid; mesh.elements().len()],
            points: Vec::new(),
            elements: Vec::new(),
            distance,
        };
        let edges = cut.divide(mesh, &touched(mesh, &nodes));
        let (distance, own) = (&cut.distance, &cut);
        let point = |k: usize| {
            let body = own.body_at(surface, edges[k][1]).unwrap_or_default();
            cut_point(mesh, surface, conditions, distance, edges[k], body)
        };
        cut.points = parallel::collect(edges.len(), PIECE, point);
        let films = cut.find_films(mesh, surface);
        cut.keep_corners(mesh, surface);
        cut.keep_edges(mesh, surface, conditions, &films);
        cut.add_films(mesh, surface, films);
        cut.keep_volume(mesh, surface);
        cut.glide_along_edges();
        cut.glide_along_chords(mesh);
        cut.mark_two_sided(mesh, surface);
        let points = &cut.points;
        parallel::change(&mut cut.elements, PIECE, |_, element| element.place(mesh, points));
        cut
    }

    /// Sets the state of these ascending elements, decomposes the cut ones, and numbers their cut edges.
    fn divide(&mut self, mesh: &Mesh<D, N>, elements: &[u32]) -> Vec<[u32; 2]> {
        let mut edges = Vec::new();
        let mut numbers: HashMap<[u32; 2], u32> = HashMap::new();
        for &element in elements {
            let nodes = mesh.elements()[element as usize];
            let inside = nodes.map(|node| self.is_inside(node));
            if inside == [true; N] {
                self.state[element as usize] = ElementState::Solid;
                continue;
            }
            let mut number = |[outside, inside]: [usize; 2]| {
                let edge = [nodes[outside], nodes[inside]];
                *numbers.entry(edge).or_insert_with(|| {
                    edges.push(edge);
                    edges.len() as u32 - 1
                })
            };
            let points = parts::cut_edges(inside).into_iter().map(&mut number).collect();
            self.state[element as usize] = ElementState::Cut(self.elements.len() as u32);
            let parts = parts::outside(&nodes, inside);
            self.elements.push(CutBySolid::new(element, nodes, points, parts));
        }
        edges
    }

    /// The solid of a background node inside, or the first of those that it is bonded with.
    fn body_at(&self, surface: &SolidSurface<D>, node: u32) -> Option<usize> {
        let place = self.inside.binary_search_by_key(&node, |inside| inside.node).ok()?;
        body_of(surface, &self.inside[place].weights)
    }

    /// True for a background node inside a solid.
    pub fn is_inside(&self, node: u32) -> bool {
        self.distance[node as usize] <= 0.0
    }

    /// Positions of the corners of a sub-simplex [m].
    pub fn corners(&self, mesh: &Mesh<D, N>, element: &CutBySolid<N>, part: &FluidSimplex<N>) -> [Vector<D>; N] {
        part.vertices.map(|vertex| match vertex {
            Vertex::Node(k) => mesh.nodes()[element.nodes[k as usize] as usize],
            Vertex::Point(k) => self.points[element.points[k as usize] as usize].position,
        })
    }

    /// Volume of the part of an element outside of solids [m³]; [m²] in 2D.
    pub fn volume_outside(&self, mesh: &Mesh<D, N>, element: usize) -> f64 {
        let volume_fraction = match self.state[element] {
            ElementState::Fluid => 1.0,
            ElementState::Solid => 0.0,
            ElementState::Cut(place) => self.elements[place as usize].volume_fraction,
        };
        volume_fraction * mesh.simplex(element).volume
    }

    /// Volume of the background mesh that counts as solid [m³]; [m²] in 2D.
    pub fn volume_inside(&self, mesh: &Mesh<D, N>) -> f64 {
        parallel::sum(self.state.len(), |e| mesh.simplex(e).volume - self.volume_outside(mesh, e))
    }

    /// Background elements, ascending, that hold a node of a solid's surface well inside although none of their nodes
    /// is inside a solid: there a solid is too thin, or too sharp, for the mesh.
    pub fn missed(&self, mesh: &Mesh<D, N>, locator: &Locator<D>, surface: &SolidSurface<D>) -> Vec<u32> {
        /// Least shape function of a place well inside an element.
        const LEAST_SHAPE_FUNCTION: f64 = 0.02;
        let mut missed = BTreeSet::new();
        let mut guess = 0;
        for x in surface.facet_nodes().filter(|x| x.is_finite()) {
            let Location::Inside { element, shape } = locator.locate(mesh, x, guess) else { continue };
            guess = element;
            if self.state[element] == ElementState::Fluid && shape.iter().all(|&n| n > LEAST_SHAPE_FUNCTION) {
                missed.insert(element as u32);
            }
        }
        missed.into_iter().collect()
    }
}

/// The solid of a place with these weights, or the first of those that it is bonded with.
fn body_of<const D: usize>(surface: &SolidSurface<D>, weights: &NodeWeights) -> Option<usize> {
    Some(surface.body_of(weights.first()?.0))
}

/// Signed distances of the nodes near solids, and the nodes inside, ascending.
fn distances<const D: usize, const N: usize>(mesh: &Mesh<D, N>, surface: &SolidSurface<D>) -> (Vec<f64>, Vec<u32>) {
    let place = |node: u32| mesh.nodes()[node as usize];
    let on_surface = |node: usize| ON_SURFACE * smallest_element(mesh, node);
    let margin = |node: usize| BESIDE_SURFACE * smallest_element(mesh, node);
    let is_near = |node: usize| surface.is_near(place(node as u32), margin(node)).then_some(node as u32);
    let near = parallel::collect_some(mesh.nodes().len(), parallel::CHUNK, is_near);
    let mut distance = vec![f64::INFINITY; mesh.nodes().len()];
    let known = parallel::collect(near.len(), PIECE, |k| {
        let (d, node) = (surface.distance(place(near[k])), near[k] as usize);
        if d > 0.0 && d < on_surface(node) { 0.0 } else { d }
    });
    near.iter().zip(&known).for_each(|(&node, &d)| distance[node as usize] = d);
    let covered = covered(mesh, surface, &near, &distance);
    covered.into_iter().for_each(|node| distance[node as usize] = distance[node as usize].min(0.0));
    let inside: Vec<u32> = near.into_iter().filter(|&node| distance[node as usize] <= 0.0).collect();
    let neighbours = touched(mesh, &inside).into_iter().flat_map(|e| mesh.elements()[e as usize]);
    let mut around: Vec<u32> = neighbours.filter(|&node| distance[node as usize] == f64::INFINITY).collect();
    around.sort_unstable();
    around.dedup();
    // They are in no box around an element, so they are outside.
    let known = parallel::collect(around.len(), PIECE, |k| surface.distance(place(around[k])).abs());
    around.iter().zip(known).for_each(|(&node, d)| distance[node as usize] = d.max(f64::MIN_POSITIVE));
    (distance, inside)
}

/// Nodes of elements with all nodes beside the surface and their middle inside, as in the corner of a solid on lines
/// of the mesh.
fn covered<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    surface: &SolidSurface<D>,
    near: &[u32],
    distance: &[f64],
) -> Vec<u32> {
    let is_beside =
        |&node: &u32| distance[node as usize].abs() < BESIDE_SURFACE * smallest_element(mesh, node as usize);
    let beside: Vec<u32> = near.iter().copied().filter(is_beside).collect();
    let is_covered = |e: &u32| {
        let middle = mesh.corners(*e as usize).into_iter().sum::<Vector<D>>() / N as f64;
        let nodes = &mesh.elements()[*e as usize];
        nodes.iter().all(|node| beside.binary_search(node).is_ok()) && surface.distance(middle) < 0.0
    };
    touched(mesh, &beside).into_iter().filter(is_covered).flat_map(|e| mesh.elements()[e as usize]).collect()
}

/// Elements around nodes, ascending.
fn touched<const D: usize, const N: usize>(mesh: &Mesh<D, N>, nodes: &[u32]) -> Vec<u32> {
    let mut elements: Vec<u32> = nodes.iter().flat_map(|&node| mesh.elements_around(node as usize)).copied().collect();
    elements.sort_unstable();
    elements.dedup();
    elements
}

/// Weights by which nodes inside move with the solids.
fn extensions<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    surface: &SolidSurface<D>,
    nodes: &[u32],
) -> Vec<NodeInside> {
    let weights = |x| surface.locate_inside(x).or_else(|| Some(surface.nearest(x)?.weights)).unwrap_or_default();
    let inside = |k: usize| NodeInside { node: nodes[k], weights: weights(mesh.nodes()[nodes[k] as usize]) };
    parallel::collect(nodes.len(), PIECE, inside)
}
