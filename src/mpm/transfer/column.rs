//! A number of each particle of a chunk.

use crate::math::simd::Lanes;

/// Particles per call of a visitor: their gathered values stay in the first-level cache.
pub(crate) const CHUNK_LEN: usize = 128;

/// A number of each particle of a chunk. Eight are stored at a time, so the end may overrun.
pub(crate) type ChunkColumn = [f64; CHUNK_LEN + 8];

/// Eight numbers of a column.
#[inline(always)]
pub(crate) fn get<L: Lanes>(p: usize, column: &ChunkColumn) -> L {
    L::load(column[p..].first_chunk().expect("columns end eight numbers beyond the chunk"))
}

/// Stores eight numbers of a column.
#[inline(always)]
pub(crate) fn put<L: Lanes>(lanes: L, p: usize, column: &mut ChunkColumn) {
    lanes.store(column[p..].first_chunk_mut().expect("columns end eight numbers beyond the chunk"));
}
