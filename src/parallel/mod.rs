//! Deterministic parallel loops: the result never depends on the number of threads.
//!
//! Floating-point sums are taken over chunks of a fixed size, and the chunk sums are added in order.

use rayon::prelude::*;

/// Entries per chunk of a deterministic reduction.
pub const CHUNK: usize = 4096;

/// Maps fixed chunks of `0..len` in parallel and folds the results in order.
pub fn reduce<T: Send>(
    len: usize,
    map: impl Fn(std::ops::Range<usize>) -> T + Sync + Send,
    fold: impl FnMut(T, T) -> T,
) -> Option<T> {
    let chunks = len.div_ceil(CHUNK);
    let parts: Vec<T> = (0..chunks).into_par_iter().map(|c| map(c * CHUNK..((c + 1) * CHUNK).min(len))).collect();
    parts.into_iter().reduce(fold)
}

/// The sum of `term` over `0..len`.
pub fn sum(len: usize, term: impl Fn(usize) -> f64 + Sync + Send) -> f64 {
    reduce(len, |range| range.map(&term).sum::<f64>(), |a, b| a + b).unwrap_or(0.0)
}

/// The least `term` over `0..len`; infinity when empty. NaN wins, so that it is noticed.
pub fn min(len: usize, term: impl Fn(usize) -> f64 + Sync + Send) -> f64 {
    let least = |a: f64, b: f64| if a < b || a.is_nan() { a } else { b };
    reduce(len, |range| range.map(&term).fold(f64::INFINITY, least), least).unwrap_or(f64::INFINITY)
}
