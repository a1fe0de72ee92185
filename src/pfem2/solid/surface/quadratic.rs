//! Quadratic shape functions on −1..1 and their products.
//!
//! ```text
//! L_0 = ½ ξ (ξ − 1),  L_1 = 1 − ξ²,  L_2 = ½ ξ (ξ + 1),   N_a(ξ) = Π_k L_{a_k}(ξ_k),   a = a_0 + 3 a_1 (+ 9 a_2)
//! ```

use crate::math::{Tensor, Vector};

/// Values, first and second derivatives of the three functions along one axis.
pub fn line(s: f64) -> [[f64; 3]; 3] {
    [[0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)], [s - 0.5, -2.0 * s, s + 0.5], [1.0, -2.0, 1.0]]
}

/// Shape functions of a line, a patch or a block of 3ⁿ nodes with n coordinates.
pub fn shape_functions(local: &[f64]) -> Vec<f64> {
    local.iter().fold(vec![1.0], |lower, &s| {
        let [along, ..] = line(s);
        along.iter().flat_map(|l| lower.iter().map(move |n| n * l)).collect()
    })
}

/// Place in an element of 3ᴰ nodes and ∂x_i/∂ξ_j there.
fn place<const D: usize>(nodes: &[Vector<D>], local: Vector<D>) -> (Vector<D>, Tensor<D>) {
    let lines = local.0.map(line);
    let (mut x, mut jacobian) = (Vector::ZERO, Tensor::ZERO);
    for (a, node) in nodes.iter().enumerate() {
        let digit = |k: usize| a / 3usize.pow(k as u32) % 3;
        let product = |by: Option<usize>| (0..D).map(|k| lines[k][usize::from(by == Some(k))][digit(k)]).product();
        x += *node * product(None);
        jacobian += Tensor::outer(*node, Vector::from_fn(|k| product(Some(k))));
    }
    (x, jacobian)
}

/// Coordinates ξ of a place in an element of 3ᴰ nodes by Newton's method, or `None` if it doesn't converge. They may
/// lie outside of −1..1, up to [`REACH`].
pub fn coordinates<const D: usize>(nodes: &[Vector<D>], x: Vector<D>) -> Option<Vector<D>> {
    let nearest = nodes.iter().enumerate().min_by(|a, b| {
        let away = |node: Vector<D>| (node - x).norm_squared();
        away(*a.1).total_cmp(&away(*b.1))
    })?;
    let corner = Vector::from_fn(|k| (nearest.0 / 3usize.pow(k as u32) % 3) as f64 - 1.0);
    [Vector::ZERO, corner * 0.8].into_iter().find_map(|start| newton(nodes, x, start))
}

/// Coordinates beyond are cut off.
pub const REACH: f64 = 1.5;

fn newton<const D: usize>(nodes: &[Vector<D>], x: Vector<D>, start: Vector<D>) -> Option<Vector<D>> {
    const PASSES: usize = 25;
    const TOLERANCE: f64 = 1e-12;
    let mut local = start;
    for _ in 0..PASSES {
        let (at, jacobian) = place(nodes, local);
        let inverse = jacobian.embed(1.0).inverse()?;
        let step = Vector::<D>::from3(inverse.apply(Vector((x - at).to3())).0);
        local = (local + step).map(|s| s.clamp(-REACH, REACH));
        if step.0.iter().all(|s| s.abs() < TOLERANCE) {
            return Some(local);
        }
    }
    None
}

/// Corners of a box that holds a line, patch or element of 3ⁿ nodes: it lies in the convex hull of its Bézier points.
pub fn bounds<const D: usize>(nodes: &[Vector<D>]) -> [Vector<D>; 2] {
    let mut hull = nodes.to_vec();
    let mut stride = 1;
    while stride < hull.len() {
        for first in (0..hull.len()).filter(|first| first / stride % 3 == 0) {
            let middle = first + stride;
            hull[middle] = hull[middle] * 2.0 - (hull[first] + hull[middle + stride]) * 0.5;
        }
        stride *= 3;
    }
    let [lower, upper] = [f64::min as fn(f64, f64) -> f64, f64::max];
    let fold = |pick: fn(f64, f64) -> f64, start: f64| {
        hull.iter().fold(Vector::splat(start), |a, b| Vector::from_fn(|i| pick(a[i], b[i])))
    };
    [fold(lower, f64::INFINITY), fold(upper, f64::NEG_INFINITY)]
}
