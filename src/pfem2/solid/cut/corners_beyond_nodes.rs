//! Corners of solids beyond the nodes inside, in two dimensions: in elements without a node inside (theory J.2).
//!
//! ```text
//! element of the corner c      c with the points p and q where the surface crosses the edge behind c: the polygon
//!                              of all nodes, p, c, q
//! elements on the way          crossed at two edges: the triangle at the node that these share, the quadrilateral
//!                              at the two others
//! element with a node inside   a triangle at each of the ends of the last edge
//! ```

use super::cut_point::crossing;
use super::polygon::{PolygonCorner, triangulated};
use super::{ElementState, FluidSimplex, SolidCut, Vertex, parts};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::solid::cut::CutBySolid;
use crate::pfem2::solid::surface::{NodeWeights, SolidSurface, SurfaceCorner};

/// Elements on the way from a corner to a node inside, at most.
const MOST_ELEMENTS_ON_THE_WAY: usize = 8;

/// Corners of a solid in an element without a node inside, and the way from there to one with a node inside.
pub(super) struct CornersBeyondNodes<'a, const D: usize> {
    corners: &'a [SurfaceCorner<D>],
    /// Elements without a node inside, that of the corners first, each with its local node opposite to the edge through
    /// which it is left.
    way: Vec<(usize, usize)>,
    /// The element with a node inside.
    root: usize,
}

/// Points where the surface crosses an edge, seen from each of its ends, with the weights of the solid's nodes there.
type Crossing<const D: usize> = [(Vector<D>, NodeWeights); 2];

impl<'a, const D: usize> CornersBeyondNodes<'a, D> {
    /// These corners of an element, if the way from there goes through elements that are `plain`: they hold no other
    /// corner.
    pub fn new<const N: usize>(
        mesh: &Mesh<D, N>,
        cut: &SolidCut<D, N>,
        element: usize,
        corners: &'a [SurfaceCorner<D>],
        plain: impl Fn(usize) -> bool,
    ) -> Option<Self> {
        let (mut way, mut element, mut entry) = (Vec::new(), element, None);
        while way.len() < MOST_ELEMENTS_ON_THE_WAY {
            let x = mesh.corners(element);
            let is_behind = |k: &usize| {
                let next = mesh.neighbour(element, *k).filter(|&next| Some(next) != entry);
                next.is_some_and(&plain) && foot_on_edge(corners, x[(k + 1) % N], x[(k + 2) % N]).is_some()
            };
            let behind = (0..N).find(is_behind)?;
            way.push((element, behind));
            let next = mesh.neighbour(element, behind)?;
            match cut.state[next] {
                ElementState::Cut(_) => return Some(Self { corners, way, root: next }),
                ElementState::Fluid => (entry, element) = (Some(element), next),
                ElementState::Solid => return None,
            }
        }
        None
    }
}

impl<const D: usize, const N: usize> SolidCut<D, N> {
    /// Keeps such corners; `None` where the surface crosses an edge on its way otherwise than twice.
    pub(super) fn keep_corners_beyond_nodes(
        &mut self,
        mesh: &Mesh<D, N>,
        surface: &SolidSurface<D>,
        beyond: &CornersBeyondNodes<D>,
    ) -> Option<()> {
        let ElementState::Cut(root) = self.state[beyond.root] else { return None };
        let crossings: Vec<Crossing<D>> = beyond
            .way
            .iter()
            .map(|&(element, k)| crossings(mesh, surface, beyond, element, k))
            .collect::<Option<_>>()?;
        let mut pieces = vec![around_corners(mesh, beyond, &crossings[0])?];
        for (pair, both) in beyond.way.windows(2).zip(crossings.windows(2)) {
            pieces.push(between_edges(mesh, [pair[0], pair[1]], [&both[0], &both[1]])?);
        }
        let &(last, k) = beyond.way.last()?;
        let nodes = mesh.elements()[last];
        let beside = self.beside_passed_edge([nodes[(k + 1) % N], nodes[(k + 2) % N]], root as usize)?;

        let numbers: Vec<[u32; 2]> =
            crossings.into_iter().map(|own| own.map(|(position, weights)| self.add_point(position, weights))).collect();
        let own: Vec<u32> =
            beyond.corners.iter().map(|corner| self.add_point(corner.position, vec![(corner.node, 1.0)])).collect();
        self.elements[root as usize].parts = beside;
        self.elements[root as usize].points.extend(numbers[numbers.len() - 1]);
        for (place, (&(element, _), parts)) in beyond.way.iter().zip(pieces).enumerate() {
            let points = match place {
                0 => numbers[0].into_iter().chain(own.iter().copied()).collect(),
                _ => [numbers[place - 1], numbers[place]].concat(),
            };
            self.state[element] = ElementState::Cut(self.elements.len() as u32);
            let (nodes, shapes) = (mesh.elements()[element], Vec::new());
            self.elements.push(CutBySolid { shapes, ..CutBySolid::new(element as u32, nodes, points, parts) });
        }
        Some(())
    }

    /// The triangles at the ends of an edge through which the solid reaches beyond its nodes, in the cut element from
    /// which it comes; the points of the surface on the edge are its next two.
    fn beside_passed_edge(&self, ends: [u32; 2], place: usize) -> Option<Vec<FluidSimplex<N>>> {
        let element = &self.elements[place];
        let inside = element.nodes.map(|node| self.is_inside(node));
        let edges = parts::cut_edges(inside);
        if edges.len() != 2 || element.points.len() != 2 || inside.iter().filter(|inside| **inside).count() != 1 {
            return None;
        }
        let triangle = |(side, end): (usize, u32)| {
            let node = element.nodes.iter().position(|&node| node == end)?;
            let own = edges.iter().position(|[outside, _]| *outside == node)?;
            let [node, own] = [Vertex::Node(node as u8), Vertex::Point(own as u8)];
            let next = Vertex::Point(2 + side as u8);
            // The element behind sees the edge the other way round.
            let corners = if side == 0 { [node, own, next] } else { [node, next, own] };
            Some(FluidSimplex { vertices: std::array::from_fn(|k| corners[k]) })
        };
        ends.into_iter().enumerate().map(triangle).collect()
    }
}

/// Points where the surface crosses the edge opposite to local node `k` of an element on the way.
fn crossings<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    surface: &SolidSurface<D>,
    beyond: &CornersBeyondNodes<D>,
    element: usize,
    k: usize,
) -> Option<Crossing<D>> {
    let corners = mesh.corners(element);
    let x = [corners[(k + 1) % N], corners[(k + 2) % N]];
    let middle = x[0] + (x[1] - x[0]) * foot_on_edge(beyond.corners, x[0], x[1])?;
    let inside = surface.distance(middle);
    if inside >= 0.0 {
        return None;
    }
    let seen = |end: usize| {
        let at = |t: f64| x[end] + (middle - x[end]) * t;
        let ends = [surface.distance(x[end]), inside];
        let (t, foot) = crossing(|x| surface.foot(x), at, ends, 0.0, (middle - x[end]).norm());
        Some((at(t), surface.weights(&foot.or_else(|| surface.foot(at(t)))?)))
    };
    Some([seen(0)?, seen(1)?])
}

/// The fluid in the element of the corners; its points are the two on the edge behind, then the corners.
fn around_corners<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    beyond: &CornersBeyondNodes<D>,
    [first, second]: &Crossing<D>,
) -> Option<Vec<FluidSimplex<N>>> {
    let &(element, k) = beyond.way.first()?;
    let x = mesh.corners(element);
    let [i, j] = [(k + 1) % N, (k + 2) % N];
    let mut corners: Vec<PolygonCorner<D>> =
        beyond.corners.iter().zip(2..).map(|(corner, n)| (Vertex::Point(n), corner.position)).collect();
    let along = |corner: &PolygonCorner<D>| (corner.1 - x[i]).dot(x[j] - x[i]);
    corners.sort_by(|a, b| along(a).total_cmp(&along(b)));
    let mut polygon = vec![(Vertex::Node(i as u8), x[i]), (Vertex::Point(0), first.0)];
    polygon.extend(corners);
    polygon.extend([(Vertex::Point(1), second.0), (Vertex::Node(j as u8), x[j]), (Vertex::Node(k as u8), x[k])]);
    triangulated(polygon)
}

/// The fluid in an element that the solid crosses from edge to edge, on both sides of it; its points are those of the
/// edge through which it comes from the element before, then those of its own. `way`: both elements with their local
/// nodes opposite to these edges.
fn between_edges<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    [(before, k), (element, own)]: [(usize, usize); 2],
    [entry, exit]: [&Crossing<D>; 2],
) -> Option<Vec<FluidSimplex<N>>> {
    let (nodes, x) = (mesh.elements()[element], mesh.corners(element));
    let ends = [1, 2].map(|n| mesh.elements()[before][(k + n) % N]);
    // Around the element; the solid is between the two points of an edge.
    let mut polygons: Vec<Vec<PolygonCorner<D>>> = vec![Vec::new()];
    for m in 0..N {
        let next = (m + 1) % N;
        polygons.last_mut()?.push((Vertex::Node(m as u8), x[m]));
        let [start, end] = if (next + 1) % N == own {
            [(Vertex::Point(2), exit[0].0), (Vertex::Point(3), exit[1].0)]
        } else if ends.contains(&nodes[m]) && ends.contains(&nodes[next]) {
            // The element before sees its edge the other way round.
            [(Vertex::Point(1), entry[1].0), (Vertex::Point(0), entry[0].0)]
        } else {
            continue;
        };
        polygons.last_mut()?.push(start);
        polygons.push(vec![end]);
    }
    let mut last = polygons.pop()?;
    last.append(polygons.first_mut()?);
    polygons[0] = last;
    let triangles = polygons.into_iter().map(triangulated).collect::<Option<Vec<_>>>()?;
    Some(triangles.concat())
}

/// Point where the way from corners into their solid crosses an edge, as a fraction of it.
fn foot_on_edge<const D: usize>(corners: &[SurfaceCorner<D>], start: Vector<D>, end: Vector<D>) -> Option<f64> {
    let middle = corners.iter().map(|corner| corner.position).sum::<Vector<D>>() / corners.len() as f64;
    let normal = corners.iter().map(|corner| corner.normal).sum::<Vector<D>>();
    let (edge, away) = (end - start, middle - start);
    let cross = |a: Vector<D>, b: Vector<D>| a[0] * b[1] - a[1] * b[0];
    let slope = cross(normal, edge);
    let (way, t) = (cross(away, edge) / slope, cross(normal, away) / slope);
    (way.is_finite() && way > 0.0 && t > 0.0 && t < 1.0).then_some(t)
}
