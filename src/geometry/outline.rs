//! The outline of a plane region: the curves where inside meets outside.
//!
//! The curves of all primitives are cut where they cross each other; a piece belongs to the outline if one
//! side of its middle lies inside the region and the other outside. So unions, intersections and
//! differences are no special case.

use super::Region;
use super::region::Bounds;
use crate::math::Vector;
use hashbrown::HashMap;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::f64::consts::TAU;

/// A smooth piece of an outline, x(s) with s from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    curve: EdgeCurve,
    from: f64,
    to: f64,
}

#[derive(Debug, Clone, Copy)]
enum EdgeCurve {
    /// x = a + s (b − a)
    Line { a: Vector<2>, b: Vector<2> },
    /// x = c + cos(2π s) e_1 + sin(2π s) e_2
    Ellipse { center: Vector<2>, axes: [Vector<2>; 2] },
}

impl EdgeCurve {
    fn at(&self, s: f64) -> Vector<2> {
        match self {
            Self::Line { a, b } => *a + (*b - *a) * s,
            Self::Ellipse { center, axes } => *center + axes[0] * (TAU * s).cos() + axes[1] * (TAU * s).sin(),
        }
    }

    fn tangent(&self, s: f64) -> Vector<2> {
        match self {
            Self::Line { a, b } => *b - *a,
            Self::Ellipse { axes, .. } => (axes[1] * (TAU * s).cos() - axes[0] * (TAU * s).sin()) * TAU,
        }
    }

    /// Straight pieces for a first guess of where curves cross.
    fn chords(&self) -> usize {
        match self {
            Self::Line { .. } => 1,
            Self::Ellipse { .. } => 256,
        }
    }

    /// A box around it, with room for what begins or ends there.
    fn around(&self) -> Rectangle<[f64; 2]> {
        let (middle, reach) = match self {
            Self::Line { a, b } => ((*a + *b) * 0.5, (*b - *a) * 0.5),
            Self::Ellipse { center, axes } => (*center, Vector::from_fn(|i| axes[0][i].hypot(axes[1][i]))),
        };
        let room = 0.01 * reach.norm();
        let corner = |sign: f64| Vector::<2>::from_fn(|i| middle[i] + sign * (reach[i].abs() + room)).0;
        Rectangle::from_corners(corner(-1.0), corner(1.0))
    }

    fn moved(self, place: &impl Fn(Vector<2>) -> Vector<2>) -> Self {
        let origin = place(Vector::ZERO);
        match self {
            Self::Line { a, b } => Self::Line { a: place(a), b: place(b) },
            Self::Ellipse { center, axes } => {
                Self::Ellipse { center: place(center), axes: axes.map(|axis| place(axis) - origin) }
            }
        }
    }
}

/// Middles of the edges that were found, in cells, so that one that comes again is recognised.
struct Middles {
    /// Middles this near are one [m].
    near: f64,
    cells: HashMap<[i64; 2], Vec<Vector<2>>>,
}

impl Middles {
    fn cell(&self, x: Vector<2>) -> [i64; 2] {
        // A cell has room for the distance; without extent, all is in one.
        x.0.map(|c| if self.near > 0.0 { (c / (4.0 * self.near)).floor() as i64 } else { 0 })
    }

    fn know(&self, x: Vector<2>) -> bool {
        let [i, j] = self.cell(x);
        let around = (0..9).filter_map(|n| self.cells.get(&[i + n % 3 - 1, j + n / 3 - 1]));
        around.flatten().any(|middle| (*middle - x).norm() < self.near)
    }

    fn add(&mut self, x: Vector<2>) {
        self.cells.entry(self.cell(x)).or_default().push(x);
    }
}

impl Edge {
    /// The point at `s` in 0..=1 [m].
    pub fn at(&self, s: f64) -> Vector<2> {
        self.curve.at(self.from + s * (self.to - self.from))
    }

    /// True for a whole ellipse, whose ends are one point.
    pub fn is_closed(&self) -> bool {
        matches!(self.curve, EdgeCurve::Ellipse { .. }) && self.to - self.from == 1.0
    }

    fn normal(&self, s: f64) -> Vector<2> {
        let t = self.curve.tangent(self.from + s * (self.to - self.from));
        Vector([-t[1], t[0]]) / t.norm()
    }
}

impl Region {
    /// The edges between inside and outside of a region in 2D, in no special order.
    ///
    /// # Errors
    /// A shape that exists in 3D only.
    pub fn outline(&self) -> Result<Vec<Edge>, String> {
        let bounds = self.bounds();
        let mut leaves = Vec::new();
        self.curves(&bounds, &|x| x, &mut leaves)?;
        let size = (0..2).map(|i| bounds.upper[i] - bounds.lower[i]).filter(|l| l.is_finite()).fold(0.0, f64::max);
        let curves: Vec<(usize, EdgeCurve)> =
            leaves.iter().enumerate().flat_map(|(i, leaf)| leaf.iter().map(move |curve| (i, *curve))).collect();
        let boxed = |(n, (_, curve)): (usize, &(usize, EdgeCurve))| GeomWithData::new(curve.around(), n);
        let tree = RTree::bulk_load(curves.iter().enumerate().map(boxed).collect());
        let mut edges = Vec::new();
        let mut middles = Middles { near: 1e-9 * size, cells: HashMap::new() };
        for (leaf, curve) in &curves {
            let around = curve.around();
            let near = tree.locate_in_envelope_intersecting(AABB::from_corners(around.lower(), around.upper()));
            let others = near.map(|other| &curves[other.data]).filter(|(other, _)| other != leaf);
            for piece in pieces(*curve, others.map(|(_, other)| other)) {
                let middle = piece.at(0.5);
                if !middles.know(middle) && self.changes_across(&piece, 1e-7 * size) {
                    middles.add(middle);
                    edges.push(piece);
                }
            }
        }
        Ok(edges)
    }

    fn changes_across(&self, edge: &Edge, step: f64) -> bool {
        let (x, n) = (edge.at(0.5), edge.normal(0.5));
        self.contains((x + n * step).to3()) != self.contains((x - n * step).to3())
    }

    /// The curves of each primitive, one list per primitive.
    fn curves(
        &self,
        bounds: &Bounds,
        place: &dyn Fn(Vector<2>) -> Vector<2>,
        leaves: &mut Vec<Vec<EdgeCurve>>,
    ) -> Result<(), String> {
        let plane = |x: &[f64; 3]| Vector([x[0], x[1]]);
        let ellipse = |center: &[f64; 3], a: f64, b: f64| {
            vec![EdgeCurve::Ellipse { center: plane(center), axes: [Vector([a, 0.0]), Vector([0.0, b])] }]
        };
        let own = match self {
            Self::Box { lower, upper } => loop_through(&[
                Vector([lower[0], lower[1]]),
                Vector([upper[0], lower[1]]),
                Vector([upper[0], upper[1]]),
                Vector([lower[0], upper[1]]),
            ]),
            Self::Sphere { center, radius } => ellipse(center, *radius, *radius),
            Self::Ellipsoid { center, semi_axes } => ellipse(center, semi_axes[0], semi_axes[1]),
            Self::Polygon(polygon) => loop_through(polygon.corners()),
            Self::HalfSpace { point, normal } => vec![across(plane(point), plane(normal), bounds)],
            Self::Cylinder { .. } | Self::Surface(_) => return Err("this shape has no outline in 2D".into()),
            Self::Union(members) | Self::Intersection(members) => {
                return members.iter().try_for_each(|member| member.curves(bounds, place, leaves));
            }
            Self::Complement(region) => return region.curves(bounds, place, leaves),
            Self::Placed { region, rotation, shift } => {
                let within =
                    |x: Vector<2>| place(Vector::from_fn(|i| rotation[i][0] * x[0] + rotation[i][1] * x[1] + shift[i]));
                return region.curves(bounds, &within, leaves);
            }
        };
        leaves.push(own.into_iter().map(|curve| curve.moved(&place)).collect());
        Ok(())
    }
}

fn loop_through(corners: &[Vector<2>]) -> Vec<EdgeCurve> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| EdgeCurve::Line { a, b }).collect()
}

/// The line through a point, long enough to cross the bounds.
fn across(point: Vector<2>, normal: Vector<2>, bounds: &Bounds) -> EdgeCurve {
    let finite = |x: f64| if x.is_finite() { x.abs() } else { 0.0 };
    let reach: f64 = (0..2).map(|i| finite(bounds.lower[i]) + finite(bounds.upper[i]) + point[i].abs()).sum();
    let along = Vector([-normal[1], normal[0]]) * (2.0 * reach.max(1e-300));
    EdgeCurve::Line { a: point - along, b: point + along }
}

/// A curve cut where others cross it.
fn pieces<'a>(curve: EdgeCurve, others: impl Iterator<Item = &'a EdgeCurve>) -> Vec<Edge> {
    let mut cuts: Vec<f64> = others.flat_map(|other| crossings(&curve, other)).collect();
    cuts.retain(|s| (1e-9..=1.0 - 1e-9).contains(s));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| *a - *b < 1e-9);
    if let (EdgeCurve::Ellipse { .. }, [first, ..]) = (&curve, cuts.as_slice()) {
        let round = first + 1.0;
        cuts.push(round);
        return cuts.windows(2).map(|ends| Edge { curve, from: ends[0], to: ends[1] }).collect();
    }
    cuts.insert(0, 0.0);
    cuts.push(1.0);
    cuts.windows(2).map(|ends| Edge { curve, from: ends[0], to: ends[1] }).collect()
}

/// Parameters of `a` where `b` crosses it, or where the two begin or end to coincide.
fn crossings(a: &EdgeCurve, b: &EdgeCurve) -> Vec<f64> {
    if let (EdgeCurve::Line { a: p, b: q }, EdgeCurve::Line { a: r, b: s }) = (a, b) {
        let (along, other) = (*q - *p, *s - *r);
        if cross(along, other).abs() <= 1e-12 * along.norm() * other.norm() {
            let aside = cross(along, *r - *p).abs() / along.norm();
            let place = |x: Vector<2>| (x - *p).dot(along) / along.norm_squared();
            return if aside <= 1e-9 * along.norm() { vec![place(*r), place(*s)] } else { Vec::new() };
        }
    }
    let (n, m) = (a.chords(), b.chords());
    let ends = |curve: &EdgeCurve, i: usize, count: usize| {
        [curve.at(i as f64 / count as f64), curve.at((i + 1) as f64 / count as f64)]
    };
    let mut found = Vec::new();
    for i in 0..n {
        let first = ends(a, i, n);
        for j in 0..m {
            if let Some([s, t]) = chords_cross(first, ends(b, j, m)) {
                found.push(sharpen(a, b, (i as f64 + s) / n as f64, (j as f64 + t) / m as f64));
            }
        }
    }
    found
}

fn cross(a: Vector<2>, b: Vector<2>) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The parameters at which two straight pieces cross, also a little beyond their ends.
fn chords_cross([a, b]: [Vector<2>; 2], [c, d]: [Vector<2>; 2]) -> Option<[f64; 2]> {
    let (u, v, w) = (b - a, d - c, c - a);
    let determinant = cross(u, v);
    if determinant.abs() <= 1e-14 * u.norm() * v.norm() {
        return None;
    }
    let (s, t) = (cross(w, v) / determinant, cross(w, u) / determinant);
    let within = -1e-3..=1.0 + 1e-3;
    (within.contains(&s) && within.contains(&t)).then_some([s, t])
}

/// Newton's iteration on a(s) = b(t); gives s.
fn sharpen(a: &EdgeCurve, b: &EdgeCurve, mut s: f64, mut t: f64) -> f64 {
    for _ in 0..20 {
        let (gap, u, v) = (b.at(t) - a.at(s), a.tangent(s), b.tangent(t));
        let determinant = cross(u, v);
        if determinant == 0.0 {
            break;
        }
        s += cross(gap, v) / determinant;
        t += cross(gap, u) / determinant;
    }
    if matches!(a, EdgeCurve::Ellipse { .. }) { s.rem_euclid(1.0) } else { s }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(lower: [f64; 2], upper: [f64; 2]) -> Region {
        Region::Box { lower: [lower[0], lower[1], f64::NEG_INFINITY], upper: [upper[0], upper[1], f64::INFINITY] }
    }

    fn length(region: &Region) -> f64 {
        let along = |edge: &Edge| -> f64 {
            (0..20_000).map(|i| (edge.at((i + 1) as f64 / 2e4) - edge.at(i as f64 / 2e4)).norm()).sum()
        };
        region.outline().unwrap().iter().map(along).sum()
    }

    /// Cylinder of radius 0.05 with a bar of height 0.02 that begins on it (Turek and Hron): the arc hidden
    /// behind the bar is 2 asin(0.2) of the circle, the sides run from x = 0.2 + √(0.05² − 0.01²) to 0.6.
    #[test]
    fn a_bar_on_a_cylinder_keeps_what_is_outside() {
        let disc = Region::Sphere { center: [0.2, 0.2, 0.0], radius: 0.05 };
        let union = Region::Union(vec![disc, rectangle([0.2, 0.19], [0.6, 0.21])]);
        let root = 0.2 + (0.05f64 * 0.05 - 0.0001).sqrt();
        let exact = 0.05 * (TAU - 2.0 * (0.2f64).asin()) + 2.0 * (0.6 - root) + 0.02;
        assert!((length(&union) - exact).abs() < 1e-7 * exact);
    }

    #[test]
    fn outlines_of_a_hole_and_of_a_notch_with_flush_sides() {
        let plate = rectangle([0.0, 0.0], [2.0, 1.0]);
        let hole = Region::Sphere { center: [1.0, 0.5, 0.0], radius: 0.25 };
        let holed = Region::Intersection(vec![plate.clone(), Region::Complement(Box::new(hole))]);
        assert!((length(&holed) - 6.0 - TAU * 0.25).abs() < 1e-6);
        let notched =
            Region::Intersection(vec![plate, Region::Complement(Box::new(rectangle([0.5, 0.0], [1.5, 0.5])))]);
        assert!((length(&notched) - 7.0).abs() < 1e-9, "{}", length(&notched));
    }

    #[test]
    fn a_whole_circle_is_closed() {
        let disc = Region::Sphere { center: [0.0; 3], radius: 1.0 };
        assert!(disc.outline().unwrap()[0].is_closed());
        assert!(Region::Cylinder { from: [0.0; 3], to: [0.0, 0.0, 1.0], radius: 1.0 }.outline().is_err());
    }
}
