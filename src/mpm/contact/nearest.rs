//! The foot of a particle on a sheet: the closest point of its facets, exactly, many times a step.
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
//! δ = ½ Σ_K W_K ((x_K − x_c)·n_K) (n_K·n)              exact to third order on spheres (Boubekeur & Alexa 2008, α = ½)
//! ```
//!
//! A quadrilateral is the fan of four triangles around its mean point, which has no preferred diagonal, so that
//! contact keeps the symmetry of the mesh. The sign of d is that of the area-weighted normals of the nodes
//! around x_c (Bærentzen & Aanæs 2005).
//!
//! Facets are binned once for many steps: each into all bins that it can reach while the sheet moves by the
//! slack, so that a query reads one bin.

use super::locate::{borders, closest, for_each_bin};
use super::sample::Facet;
use crate::math::Vector;
use hashbrown::{HashMap, HashSet};

/// How far, in cells, the sheet may move before its facets are binned anew.
const SLACK: f64 = 0.5;

/// Closer than this [cells] the direction to the foot is lost in rounding, and the sheet's normal stands in.
const TOUCHING: f64 = 1e-7;

/// The least cosine between the normals of the nodes and that of the foot on a surface that counts as smooth.
const SMOOTH: f64 = 0.7;

/// The closest point of a sheet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foot<const D: usize> {
    /// Its facet.
    pub facet: u32,
    /// W_K of the facet's nodes.
    pub weights: [f64; 4],
    /// Signed distance d [m].
    pub distance: f64,
    /// Unit vector n.
    pub normal: Vector<D>,
    /// How far the curved surface lies above the facet, δ [m].
    pub bulge: f64,
    /// True if the point is beyond a free edge rather than beside the sheet.
    pub beyond: bool,
}

/// Finds feet on one sheet.
#[derive(Debug, Default)]
pub(super) struct Nearest<const D: usize> {
    bins: HashMap<[i32; D], Vec<u32>>,
    size: f64,
    binned: Vec<Vector<D>>,
    borders: HashSet<[u32; 2]>,
    /// Facets around each node: starts, and the facets.
    around: (Vec<u32>, Vec<u32>),
}

impl<const D: usize> Nearest<D> {
    /// For these facets over `nodes` nodes.
    pub fn new(facets: &[Facet], nodes: usize) -> Self {
        let mut starts = vec![0_u32; nodes + 1];
        for &k in facets.iter().flat_map(|facet| facet.nodes()) {
            starts[k as usize + 1] += 1;
        }
        for k in 0..nodes {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let mut around = vec![0; starts[nodes] as usize];
        for (e, facet) in facets.iter().enumerate() {
            for &k in facet.nodes() {
                around[next[k as usize] as usize] = e as u32;
                next[k as usize] += 1;
            }
        }
        Self { borders: borders(facets), around: (starts, around), ..Self::default() }
    }

    /// Bins the facets again if the sheet has moved too far. Feet are found within `reach` [m].
    pub fn refresh(&mut self, facets: &[Facet], position: &[Vector<D>], reach: f64, cell: f64) {
        let slack = SLACK * cell;
        let moved = |(a, b): (&Vector<D>, &Vector<D>)| (*a - *b).norm_squared() > slack * slack;
        if self.binned.len() == position.len() && !position.iter().zip(&self.binned).any(moved) {
            return;
        }
        self.binned = position.to_vec();
        self.size = cell;
        self.bins.clear();
        for (e, facet) in facets.iter().enumerate() {
            let x = facet.corners(position);
            let end = |sign: f64| {
                let corner = |a: usize| x.iter().map(|x| sign * x[a]).fold(f64::NEG_INFINITY, f64::max);
                self.bin(Vector::from_fn(|a| sign * (corner(a) + reach + slack)))
            };
            for_each_bin(end(-1.0), end(1.0), |bin| self.bins.entry(bin).or_default().push(e as u32));
        }
    }

    fn bin(&self, x: Vector<D>) -> [i32; D] {
        std::array::from_fn(|a| (x[a] / self.size).floor() as i32)
    }

    /// The foot of `x` [m] if it is within `reach` [m], which must not exceed that of [`Self::refresh`].
    pub fn foot(&self, facets: &[Facet], position: &[Vector<D>], x: Vector<D>, reach: f64) -> Option<Foot<D>> {
        let candidates = self.bins.get(&self.bin(x))?;
        let mut best = Best { square: reach * reach, facet: u32::MAX, weights: [0.0; 4], point: Vector::ZERO };
        for &e in candidates {
            let facet = &facets[e as usize];
            let corners = facet.corners(position);
            if square_to_bounds(&corners, x) <= best.square {
                best.compare(e, facet.count, corners, x);
            }
        }
        (best.facet != u32::MAX).then(|| self.close(facets, position, x, &best))
    }

    fn close(&self, facets: &[Facet], position: &[Vector<D>], x: Vector<D>, best: &Best<D>) -> Foot<D> {
        let facet = &facets[best.facet as usize];
        let normals: [Vector<D>; 4] = std::array::from_fn(|k| self.node_normal(facets, position, facet.nodes[k]));
        let mean: Vector<D> = normals.iter().zip(best.weights).map(|(&n, w)| n * w).sum();
        let flat = || facet.area(position).normalized().unwrap_or_else(|| Vector::unit(0));
        let mean = mean.normalized().unwrap_or_else(flat);
        let (arm, distance) = (x - best.point, best.square.sqrt());
        let height = arm.dot(mean);
        let side = if height < 0.0 { -1.0 } else { 1.0 };
        let lost = distance <= TOUCHING * self.size;
        let border = on_border(facet, &best.weights, &self.borders);
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

    /// The area vectors around a node, added up [m²].
    fn node_normal(&self, facets: &[Facet], position: &[Vector<D>], node: u32) -> Vector<D> {
        let (starts, around) = &self.around;
        let near = &around[starts[node as usize] as usize..starts[node as usize + 1] as usize];
        near.iter().map(|&e| facets[e as usize].area(position)).sum()
    }
}

/// δ at a point with these weights; zero where the normals of the nodes differ too much to describe a surface.
fn bulge<const D: usize>(
    corners: &[Vector<D>; 4],
    weights: &[f64; 4],
    point: Vector<D>,
    normals: &[Vector<D>; 4],
    normal: Vector<D>,
) -> f64 {
    let mut sum = 0.0;
    for ((corner, weight), n) in corners.iter().zip(weights).zip(normals).filter(|((_, weight), _)| **weight > 0.0) {
        let n = n.normalized().unwrap_or_default();
        let along = n.dot(normal);
        if along < SMOOTH {
            return 0.0;
        }
        sum += 0.5 * weight * (*corner - point).dot(n) * along;
    }
    sum
}

/// The closest point so far.
struct Best<const D: usize> {
    square: f64,
    facet: u32,
    weights: [f64; 4],
    point: Vector<D>,
}

impl<const D: usize> Best<D> {
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
        let shares = closest(corners, x);
        let point = corners.iter().zip(shares).map(|(&corner, w)| corner * w).sum::<Vector<D>>();
        let square = (x - point).norm_squared();
        if square < self.square {
            let mut weights = [0.0; 4];
            for (node, share) in nodes.into_iter().zip(shares) {
                if node == MIDDLE {
                    weights.iter_mut().for_each(|w| *w += 0.25 * share);
                } else {
                    weights[node] += share;
                }
            }
            *self = Self { square, facet: e, weights, point };
        }
    }
}

/// The mean point of a quadrilateral among the corners of a triangle.
const MIDDLE: usize = 4;

/// True if the point with these weights lies on a free edge: all nodes but those of the edge have no weight.
fn on_border(facet: &Facet, weights: &[f64; 4], borders: &HashSet<[u32; 2]>) -> bool {
    let (nodes, n) = (facet.nodes(), facet.count);
    if n == 2 {
        return (0..2).any(|k| weights[k] == 1.0 && borders.contains(&[nodes[k]; 2]));
    }
    (0..n).any(|k| {
        let next = (k + 1) % n;
        let (a, b) = (nodes[k], nodes[next]);
        (0..n).all(|j| j == k || j == next || weights[j] == 0.0) && borders.contains(&[a.min(b), a.max(b)])
    })
}

/// Squared distance to the box around the corners [m²], a lower bound of that to the facet.
fn square_to_bounds<const D: usize>(corners: &[Vector<D>; 4], x: Vector<D>) -> f64 {
    (0..D)
        .map(|a| {
            let lower = corners.iter().map(|c| c[a]).fold(f64::INFINITY, f64::min);
            let upper = corners.iter().map(|c| c[a]).fold(f64::NEG_INFINITY, f64::max);
            let outside = (lower - x[a]).max(x[a] - upper).max(0.0);
            outside * outside
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn foot<const D: usize>(facets: &[Facet], position: &[Vector<D>], x: Vector<D>) -> Option<Foot<D>> {
        let mut nearest = Nearest::new(facets, position.len());
        nearest.refresh(facets, position, 0.6, 0.3);
        nearest.foot(facets, position, x, 0.6)
    }

    /// A loop that runs counter-clockwise: outside is positive, also across its corners.
    #[test]
    fn the_side_of_a_loop_is_right_around_its_corners() {
        let position = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vector);
        let facets: Vec<_> = (0..4).map(|k| Facet::new(&[k, (k + 1) % 4])).collect();
        for (x, expected) in
            [([0.9, 0.8], -0.1), ([1.1, 0.5], 0.1), ([1.03, 1.04], 0.05), ([0.97, 0.99], -0.01), ([-0.3, -0.4], 0.5)]
        {
            let found = foot(&facets, &position, Vector(x)).unwrap();
            assert!((found.distance - expected).abs() < 1e-12, "{x:?}: {found:?}");
        }
        assert!(foot(&facets, &position, Vector([9.0, 9.0])).is_none());
    }

    /// On a tilted plane the foot is the orthogonal projection, whatever the elements.
    #[test]
    fn the_foot_on_a_plane_is_the_projection() {
        let plane = |x: f64, y: f64| Vector([x, y, 0.3 * x - 0.2 * y]);
        let position: Vec<_> = (0..9).map(|k| plane(f64::from(k % 3), f64::from(k / 3))).collect();
        let quad = |k: u32| [k, k + 1, k + 4, k + 3];
        let mut facets: Vec<_> = [0, 1, 3].map(|k| Facet::new(&quad(k))).to_vec();
        facets.extend([Facet::new(&[4, 5, 8]), Facet::new(&[4, 8, 7])]);
        let normal = Vector([-0.3, 0.2, 1.0]).normalized().unwrap();
        for (x, y, d) in [(0.4, 0.3, 0.2), (1.7, 1.1, -0.3), (1.2, 1.9, 0.1), (0.8, 1.5, -1e-3), (0.1, 1.2, 1e-9)] {
            let found = foot(&facets, &position, plane(x, y) + normal * d).unwrap();
            assert!((found.distance - d).abs() < 1e-12 && (found.normal - normal).norm() < 1e-6, "{found:?}");
            let corners = facets[found.facet as usize].corners(&position);
            let point: Vector<3> = corners.iter().zip(found.weights).map(|(&c, w)| c * w).sum();
            assert!((point - plane(x, y)).norm() < 1e-12 && !found.beyond);
        }
        assert!(foot(&facets, &position, plane(-0.3, 1.0)).unwrap().beyond);
    }

    /// Quadrilaterals with their nodes on a sphere: the curved surface is the sphere, to a twentieth of what the
    /// facets are off.
    #[test]
    fn the_curved_surface_of_a_ball_is_a_ball() {
        let (n, h, r) = (9_u32, 0.1, 1.0_f64);
        let at = |i: u32| h * (f64::from(i) - 4.0);
        let on_ball = |x: f64, y: f64| Vector([x, y, -(r * r - x * x - y * y).sqrt()]);
        let position: Vec<_> = (0..n * n).map(|k| on_ball(at(k % n), at(k / n))).collect();
        let quad = |k: u32| [k, k + 1, k + n + 1, k + n];
        let facets: Vec<_> = (0..n * (n - 1)).filter(|k| k % n < n - 1).map(|k| Facet::new(&quad(k))).collect();
        for (x, y) in [(0.05, 0.0), (0.05, 0.05), (0.02, 0.07), (-0.03, 0.01)] {
            let found = foot(&facets, &position, on_ball(x, y) * 0.99).unwrap();
            let (flat, curved) = (found.distance - 0.01, found.distance - found.bulge - 0.01);
            assert!(flat < -5e-4 && curved.abs() < -flat / 20.0, "{x} {y}: {flat:e} {curved:e}");
        }
    }
}
