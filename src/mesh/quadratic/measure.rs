//! Measures of meshes of solids: Jacobian determinants, volume, surface.

use super::QuadraticMesh;
use crate::geometry::Region;
use crate::math::Vector;

/// A determinant below this part of the largest one of its element is that of a fold.
const FOLDED: f64 = 1e-3;

/// A side of an element: where a coordinate ξ_axis is −1, or 1 on the upper side.
#[derive(Debug, Clone, Copy)]
pub(super) struct ElementSide {
    pub element: usize,
    pub axis: usize,
    pub upper: bool,
}

/// Distance of a node on the boundary of a mesh from the surface of the region that the mesh fills.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Distance [m].
    pub length: f64,
    /// Mean distance of the corners along the edges of the element's side there [m].
    pub edge: f64,
    /// The node [m].
    pub place: [f64; 3],
}

impl Deviation {
    /// A boundary is good up to this part of an edge. A chord of a circle is that far off its arc at 9°: 40 of them
    /// enclose 0.4 % less than the circle.
    pub const GOOD: f64 = 0.02;

    /// The distance over the length of an edge.
    pub fn part(&self) -> f64 {
        self.length / self.edge
    }
}

/// L_0, L_1, L_2 at a coordinate, and their slopes.
fn quadratic(xi: f64) -> [[f64; 3]; 2] {
    [[0.5 * xi * (xi - 1.0), 1.0 - xi * xi, 0.5 * xi * (xi + 1.0)], [xi - 0.5, -2.0 * xi, xi + 0.5]]
}

impl QuadraticMesh {
    /// Σ_a of the nodes of an element [m] times a product of functions per axis.
    fn sum(&self, element: usize, along: [[f64; 3]; 3]) -> Vector<3> {
        let weight = |a: usize| (0..self.dimension).map(|k| along[k][a / 3usize.pow(k as u32) % 3]).product::<f64>();
        let own = self.elements[element].iter().enumerate();
        own.map(|(a, &n)| Vector(self.nodes[n as usize]) * weight(a)).sum()
    }

    /// The place x(ξ) in an element [m].
    pub fn position(&self, element: usize, xi: [f64; 3]) -> [f64; 3] {
        self.sum(element, xi.map(|x| quadratic(x)[0])).0
    }

    /// det ∂x/∂ξ in an element [m³; m² in 2D].
    pub fn jacobian(&self, element: usize, xi: [f64; 3]) -> f64 {
        let slope = |k: usize| self.sum(element, std::array::from_fn(|i| quadratic(xi[i])[usize::from(i == k)]));
        let third = if self.dimension == 3 { slope(2) } else { Vector::unit(2) };
        slope(0).cross(slope(1)).dot(third)
    }

    /// Points −1, 0, 1 or those of Gauss along each axis.
    fn points(&self, along: [f64; 3]) -> impl Iterator<Item = [f64; 3]> + use<> {
        let dimension = self.dimension;
        let point = move |a: usize| {
            std::array::from_fn(|k| if k < dimension { along[a / 3usize.pow(k as u32) % 3] } else { 0.0 })
        };
        (0..3usize.pow(dimension as u32)).map(point)
    }

    /// Volume [m³], area in 2D [m²].
    pub fn volume(&self) -> f64 {
        let gauss = 0.6f64.sqrt();
        let weight = |x: f64| if x == 0.0 { 8.0 / 9.0 } else { 5.0 / 9.0 };
        let at = |e: usize, xi: [f64; 3]| {
            xi[..self.dimension].iter().map(|&x| weight(x)).product::<f64>() * self.jacobian(e, xi)
        };
        let own = |e: usize| self.points([-gauss, 0.0, gauss]).map(|xi| at(e, xi)).sum::<f64>();
        (0..self.elements.len()).map(own).sum()
    }

    /// The first element with a determinant that is not positive at its nodes, and the place [m].
    pub fn folded(&self) -> Option<(usize, [f64; 3])> {
        (0..self.elements.len()).find_map(|e| {
            let sampled = || self.points([-1.0, 0.0, 1.0]).map(|xi| (self.jacobian(e, xi), xi));
            let most = sampled().map(|(j, _)| j.abs()).fold(0.0, f64::max);
            let (_, xi) = sampled().find(|(j, _)| j.is_nan() || *j <= FOLDED * most)?;
            Some((e, self.position(e, xi)))
        })
    }

    /// The local node in the middle of a side.
    fn middle(&self, axis: usize, upper: bool) -> usize {
        let (centre, stride) = (3usize.pow(self.dimension as u32) / 2, 3usize.pow(axis as u32));
        if upper { centre + stride } else { centre - stride }
    }

    /// Sides on the surface, in the order of elements: those whose middle node no other element has.
    pub(super) fn surface(&self) -> Vec<ElementSide> {
        let all = || {
            let ends = (0..self.dimension).flat_map(|axis| [(axis, false), (axis, true)]);
            let of = move |element| ends.clone().map(move |(axis, upper)| ElementSide { element, axis, upper });
            (0..self.elements.len()).flat_map(of)
        };
        let node = |side: &ElementSide| self.elements[side.element][self.middle(side.axis, side.upper)];
        let mut count = vec![0u32; self.nodes.len()];
        all().for_each(|side| count[node(&side) as usize] += 1);
        all().filter(|side| count[node(side) as usize] == 1).collect()
    }

    /// Nodes on the surface, ascending.
    pub(super) fn surface_nodes(&self) -> Vec<u32> {
        let mut nodes: Vec<u32> = Vec::new();
        for side in self.surface() {
            nodes.extend(self.nodes_of(side).map(|a| self.elements[side.element][a]));
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Local nodes of a side.
    fn nodes_of(&self, side: ElementSide) -> impl Iterator<Item = usize> + use<> {
        let at_end = move |a: &usize| a / 3usize.pow(side.axis as u32) % 3 == if side.upper { 2 } else { 0 };
        (0..3usize.pow(self.dimension as u32)).filter(at_end)
    }

    /// The node on the boundary that is farthest from the surface of a region, over the edges of its side; `None` of a
    /// mesh without elements.
    pub fn deviation(&self, region: &Region) -> Option<Deviation> {
        self.deviation_by(|x| region.signed_distance(x))
    }

    /// The same with the distance from a surface [m] at places [m].
    pub(super) fn deviation_by(&self, distance: impl Fn([f64; 3]) -> f64) -> Option<Deviation> {
        let mut most: Option<Deviation> = None;
        for side in self.surface() {
            let edge = self.mean_edge(side);
            for a in self.nodes_of(side) {
                let place = self.nodes[self.elements[side.element][a] as usize];
                let next = Deviation { length: distance(place).abs(), edge, place };
                if most.is_none_or(|most| next.part() > most.part()) {
                    most = Some(next);
                }
            }
        }
        most
    }

    /// Mean distance of the corners along the edges of a side [m].
    fn mean_edge(&self, side: ElementSide) -> f64 {
        let own = &self.elements[side.element];
        let x = |a: usize| Vector(self.nodes[own[a] as usize]);
        let along = |k: usize| 3usize.pow(k as u32);
        let starts = |k: usize| {
            let is_start =
                move |a: &usize| (0..self.dimension).all(|i| a / along(i) % 3 != 1) && (a / along(k)).is_multiple_of(3);
            self.nodes_of(side).filter(is_start)
        };
        let axes = (0..self.dimension).filter(|&k| k != side.axis);
        let edges = axes.flat_map(|k| starts(k).map(move |a| [a, a + 2 * along(k)]));
        let lengths: Vec<f64> = edges.map(|[a, b]| (x(a) - x(b)).norm()).collect();
        lengths.iter().sum::<f64>() / lengths.len().max(1) as f64
    }

    /// The largest distance from the surface of the mesh to that of a region [m], between the nodes.
    pub(super) fn distance_to(&self, region: &Region) -> f64 {
        let mut most = 0.0f64;
        for side in self.surface() {
            let end = if side.upper { 1.0 } else { -1.0 };
            for xi in self.points([-0.5, 0.0, 0.5]) {
                let xi = std::array::from_fn(|k| if k == side.axis { end } else { xi[k] });
                most = most.max(region.signed_distance(self.position(side.element, xi)).abs());
            }
        }
        most
    }
}
