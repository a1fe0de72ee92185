//! Points spread in a plane region by a truss of springs (Persson & Strang, *A simple mesh generator in
//! MATLAB*, SIAM Review 46, 2004): every edge of the Delaunay triangulation pushes its ends apart until it has
//! the length that the size asks for,
//!
//! ```text
//! f = max(l_0 − l, 0),   l_0 = 1.2 h(x_mid) √(Σ l² / Σ h²),   x ← x + 0.2 Σ f min(1, h/(2 |Σ f|))
//! ```
//!
//! and x is pushed back until it is 0.35 h inside.

use super::size::SizeField;
use crate::geometry::Region;
use crate::math::Vector;
use crate::parallel;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Points and springs that a thread takes at once.
const PIECE: usize = 1024;

/// A point of a triangulation and its number.
#[derive(Debug, Clone, Copy)]
pub struct Site {
    at: Point2<f64>,
    /// Number of the point.
    pub index: u32,
}

impl HasPosition for Site {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// The points with their numbers.
pub fn sites(points: &[Vector<2>]) -> Vec<Site> {
    points.iter().enumerate().map(|(i, x)| Site { at: Point2::new(x[0], x[1]), index: i as u32 }).collect()
}

/// Moves all points but the first `fixed` to even spacing.
pub fn relax(points: &mut Vec<Vector<2>>, fixed: usize, region: &Region, size: &SizeField) -> Result<(), String> {
    const ROUNDS: usize = 60;
    for round in 0..ROUNDS {
        let springs = springs(points, region)?;
        let push = forces(points, &springs, size);
        let moved = |n: usize| {
            let (x, push) = (points[fixed + n], push[fixed + n]);
            let h = size.at(x.to3());
            let step = push * (0.2 * (0.5 * h / push.norm().max(0.5 * h)));
            (inside(x + step, region, 0.35 * h), step.norm() / h)
        };
        let moved: Vec<(Vector<2>, f64)> = parallel::collect(points.len() - fixed, PIECE, moved);
        points[fixed..].iter_mut().zip(&moved).for_each(|(x, (place, _))| *x = *place);
        let moved = moved.iter().map(|(_, way)| *way).fold(0.0, f64::max);
        if round % 10 == 9 && round + 10 < ROUNDS {
            drop_crowded(points, fixed, &springs, size);
        }
        if moved < 1e-3 {
            break;
        }
    }
    Ok(())
}

/// Edges of the triangulation inside the region.
fn springs(points: &[Vector<2>], region: &Region) -> Result<Vec<[u32; 2]>, String> {
    let triangulation: DelaunayTriangulation<Site> =
        DelaunayTriangulation::bulk_load(sites(points)).map_err(|why| why.to_string())?;
    let ends = |vertices: [u32; 2]| [vertices[0].min(vertices[1]), vertices[0].max(vertices[1])];
    let edges = triangulation.undirected_edges();
    let edges: Vec<[u32; 2]> = edges.map(|edge| ends(edge.vertices().map(|vertex| vertex.data().index))).collect();
    let inside = |n: usize| {
        let [a, b] = edges[n].map(|end| points[end as usize]);
        region.contains(((a + b) * 0.5).to3()).then_some(edges[n])
    };
    let mut springs = parallel::collect_some(edges.len(), PIECE, inside);
    springs.sort_unstable();
    Ok(springs)
}

fn forces(points: &[Vector<2>], springs: &[[u32; 2]], size: &SizeField) -> Vec<Vector<2>> {
    let middle = |[a, b]: [u32; 2]| (points[a as usize] + points[b as usize]) * 0.5;
    let wanted: Vec<f64> = parallel::collect(springs.len(), PIECE, |n| size.at(middle(springs[n]).to3()));
    let length = |[a, b]: [u32; 2]| (points[b as usize] - points[a as usize]).norm();
    let (squares, sizes) = springs
        .iter()
        .zip(&wanted)
        .fold((0.0, 0.0), |(l, h), (&spring, size)| (l + length(spring).powi(2), h + size * size));
    let scale = 1.2 * (squares / sizes).sqrt();
    let mut push = vec![Vector::ZERO; points.len()];
    for (&[a, b], h) in springs.iter().zip(&wanted) {
        let along = points[b as usize] - points[a as usize];
        let (l, rest) = (along.norm(), scale * h);
        if l < rest {
            let force = along * ((rest - l) / l);
            push[b as usize] += force;
            push[a as usize] -= force;
        }
    }
    push
}

/// `x`, pushed back along the normal until it is `margin` inside the region.
fn inside(mut x: Vector<2>, region: &Region, margin: f64) -> Vector<2> {
    for _ in 0..3 {
        let (distance, normal) = region.distance_and_normal(x.to3());
        if distance <= -margin {
            break;
        }
        x -= Vector([normal[0], normal[1]]) * (distance + margin);
    }
    x
}

/// Removes the free end of every edge that is shorter than half the wanted size.
fn drop_crowded(points: &mut Vec<Vector<2>>, fixed: usize, springs: &[[u32; 2]], size: &SizeField) {
    let mut drop = vec![false; points.len()];
    for &[a, b] in springs {
        let (x, y) = (points[a as usize], points[b as usize]);
        let crowded = (y - x).norm() < 0.5 * size.at(((x + y) * 0.5).to3());
        if crowded && b as usize >= fixed && !drop[a as usize] {
            drop[b as usize] = true;
        }
    }
    let mut keep = drop.iter().map(|d| !d);
    points.retain(|_| keep.next().unwrap_or(true));
}
