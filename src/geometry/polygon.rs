//! A simple polygon in the x-y plane, extruded along z in 3D.

use super::primitive::{Distance, layer, product};
use crate::math::Vector;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// A polygon (counter-clockwise), between two heights in 3D, without end in z in 2D.
#[derive(Debug, Clone)]
pub struct Polygon {
    corners: Vec<Vector<2>>,
    lower: f64,
    upper: f64,
    /// Boxes around the sides; nothing where there are few.
    tree: Option<RTree<SideBox>>,
}

impl PartialEq for Polygon {
    fn eq(&self, other: &Self) -> bool {
        (&self.corners, self.lower, self.upper) == (&other.corners, other.lower, other.upper)
    }
}

/// The box around a side, and which side it is.
type SideBox = GeomWithData<Rectangle<[f64; 2]>, usize>;

/// Up to so many sides, all of them are looked at.
const FEW_SIDES: usize = 32;

impl Polygon {
    /// The polygon through `corners` [m], in either sense of rotation, between the heights z = `lower` and `upper` [m].
    ///
    /// # Errors
    /// Fewer than three corners, no area, repeated corners, or sides that cross; the message names them.
    pub fn new(mut corners: Vec<Vector<2>>, lower: f64, upper: f64) -> Result<Self, String> {
        if corners.len() < 3 {
            return Err(format!("a polygon needs at least 3 corners, not {}", corners.len()));
        }
        if let Some((i, j)) = crossing(&corners, &boxes(&corners)) {
            return Err(format!("sides {i} and {j} of the polygon touch or cross (counted from 0)"));
        }
        let twice_area = shoelace(&corners);
        if twice_area == 0.0 {
            return Err("the polygon has no area".into());
        }
        if twice_area < 0.0 {
            corners.reverse();
        }
        let tree = (corners.len() > FEW_SIDES).then(|| boxes(&corners));
        Ok(Self { corners, lower, upper, tree })
    }

    /// Corners in counter-clockwise order [m].
    pub fn corners(&self) -> &[Vector<2>] {
        &self.corners
    }

    /// Heights between which it is extruded [m]; infinite in 2D.
    pub fn heights(&self) -> [f64; 2] {
        [self.lower, self.upper]
    }

    /// Area of the polygon [m²].
    pub fn area(&self) -> f64 {
        0.5 * shoelace(&self.corners)
    }

    /// Signed distance and outward normal of the extruded polygon.
    pub(super) fn distance(&self, x: Vector<3>) -> Distance {
        product(self.plane_distance(Vector([x[0], x[1]])), layer(2, self.lower, self.upper, x[2]))
    }

    fn plane_distance(&self, x: Vector<2>) -> Distance {
        let mut nearest = (f64::INFINITY, Vector::ZERO, Vector::ZERO);
        for (a, b) in self.near(x) {
            let (side, away) = from_side(x, a, b);
            if away.norm_squared() < nearest.0 {
                nearest = (away.norm_squared(), away, side);
            }
        }
        let (squared, away, side) = nearest;
        let crossed = |&(a, b): &(Vector<2>, Vector<2>)| {
            let side = b - a;
            (a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (x[1] - a[1]) * side[0] / side[1]
        };
        let inside = self.to_the_right(x).filter(crossed).count() % 2 == 1;
        let sign = if inside { -1.0 } else { 1.0 };
        let outward = Vector([side[1], -side[0]]);
        let n = (away * sign).normalized().or(outward.normalized()).unwrap_or(Vector::unit(0));
        (sign * squared.sqrt(), Vector(n.to3()))
    }
}

impl Polygon {
    /// Sides in their order, the nearest ones to `x` [m] among them.
    fn near(&self, x: Vector<2>) -> Box<dyn Iterator<Item = (Vector<2>, Vector<2>)> + '_> {
        let Some(tree) = &self.tree else { return Box::new(sides(&self.corners)) };
        // Boxes in the order of their distance, as long as they can hold a nearer side than was found.
        let mut least = f64::INFINITY;
        let mut near = Vec::new();
        for (side, beyond) in tree.nearest_neighbor_iter_with_distance_2(x.0) {
            if beyond > least * (1.0 + 1e-9) {
                break;
            }
            let (a, b) = self.side(side.data);
            least = least.min(from_side(x, a, b).1.norm_squared());
            near.push(side.data);
        }
        near.sort_unstable();
        Box::new(near.into_iter().map(|i| self.side(i)))
    }

    /// Sides that a line from `x` [m] to the right may cross.
    fn to_the_right(&self, x: Vector<2>) -> Box<dyn Iterator<Item = (Vector<2>, Vector<2>)> + '_> {
        let Some(tree) = &self.tree else { return Box::new(sides(&self.corners)) };
        let line = AABB::from_corners(x.0, [f64::MAX, x[1]]);
        Box::new(tree.locate_in_envelope_intersecting(line).map(|side| self.side(side.data)))
    }

    fn side(&self, i: usize) -> (Vector<2>, Vector<2>) {
        (self.corners[i], self.corners[(i + 1) % self.corners.len()])
    }
}

/// A side from `a` to `b`, and the way to `x` from its nearest point [m].
fn from_side(x: Vector<2>, a: Vector<2>, b: Vector<2>) -> (Vector<2>, Vector<2>) {
    let side = b - a;
    let t = ((x - a).dot(side) / side.norm_squared()).clamp(0.0, 1.0);
    (side, x - a - side * t)
}

fn boxes(corners: &[Vector<2>]) -> RTree<SideBox> {
    let around = |(i, (a, b)): (usize, (Vector<2>, Vector<2>))| GeomWithData::new(Rectangle::from_corners(a.0, b.0), i);
    RTree::bulk_load(sides(corners).enumerate().map(around).collect())
}

fn sides(corners: &[Vector<2>]) -> impl Iterator<Item = (Vector<2>, Vector<2>)> + '_ {
    (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]))
}

fn cross(a: Vector<2>, b: Vector<2>) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Twice the signed area; relative to the first corner, so that a far origin costs no digits.
fn shoelace(corners: &[Vector<2>]) -> f64 {
    sides(corners).map(|(a, b)| cross(a - corners[0], b - corners[0])).sum()
}

/// Two sides that touch where they should not.
fn crossing(corners: &[Vector<2>], tree: &RTree<SideBox>) -> Option<(usize, usize)> {
    let n = corners.len();
    let side: Vec<_> = sides(corners).collect();
    let wrong = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (side[i], side[j]);
        let neighbours = j == i + 1 || (i == 0 && j == n - 1);
        if neighbours { fold_back(side[i], side[j], j == i + 1) } else { touch(a, b, c, d) }
    };
    let first = |i: usize| {
        let near = AABB::from_corners(side[i].0.0, side[i].1.0);
        let others = tree.locate_in_envelope_intersecting(near).map(|other| other.data);
        others.filter(|&j| j > i && wrong(i, j)).min().map(|j| (i, j))
    };
    (0..n).find_map(first).or_else(|| (0..n).find(|&i| side[i].0 == side[i].1).map(|i| (i, (i + 1) % n)))
}

/// Two sides with a common corner that run along each other.
fn fold_back(first: (Vector<2>, Vector<2>), second: (Vector<2>, Vector<2>), in_order: bool) -> bool {
    let (a, b) = if in_order { (first, second) } else { (second, first) };
    let (u, v) = (a.1 - a.0, b.1 - b.0);
    cross(u, v) == 0.0 && u.dot(v) <= 0.0
}

/// Two sides that have a point in common. Where they lie in line, round-off decides on which side of each other their
/// ends are, so that the boxes around them have the first word.
fn touch(a: Vector<2>, b: Vector<2>, c: Vector<2>, d: Vector<2>) -> bool {
    if (0..2).any(|i| a[i].max(b[i]) < c[i].min(d[i]) || c[i].max(d[i]) < a[i].min(b[i])) {
        return false;
    }
    let turn = |p: Vector<2>, q: Vector<2>, r: Vector<2>| cross(q - p, r - p);
    let between = |p: Vector<2>, q: Vector<2>, r: Vector<2>| (r - p).dot(r - q) <= 0.0;
    let (t1, t2, t3, t4) = (turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b));
    (t1 * t2 < 0.0 && t3 * t4 < 0.0)
        || (t1 == 0.0 && between(a, b, c))
        || (t2 == 0.0 && between(a, b, d))
        || (t3 == 0.0 && between(c, d, a))
        || (t4 == 0.0 && between(c, d, b))
}
