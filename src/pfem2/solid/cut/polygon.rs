//! The fluid part of an element as a polygon, divided into triangles by clipping ears: of all ears the one of the best
//! shape first (theory J.2).

use super::{FluidSimplex, Vertex};
use crate::math::Vector;

/// Area of a triangle over the square of its longest side below which its corners lie in a line.
const FLAT: f64 = 1e-6;

/// A corner of the polygon that the fluid fills in an element.
pub(super) type PolygonCorner<const D: usize> = (Vertex, Vector<D>);

/// A polygon, counter-clockwise, as triangles; `None` if it crosses itself.
pub(super) fn triangulated<const D: usize, const N: usize>(
    mut polygon: Vec<PolygonCorner<D>>,
) -> Option<Vec<FluidSimplex<N>>> {
    let mut triangles = Vec::new();
    while polygon.len() > 2 {
        let count = polygon.len();
        let ear = |i: usize| [(i + count - 1) % count, i, (i + 1) % count];
        let shape = |i: usize| {
            let corners = ear(i).map(|k| polygon[k].1);
            let mut others = (0..count).filter(|k| !ear(i).contains(k)).map(|k| polygon[k].1);
            if others.any(|x| contains(&corners, x)) { 0.0 } else { quality(&corners) }
        };
        let best = (0..count).map(|i| (i, shape(i))).max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
        if best.1 > 0.0 {
            let corners = ear(best.0).map(|k| polygon[k].0);
            triangles.push(FluidSimplex { vertices: std::array::from_fn(|k| corners[k]) });
            polygon.remove(best.0);
            continue;
        }
        // Along a surface on an edge of the mesh corners lie in a line but for rounding: no triangle.
        let flatness = |i: usize| quality(&ear(i).map(|k| polygon[k].1)).abs();
        let flat = (0..count).map(|i| (i, flatness(i))).min_by(|a, b| a.1.total_cmp(&b.1))?;
        if flat.1 > FLAT {
            return None;
        }
        polygon.remove(flat.0);
    }
    Some(triangles)
}

/// Twice the area of a triangle [m²], positive where its corners run counter-clockwise.
fn area<const D: usize>([a, b, c]: &[Vector<D>; 3]) -> f64 {
    let (u, v) = (*b - *a, *c - *a);
    u[0] * v[1] - u[1] * v[0]
}

/// Area of a triangle over the square of its longest side, twice.
fn quality<const D: usize>(corners: &[Vector<D>; 3]) -> f64 {
    let [a, b, c] = *corners;
    let longest = [b - a, c - b, a - c].iter().map(|side| side.norm_squared()).fold(0.0, f64::max);
    if longest > 0.0 { area(corners) / longest } else { 0.0 }
}

/// True if a triangle holds a place.
fn contains<const D: usize>([a, b, c]: &[Vector<D>; 3], x: Vector<D>) -> bool {
    [[*a, *b, x], [*b, *c, x], [*c, *a, x]].iter().all(|triangle| area(triangle) >= 0.0)
}
