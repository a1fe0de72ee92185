//! Closed surfaces for the tests.

use crate::geometry::Triangles;
use crate::math::Vector;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A polygon, cut into triangles, between two heights.
pub fn prism(corners: &[[f64; 2]], cut: &[[u32; 3]], [lower, upper]: [f64; 2]) -> Triangles {
    let n = corners.len() as u32;
    let at = |z: f64| corners.iter().map(move |&[x, y]| [x, y, z]);
    let mut triangles: Vec<[u32; 3]> = cut.iter().flat_map(|&[a, b, c]| [[a, c, b], [a + n, b + n, c + n]]).collect();
    for a in 0..n {
        let b = (a + 1) % n;
        triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
    }
    Triangles { vertices: at(lower).chain(at(upper)).collect(), triangles }
}

pub fn cuboid(lower: [f64; 3], upper: [f64; 3]) -> Triangles {
    let [[x, y, z], [u, v, w]] = [lower, upper];
    prism(&[[x, y], [u, y], [u, v], [x, v]], &[[0, 1, 2], [0, 2, 3]], [z, w])
}

/// Two arms, 3 long and 1 thick, 2 wide.
pub fn bracket() -> Triangles {
    let corners = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    prism(&corners, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], [0.0, 2.0])
}

/// A profile (r, z), counter-clockwise seen with r to the right, turned about the third axis in `count` steps; one that
/// doesn't begin on the axis is a loop.
pub fn revolved(profile: &[[f64; 2]], count: u32) -> Triangles {
    let is_loop = profile[0][0] > 0.0;
    let mut vertices = Vec::new();
    let rows: Vec<Vec<u32>> = profile
        .iter()
        .map(|&[r, z]| {
            let first = vertices.len() as u32;
            let steps = if r > 0.0 { count } else { 1 };
            vertices.extend((0..steps).map(|k| {
                let (sin, cos) = (TAU * f64::from(k) / f64::from(count)).sin_cos();
                [r * cos, r * sin, z]
            }));
            (0..count).map(|k| first + k % steps).collect()
        })
        .collect();
    let mut triangles = Vec::new();
    for i in 0..rows.len() - usize::from(!is_loop) {
        let (row, next) = (&rows[i], &rows[(i + 1) % rows.len()]);
        for k in 0..count as usize {
            let l = (k + 1) % count as usize;
            let halves = [[row[k], row[l], next[l]], [row[k], next[l], next[k]]];
            triangles.extend(halves.into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
        }
    }
    Triangles { vertices, triangles }
}

/// A ring of this radius with a round section.
pub fn torus(radius: f64, thin: f64, count: u32) -> Triangles {
    let around = (0..count / 2).map(|k| (TAU * f64::from(k) / f64::from(count / 2)).sin_cos());
    revolved(&around.map(|(sin, cos)| [radius + thin * cos, thin * sin]).collect::<Vec<_>>(), count)
}

/// An icosahedron whose triangles are parted in four some times, with all vertices on the unit sphere.
pub fn icosphere(times: usize) -> Triangles {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let first = |k: usize| {
        (0..4).map(move |i| {
            let (a, b) = ([-1.0, 1.0][i % 2], [-g, g][i / 2]);
            let mut x = [0.0; 3];
            (x[k], x[(k + 1) % 3]) = (a, b);
            Vector(x).normalized().unwrap()
        })
    };
    let mut places: Vec<Vector<3>> = (0..3).flat_map(first).collect();
    let near = |a: usize, b: usize| (places[a] - places[b]).norm() < 1.1;
    let mut triangles = Vec::new();
    for (a, b, c) in (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| (a, b, c)))) {
        if near(a, b) && near(b, c) && near(c, a) {
            let out = (places[b] - places[a]).cross(places[c] - places[a]).dot(places[a]) > 0.0;
            triangles.push(if out { [a, b, c] } else { [a, c, b] }.map(|v| v as u32));
        }
    }
    for _ in 0..times {
        let mut between = BTreeMap::new();
        let mut parted = Vec::new();
        for &[a, b, c] in &triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[a, b]: [u32; 2]| {
                *between.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    places.push((places[a as usize] + places[b as usize]).normalized().unwrap());
                    places.len() as u32 - 1
                })
            });
            parted.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = parted;
    }
    Triangles { vertices: places.into_iter().map(|x| x.0).collect(), triangles }
}

/// A plate 4 × 4 with a round hole of radius 1, between two heights.
pub fn plate_with_hole(heights: [f64; 2], count: u32) -> Triangles {
    let n = count;
    let angle = |k: u32| TAU * f64::from(k) / f64::from(n);
    let outer = |k: u32| {
        let (sin, cos) = angle(k).sin_cos();
        let scale = 2.0 / sin.abs().max(cos.abs());
        [scale * cos, scale * sin]
    };
    let inner = |k: u32| [angle(k).cos(), angle(k).sin()];
    let plane: Vec<[f64; 2]> = (0..n).map(outer).chain((0..n).map(inner)).collect();
    let vertices = heights.iter().flat_map(|&z| plane.iter().map(move |&[x, y]| [x, y, z])).collect();
    let mut triangles = Vec::new();
    for a in 0..n {
        let b = (a + 1) % n;
        let (o, i, t) = ([a, b], [a + n, b + n], 2 * n);
        let mut quad = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
        quad([o[0] + t, o[1] + t, i[1] + t, i[0] + t]);
        quad([o[1], o[0], i[0], i[1]]);
        quad([o[0], o[1], o[1] + t, o[0] + t]);
        quad([i[1], i[0], i[0] + t, i[1] + t]);
    }
    Triangles { vertices, triangles }
}

/// Turned by an angle about a skew axis.
pub fn turned(mut surface: Triangles, degrees: f64) -> Triangles {
    let axis = Vector([1.0, 2.0, 3.0]).normalized().unwrap();
    let (sin, cos) = (degrees * PI / 180.0).sin_cos();
    for x in &mut surface.vertices {
        let own = Vector(*x);
        *x = (own * cos + axis.cross(own) * sin + axis * (axis.dot(own) * (1.0 - cos))).0;
    }
    surface
}
