//! The thickness of a solid: from the middle of a side on its surface straight inward to the other side, where that
//! faces it.

use super::QuadraticMesh;
use super::measure::ElementSide;
use crate::math::Vector;

/// Sides from which the thickness is measured, at most.
const MOST_SIDES: usize = 400;

/// Two sides face each other if the cosine between their normals is below minus this.
const FACING_COSINE: f64 = 0.7;

/// Rounding of places in a triangle.
const ROUNDING: f64 = 1e-9;

/// Thickness of a solid at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thickness {
    /// Elements across.
    pub elements: usize,
    /// Thickness [m].
    pub length: f64,
    /// The middle [m].
    pub middle: [f64; 3],
}

/// A flat piece of the surface, turned outward.
struct FacePiece {
    corners: [Vector<3>; 3],
    normal: Vector<3>,
}

impl QuadraticMesh {
    /// Thickness of the solid where it is thinnest; of a solid without sides that face each other, as that of a
    /// triangle may be, its least extent.
    pub fn thinnest(&self) -> Thickness {
        self.thicknesses()
            .into_iter()
            .min_by(|a, b| a.length.total_cmp(&b.length))
            .unwrap_or_else(|| self.least_extent())
    }

    /// Thicknesses of the solid behind its sides, 400 of them at most, spread evenly; none where no sides face each
    /// other.
    pub fn thicknesses(&self) -> Vec<Thickness> {
        let sides = self.surface();
        let pieces: Vec<FacePiece> = sides.iter().flat_map(|&side| self.pieces(side)).collect();
        let stride = sides.len().div_ceil(MOST_SIDES).max(1);
        sides.iter().step_by(stride).filter_map(|&side| self.across(side, &pieces)).collect()
    }

    fn least_extent(&self) -> Thickness {
        let [lower, upper] = self.extent().map(Vector);
        let length = (0..self.dimension).map(|k| upper[k] - lower[k]).fold(f64::INFINITY, f64::min);
        let per_element = (self.volume() / self.elements.len().max(1) as f64).powf(1.0 / self.dimension as f64);
        let elements = if self.elements.is_empty() { 0 } else { count(length, per_element) };
        Thickness { elements, length, middle: ((lower + upper) * 0.5).0 }
    }

    /// Thickness from the middle of a side to the surface that faces it behind.
    fn across(&self, side: ElementSide, pieces: &[FacePiece]) -> Option<Thickness> {
        let at = |end: f64| {
            let xi = std::array::from_fn(|k| if k == side.axis { end } else { 0.0 });
            Vector(self.position(side.element, xi))
        };
        let end = if side.upper { 1.0 } else { -1.0 };
        let (from, opposite) = (at(end), at(-end));
        let inward = -self.pieces(side).first()?.normal;
        let facing = pieces.iter().filter(|piece| piece.normal.dot(inward) > FACING_COSINE);
        let depth = (opposite - from).dot(inward);
        let ahead = facing.filter_map(|piece| piece.hit(from, inward)).filter(|&length| length > ROUNDING * depth);
        let length = ahead.fold(f64::INFINITY, f64::min);
        let middle = (from + inward * (0.5 * length)).0;
        (length.is_finite() && depth > 0.0).then(|| Thickness { elements: count(length, depth), length, middle })
    }

    /// A side as triangles between its nodes; in 2D each segment between these is a strip, two units wide in the third
    /// direction.
    fn pieces(&self, side: ElementSide) -> Vec<FacePiece> {
        let end = if side.upper { 1.0 } else { -1.0 };
        let along: Vec<usize> = (0..self.dimension).filter(|&k| k != side.axis).collect();
        let at = |own: [f64; 2]| {
            let mut xi = [0.0; 3];
            xi[side.axis] = end;
            along.iter().zip(own).for_each(|(&k, x)| xi[k] = x);
            Vector(self.position(side.element, xi))
        };
        let up = Vector::unit(2);
        let strip =
            |from: f64, to: f64| [at([from, 0.0]) - up, at([to, 0.0]) - up, at([to, 0.0]) + up, at([from, 0.0]) + up];
        let fours = match self.dimension {
            2 => vec![strip(-1.0, 0.0), strip(0.0, 1.0)],
            _ => [[-1.0, -1.0], [0.0, -1.0], [-1.0, 0.0], [0.0, 0.0]]
                .map(|[x, y]| [at([x, y]), at([x + 1.0, y]), at([x + 1.0, y + 1.0]), at([x, y + 1.0])])
                .to_vec(),
        };
        // The middle of a side that is curved more than the element is thick lies outward, its chord may not.
        let outward = at([0.0; 2]) - Vector(self.position(side.element, [0.0; 3]));
        let turned = |corners: [Vector<3>; 3]| {
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized()?;
            Some(FacePiece { corners, normal: if normal.dot(outward) < 0.0 { -normal } else { normal } })
        };
        fours.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).filter_map(turned).collect()
    }
}

/// Number of elements of a size that make up a length.
fn count(length: f64, size: f64) -> usize {
    (length / size).round().max(1.0) as usize
}

impl FacePiece {
    /// The distance along a unit vector to the place where it meets the triangle (Möller & Trumbore 1997).
    fn hit(&self, from: Vector<3>, along: Vector<3>) -> Option<f64> {
        let [a, b, c] = self.corners;
        let (u, v, w) = (b - a, c - a, from - a);
        let (p, q) = (along.cross(v), w.cross(u));
        let determinant = u.dot(p);
        let (s, t) = (w.dot(p) / determinant, along.dot(q) / determinant);
        let within = s >= -ROUNDING && t >= -ROUNDING && s + t <= 1.0 + ROUNDING;
        within.then(|| v.dot(q) / determinant)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{plate, without};
    use super::*;
    use crate::geometry::Region;

    #[test]
    fn thickness_of_a_bridge_of_a_disc_of_a_block_and_of_a_hollow_ball() {
        let hole = Region::Sphere { center: [1.0, 0.5, 0.0], radius: 0.3 };
        let bridge = QuadraticMesh::fill(&without(plate([0.0, 0.0], [2.0, 1.0]), hole), 0.1, 2).unwrap().thinnest();
        assert!((0.2..0.21).contains(&bridge.length) && (2..=4).contains(&bridge.elements), "{bridge:?}");
        let disc = Region::Sphere { center: [0.0; 3], radius: 1.0 };
        let across = QuadraticMesh::fill(&disc, 0.25, 2).unwrap().thinnest();
        assert!((1.9..2.0 + 1e-12).contains(&across.length), "{across:?}");
        let block = Region::Box { lower: [0.0; 3], upper: [3.0, 2.0, 0.5] };
        let across = QuadraticMesh::fill(&block, 0.25, 3).unwrap().thinnest();
        assert!((across.length - 0.5).abs() < 1e-12 && across.elements == 2, "{across:?}");
        assert!((across.middle[2] - 0.25).abs() < 1e-12);
        let ball = |radius| Region::Sphere { center: [0.0; 3], radius };
        let across = QuadraticMesh::fill(&without(ball(0.06), ball(0.05)), 0.04, 3).unwrap().thinnest();
        assert!((across.length / 0.01 - 1.0).abs() < 0.05 && across.elements == 1, "{across:?}");
    }
}
