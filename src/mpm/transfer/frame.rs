//! Positions in tile coordinates, and the weights of eight particles there (theory A.3).

use super::Sweep;
use super::group::LaneGroup;
use crate::math::Vector;
use crate::math::simd::Lanes;
use crate::mpm::bins::tile_origin;
use crate::mpm::grid::Fold;
use crate::mpm::grid::tile::{PLANE, TILE};
use crate::mpm::kernel::{ShapeFunction, Weights};

/// Positions to tile coordinates: s = x · scale − shift.
#[derive(Clone, Copy)]
pub(crate) struct TileFrame<const D: usize> {
    /// 1/h [1/m].
    pub scale: f64,
    shift: [f64; 3],
    ends: Ends<D>,
}

/// Ends of the domain beyond which ghosts extrapolate, in tile coordinates; `None` where there is none in the tile.
type Ends<const D: usize> = [[Option<f64>; 2]; D];

impl<const D: usize> TileFrame<D> {
    /// The tile of a block.
    pub fn new(sweep: &Sweep<'_, D>, block: [i32; D]) -> Self {
        let scale = 1.0 / sweep.cell;
        let tile = tile_origin(block);
        let end = |a: usize, end: usize| {
            let plane = if end == 0 { 0.0 } else { f64::from(sweep.cells[a]) } - tile[a];
            let extrapolates = sweep.folds[a][end] == Fold::Extrapolate && (0.0..TILE as f64).contains(&plane);
            extrapolates.then_some(plane)
        };
        Self {
            scale,
            shift: std::array::from_fn(|a| if a < D { sweep.origin[a] * scale + tile[a] } else { 0.0 }),
            ends: std::array::from_fn(|a| [end(a, 0), end(a, 1)]),
        }
    }

    /// Next to walls that extrapolate the affine parts of ghosts count with the places of the nodes that they are folded
    /// to ([`Weights::fold_moments`]).
    #[inline(always)]
    pub fn fold_moments<L: Lanes, const W: usize>(&self, weights: &mut [Weights<L, W>; D], base: &[L; D]) {
        for axis in 0..D {
            for (plane, inward) in self.ends[axis].iter().zip([1.0, -1.0]) {
                if let Some(plane) = plane {
                    weights[axis].fold_moments(base[axis], *plane, inward);
                }
            }
        }
    }

    /// Tile coordinates of a group of particles.
    #[inline(always)]
    pub fn coordinates<L: Lanes>(&self, group: LaneGroup, position: &[Vector<D>]) -> [L; D] {
        let mut s = group.vectors::<L, D>(position);
        for (s, shift) in s.iter_mut().zip(self.shift) {
            *s = s.mul(L::splat(self.scale)).sub(L::splat(shift));
        }
        s
    }
}

/// First node of the support along an axis. A particle beyond the slack is caught before a sweep; the clamp keeps a
/// bug from reading elsewhere.
#[inline(always)]
pub(crate) fn base<L: Lanes, S: ShapeFunction<W>, const W: usize>(shape: S, s: L) -> L {
    shape.base(s).max(L::splat(0.0)).min(L::splat((TILE - W) as f64))
}

/// The number of the tile node at whole-numbered coordinates.
#[inline(always)]
pub(crate) fn tile_number<L: Lanes, const D: usize>(base: &[L; D]) -> L {
    let strides = [1.0, TILE as f64, PLANE as f64];
    let mut number = base[0];
    for axis in 1..D {
        number = base[axis].mul_add(L::splat(strides[axis]), number);
    }
    number
}

/// Weights along all axes.
#[inline(always)]
pub(crate) fn weights<L: Lanes, S: ShapeFunction<W>, const W: usize, const D: usize>(
    shape: S,
    s: &[L; D],
    base: &[L; D],
) -> [Weights<L, W>; D] {
    let mut weights = [shape.weights(s[0], base[0]); D];
    for axis in 1..D {
        weights[axis] = shape.weights(s[axis], base[axis]);
    }
    weights
}
