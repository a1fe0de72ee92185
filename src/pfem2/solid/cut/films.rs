//! Films of fluid between surfaces that face each other nearer than an element, with no node between (theory J.2a).
//!
//! ```text
//! edge (i, j), both inside, of length L along e
//! in different bodies:    s_i and s_j from its ends to where it leaves each
//! in one:                 s_i = |d_i|/(n_i·e),  s_j = −|d_j|/(n_j·e),  n_i·e > 0,  n_j·e < 0,  n: at the nearest places
//! s_i + s_j < L,  d(½ (x_i + s_i e + x_j − s_j e)) > 0:  a film crosses it, with two cut points
//! in different bodies that touch:  L/1000 thick about ½ (x_i + s_i e + x_j − s_j e)
//! ```
//!
//! Without them such elements would hold nothing, and the pressure around would press the two surfaces together, a
//! constant one, too. The fluid of a film moves with its cut points, which follow the solids: it sticks there.

use super::cut_point::{LEAST_EDGE_FRACTION, LEAST_INNER_EDGE_FRACTION, LEAST_THICKNESS, crossing};
use super::film_parts::{FilmElement, FilmNumbers};
use super::{CutBySolid, CutPoint, ElementState, PIECE, SolidCut};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::solid::surface::SolidSurface;
use std::collections::BTreeSet;

/// Cosine of the angle between an edge and a normal below which the edge runs along the surface.
const LEAST_COSINE: f64 = 0.05;

/// Solids that lie deeper in each other than this part of an edge have no film there: they have passed each other.
const LARGEST_OVERLAP: f64 = 0.5;

/// An edge of the mesh between two nodes inside, the lower first, and the cut points where a film crosses it, the one
/// beside the lower node first.
type FilmEdge<const D: usize> = ([u32; 2], [CutPoint<D>; 2]);

/// A node inside, beside the surface.
struct FilmSide<const D: usize> {
    position: Vector<D>,
    /// Its solid, or the first of those that are bonded.
    body: usize,
    /// Its depth [m].
    depth: f64,
    /// Outward unit normal at the nearest place of the surface.
    normal: Vector<D>,
}

/// Films, with the elements whose edges they cross.
pub(super) struct Films<const D: usize> {
    edges: Vec<FilmEdge<D>>,
    pub elements: BTreeSet<u32>,
}

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Finds the films between surfaces.
    pub(super) fn find_films(&self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>) -> Films<D> {
        let edges = self.film_edges(mesh, surface);
        let beside = |[i, j]: [u32; 2]| {
            let around = mesh.elements_around(i as usize).iter().copied();
            around.filter(move |&e| mesh.elements()[e as usize].contains(&j))
        };
        let elements = edges.iter().flat_map(|(edge, _)| beside(*edge)).collect();
        Films { edges, elements }
    }

    /// Adds films to elements with all nodes inside, and to those that are cut.
    pub(super) fn add_films(&mut self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>, films: Films<D>) {
        let mut numbers = FilmNumbers::new();
        for (edge, points) in films.edges {
            let first = self.points.len() as u32;
            self.points.extend(points);
            numbers.insert(edge, [first, first + 1]);
        }
        for element in films.elements {
            self.add_film(mesh, surface, element, &numbers);
        }
    }

    /// Divides the fluid part of an element anew, with the films that cross its edges; an element in which that fails
    /// stays as it is.
    fn add_film(&mut self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>, element: u32, numbers: &FilmNumbers) {
        let nodes = mesh.elements()[element as usize];
        let place = match self.state[element as usize] {
            ElementState::Fluid => return,
            ElementState::Solid => None,
            ElementState::Cut(place) => Some(place as usize),
        };
        let own: &[u32] = place.map_or(&[], |place| &self.elements[place].points);
        let with_films = FilmElement { cut: self, mesh, surface, number: element as usize, own };
        let Some((points, parts)) = with_films.divided(numbers) else { return };
        if let Some(place) = place {
            self.elements[place] = CutBySolid { points, parts, ..self.elements[place].clone() };
            return;
        }
        self.state[element as usize] = ElementState::Cut(self.elements.len() as u32);
        self.elements.push(CutBySolid::new(element, nodes, points, parts));
    }

    /// The edges that films cross, ascending.
    fn film_edges(&self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>) -> Vec<FilmEdge<D>> {
        let edges = self.edges_near_surfaces(mesh);
        let mut nodes: Vec<u32> = edges.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let side = |k: usize| self.side(mesh, surface, nodes[k]);
        let sides = parallel::collect(nodes.len(), PIECE, side);
        let side_of = |node: u32| sides[nodes.binary_search(&node).ok()?].as_ref();
        let film = |k: usize| {
            let [i, j] = edges[k];
            Some((edges[k], film_between(surface, edges[k], [side_of(i)?, side_of(j)?])?))
        };
        parallel::collect(edges.len(), PIECE, film).into_iter().flatten().collect()
    }

    /// Edges between two nodes inside that are longer than both depths together, ascending.
    fn edges_near_surfaces(&self, mesh: &Mesh<D, N>) -> Vec<[u32; 2]> {
        let depth = |node: u32| self.distance[node as usize].abs();
        let mut edges = Vec::new();
        for &i in self.inside.iter().map(|inside| &inside.node) {
            for nodes in mesh.elements_around(i as usize).iter().map(|&e| mesh.elements()[e as usize]) {
                let others = nodes.into_iter().filter(|&j| j > i && self.is_inside(j));
                let length = |j: u32| (mesh.nodes()[j as usize] - mesh.nodes()[i as usize]).norm();
                edges.extend(
                    others.filter(|&j| depth(i) + depth(j) < (1.0 + LARGEST_OVERLAP) * length(j)).map(|j| [i, j]),
                );
            }
        }
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    fn side(&self, mesh: &Mesh<D, N>, surface: &SolidSurface<D>, node: u32) -> Option<FilmSide<D>> {
        let position = mesh.nodes()[node as usize];
        let foot = surface.foot(position)?;
        let (body, depth) = (self.body_at(surface, node)?, self.distance[node as usize].abs());
        Some(FilmSide { position, body, depth, normal: surface.normal(&foot)? })
    }
}

/// The ways from the ends of an edge of this length [m] along a unit vector to the surface [m].
fn ways_to_surface<const D: usize>(
    surface: &SolidSurface<D>,
    sides: [&FilmSide<D>; 2],
    along: Vector<D>,
    length: f64,
) -> Option<[f64; 2]> {
    let [first, second] = sides;
    if first.body == second.body {
        let cosines = [first.normal.dot(along), -second.normal.dot(along)];
        let faces = cosines.iter().all(|cosine| *cosine > LEAST_COSINE);
        return faces.then(|| [first.depth / cosines[0], second.depth / cosines[1]]);
    }
    let way = |own: &FilmSide<D>, other: &FilmSide<D>| {
        let nearest = |x| surface.foot_on_body(own.body, x);
        let at = |t: f64| other.position + (own.position - other.position) * t;
        let ends = [nearest(at(0.0))?.distance, nearest(at(1.0))?.distance];
        // A node on the surface, along which the edge may run, is as far inside as others that count as inside.
        let margin = LEAST_EDGE_FRACTION * length;
        let level = if ends[1] < -margin { 0.0 } else { margin };
        let crossed = || (1.0 - crossing(nearest, at, [ends[0], ends[1].min(0.0)], level, length).0) * length;
        Some(if ends[0] > level { crossed() } else { length })
    };
    Some([way(first, second)?, way(second, first)?])
}

/// The cut points of an edge between nodes inside, if a film crosses it.
fn film_between<const D: usize>(
    surface: &SolidSurface<D>,
    edge: [u32; 2],
    sides: [&FilmSide<D>; 2],
) -> Option<[CutPoint<D>; 2]> {
    let way = sides[1].position - sides[0].position;
    let length = way.norm();
    let along = way / length;
    let [first, second] = ways_to_surface(surface, sides, along, length)?;
    let gap = length - first - second;
    let middle = sides[0].position + along * (first + 0.5 * gap);
    let least = LEAST_THICKNESS * length;
    let open = (gap > least).then(|| open_film(surface, edge, sides, middle)).flatten();
    let open = open.filter(|points| (points[1].position - points[0].position).norm() > least);
    // All edges between two solids have films: with some of them alone an element couldn't be divided, and where one
    // isn't, the film around has no way out.
    let touch = sides[0].body != sides[1].body;
    open.or_else(|| touch.then(|| touching(surface, edge, sides, middle)).flatten())
}

/// The cut points of an edge on both sides of a place in a film.
fn open_film<const D: usize>(
    surface: &SolidSurface<D>,
    edge: [u32; 2],
    sides: [&FilmSide<D>; 2],
    middle: Vector<D>,
) -> Option<[CutPoint<D>; 2]> {
    let length = (sides[1].position - sides[0].position).norm();
    let [own, other] = [0, 1].map(|k| surface.foot_on_body(sides[k].body, middle).map(|foot| foot.distance));
    if own? <= 0.0 || other? <= 0.0 || surface.distance(middle) <= 0.0 {
        return None;
    }
    let point = |k: usize| film_point(surface, sides[k], middle, [edge[k], edge[1 - k]], length);
    Some([point(0)?, point(1)?])
}

/// The cut points of an edge between solids that touch, or with a third one between them: half of the least thickness
/// off a place.
fn touching<const D: usize>(
    surface: &SolidSurface<D>,
    edge: [u32; 2],
    sides: [&FilmSide<D>; 2],
    middle: Vector<D>,
) -> Option<[CutPoint<D>; 2]> {
    let way = sides[1].position - sides[0].position;
    let place = (middle - sides[0].position).dot(way) / way.norm_squared();
    let half = 0.5 * LEAST_THICKNESS;
    let place = place.clamp(LEAST_EDGE_FRACTION + half, 1.0 - LEAST_EDGE_FRACTION - half);
    let point = |k: usize, t: f64| {
        let position = sides[0].position + way * t;
        let foot = surface.foot_on_body(sides[k].body, position)?;
        Some(CutPoint::in_film([edge[k], edge[1 - k]], position, surface.weights(&foot)))
    };
    Some([point(0, place - half)?, point(1, place + half)?])
}

/// The cut point between a place in a film and a node inside, on an edge of this length [m] whose nodes, that one
/// first, are `film_edge`.
fn film_point<const D: usize>(
    surface: &SolidSurface<D>,
    side: &FilmSide<D>,
    middle: Vector<D>,
    film_edge: [u32; 2],
    length: f64,
) -> Option<CutPoint<D>> {
    let nearest = |x| surface.foot_on_body(side.body, x);
    let to = side.position - middle;
    let at = |t: f64| middle + to * t;
    let margin = LEAST_INNER_EDGE_FRACTION * length;
    let ends = [nearest(middle)?.distance, nearest(side.position)?.distance];
    let level = if ends[1] < -margin { 0.0 } else { ends[1] + margin };
    let (t, foot) = crossing(nearest, at, ends, level, to.norm());
    let kept = t.clamp(LEAST_EDGE_FRACTION, 1.0 - LEAST_INNER_EDGE_FRACTION);
    let foot = foot.filter(|_| kept == t).or_else(|| nearest(at(kept)))?;
    Some(CutPoint::in_film(film_edge, at(kept), surface.weights(&foot)))
}
