//! Edges of solids become edges of the fluid part of elements, in three dimensions (theory J.2).
//!
//! ```text
//! m      on the edge of the solid in an element                 `edge_passages`
//! e      where the edge passes a face between two such elements
//! p, q   where the solid crosses an edge of the mesh with both of its nodes outside, seen from each of these  `edge_reach`
//! ```
//!
//! Elements with m are cones, others are divided by their nodes (`cones`); where p and q don't divide them, because
//! the edge of the solid passes beside them, they are cones about a place amid p and q.

use super::cones::{Corner, CrossedElement};
use super::edge_passages::{EdgePoint, LEAST_SHAPE_FUNCTION, Passage, SharpEdges};
use super::films::Films;
use super::{CutBySolid, CutPoint, ElementState, FluidSimplex, SolidCut, Vertex, parts};
use crate::math::{Tensor, Vector};
use crate::mesh::{Mesh, Simplex};
use crate::parallel;
use crate::pfem2::solid::setup::SurfaceCondition;
use crate::pfem2::solid::surface::SolidSurface;
use std::collections::{BTreeMap, BTreeSet};

/// Distance of e from a crossing on a side of its face, over the longest side, below which it is that.
const AT_CROSSING: f64 = 0.01;

/// Part of an element that an apex must add to the fluid or take from it where no edge or face says that it is needed.
const LEAST_APEX_FRACTION: f64 = 0.01;

/// Elements per piece of a parallel loop.
const PIECE: usize = 16;

/// An element near edges of solids.
pub(super) struct NearEdge<const D: usize, const N: usize> {
    pub crossed: CrossedElement<N>,
    passages: Vec<Passage>,
    pub apex: Option<EdgePoint<D>>,
}

/// A surface and its conditions.
pub(super) struct Solids<'a, const D: usize> {
    pub surface: &'a SolidSurface<D>,
    pub conditions: &'a [SurfaceCondition],
    pub edges: SharpEdges<D>,
}

/// A crossing of an edge of the mesh from its first node.
pub(super) type Crossings<const D: usize> = BTreeMap<[u32; 2], CutPoint<D>>;

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Makes edges of solids edges of the fluid part of elements.
    ///
    /// Elements with films, or with cut points of several bodies, keep none: a cone would join these.
    pub(super) fn keep_edges(
        &mut self,
        mesh: &Mesh<D, N>,
        surface: &SolidSurface<D>,
        conditions: &[SurfaceCondition],
        films: &Films<D>,
    ) {
        let edges = SharpEdges::new(surface.sharp_edges());
        if edges.pieces.is_empty() {
            return;
        }
        let solids = Solids { surface, conditions, edges };
        let passed = self.passed(mesh, &solids.edges);
        let (mut near, twice) = self.near_edges_of_one_body(mesh, &solids, &passed, films);
        let on_faces = self.points_on_faces(mesh, &solids, &near);
        let numbers: BTreeMap<[u32; 2], u32> = twice.into_iter().map(|(edge, point)| (edge, self.add(point))).collect();
        let faces: BTreeMap<Vec<u32>, u32> = on_faces
            .into_iter()
            .map(|(face, point)| {
                let beside = face.iter().copied().find(|&node| !self.is_inside(node));
                (face, self.add(self.edge_point(point, beside, &solids)))
            })
            .collect();
        for CrossedElement { nodes, crossings, .. } in near.values_mut().map(|own| &mut own.crossed) {
            for ([i, j], number) in crossings {
                *number = numbers.get(&[nodes[*i], nodes[*j]]).copied().unwrap_or(*number);
            }
        }
        for own in near.into_values() {
            self.rebuild(mesh, &solids, own, &faces);
        }
    }

    /// Elements, ascending, that have a node of a cut one and that edges pass.
    fn passed(&self, mesh: &Mesh<D, N>, edges: &SharpEdges<D>) -> Vec<(usize, Vec<Passage>)> {
        let nodes: BTreeSet<u32> = self.elements.iter().flat_map(|cut| cut.nodes).collect();
        let around: BTreeSet<u32> =
            nodes.into_iter().flat_map(|node| mesh.elements_around(node as usize)).copied().collect();
        let around: Vec<u32> = around.into_iter().filter(|&e| self.state[e as usize] != ElementState::Solid).collect();
        let found = parallel::collect(around.len(), PIECE, |k| {
            let element = around[k] as usize;
            (element, edges.passages(mesh, element))
        });
        found.into_iter().filter(|(_, passages)| !passages.is_empty()).collect()
    }

    /// Crossings of edges of elements around these that have both of their nodes outside, from each of these.
    pub(super) fn crossed_twice(
        &self,
        mesh: &Mesh<D, N>,
        solids: &Solids<D>,
        passed: &[(usize, Vec<Passage>)],
    ) -> Crossings<D> {
        let mut at_nodes: BTreeMap<u32, BTreeSet<usize>> = BTreeMap::new();
        for (element, passages) in passed {
            for &node in &mesh.elements()[*element] {
                at_nodes.entry(node).or_default().extend(passages.iter().map(|passage| passage.piece));
            }
        }
        let around = at_nodes.keys().flat_map(|&node| mesh.elements_around(node as usize));
        let mut pieces: BTreeMap<[u32; 2], BTreeSet<usize>> = BTreeMap::new();
        for nodes in around.map(|&e| mesh.elements()[e as usize]) {
            for (i, j) in (0..N).flat_map(|i| (i + 1..N).map(move |j| (i, j))) {
                let edge = ascending([nodes[i], nodes[j]]);
                if !edge.iter().any(|&node| self.is_inside(node)) {
                    let near = edge.iter().filter_map(|node| at_nodes.get(node)).flatten();
                    pieces.entry(edge).or_default().extend(near);
                }
            }
        }
        let all: Vec<([u32; 2], BTreeSet<usize>)> = pieces.into_iter().collect();
        let found = parallel::collect(all.len(), PIECE, |k| {
            let (edge, own) = &all[k];
            own.iter().find_map(|&piece| solids.reach(mesh, *edge, piece))
        });
        found.into_iter().flatten().flatten().collect()
    }

    /// The elements of which an edge of a solid or one of these crossings is part, by their numbers.
    pub(super) fn near_edges(
        &self,
        mesh: &Mesh<D, N>,
        solids: &Solids<D>,
        twice: &Crossings<D>,
    ) -> BTreeMap<usize, NearEdge<D, N>> {
        let beside = |[i, j]: [u32; 2]| {
            let around = mesh.elements_around(i as usize).iter().map(|&e| e as usize);
            around.filter(move |&e| mesh.elements()[e].contains(&j))
        };
        let mut all: BTreeSet<usize> = twice.keys().flat_map(|&edge| beside(edge)).collect();
        all.extend(self.elements.iter().map(|cut| cut.element as usize));
        let all: Vec<usize> = all.into_iter().collect();
        let near = parallel::collect(all.len(), PIECE, |k| {
            let passages = solids.edges.passages(mesh, all[k]);
            let crossed = self.crossed(mesh, all[k], twice);
            let apex = solids.edges.apex(mesh, all[k], &passages);
            let apex = apex.or_else(|| solids.amid(mesh, &crossed, twice).filter(|_| !crossed.is_divided()));
            (all[k], NearEdge { crossed, passages, apex })
        });
        near.into_iter().filter(|(_, own)| own.apex.is_some() || own.crossed.has_crossed_twice()).collect()
    }

    /// The crossings of an element; those of edges with both nodes outside have no number yet.
    fn crossed(&self, mesh: &Mesh<D, N>, element: usize, twice: &Crossings<D>) -> CrossedElement<N> {
        let nodes = mesh.elements()[element];
        let inside = nodes.map(|node| self.is_inside(node));
        let mut crossings: Vec<([usize; 2], u32)> = match self.state[element] {
            ElementState::Cut(place) => {
                parts::cut_edges(inside).into_iter().zip(self.elements[place as usize].points.iter().copied()).collect()
            }
            _ => Vec::new(),
        };
        let pairs = (0..N).flat_map(|i| (0..N).map(move |j| [i, j]));
        crossings
            .extend(pairs.filter(|&[i, j]| twice.contains_key(&[nodes[i], nodes[j]])).map(|edge| (edge, u32::MAX)));
        CrossedElement { element, nodes, inside, crossings }
    }

    /// The points in which edges of solids pass faces between elements that both have an apex, by the nodes
    /// of the face.
    fn points_on_faces(
        &self,
        mesh: &Mesh<D, N>,
        solids: &Solids<D>,
        near: &BTreeMap<usize, NearEdge<D, N>>,
    ) -> BTreeMap<Vec<u32>, EdgePoint<D>> {
        let mut found: BTreeMap<Vec<u32>, Option<EdgePoint<D>>> = BTreeMap::new();
        for own in near.values().filter(|own| own.apex.is_some()) {
            let sides = own.passages.iter().flat_map(|passage| (0..2).map(move |side| (passage, side)));
            let faces: Vec<(usize, EdgePoint<D>)> = sides
                .filter_map(|(own, side)| Some((own.faces[side]?, solids.edges.at(own.piece, own.range[side]))))
                .collect();
            for (opposite, point) in &faces {
                let is_alone = faces.iter().filter(|(other, _)| other == opposite).count() == 1;
                let neighbour = mesh.neighbour(own.crossed.element, *opposite);
                let keeps = neighbour.is_none_or(|e| near.get(&e).is_some_and(|other| other.apex.is_some()));
                let point = self.on_face(mesh, &own.crossed, *opposite, point).filter(|_| is_alone && keeps);
                found.entry(face(&own.crossed, *opposite)).or_insert(point);
            }
        }
        found.into_iter().filter_map(|(face, point)| Some((face, point?))).collect()
    }

    /// A point in a face of an element, no nearer to its sides than it may be; `None` if nothing crosses its sides, or
    /// if it is one of these crossings.
    fn on_face(
        &self,
        mesh: &Mesh<D, N>,
        own: &CrossedElement<N>,
        opposite: usize,
        point: &EdgePoint<D>,
    ) -> Option<EdgePoint<D>> {
        if !own.crosses_face(opposite) {
            return None;
        }
        let nodes: Vec<usize> = (0..N).filter(|k| *k != opposite).collect();
        let x = mesh.corners(own.element);
        let shape = mesh.shape_functions(own.element, point.position);
        let kept = nodes.iter().map(|&k| (k, shape[k].max(LEAST_SHAPE_FUNCTION)));
        let sum: f64 = kept.clone().map(|(_, n)| n).sum();
        let position: Vector<D> = kept.map(|(k, n)| x[k] * (n / sum)).sum();
        let pairs = || nodes.iter().flat_map(|&i| nodes.iter().map(move |&j| (i, j)));
        let longest = pairs().map(|(i, j)| (x[i] - x[j]).norm()).fold(0.0, f64::max);
        let on_sides = own.crossings.iter().filter(|(edge, number)| !edge.contains(&opposite) && *number != u32::MAX);
        let away = on_sides.map(|(_, number)| (self.points[*number as usize].position - position).norm());
        let nearest = away.fold(f64::INFINITY, f64::min);
        (nearest > AT_CROSSING * longest).then(|| EdgePoint { position, ..point.clone() })
    }

    fn add(&mut self, point: CutPoint<D>) -> u32 {
        self.points.push(point);
        self.points.len() as u32 - 1
    }

    /// A cut point on an edge: a fluid that glides does so along the edge.
    fn edge_point(&self, point: EdgePoint<D>, gliding_node: Option<u32>, solids: &Solids<D>) -> CutPoint<D> {
        let EdgePoint { position, weights, tangent } = point;
        let along = tangent.filter(|_| solids.glides(position)).map(|tangent| Tensor::outer(tangent, tangent));
        let bound_directions = along.map(|along| Tensor::identity() - along);
        CutPoint { edge: None, film_edge: None, gliding_node, position, weights, normal: None, bound_directions }
    }

    /// Gives an element its fluid part.
    fn rebuild(&mut self, mesh: &Mesh<D, N>, solids: &Solids<D>, own: NearEdge<D, N>, faces: &BTreeMap<Vec<u32>, u32>) {
        let NearEdge { crossed, apex, .. } = own;
        let on_faces: [Option<u32>; N] = std::array::from_fn(|k| faces.get(&face(&crossed, k)).copied());
        let is_needed = crossed.has_crossed_twice() || on_faces.iter().any(Option::is_some);
        let before = self.volume_of_parts(mesh, crossed.element);
        let mark = self.points.len();
        let parts = match apex {
            Some(apex) => {
                let beside = crossed.nodes.iter().copied().find(|&node| !self.is_inside(node));
                let apex = self.add(self.edge_point(apex, beside, solids));
                crossed.cone(on_faces, apex)
            }
            None if is_needed => crossed.prisms(),
            None => return,
        };
        let (points, parts) = self.numbered(mesh, &crossed, &parts);
        let volume: f64 = parts.iter().map(|(_, volume)| volume).sum();
        let changed = (volume - before).abs() > LEAST_APEX_FRACTION * mesh.simplex(crossed.element).volume;
        if !is_needed && !changed {
            self.points.truncate(mark);
            return;
        }
        let parts = parts.into_iter().map(|(part, _)| part).collect();
        match self.state[crossed.element] {
            ElementState::Cut(place) => {
                let cut = &mut self.elements[place as usize];
                (cut.points, cut.parts) = (points, parts);
            }
            _ => {
                self.state[crossed.element] = ElementState::Cut(self.elements.len() as u32);
                let (element, nodes) = (crossed.element as u32, crossed.nodes);
                self.elements.push(CutBySolid::new(element, nodes, points, parts));
            }
        }
    }

    /// Volume of the fluid part of an element so far [m³].
    fn volume_of_parts(&self, mesh: &Mesh<D, N>, element: usize) -> f64 {
        let ElementState::Cut(place) = self.state[element] else { return mesh.simplex(element).volume };
        let cut = &self.elements[place as usize];
        let simplex = |part| Some(Simplex::<D, N>::new(self.corners(mesh, cut, part))?.volume);
        cut.parts.iter().filter_map(simplex).sum()
    }

    /// The points of an element, those of its cut edges first, and its parts with their volumes [m³].
    fn numbered(
        &self,
        mesh: &Mesh<D, N>,
        crossed: &CrossedElement<N>,
        parts: &[[Corner; N]],
    ) -> (Vec<u32>, Vec<(FluidSimplex<N>, f64)>) {
        let mut points: Vec<u32> = crossed.crossings.iter().map(|(_, number)| *number).collect();
        let mut numbered = Vec::new();
        for part in parts {
            let mut vertices = part.map(|corner| match corner {
                Corner::Node(k) => Vertex::Node(k as u8),
                Corner::Point(number) => {
                    let place = points.iter().position(|&own| own == number).unwrap_or(points.len());
                    if place == points.len() {
                        points.push(number);
                    }
                    Vertex::Point(place as u8)
                }
            });
            let position = |vertex: Vertex| match vertex {
                Vertex::Node(k) => mesh.nodes()[crossed.nodes[usize::from(k)] as usize],
                Vertex::Point(k) => self.points[points[usize::from(k)] as usize].position,
            };
            let Some(Simplex { volume, .. }) = Simplex::<D, N>::new(vertices.map(position)) else { continue };
            if volume < 0.0 {
                vertices.swap(0, 1);
            }
            numbered.push((FluidSimplex { vertices }, volume.abs()));
        }
        (points, numbered)
    }
}

impl<const D: usize> Solids<'_, D> {
    /// True if the fluid glides along the solid nearest to a place.
    fn glides(&self, x: Vector<D>) -> bool {
        let foot = self.surface.foot(x);
        foot.is_some_and(|foot| self.conditions.get(foot.solid) == Some(&SurfaceCondition::Slip))
    }
}

pub(super) fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Nodes of the face of an element opposite to one of its nodes, ascending.
fn face<const N: usize>(own: &CrossedElement<N>, opposite: usize) -> Vec<u32> {
    let mut nodes: Vec<u32> = (0..N).filter(|k| *k != opposite).map(|k| own.nodes[k]).collect();
    nodes.sort_unstable();
    nodes
}
