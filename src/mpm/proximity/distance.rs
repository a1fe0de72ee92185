//! Distance between two elements: segments in the plane; triangles and quadrilaterals in space (theory D.17).
//!
//! A quadrilateral is the fan of four triangles around its mean point, as contact sees it. Two triangles that don't
//! cross are nearest to each other at points of two edges, or at a corner of one and its foot inside the other; if they
//! cross, an edge of one goes through the other (Ericson 2005, Real-Time Collision Detection, 5.1.9 and 5.3).

use crate::math::Vector;

/// Two segments of the plane this near, over their lengths, cross.
const CROSSING: f64 = 1e-9;

/// The shortest line between two elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// Distance [m]; 0 if they cross.
    pub distance: f64,
    /// The middle of the shortest line between them [m].
    pub place: Vector<3>,
}

/// The shortest line between two elements, each given by its corners [m]; `None` if it is not shorter than `within`
/// [m].
pub fn approach(a: &[Vector<3>], b: &[Vector<3>], within: f64) -> Option<Approach> {
    let mut best = ShortestLine { square: within * within, place: None };
    let (pieces, others) = (Fan::new(a), Fan::new(b));
    for piece in pieces.all() {
        for other in others.all() {
            if square_between_boxes(piece, other) < best.square {
                compare(piece, other, &mut best);
            }
        }
    }
    best.place.map(|place| Approach { distance: best.square.sqrt(), place })
}

/// The segment or triangles that an element consists of.
struct Fan {
    corners: [[Vector<3>; 3]; 4],
    /// Number of pieces, and of corners of each.
    counts: [usize; 2],
}

impl Fan {
    fn new(x: &[Vector<3>]) -> Self {
        match *x {
            [a, b] => Self { corners: [[a, b, b]; 4], counts: [1, 2] },
            [a, b, c] => Self { corners: [[a, b, c]; 4], counts: [1, 3] },
            _ => {
                let middle = x.iter().copied().sum::<Vector<3>>() / x.len() as f64;
                Self { corners: std::array::from_fn(|k| [x[k], x[(k + 1) % x.len()], middle]), counts: [4, 3] }
            }
        }
    }

    fn all(&self) -> impl Iterator<Item = &[Vector<3>]> {
        let [count, corners] = self.counts;
        self.corners[..count].iter().map(move |piece| &piece[..corners])
    }
}

/// The shortest line so far.
struct ShortestLine {
    square: f64,
    place: Option<Vector<3>>,
}

impl ShortestLine {
    fn offer(&mut self, p: Vector<3>, q: Vector<3>) {
        let square = (p - q).norm_squared();
        if square < self.square {
            *self = Self { square, place: Some((p + q) * 0.5) };
        }
    }

    fn cross(&mut self, place: Vector<3>) {
        *self = Self { square: 0.0, place: Some(place) };
    }
}

/// The sides of a triangle, or a segment itself.
fn sides(piece: &[Vector<3>]) -> impl Iterator<Item = [Vector<3>; 2]> {
    let n = piece.len();
    (0..if n == 2 { 1 } else { n }).map(move |k| [piece[k], piece[(k + 1) % n]])
}

fn compare(a: &[Vector<3>], b: &[Vector<3>], best: &mut ShortestLine) {
    for [p, q] in sides(a) {
        for [r, s] in sides(b) {
            let (x, y) = between_segments([p, q], [r, s]);
            let flat = a.len() == 2 && (x - y).norm() <= CROSSING * ((q - p).norm() + (s - r).norm());
            if flat { best.cross(x) } else { best.offer(x, y) }
        }
    }
    if a.len() == 2 {
        return;
    }
    for (plate, other) in [(a, b), (b, a)] {
        let normal = (plate[1] - plate[0]).cross(plate[2] - plate[0]);
        for &x in other {
            let foot = x - normal * ((x - plate[0]).dot(normal) / normal.norm_squared());
            if inside(plate, normal, foot) {
                best.offer(x, foot);
            }
        }
        for [p, q] in sides(other) {
            let [above, below] = [p, q].map(|x| (x - plate[0]).dot(normal));
            let x = p + (q - p) * (above / (above - below));
            if above * below < 0.0 && inside(plate, normal, x) {
                best.cross(x);
            }
        }
    }
}

/// True if a point of the plane of a triangle lies in it.
fn inside(triangle: &[Vector<3>], normal: Vector<3>, x: Vector<3>) -> bool {
    sides(triangle).all(|[p, q]| (p - x).cross(q - x).dot(normal) >= 0.0)
}

/// The points of two segments that are nearest to each other.
fn between_segments([p, q]: [Vector<3>; 2], [r, s]: [Vector<3>; 2]) -> (Vector<3>, Vector<3>) {
    let (u, v, w) = (q - p, s - r, p - r);
    let (a, b, c, d, e) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let fraction = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    // Of parallel segments any point will do, as long as its partner is found from it.
    let first = fraction(b * e - c * d, a * c - b * b);
    let second = fraction(b * first + e, c);
    // If the second was held at its end, the first follows.
    let first = fraction(b * second - d, a);
    (p + u * first, r + v * second)
}

/// Squared distance of the boxes around two pieces [m²].
fn square_between_boxes(a: &[Vector<3>], b: &[Vector<3>]) -> f64 {
    let bound =
        |x: &[Vector<3>], i: usize, start: f64, pick: fn(f64, f64) -> f64| x.iter().map(|x| x[i]).fold(start, pick);
    let gap = |i: usize| {
        let low = |x| bound(x, i, f64::INFINITY, f64::min);
        let high = |x| bound(x, i, f64::NEG_INFINITY, f64::max);
        (low(a) - high(b)).max(low(b) - high(a)).max(0.0)
    };
    (0..3).map(|i| gap(i).powi(2)).sum()
}
