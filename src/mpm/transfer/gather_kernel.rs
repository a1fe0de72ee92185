//! The gather of eight particles with the same support from a tile.
//!
//! With the weights N_i of the axes, the shape function is a product, and the sums over nodes (i, j, k)
//!
//! ```text
//! Σ N_i N_j N_k R,   Σ K_i N_j N_k v,   Σ N_i K_j N_k v,   Σ N_i N_j K_k v
//! ```
//!
//! of the records R and the velocities v in them, where K is h ∂N/∂x, Lian (62, 63), or N (x_I − x_p)/h (APIC), are
//! formed row by row and plane by plane. The particles are the lanes, since they read the same numbers. A scatter
//! ([`super::scatter_kernel`]) is its adjoint.

use crate::math::simd::{Lanes, WIDTH};
use crate::mpm::grid::tile::{TILE, Tile, tile_index};
use crate::mpm::kernel::Weights;

/// The sums that a gather forms, as a type: unused ones are never computed.
pub(crate) trait GatherSums: Copy {
    /// The first lane of a record that is read: 0 the scalar, 1 the velocity.
    const FROM: usize;
    /// One past the last lane that is read, in so many dimensions: the scalar's, the velocity's, or the acceleration's.
    const TO: fn(usize) -> usize;
    /// The slopes of the velocity that it forms: its gradient, its affine moment.
    const SLOPES: [bool; 2];
}

/// Σ N R of the records R around eight particles, and per kind of slope and axis Σ K v (kind 0: h times the gradient,
/// kind 1: the affine moment over h).
#[derive(Clone, Copy)]
pub(crate) struct Gathered<L, const D: usize> {
    /// Σ N R.
    pub value: [L; WIDTH],
    /// Σ K v by kind, axis and component.
    pub slopes: [[[L; D]; D]; 2],
}

impl<L: Lanes, const D: usize> Gathered<L, D> {
    #[inline(always)]
    fn zero() -> Self {
        let zero = L::splat(0.0);
        Self { value: [zero; WIDTH], slopes: [[[zero; D]; D]; 2] }
    }

    /// Adds a part of lower dimension with the weight `n`; its value enters the slope along `axis` with `slopes`.
    #[inline(always)]
    fn add<Q: GatherSums>(&mut self, part: &Self, n: L, slopes: [L; 2], axis: usize) {
        for lane in Q::FROM..(Q::TO)(D) {
            self.value[lane] = part.value[lane].mul_add(n, self.value[lane]);
        }
        for kind in 0..2 {
            if !Q::SLOPES[kind] {
                continue;
            }
            for a in 0..D {
                for lower in 0..axis {
                    let sum = &mut self.slopes[kind][lower][a];
                    *sum = part.slopes[kind][lower][a].mul_add(n, *sum);
                }
                let sum = &mut self.slopes[kind][axis][a];
                *sum = part.value[1 + a].mul_add(slopes[kind], *sum);
            }
        }
    }
}

/// Gathers for eight particles whose supports begin at the tile's node `first`.
#[inline(always)]
pub(crate) fn gather<L: Lanes, Q: GatherSums, const W: usize, const D: usize>(
    tile: &Tile,
    first: usize,
    weights: &[Weights<L, W>; D],
) -> Gathered<L, D> {
    let mut sum = Gathered::zero();
    for k in 0..if D == 3 { W } else { 1 } {
        let nodes = &tile[first + tile_index(0, 0, k)..][..TILE * (W - 1) + W];
        let mut plane = Gathered::zero();
        for j in 0..W {
            let mut row = Gathered::zero();
            for i in 0..W {
                let mut node = Gathered::zero();
                for lane in Q::FROM..(Q::TO)(D) {
                    node.value[lane] = L::splat(nodes[TILE * j + i].0[lane]);
                }
                row.add::<Q>(&node, weights[0].n[i], weights[0].slopes(i), 0);
            }
            plane.add::<Q>(&row, weights[1].n[j], weights[1].slopes(j), 1);
        }
        if D == 2 {
            return plane;
        }
        sum.add::<Q>(&plane, weights[D - 1].n[k], weights[D - 1].slopes(k), D - 1);
    }
    sum
}
