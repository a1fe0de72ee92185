//! Vectors of numbers in parallel, with sums in a fixed order.

use crate::parallel::{CHUNK, reduce};
use rayon::prelude::*;

/// a·b.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    reduce(a.len(), |range| dot_of(&a[range.clone()], &b[range]), |a, b| a + b).unwrap_or(0.0)
}

/// |a|.
pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// a·b_k for all k in one pass over a.
pub(super) fn dots(a: &[f64], b: &[Vec<f64>]) -> Vec<f64> {
    let partial = |range: std::ops::Range<usize>| -> Vec<f64> {
        b.iter().map(|b| dot_of(&a[range.clone()], &b[range.clone()])).collect()
    };
    let add = |mut a: Vec<f64>, b: Vec<f64>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    reduce(a.len(), partial, add).unwrap_or_default()
}

/// y += Σ_k c_k x_k in one pass over y.
pub(super) fn add_multiples(y: &mut [f64], c: &[f64], x: &[Vec<f64>]) {
    y.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, y)| {
        let from = chunk * CHUNK;
        for (c, x) in c.iter().zip(x) {
            y.iter_mut().zip(&x[from..]).for_each(|(y, x)| *y += c * x);
        }
    });
}

/// y_i ← f(i, y_i).
pub(super) fn update(y: &mut [f64], f: impl Fn(usize, f64) -> f64 + Sync) {
    y.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, y)| {
        y.iter_mut().enumerate().for_each(|(i, y)| *y = f(chunk * CHUNK + i, *y));
    });
}

/// Four sums side by side, so that they fill the registers.
fn dot_of(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    for (a, b) in a4.0.iter().zip(b4.0) {
        (0..4).for_each(|k| sums[k] += a[k] * b[k]);
    }
    let rest: f64 = a4.1.iter().zip(b4.1).map(|(a, b)| a * b).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// A pseudo-random vector with parts of all modes, the same in every run: the golden ratio fills an interval evenly.
pub(super) fn start_vector(k: usize, n: usize) -> Vec<f64> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (0..n).map(|i| ((i * (2 * k + 1) + k + 1) as f64 * GOLDEN).fract() - 0.5).collect()
}
