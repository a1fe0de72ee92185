//! The places of the particles of a chunk in their tile: found once for all that a visit does.

use super::column::{CHUNK_LEN, ChunkColumn, get, put};
use super::frame::{self, TileFrame};
use super::group::LaneGroup;
use crate::math::Vector;
use crate::math::simd::{Lanes, Task, WIDTH, widest};
use crate::mpm::grid::tile::Extent;
use crate::mpm::kernel::{Kernel, ShapeFunction, Weights, with_shape};

/// The first node of an empty lane.
const NOWHERE: f64 = -1.0;

/// Tile coordinates of the particles of a chunk, and where their supports begin.
#[repr(C, align(64))]
pub(crate) struct Places<const D: usize> {
    s: [ChunkColumn; D],
    /// The number of the first node, a whole number.
    first: ChunkColumn,
    len: usize,
}

impl<const D: usize> Default for Places<D> {
    fn default() -> Self {
        Self { s: [[0.0; CHUNK_LEN + WIDTH]; D], first: [NOWHERE; CHUNK_LEN + WIDTH], len: 0 }
    }
}

impl<const D: usize> Places<D> {
    /// Places at most a chunk of particles. Returns the part of the tile that they reach.
    pub fn locate(&mut self, kernel: Kernel, frame: TileFrame<D>, positions: &[Vector<D>]) -> Extent {
        with_shape!(kernel, shape => widest(Locate { places: self, shape, frame, positions }))
    }

    /// Number of particles.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// The first node of the support of particle `p`.
    #[inline(always)]
    pub fn first(&self, p: usize) -> usize {
        self.first[p] as usize
    }

    /// Number of the eight particles from `p` on with the same support as the first of them.
    #[inline(always)]
    pub fn run(&self, p: usize) -> usize {
        let mut same = 0u32;
        for k in 0..WIDTH {
            same |= u32::from(self.first[p + k] == self.first[p]) << k;
        }
        same.trailing_ones() as usize
    }

    /// Weights of the run from particle `p` on, and where its support begins. Lanes beyond the run mean nothing.
    #[inline(always)]
    pub fn weights<L: Lanes, S: ShapeFunction<W>, const W: usize>(
        &self,
        shape: S,
        p: usize,
    ) -> ([Weights<L, W>; D], [L; D]) {
        let mut s = [L::splat(0.0); D];
        let mut base = s;
        for axis in 0..D {
            s[axis] = get(p, &self.s[axis]);
            base[axis] = frame::base(shape, L::splat(self.s[axis][p]));
        }
        (frame::weights(shape, &s, &base), base)
    }
}

struct Locate<'a, S, const W: usize, const D: usize> {
    places: &'a mut Places<D>,
    shape: S,
    frame: TileFrame<D>,
    positions: &'a [Vector<D>],
}

impl<S: ShapeFunction<W>, const W: usize, const D: usize> Task for Locate<'_, S, W, D> {
    type Output = Extent;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Extent {
        let Self { places, shape, frame, positions } = self;
        let n = positions.len().min(CHUNK_LEN);
        let (mut lowest, mut highest) = ([L::splat(f64::INFINITY); D], [L::splat(0.0); D]);
        for p in (0..n).step_by(WIDTH) {
            let group = LaneGroup::new(p, n - p);
            let s = frame.coordinates::<L>(group, positions);
            let mut base = s;
            for axis in 0..D {
                base[axis] = frame::base(shape, s[axis]);
                lowest[axis] = lowest[axis].min(base[axis]);
                highest[axis] = highest[axis].max(base[axis]);
                put(s[axis], p, &mut places.s[axis]);
            }
            put(frame::tile_number(&base), p, &mut places.first);
        }
        places.first[n..n + WIDTH].fill(NOWHERE);
        places.len = n;
        Extent::around::<L, W, D>(&lowest, &highest)
    }
}
