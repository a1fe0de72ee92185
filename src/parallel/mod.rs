//! Deterministic parallel loops: the result never depends on the number of threads.
//!
//! Floating-point sums are taken over chunks of a fixed size, and the chunk sums are added in order.

use rayon::prelude::*;
use std::ops::Range;

/// Entries per chunk of a deterministic reduction.
pub const CHUNK: usize = 4096;

/// Maps fixed chunks of `0..len` in parallel and folds the results in order.
pub fn reduce<T: Send>(
    len: usize,
    map: impl Fn(Range<usize>) -> T + Sync + Send,
    fold: impl FnMut(T, T) -> T,
) -> Option<T> {
    let chunks = len.div_ceil(CHUNK);
    let parts: Vec<T> = (0..chunks).into_par_iter().map(|c| map(c * CHUNK..((c + 1) * CHUNK).min(len))).collect();
    parts.into_iter().reduce(fold)
}

/// Calls `run` for every entry, in parallel.
pub fn for_each_mut<T: Send>(entries: &mut [T], run: impl Fn(&mut T) + Sync) {
    entries.par_chunks_mut(CHUNK).for_each(|chunk| chunk.iter_mut().for_each(&run));
}

/// Calls `run` for every pair of entries of two columns of one length, in parallel.
pub fn for_each_pair_mut<A: Send, B: Send>(a: &mut [A], b: &mut [B], run: impl Fn(&mut A, &mut B) + Sync) {
    a.par_chunks_mut(CHUNK)
        .zip(b.par_chunks_mut(CHUNK))
        .for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| run(a, b)));
}

/// As [`for_each_pair_mut`]; folds what `run` returns in order, chunk by chunk.
pub fn reduce_pair_mut<A: Send, B: Send, T: Send>(
    a: &mut [A],
    b: &mut [B],
    run: impl Fn(&mut A, &mut B) -> T + Sync,
    fold: impl Fn(T, T) -> T + Sync,
) -> Option<T> {
    let chunk = |(a, b): (&mut [A], &mut [B])| a.iter_mut().zip(b).map(|(a, b)| run(a, b)).reduce(&fold);
    let parts: Vec<Option<T>> = a.par_chunks_mut(CHUNK).zip(b.par_chunks_mut(CHUNK)).map(chunk).collect();
    parts.into_iter().flatten().reduce(fold)
}

/// As [`for_each_pair_mut`], with the number of the pair; what `run` returns, in order.
pub fn collect_pair_mut<A: Send, B: Send, T: Send>(
    a: &mut [A],
    b: &mut [B],
    run: impl Fn(usize, &mut A, &mut B) -> Option<T> + Sync,
) -> Vec<T> {
    let chunk = |(chunk, (a, b)): (usize, (&mut [A], &mut [B]))| {
        let pairs = a.iter_mut().zip(b).enumerate();
        pairs.filter_map(|(n, (a, b))| run(chunk * CHUNK + n, a, b)).collect::<Vec<_>>()
    };
    a.par_chunks_mut(CHUNK).zip(b.par_chunks_mut(CHUNK)).enumerate().flat_map_iter(chunk).collect()
}

/// The entries of ascending ranges that don't overlap, each to be changed by a thread of its own.
pub fn parts_mut<T>(mut entries: &mut [T], ranges: impl Iterator<Item = Range<usize>>) -> Vec<&mut [T]> {
    let mut start = 0;
    let part = |range: Range<usize>| {
        let (part, rest) = std::mem::take(&mut entries)[range.start - start..].split_at_mut(range.len());
        (entries, start) = (rest, range.end);
        part
    };
    ranges.map(part).collect()
}

/// Replaces a column by what `map` makes of another, in parallel.
pub fn map_into<A: Sync, B: Send>(from: &[A], to: &mut Vec<B>, map: impl Fn(&A) -> B + Sync + Send) {
    from.par_iter().with_min_len(CHUNK).map(map).collect_into_vec(to);
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
