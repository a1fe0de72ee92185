//! Measures of meshes of solids: Jacobian determinants, volume, surface, thickness.

use super::QuadraticMesh;
use crate::geometry::Region;
use crate::math::Vector;
use hashbrown::HashMap;

/// A determinant below this part of the largest one of its element is that of a fold.
const FOLDED: f64 = 1e-3;

/// Two ends of a row of elements face each other if the cosine between its first and its last direction is larger.
const FACING: f64 = 0.7;

/// The thinnest place of a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thinnest {
    /// Elements across it.
    pub elements: usize,
    /// Thickness [m].
    pub length: f64,
    /// Its middle [m].
    pub middle: [f64; 3],
}

/// A side of an element: where a coordinate ξ_axis is −1, or 1 on the upper side.
#[derive(Debug, Clone, Copy)]
struct Side {
    element: usize,
    axis: usize,
    upper: bool,
}

/// A row of elements between two sides on the surface.
#[derive(Debug, Clone, Copy)]
struct Row {
    /// True if the two face each other.
    facing: bool,
    place: Thinnest,
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
            let (_, xi) = sampled().find(|(j, _)| !(*j > FOLDED * most))?;
            Some((e, self.position(e, xi)))
        })
    }

    /// The local node in the middle of a side.
    fn middle(&self, axis: usize, upper: bool) -> usize {
        let (centre, stride) = (3usize.pow(self.dimension as u32) / 2, 3usize.pow(axis as u32));
        if upper { centre + stride } else { centre - stride }
    }

    /// All sides, by the node in their middle: two of neighbours, one on the surface.
    fn sides(&self) -> HashMap<u32, Vec<Side>> {
        let mut sides: HashMap<u32, Vec<Side>> = HashMap::with_capacity(2 * self.dimension * self.elements.len());
        for (element, nodes) in self.elements.iter().enumerate() {
            for (axis, upper) in (0..self.dimension).flat_map(|axis| [(axis, false), (axis, true)]) {
                let own = Side { element, axis, upper };
                sides.entry(nodes[self.middle(axis, upper)]).or_default().push(own);
            }
        }
        sides
    }

    /// Sides on the surface, in the order of elements.
    fn surface(&self, sides: &HashMap<u32, Vec<Side>>) -> Vec<Side> {
        let mut surface: Vec<Side> =
            sides.values().filter(|own| own.len() == 1).flat_map(|own| own.iter().copied()).collect();
        surface.sort_unstable_by_key(|side| (side.element, side.axis, side.upper));
        surface
    }

    /// Nodes on the surface, ascending.
    pub(super) fn surface_nodes(&self) -> Vec<u32> {
        let on = |side: Side, a: usize| a / 3usize.pow(side.axis as u32) % 3 == if side.upper { 2 } else { 0 };
        let mut nodes: Vec<u32> = Vec::new();
        for side in self.surface(&self.sides()) {
            let own = self.elements[side.element].iter().enumerate();
            nodes.extend(own.filter(|(a, _)| on(side, *a)).map(|(_, &n)| n));
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// The largest distance from the surface of the mesh to that of a region [m], between the nodes.
    pub(super) fn distance_to(&self, region: &Region) -> f64 {
        let mut most = 0.0f64;
        for side in self.surface(&self.sides()) {
            let end = if side.upper { 1.0 } else { -1.0 };
            for xi in self.points([-0.5, 0.0, 0.5]) {
                let xi = std::array::from_fn(|k| if k == side.axis { end } else { xi[k] });
                most = most.max(region.signed_distance(self.position(side.element, xi)).abs());
            }
        }
        most
    }

    /// The thinnest place: the shortest row of elements from a side on the surface, each time to the side opposite, to another that
    /// faces it; the shortest of all rows where no two sides do. `None` without elements.
    pub fn thinnest(&self) -> Option<Thinnest> {
        let sides = self.sides();
        let rows = self.surface(&sides).into_iter().map(|first| self.row(&sides, first));
        let order = |a: &Row, b: &Row| b.facing.cmp(&a.facing).then(a.place.length.total_cmp(&b.place.length));
        rows.min_by(order).map(|row| row.place)
    }

    /// The row of elements that begins at a side on the surface.
    fn row(&self, sides: &HashMap<u32, Vec<Side>>, first: Side) -> Row {
        let place = |node: u32| Vector(self.nodes[node as usize]);
        let center = |e: usize| place(self.elements[e][3usize.pow(self.dimension as u32) / 2]);
        let node = |side: Side, upper: bool| self.elements[side.element][self.middle(side.axis, upper)];
        let (mut side, mut elements, mut length) = (first, 0, 0.0);
        let begin = place(node(first, first.upper));
        loop {
            let [enter, leave] = [side.upper, !side.upper].map(|upper| node(side, upper));
            (elements, length) = (elements + 1, length + (place(leave) - place(enter)).norm());
            let next = sides[&leave].iter().find(|next| next.element != side.element);
            let Some(&next) = next.filter(|_| elements <= self.elements.len()) else {
                let (ahead, end) = (center(first.element) - begin, place(leave));
                let last = end - center(side.element);
                let facing = ahead.dot(last) > FACING * ahead.norm() * last.norm();
                return Row { facing, place: Thinnest { elements, length, middle: ((begin + end) * 0.5).0 } };
            };
            side = next;
        }
    }
}
