//! The foot of a particle on a sheet: the closest point of its facets, exactly, many times a step (theory D.3).
//!
//! ```text
//! x_c = Σ_K W_K x_K,   ΣW_K = 1,      d = ±|x − x_c|,      n = (x − x_c)/d        n points to the + side
//! ```
//!
//! Elements are flat, what they stand for is not: where a sheet hugs a ball of radius R, facets of length h stand h²/8R
//! inside it. The distance is therefore measured to the curved surface that the normals n_K of the nodes describe,
//! which lies above the facet by
//!
//! ```text
//! δ = ½ Σ_K W_K ((x_K − x_c)·n_K) (n_K·n)   exact to third order on spheres (Boubekeur & Alexa 2008, α = ½); theory (D.8)
//! ```
//!
//! A quadrilateral is the fan of four triangles around its mean point, which has no preferred diagonal, so that
//! contact keeps the symmetry of the mesh. The sign of d is that of the area-weighted normals of the nodes
//! around x_c (Bærentzen & Aanæs 2005).
//!
//! Facets are binned once for many steps: each into all bins that it can reach while the sheet moves by the
//! slack, so that a query reads one bin. Bounds of facets and normals of nodes are found once for all queries at
//! the same positions, and the nearest mean point of a facet bounds the distance, so that few facets are measured.

use crate::geometry::SpatialBins;
use crate::geometry::closest_on_triangle;
use crate::math::Vector;
use crate::mpm::contact::facet::{SheetFacet, free_edges};
use crate::parallel::{self, Groups};
use hashbrown::HashSet;

/// Displacement of the sheet after which its facets are binned anew [cells].
const SLACK: f64 = 0.5;

/// Nodes and facets per parallel task.
const TASK: usize = 1024;

/// Relative rounding error of the distance from the mean point of a facet.
const ROUNDING: f64 = 1e-9;

/// Closer than this [cells] the direction to the foot is lost in rounding, and the sheet's normal stands in.
const TOUCHING: f64 = 1e-7;

/// The least cosine between the normals of the nodes and that of the foot on a surface that counts as smooth.
const SMOOTH: f64 = 0.7;

/// The closest point of a sheet.
#[derive(Debug, Clone, Copy)]
pub struct Foot<const D: usize> {
    /// Facet on which the foot lies.
    pub facet: u32,
    /// W_K of the facet's nodes.
    pub weights: [f64; 4],
    /// Signed distance d [m].
    pub distance: f64,
    /// Unit vector n.
    pub normal: Vector<D>,
    /// Height of the curved surface above the facet, δ [m].
    pub bulge: f64,
    /// True if the point is beyond a free edge rather than beside the sheet.
    pub beyond: bool,
}

/// Finds feet on one sheet.
#[derive(Debug, Default)]
pub struct Nearest<const D: usize> {
    bins: SpatialBins<D>,
    /// Size of a cell and of a bin [m].
    cell: f64,
    binned: Vec<Vector<D>>,
    free_edges: HashSet<[u32; 2]>,
    /// Facets around each node.
    around: Groups,
    current: CurrentShape<D>,
}

/// The shape of a sheet at the last refresh.
#[derive(Debug, Default)]
struct CurrentShape<const D: usize> {
    position: Vec<Vector<D>>,
    bounds: Vec<FacetBounds<D>>,
    normals: Vec<NodeNormal<D>>,
}

/// The box around a facet, and the mean of its corners [m].
#[derive(Debug, Clone, Copy)]
struct FacetBounds<const D: usize> {
    lower: Vector<D>,
    upper: Vector<D>,
    middle: Vector<D>,
}

/// The area vectors around a node, added up [m²], and the unit vector along them, zero where they cancel.
#[derive(Debug, Clone, Copy)]
struct NodeNormal<const D: usize> {
    area: Vector<D>,
    unit: Vector<D>,
}

impl<const D: usize> Nearest<D> {
    /// The search in these facets over `nodes` nodes.
    pub fn new(facets: &[SheetFacet], nodes: usize) -> Self {
        let corners = (0..).zip(facets).flat_map(|(e, facet)| facet.nodes().iter().map(move |&node| (node, e)));
        let around = Groups::from_pairs(nodes, corners);
        Self { free_edges: free_edges(facets), around, ..Self::default() }
    }

    /// Sets the positions of the nodes [m]. Feet are found within `reach` [m].
    pub fn refresh(&mut self, facets: &[SheetFacet], position: &[Vector<D>], reach: f64, cell: f64) {
        self.bin_facets(facets, position, reach, cell);
        if self.current.position != position {
            let bounds = parallel::collect(facets.len(), TASK, |e| FacetBounds::of(&facets[e], position));
            let areas = parallel::collect(facets.len(), TASK, |e| facets[e].area(position));
            let normal = |node: usize| self.node_normal(|e| areas[e as usize], node as u32);
            let normals = parallel::collect(position.len(), TASK, normal);
            self.current = CurrentShape { position: position.to_vec(), bounds, normals };
        }
    }

    /// Bins the facets again if the sheet has moved too far.
    fn bin_facets(&mut self, facets: &[SheetFacet], position: &[Vector<D>], reach: f64, cell: f64) {
        let slack = SLACK * cell;
        let moved = |(a, b): (&Vector<D>, &Vector<D>)| (*a - *b).norm_squared() > slack * slack;
        if self.binned.len() == position.len() && !position.iter().zip(&self.binned).any(moved) {
            return;
        }
        self.binned = position.to_vec();
        self.cell = cell;
        self.bins.clear(cell);
        for (e, facet) in (0..).zip(facets) {
            let x = facet.corners(position);
            let end = |sign: f64| {
                let corner = |a: usize| x.iter().map(|x| sign * x[a]).fold(f64::NEG_INFINITY, f64::max);
                Vector::from_fn(|a| sign * (corner(a) + reach + slack))
            };
            self.bins.add(e, end(-1.0), end(1.0));
        }
    }

    /// The foot of `x` [m] on the sheet where it was refreshed last, if it is within `reach` [m], which must not exceed
    /// that of [`Self::refresh`].
    pub fn foot(&self, facets: &[SheetFacet], x: Vector<D>, reach: f64) -> Option<Foot<D>> {
        let CurrentShape { position, bounds, normals } = &self.current;
        let best = self.closest(facets, position, |e| bounds[e as usize], x, reach)?;
        Some(self.foot_from(facets, position, |node| normals[node as usize], x, &best))
    }

    /// The foot on the sheet at other positions [m], within the slack of those.
    pub fn foot_at(&self, facets: &[SheetFacet], position: &[Vector<D>], x: Vector<D>, reach: f64) -> Option<Foot<D>> {
        let best = self.closest(facets, position, |e| FacetBounds::of(&facets[e as usize], position), x, reach)?;
        Some(self.foot_from(
            facets,
            position,
            |node| self.node_normal(|e| facets[e as usize].area(position), node),
            x,
            &best,
        ))
    }

    /// The first of the closest points in the order of the facets.
    #[inline]
    fn closest(
        &self,
        facets: &[SheetFacet],
        position: &[Vector<D>],
        bounds: impl Fn(u32) -> FacetBounds<D>,
        x: Vector<D>,
        reach: f64,
    ) -> Option<ClosestSoFar<D>> {
        let candidates = self.bins.at(x);
        let middle = candidates.iter().map(|&e| (x - bounds(e).middle).norm_squared()).fold(f64::INFINITY, f64::min);
        let bound = middle * (1.0 + ROUNDING) + (TOUCHING * self.cell).powi(2);
        let mut best =
            ClosestSoFar { square: bound.min(reach * reach), facet: u32::MAX, weights: [0.0; 4], point: Vector::ZERO };
        for &e in candidates {
            if bounds(e).square_to(x) <= best.square {
                let facet = &facets[e as usize];
                best.compare(e, facet.count, facet.corners(position), x);
            }
        }
        (best.facet != u32::MAX).then_some(best)
    }

    fn foot_from(
        &self,
        facets: &[SheetFacet],
        position: &[Vector<D>],
        node_normal: impl Fn(u32) -> NodeNormal<D>,
        x: Vector<D>,
        best: &ClosestSoFar<D>,
    ) -> Foot<D> {
        let facet = &facets[best.facet as usize];
        let normals = facet.nodes.map(node_normal);
        let mean: Vector<D> = normals.iter().zip(best.weights).map(|(n, w)| n.area * w).sum();
        let flat = || facet.area(position).normalized().unwrap_or_else(|| Vector::unit(0));
        let mean = mean.normalized().unwrap_or_else(flat);
        let (arm, distance) = (x - best.point, best.square.sqrt());
        let height = arm.dot(mean);
        let side = if height < 0.0 { -1.0 } else { 1.0 };
        let lost = distance <= TOUCHING * self.cell;
        let border = on_free_edge(facet, &best.weights, &self.free_edges);
        let normal = if lost { mean } else { arm * (side / distance) };
        Foot {
            facet: best.facet,
            weights: best.weights,
            distance: side * distance,
            normal,
            bulge: bulge(&facet.corners(position), &best.weights, best.point, &normals, normal),
            beyond: border && height.abs() < 0.5 * distance,
        }
    }

    fn node_normal(&self, area: impl Fn(u32) -> Vector<D>, node: u32) -> NodeNormal<D> {
        let area: Vector<D> = self.around.of(node as usize).iter().map(|&e| area(e)).sum();
        NodeNormal { area, unit: area.normalized().unwrap_or_default() }
    }
}

impl<const D: usize> FacetBounds<D> {
    fn of(facet: &SheetFacet, position: &[Vector<D>]) -> Self {
        let x = facet.corners(position);
        let of = |pick: fn(f64, f64) -> f64| Vector::from_fn(|a| pick(pick(x[0][a], x[1][a]), pick(x[2][a], x[3][a])));
        let middle = x[..facet.count].iter().copied().sum::<Vector<D>>() / facet.count as f64;
        Self { lower: of(f64::min), upper: of(f64::max), middle }
    }

    /// Squared distance [m²], a lower bound of that to the facet.
    fn square_to(&self, x: Vector<D>) -> f64 {
        let outside = |a: usize| (self.lower[a] - x[a]).max(x[a] - self.upper[a]).max(0.0);
        (0..D).map(|a| outside(a) * outside(a)).sum()
    }
}

/// δ at a point with these weights; zero where the normals of the nodes differ too much to describe a surface.
fn bulge<const D: usize>(
    corners: &[Vector<D>; 4],
    weights: &[f64; 4],
    point: Vector<D>,
    normals: &[NodeNormal<D>; 4],
    normal: Vector<D>,
) -> f64 {
    let mut sum = 0.0;
    for ((corner, weight), n) in corners.iter().zip(weights).zip(normals).filter(|((_, weight), _)| **weight > 0.0) {
        let n = n.unit;
        let along = n.dot(normal);
        if along < SMOOTH {
            return 0.0;
        }
        sum += 0.5 * weight * (*corner - point).dot(n) * along;
    }
    sum
}

/// The closest point so far.
struct ClosestSoFar<const D: usize> {
    square: f64,
    facet: u32,
    weights: [f64; 4],
    point: Vector<D>,
}

impl<const D: usize> ClosestSoFar<D> {
    fn compare(&mut self, e: u32, count: usize, corners: [Vector<D>; 4], x: Vector<D>) {
        match count {
            2 => self.offer(e, [0, 1, 1], [corners[0], corners[1], corners[1]], x),
            3 => self.offer(e, [0, 1, 2], [corners[0], corners[1], corners[2]], x),
            _ => {
                let middle = corners.iter().copied().sum::<Vector<D>>() * 0.25;
                for k in 0..4 {
                    let next = (k + 1) % 4;
                    self.offer(e, [k, next, MIDDLE], [corners[k], corners[next], middle], x);
                }
            }
        }
    }

    fn offer(&mut self, e: u32, nodes: [usize; 3], corners: [Vector<D>; 3], x: Vector<D>) {
        let barycentric = closest_on_triangle(corners, x);
        let point = corners.iter().zip(barycentric).map(|(&corner, w)| corner * w).sum::<Vector<D>>();
        let square = (x - point).norm_squared();
        if square < self.square {
            let mut weights = [0.0; 4];
            for (node, weight) in nodes.into_iter().zip(barycentric) {
                if node == MIDDLE {
                    weights.iter_mut().for_each(|w| *w += 0.25 * weight);
                } else {
                    weights[node] += weight;
                }
            }
            *self = Self { square, facet: e, weights, point };
        }
    }
}

/// The mean point of a quadrilateral among the corners of a triangle.
const MIDDLE: usize = 4;

/// True if the point with these weights lies on a free edge: all nodes but those of the edge have no weight.
fn on_free_edge(facet: &SheetFacet, weights: &[f64; 4], free_edges: &HashSet<[u32; 2]>) -> bool {
    let (nodes, n) = (facet.nodes(), facet.count);
    if n == 2 {
        return (0..2).any(|k| weights[k] == 1.0 && free_edges.contains(&[nodes[k]; 2]));
    }
    (0..n).any(|k| {
        let next = (k + 1) % n;
        let (a, b) = (nodes[k], nodes[next]);
        (0..n).all(|j| j == k || j == next || weights[j] == 0.0) && free_edges.contains(&[a.min(b), a.max(b)])
    })
}

#[cfg(test)]
mod tests;
