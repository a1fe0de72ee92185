//! Deterministic parallel loops: the result never depends on the number of threads.
//!
//! All loops of the program but those of the transfers and of the linear algebra go through here, as one kind or
//! another of [`run`]: pieces of a fixed size are worked on in any order, and their results are put together in the
//! order of the pieces. Sums are taken over chunks of [`CHUNK`] entries, and the chunk sums are added in order.
//!
//! The threads know the work of a piece as a `dyn Fn`, so that each loop costs little code.

mod groups;

pub use groups::Groups;

use rayon::prelude::*;
use std::cmp::Ordering;
use std::io;
use std::iter::Sum;
use std::ops::{Add, Range};
use std::sync::{Mutex, PoisonError};

/// Entries per chunk of a deterministic reduction.
pub const CHUNK: usize = 4096;

/// Calls `task` for every number below `count`, in parallel.
pub fn run(count: usize, task: &(dyn Fn(usize) + Sync)) {
    match count {
        0 => {}
        1 => task(0),
        _ => (0..count).into_par_iter().for_each(task),
    }
}

/// Computes with this many threads (all cores where not said), of which this one is the first: each of the many short
/// loops of a step would else be handed to a sleeping thread, and wait for it.
///
/// # Errors
/// The threads can't be started, or have been started before.
pub fn use_threads(count: Option<usize>) -> io::Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count.unwrap_or(0)).use_current_thread();
    pool.build_global().map_err(io::Error::other)
}

/// Number of threads: for reports of runs, and for work that costs more the more pieces it is cut into.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// Slices of one length that are cut at the same places, each alone or in tuples.
pub trait Slices: Send + Sized {
    /// Number of entries of each.
    fn len(&self) -> usize;

    /// True without any entry.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The entries before `at`, and the others.
    fn split_at(self, at: usize) -> (Self, Self);
}

impl<T: Sync> Slices for &[T] {
    fn len(&self) -> usize {
        <[T]>::len(self)
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        <[T]>::split_at(self, at)
    }
}

impl<T: Send> Slices for &mut [T] {
    fn len(&self) -> usize {
        <[T]>::len(self)
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        <[T]>::split_at_mut(self, at)
    }
}

/// Tuples of columns.
macro_rules! tuples {
    ($($(($part:ident $number:tt))*;)*) => {$(
        impl<$($part: Slices),*> Slices for ($($part,)*) {
            fn len(&self) -> usize {
                self.0.len()
            }

            fn split_at(self, at: usize) -> (Self, Self) {
                let parts = ($(self.$number.split_at(at),)*);
                (($(parts.$number.0,)*), ($(parts.$number.1,)*))
            }
        }
    )*};
}

tuples! {
    (A 0) (B 1);
    (A 0) (B 1) (C 2);
    (A 0) (B 1) (C 2) (E 3);
    (A 0) (B 1) (C 2) (E 3) (F 4);
}

/// The results of `work` on pieces of `size` entries of the columns, given the number of the first entry, in their
/// order.
pub fn map_chunks<C: Slices, T: Send>(columns: C, size: usize, work: impl Fn(usize, C) -> T + Sync) -> Vec<T> {
    let mut pieces: Vec<Mutex<(Option<C>, Option<T>)>> = Vec::with_capacity(columns.len().div_ceil(size));
    let mut rest = columns;
    while !rest.is_empty() {
        let (piece, others) = {
            let at = size.min(rest.len());
            rest.split_at(at)
        };
        pieces.push(Mutex::new((Some(piece), None)));
        rest = others;
    }
    run(pieces.len(), &|n| {
        // Each piece has one task alone.
        let mut piece = pieces[n].lock().unwrap_or_else(PoisonError::into_inner);
        piece.1 = piece.0.take().map(|columns| work(n * size, columns));
    });
    pieces.into_iter().filter_map(|piece| piece.into_inner().unwrap_or_else(PoisonError::into_inner).1).collect()
}

/// Calls `work` for pieces of `size` entries of the columns, with the number of the first, in parallel.
pub fn for_each_chunk<C: Slices>(columns: C, size: usize, work: impl Fn(usize, C) + Sync) {
    map_chunks(columns, size, work);
}

/// The results of `work` on the pieces of `0..len` of `size` numbers, in order.
pub fn map_ranges<T: Send>(len: usize, size: usize, work: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let pieces: Vec<Mutex<Option<T>>> = (0..len.div_ceil(size)).map(|_| Mutex::new(None)).collect();
    run(pieces.len(), &|n| {
        let made = work(n * size..((n + 1) * size).min(len));
        *pieces[n].lock().unwrap_or_else(PoisonError::into_inner) = Some(made);
    });
    pieces.into_iter().filter_map(|piece| piece.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// `of(n)` for every n below `len`, in pieces of `size`.
pub fn collect<T: Send>(len: usize, size: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    join(map_ranges(len, size, |range| range.map(&of).collect()))
}

/// The results of `of`, as [`collect`] gives them, without the `None`s.
pub fn collect_some<T: Send>(len: usize, size: usize, of: impl Fn(usize) -> Option<T> + Sync) -> Vec<T> {
    join(map_ranges(len, size, |range| range.filter_map(&of).collect()))
}

/// The entries of the iterators that `of` returns, one after the other, as [`collect`] cuts them.
pub fn collect_all<I: IntoIterator>(len: usize, size: usize, of: impl Fn(usize) -> I + Sync) -> Vec<I::Item>
where
    I::Item: Send,
{
    join(map_ranges(len, size, |range| range.flat_map(&of).collect()))
}

/// One list after the other.
fn join<T>(mut lists: Vec<Vec<T>>) -> Vec<T> {
    if lists.len() == 1 {
        return lists.pop().unwrap_or_default();
    }
    let mut all = Vec::with_capacity(lists.iter().map(Vec::len).sum());
    lists.into_iter().for_each(|list| all.extend(list));
    all
}

/// The first number below `len` of which `holds` is true.
pub fn first(len: usize, holds: impl Fn(usize) -> bool + Sync) -> Option<usize> {
    map_ranges(len, CHUNK, |mut range| range.find(|&n| holds(n))).into_iter().flatten().next()
}

/// Calls `change` for every entry with its number, in pieces of `size`.
pub fn change<T: Send>(entries: &mut [T], size: usize, change: impl Fn(usize, &mut T) + Sync) {
    for_each_chunk(entries, size, |start, entries| {
        entries.iter_mut().enumerate().for_each(|(n, entry)| change(start + n, entry));
    });
}

/// Sets every entry to the result of `of` on its number, in pieces of `size`.
pub fn fill<T: Send>(entries: &mut [T], size: usize, of: impl Fn(usize) -> T + Sync) {
    change(entries, size, |n, entry| *entry = of(n));
}

/// Maps fixed chunks of `0..len` in parallel and folds the results in order.
pub fn reduce<T: Send>(
    len: usize,
    map: impl Fn(Range<usize>) -> T + Sync + Send,
    fold: impl FnMut(T, T) -> T,
) -> Option<T> {
    map_ranges(len, CHUNK, map).into_iter().reduce(fold)
}

/// Calls `run` for every entry, in parallel.
pub fn for_each_mut<T: Send>(entries: &mut [T], run: impl Fn(&mut T) + Sync) {
    for_each_chunk(entries, CHUNK, |_, chunk| chunk.iter_mut().for_each(&run));
}

/// Calls `run` for every pair of entries of two columns of one length, in parallel.
pub fn for_each_pair_mut<A: Send, B: Send>(a: &mut [A], b: &mut [B], run: impl Fn(&mut A, &mut B) + Sync) {
    for_each_chunk((a, b), CHUNK, |_, (a, b)| a.iter_mut().zip(b).for_each(|(a, b)| run(a, b)));
}

/// Calls `run`, as [`for_each_pair_mut`] does; folds what it returns in order, chunk by chunk.
pub fn reduce_pair_mut<A: Send, B: Send, T: Send>(
    a: &mut [A],
    b: &mut [B],
    run: impl Fn(&mut A, &mut B) -> T + Sync,
    fold: impl Fn(T, T) -> T + Sync,
) -> Option<T> {
    let parts = map_chunks((a, b), CHUNK, |_, (a, b): (&mut [A], &mut [B])| {
        a.iter_mut().zip(b).map(|(a, b)| run(a, b)).reduce(&fold)
    });
    parts.into_iter().flatten().reduce(fold)
}

/// Calls `run` with the number of the pair, as [`for_each_pair_mut`] does; returns what it returns, in order.
pub fn collect_pair_mut<A: Send, B: Send, T: Send>(
    a: &mut [A],
    b: &mut [B],
    run: impl Fn(usize, &mut A, &mut B) -> Option<T> + Sync,
) -> Vec<T> {
    join(map_chunks((a, b), CHUNK, |start, (a, b): (&mut [A], &mut [B])| {
        let pairs = a.iter_mut().zip(b).enumerate();
        pairs.filter_map(|(n, (a, b))| run(start + n, a, b)).collect()
    }))
}

/// The entries of ascending ranges that don't overlap, each to be changed by one thread.
pub fn parts_mut<T>(mut entries: &mut [T], ranges: impl Iterator<Item = Range<usize>>) -> Vec<&mut [T]> {
    let mut start = 0;
    let part = |range: Range<usize>| {
        let (part, rest) = std::mem::take(&mut entries)[range.start - start..].split_at_mut(range.len());
        (entries, start) = (rest, range.end);
        part
    };
    ranges.map(part).collect()
}

/// Replaces a column by the results of `map` on another, in parallel.
pub fn map_into<A: Sync, B: Send + Clone + Default>(from: &[A], to: &mut Vec<B>, map: impl Fn(&A) -> B + Sync + Send) {
    to.resize(from.len(), B::default());
    for_each_chunk((from, &mut to[..]), CHUNK, |_, (from, to)| {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = map(from));
    });
}

/// The sum of `term` over `0..len`, of numbers as of vectors; zero when empty.
///
/// ```
/// use lateen::math::Vector;
/// use lateen::parallel;
///
/// assert_eq!(parallel::sum(100_000, |n| n as f64), 0.5 * 99_999.0 * 100_000.0);
/// assert_eq!(parallel::sum(3, |n| Vector([1.0, n as f64])), Vector([3.0, 3.0]));
/// ```
pub fn sum<T: Send + Default + Sum + Add<Output = T>>(len: usize, term: impl Fn(usize) -> T + Sync + Send) -> T {
    reduce(len, |range| range.map(&term).sum(), |a: T, b| a + b).unwrap_or_default()
}

/// The number of `n` in `0..len` for which `holds(n)` is true.
///
/// ```
/// use lateen::parallel;
///
/// assert_eq!(parallel::count(100_000, |n| n % 3 == 0), 33_334);
/// ```
pub fn count(len: usize, holds: impl Fn(usize) -> bool + Sync + Send) -> usize {
    sum(len, |n| usize::from(holds(n)))
}

/// Lower and upper corner of the box around the places `0..len`; infinity and its negative when empty. NaN counts as
/// nothing.
///
/// ```
/// use lateen::parallel;
///
/// assert_eq!(parallel::corners(3, |n| [n as f64, -(n as f64)]), [[0.0, -2.0], [2.0, 0.0]]);
/// ```
pub fn corners<const D: usize>(len: usize, place: impl Fn(usize) -> [f64; D] + Sync + Send) -> [[f64; D]; 2] {
    let empty = [[f64::INFINITY; D], [f64::NEG_INFINITY; D]];
    let both = |[low, high]: [[f64; D]; 2], [lower, upper]: [[f64; D]; 2]| {
        [std::array::from_fn(|a| low[a].min(lower[a])), std::array::from_fn(|a| high[a].max(upper[a]))]
    };
    reduce(len, |range| range.map(&place).fold(empty, |found, x| both(found, [x, x])), both).unwrap_or(empty)
}

/// The least `term` over `0..len`; infinity when empty. NaN wins, so that it is noticed.
pub fn min(len: usize, term: impl Fn(usize) -> f64 + Sync + Send) -> f64 {
    let least = |a: f64, b: f64| if a < b || a.is_nan() { a } else { b };
    reduce(len, |range| range.map(&term).fold(f64::INFINITY, least), least).unwrap_or(f64::INFINITY)
}

/// The largest `term` over `0..len`, zero where none is above; NaN counts as nothing.
///
/// ```
/// use lateen::parallel;
///
/// assert_eq!(parallel::max(100_000, |n| (n as f64 - 70_000.0).abs()), 70_000.0);
/// assert_eq!(parallel::max(0, |_| 1.0), 0.0);
/// ```
pub fn max(len: usize, term: impl Fn(usize) -> f64 + Sync + Send) -> f64 {
    reduce(len, |range| range.map(&term).fold(0.0, f64::max), f64::max).unwrap_or(0.0)
}

/// Sorts entries. Those that compare as equal must be alike: which of them comes first is not said.
///
/// ```
/// use lateen::parallel;
///
/// let mut blocks: Vec<[u32; 2]> = (0..100_000).map(|n| [n * 7919 % 1009, n % 3]).collect();
/// let mut expected = blocks.clone();
/// parallel::sort_unstable_by(&mut blocks, |a, b| b.cmp(a));
/// expected.sort_by(|a, b| b.cmp(a));
/// assert_eq!(blocks, expected);
/// ```
pub fn sort_unstable_by<T: Send>(entries: &mut [T], order: impl Fn(&T, &T) -> Ordering + Sync) {
    entries.par_sort_unstable_by(order);
}

/// The results of `work` on each of the parts, in their order; each is a task.
pub fn map_parts<P: Send, T: Send>(parts: impl IntoIterator<Item = P>, work: impl Fn(P) -> T + Sync) -> Vec<T> {
    let mut parts: Vec<Option<P>> = parts.into_iter().map(Some).collect();
    map_chunks(&mut parts[..], 1, |_, part| part[0].take().map(&work)).into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces of every size give what a plain loop gives, in its order.
    #[test]
    fn pieces_come_in_order() {
        let squares: Vec<usize> = (0..1000).map(|n| n * n).collect();
        for size in [1, 7, 999, 1000, 5000] {
            assert_eq!(collect(1000, size, |n| n * n), squares);
            let odd: Vec<usize> = squares.iter().copied().filter(|n| n % 2 == 1).collect();
            assert_eq!(collect_some(1000, size, |n| (n % 2 == 1).then_some(n * n)), odd);
            let twice: Vec<usize> = (0..1000).flat_map(|n| [n, n]).collect();
            assert_eq!(collect_all(1000, size, |n| [n, n]), twice);
            let (mut a, b) = (vec![0; 1000], &squares[..]);
            for_each_chunk((&mut a[..], b), size, |start, (a, b)| {
                a.iter_mut().zip(b).enumerate().for_each(|(n, (a, b))| *a = b + start + n);
            });
            assert!(a.iter().enumerate().all(|(n, a)| *a == n * n + n), "{size}");
            change(&mut a, size, |n, a| *a -= n);
            assert_eq!(a, squares);
        }
        assert_eq!(first(100_000, |n| n >= 70_000), Some(70_000));
        assert_eq!(first(0, |_| true), None);
        assert_eq!(map_parts(squares, |square| square + 1)[999], 999 * 999 + 1);
        assert_eq!(collect(0, 4, |n| n), Vec::<usize>::new());
        assert!(threads() > 0);
    }

    /// Beyond a chunk and below it, with entries that count as nothing.
    #[test]
    fn sums_and_extremes_are_those_of_a_plain_loop() {
        for len in [0, 1, CHUNK - 1, CHUNK, 3 * CHUNK + 17] {
            let place = |n: usize| [(n * 7919 % 10_007) as f64, -((n * 104_729 % 9973) as f64)];
            let x = |n: usize| if n % 1000 == 999 { [f64::NAN; 2] } else { place(n) };
            let all: f64 = (0..len).map(|n| place(n)[0]).sum();
            assert_eq!(sum(len, |n| place(n)[0]), all);
            assert_eq!(sum(len, |n| n), (0..len).sum::<usize>());
            assert_eq!(count(len, |n| n % 5 == 2), (0..len).filter(|n| n % 5 == 2).count());
            let extreme = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| {
                (0..len).map(|n| x(n)[axis]).filter(|x| !x.is_nan()).fold(start, pick)
            };
            let lower = [0, 1].map(|axis| extreme(axis, f64::INFINITY, f64::min));
            let upper = [0, 1].map(|axis| extreme(axis, f64::NEG_INFINITY, f64::max));
            assert_eq!(corners(len, x), [lower, upper]);
        }
    }
}
