//! The directions of a lattice: those in which most of the surface is level.
//!
//! ```text
//! s(R) = Σ A_i ‖Rᵀ n_i‖₁ / Σ A_i;   the frame R with the least s:   1 if every triangle is normal to an axis, 1.5 of a ball
//! ```
//!
//! Frames that are tried: that of the coordinates; those of two large flat parts normal to each other; one large flat
//! part and the longest straight direction in it; the principal axes of the surface.

use super::features::normals;
use crate::geometry::Triangles;
use crate::math::{SymTensor, Vector};

/// Another frame than that of the coordinates must be better by this factor.
const WORTH: f64 = 0.98;

/// Flat parts that are tried in pairs, the largest ones.
const DIRECTIONS: usize = 8;

/// Normals closer than this cosine are those of one flat part (0.5°).
const SAME: f64 = 0.99996;

/// Normals with a cosine below are normal to each other (0.5°).
const NORMAL: f64 = 0.0087;

/// Axes of a lattice, orthonormal and right-handed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes(pub [Vector<3>; 3]);

impl Axes {
    /// Those in which most of a surface is level.
    pub fn of(surface: &Triangles) -> Self {
        let normals = &normals(surface);
        let own = Self([0, 1, 2].map(Vector::unit));
        let areas: Vec<f64> = surface.triangles.iter().map(|t| area(surface, t)).collect();
        let flat = directions(normals, &areas);
        let mut best = (WORTH * own.score(normals, &areas), own);
        let pairs = flat.iter().enumerate().flat_map(|(i, &a)| flat[i + 1..].iter().map(move |&b| [a, b]));
        let pairs = pairs.filter(|[a, b]| a.dot(*b).abs() < NORMAL);
        let along = flat.iter().filter_map(|&n| Some([n, longest(surface, n)?]));
        for [a, b] in pairs.chain(along).chain([principal(surface, &areas)]) {
            let Some(axes) = Self::from_pair(a, b) else { continue };
            let score = axes.score(normals, &areas);
            // Rounding must not choose among equals.
            if score < (1.0 - 1e-9) * best.0 {
                best = (score, axes);
            }
        }
        best.1
    }

    /// Axes along `a` and, made normal to it, `b`; each named for the coordinate that it is nearest to.
    fn from_pair(a: Vector<3>, b: Vector<3>) -> Option<Self> {
        let a = a.normalized()?;
        let b = (b - a * a.dot(b)).normalized()?;
        let all = [a, b, a.cross(b)];
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let fit = |order: &[usize; 3]| (0..3).map(|k| all[order[k]][k].abs()).sum::<f64>();
        let order = orders.into_iter().reduce(|best, next| if fit(&next) > fit(&best) + 1e-9 { next } else { best })?;
        let [x, y, _] = [0, 1, 2].map(|k| all[order[k]] * all[order[k]][k].signum());
        Some(Self([x, y, x.cross(y)]))
    }

    fn score(&self, normals: &[Vector<3>], areas: &[f64]) -> f64 {
        let of = |n: &Vector<3>| self.0.iter().map(|axis| axis.dot(*n).abs()).sum::<f64>();
        normals.iter().zip(areas).map(|(n, area)| area * of(n)).sum::<f64>() / areas.iter().sum::<f64>()
    }

    /// Coordinates along the axes.
    pub fn along(&self, x: Vector<3>) -> Vector<3> {
        if self.is_own() { x } else { Vector(self.0.map(|axis| axis.dot(x))) }
    }

    /// The vector with these coordinates along the axes.
    pub fn back(&self, x: Vector<3>) -> Vector<3> {
        if self.is_own() { x } else { self.0[0] * x[0] + self.0[1] * x[1] + self.0[2] * x[2] }
    }

    /// True for the frame of the coordinates, in which nothing is rounded.
    fn is_own(&self) -> bool {
        (0..3).all(|k| self.0[k] == Vector::unit(k))
    }
}

/// Area of a triangle [m²].
pub fn area(surface: &Triangles, triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| Vector(surface.vertices[v as usize]));
    0.5 * (b - a).cross(c - a).norm()
}

/// Triangles with about the same normal, whichever way they face.
struct FlatPart {
    /// Normal of the largest of them.
    first: Vector<3>,
    /// Sum of areas times normals, turned to the side of the first [m²].
    sum: Vector<3>,
    /// Sum of areas [m²].
    area: f64,
}

/// Normals of the largest flat parts, whichever way they face: means of the triangles there, the largest area first.
fn directions(normals: &[Vector<3>], areas: &[f64]) -> Vec<Vector<3>> {
    let mut order: Vec<usize> = (0..normals.len()).collect();
    order.sort_by(|&a, &b| areas[b].total_cmp(&areas[a]).then(a.cmp(&b)));
    let mut parts: Vec<FlatPart> = Vec::new();
    for i in order {
        let n = normals[i];
        match parts.iter_mut().take(64).find(|part| part.first.dot(n).abs() > SAME) {
            Some(part) => {
                part.sum += n * (areas[i] * part.first.dot(n).signum());
                part.area += areas[i];
            }
            None => parts.push(FlatPart { first: n, sum: n * areas[i], area: areas[i] }),
        }
    }
    parts.sort_by(|a, b| b.area.total_cmp(&a.area));
    parts.into_iter().take(DIRECTIONS).filter_map(|part| part.sum.normalized()).collect()
}

/// The direction of the longest side of a triangle that is normal to `n`.
fn longest(surface: &Triangles, n: Vector<3>) -> Option<Vector<3>> {
    let sides = surface.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let vectors = sides.map(|[a, b]| Vector(surface.vertices[b as usize]) - Vector(surface.vertices[a as usize]));
    let level = vectors.filter(|side| side.dot(n).abs() < NORMAL * side.norm());
    level.reduce(|best, side| if side.norm() > (1.0 + 1e-9) * best.norm() { side } else { best })
}

/// The principal directions of the places of the surface with the largest and the least spread.
fn principal(surface: &Triangles, areas: &[f64]) -> [Vector<3>; 2] {
    let centre = |t: &[u32; 3]| t.iter().map(|&v| Vector(surface.vertices[v as usize])).sum::<Vector<3>>() / 3.0;
    let weighed = || surface.triangles.iter().map(centre).zip(areas);
    let middle = weighed().map(|(x, &area)| x * area).sum::<Vector<3>>() / areas.iter().sum::<f64>();
    let spread = weighed().fold(SymTensor::ZERO, |sum, (x, &area)| {
        let [x, y, z] = (x - middle).0;
        sum + SymTensor([x * x, y * y, z * z, x * y, y * z, z * x]) * area
    });
    let [first, _, last] = spread.spectrum().directions;
    [first, last]
}
