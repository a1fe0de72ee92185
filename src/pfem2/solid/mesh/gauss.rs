//! Shape functions of elements of solids, and the points at which their integrals are taken (theory J.1).
//!
//! ```text
//! N_a(ξ) = Π_k L_{a_k}(ξ_k),   ξ_k = −√0.6, 0, √0.6 with the weights 5/9, 8/9, 5/9
//! ```

use crate::math::Vector;

/// A point of numerical integration, with the shape functions of all nodes there.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussPoint {
    /// Weight of the point: 2 per axis in sum.
    pub weight: f64,
    /// Shape functions N_a.
    pub shape: Vec<f64>,
    /// Slopes ∂N_a/∂ξ of the shape functions, padded with zeros.
    pub slopes: Vec<[f64; 3]>,
}

impl GaussPoint {
    /// Σ N_a x_a.
    pub fn interpolate<const D: usize>(&self, nodal: &[Vector<D>]) -> Vector<D> {
        nodal.iter().zip(&self.shape).map(|(x, shape)| *x * *shape).sum()
    }
}

/// The three Gauss points per axis of [−1, 1] raised to this number of `dimensions` (at most 3).
pub fn gauss_points(dimensions: usize) -> Vec<GaussPoint> {
    let (places, weights) = ([-0.6f64.sqrt(), 0.0, 0.6f64.sqrt()], [5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0]);
    let point = |index: usize| {
        let at: Vec<usize> = (0..dimensions).map(|k| digit(index, k)).collect();
        let local: Vec<f64> = at.iter().map(|&k| places[k]).collect();
        let weight = at.iter().map(|&k| weights[k]).product();
        GaussPoint { weight, shape: shape_functions(&local), slopes: shape_slopes(&local) }
    };
    (0..3usize.pow(dimensions as u32)).map(point).collect()
}

/// Values at the nodes of the functions through the Gauss points: `[node][point]`.
pub fn to_nodes(dimensions: usize) -> Vec<Vec<f64>> {
    let g = 0.6f64.sqrt();
    // Lagrange's polynomials of −g, 0, g.
    let through = |x: f64| [0.5 * x * (x - g), g * g - x * x, 0.5 * x * (x + g)].map(|value| value / (g * g));
    let along = [-1.0, 0.0, 1.0].map(through);
    let count = 3usize.pow(dimensions as u32);
    let weight = |node, point| (0..dimensions).map(|k| along[digit(node, k)][digit(point, k)]).product();
    (0..count).map(|node| (0..count).map(|point| weight(node, point)).collect()).collect()
}

/// Place along axis `k` of a local node in lexicographic order.
fn digit(node: usize, k: usize) -> usize {
    node / 3usize.pow(k as u32) % 3
}

/// L_0, L_1, L_2 at ξ.
fn lagrange(x: f64) -> [f64; 3] {
    [0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)]
}

/// Slopes of L_0, L_1, L_2 at ξ.
fn lagrange_slopes(x: f64) -> [f64; 3] {
    [x - 0.5, -2.0 * x, x + 0.5]
}

/// Shape functions N_a of all nodes at ξ = `local`, one coordinate per dimension, in the order of [`super`].
pub fn shape_functions(local: &[f64]) -> Vec<f64> {
    let along: Vec<[f64; 3]> = local.iter().map(|&x| lagrange(x)).collect();
    let shape = |a| along.iter().enumerate().map(|(k, values)| values[digit(a, k)]).product();
    (0..3usize.pow(local.len() as u32)).map(shape).collect()
}

/// Slopes ∂N_a/∂ξ of the shape functions, padded with zeros.
pub fn shape_slopes(local: &[f64]) -> Vec<[f64; 3]> {
    let values: Vec<[f64; 3]> = local.iter().map(|&x| lagrange(x)).collect();
    let slopes: Vec<[f64; 3]> = local.iter().map(|&x| lagrange_slopes(x)).collect();
    let factor = |a: usize, k: usize, axis: usize| if k == axis { slopes[k] } else { values[k] }[digit(a, k)];
    let slope = |a: usize, axis: usize| {
        if axis < local.len() { (0..local.len()).map(|k| factor(a, k, axis)).product() } else { 0.0 }
    };
    (0..3usize.pow(local.len() as u32)).map(|a| std::array::from_fn(|axis| slope(a, axis))).collect()
}
