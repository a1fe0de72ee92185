//! Passages of edges of solids through the elements of the mesh, in three dimensions (theory J.2).

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::solid::surface::{EdgePiece, NodeWeights};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Least shape function of m in its element and of e in its face: nearer to their sides they are moved there.
pub(super) const LEAST_SHAPE_FUNCTION: f64 = 0.005;

/// Shape function gained along a piece of an edge below which it hardly touches an element.
const GRAZING: f64 = 1e-6;

/// Shape function below zero down to which a place belongs to an element: an edge in a face passes the elements on both
/// sides.
const ON_FACE: f64 = 1e-9;

/// Edges of solids in a tree of boxes.
pub struct SharpEdges<const D: usize> {
    /// Straight pieces.
    pub pieces: Vec<EdgePiece<D>>,
    boxes: RTree<GeomWithData<Rectangle<[f64; D]>, usize>>,
}

/// Part of a piece of an edge that lies in an element.
#[derive(Debug, Clone, Copy)]
pub struct Passage {
    /// The piece.
    pub piece: usize,
    /// Fractions of it.
    pub range: [f64; 2],
    /// Local nodes opposite to the faces through which it comes and goes; none where it ends inside.
    pub faces: [Option<usize>; 2],
}

/// A place on an edge of a solid.
#[derive(Debug, Clone)]
pub struct EdgePoint<const D: usize> {
    /// Position [m].
    pub position: Vector<D>,
    /// Shape functions of the solid's nodes there.
    pub weights: NodeWeights,
    /// Unit tangent of the edge; none at a corner.
    pub tangent: Option<Vector<D>>,
}

impl<const D: usize> EdgePoint<D> {
    /// The middle of several; `None` of none.
    fn mean(points: &[Self]) -> Option<Self> {
        if points.is_empty() {
            return None;
        }
        let factor = 1.0 / points.len() as f64;
        let position = points.iter().map(|point| point.position * factor).sum();
        let weights = points.iter().flat_map(|point| &point.weights).map(|&(a, weight)| (a, weight * factor)).collect();
        Some(Self { position, weights, tangent: None })
    }
}

impl Passage {
    /// Sides on which the piece ends in the element.
    fn inner_ends(&self) -> impl Iterator<Item = usize> + Clone + use<> {
        let faces = self.faces;
        (0..2).filter(move |&side| faces[side].is_none())
    }
}

impl<const D: usize> SharpEdges<D> {
    /// The edges with these pieces.
    pub fn new(pieces: Vec<EdgePiece<D>>) -> Self {
        let entry = |(k, piece): (usize, &EdgePiece<D>)| {
            let [start, end] = piece.ends.map(|end| end.position);
            GeomWithData::new(Rectangle::from_corners(start.0, end.0), k)
        };
        let boxes = RTree::bulk_load(pieces.iter().enumerate().map(entry).collect());
        Self { pieces, boxes }
    }

    /// The place at a fraction of a piece.
    pub fn at(&self, piece: usize, fraction: f64) -> EdgePoint<D> {
        let own = &self.pieces[piece];
        EdgePoint { position: own.at(fraction), weights: own.weights(fraction), tangent: own.tangent() }
    }

    /// Passages of all edges through an element.
    pub fn passages<const N: usize>(&self, mesh: &Mesh<D, N>, element: usize) -> Vec<Passage> {
        let x = mesh.corners(element);
        let corner = |pick: fn(f64, f64) -> f64| x.iter().fold(x[0], |a, b| Vector::from_fn(|i| pick(a[i], b[i])));
        let envelope = AABB::from_corners(corner(f64::min).0, corner(f64::max).0);
        let mut near: Vec<usize> =
            self.boxes.locate_in_envelope_intersecting(envelope).map(|entry| entry.data).collect();
        near.sort_unstable();
        let shape = |x| mesh.shape_functions(element, x);
        let own = |piece: usize| passage(piece, self.pieces[piece].ends.map(|end| shape(end.position)));
        near.into_iter().filter_map(own).collect()
    }

    /// The apex of an element with these passages: the corner of the solid in it, or the place on its edge that is
    /// farthest from its faces. Of several edges that don't meet in it, the middle between them: they meet near by, and
    /// it is on the side of the solid that they bound. `None` without passages.
    pub fn apex<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        element: usize,
        passages: &[Passage],
    ) -> Option<EdgePoint<D>> {
        let middles = passages.iter().map(|own| self.at(own.piece, 0.5 * (own.range[0] + own.range[1])));
        let ends = passages.iter().flat_map(|own| own.inner_ends().map(move |side| (own.piece, side)));
        let end = |(piece, side): (usize, usize)| &self.pieces[piece].ends[side];
        let corner = ends.clone().find(|&place| end(place).is_corner);
        let depth = |x: Vector<D>| mesh.shape_functions(element, x).into_iter().fold(f64::INFINITY, f64::min);
        let mut apex = match corner {
            Some((piece, side)) => EdgePoint { tangent: None, ..self.at(piece, side as f64) },
            None if self.meet(passages) => {
                let bends = ends.map(|(piece, side)| self.at(piece, side as f64));
                middles.chain(bends).max_by(|a, b| depth(a.position).total_cmp(&depth(b.position)))?
            }
            None => EdgePoint::mean(&middles.collect::<Vec<_>>())?,
        };
        apex.position = moved_inside(mesh, element, apex.position);
        Some(apex)
    }

    /// True if all passages hang together by ends of pieces inside.
    fn meet(&self, passages: &[Passage]) -> bool {
        let number = |own: &Passage, side: usize| self.pieces[own.piece].ends[side].number;
        let numbers = |own: &Passage| own.inner_ends().map(|side| number(own, side)).collect::<Vec<usize>>();
        let Some(first) = passages.first() else { return false };
        let mut reached = numbers(first);
        let mut rest: Vec<Vec<usize>> = passages[1..].iter().map(numbers).collect();
        while let Some(next) = rest.iter().position(|own| own.iter().any(|number| reached.contains(number))) {
            reached.extend(rest.swap_remove(next));
        }
        rest.is_empty()
    }
}

/// Passage of a piece through an element, given its shape functions at the ends.
fn passage<const N: usize>(piece: usize, [start, end]: [[f64; N]; 2]) -> Option<Passage> {
    let [start, end] = [start, end].map(|shape| shape.map(|n| n + ON_FACE));
    let (mut range, mut faces) = ([0.0, 1.0], [None, None]);
    for k in 0..N {
        if start[k] >= 0.0 && end[k] >= 0.0 {
            continue;
        }
        let at = start[k] / (start[k] - end[k]);
        match (start[k] < 0.0, end[k] < 0.0) {
            (true, true) => return None,
            (true, false) if at > range[0] => (range[0], faces[0]) = (at, Some(k)),
            (false, true) if at < range[1] => (range[1], faces[1]) = (at, Some(k)),
            _ => {}
        }
    }
    let steepest = start.iter().zip(&end).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
    ((range[1] - range[0]) * steepest > GRAZING).then_some(Passage { piece, range, faces })
}

/// A place in an element, no nearer to its faces than it may be [m].
pub(super) fn moved_inside<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    element: usize,
    x: Vector<D>,
) -> Vector<D> {
    let kept = mesh.shape_functions(element, x).map(|n| n.max(LEAST_SHAPE_FUNCTION));
    let sum: f64 = kept.iter().sum();
    mesh.corners(element).into_iter().zip(kept).map(|(x, n)| x * (n / sum)).sum()
}
