//! Transfers between particles and a tile.
//!
//! With the weights N_i of the axes, the shape function is a product, and a scatter of a value V and of
//! slopes H_d along the axes is a sum over nodes (i, j, k)
//!
//! ```text
//! node += N_i N_j N_k V + K_i N_j N_k H_x + N_i K_j N_k H_y + N_i N_j K_k H_z
//! ```
//!
//! where K is h ∂N/∂x in the force lanes (internal force, 17) and N (x_I − x_p)/h in the momentum lanes (APIC).
//! A gather is its adjoint. A scatter takes one particle after the other and a node's record as lanes, since
//! particles add to the same nodes. A gather takes eight particles with the same nodes as lanes, since they read the
//! same numbers.

use super::shape::Weights;
use super::tile::{TILE, Tile, tile_index};
use crate::math::simd::{Lanes, Row, WIDTH};

/// Weights of eight particles in memory, where each of them finds its own.
pub(crate) struct WeightRows<const W: usize> {
    /// N per axis and node.
    n: [[Row; W]; 3],
    gradient: [[Row; W]; 3],
    moment: [[Row; W]; 3],
}

impl<const W: usize> Default for WeightRows<W> {
    fn default() -> Self {
        let rows = [[Row::default(); W]; 3];
        Self { n: rows, gradient: rows, moment: rows }
    }
}

impl<const W: usize> WeightRows<W> {
    /// Stores the weights of all axes; moments only where they are used.
    #[inline(always)]
    pub fn put<L: Lanes, const D: usize, const AFFINE: bool>(&mut self, weights: &[Weights<L, W>; D]) {
        for axis in 0..D {
            for i in 0..W {
                weights[axis].n[i].store(&mut self.n[axis][i].0);
                weights[axis].gradient[i].store(&mut self.gradient[axis][i].0);
                if AFFINE {
                    weights[axis].moment[i].store(&mut self.moment[axis][i].0);
                }
            }
        }
    }

    /// N of particle `k`, in all lanes.
    #[inline(always)]
    fn n<L: Lanes>(&self, axis: usize, i: usize, k: usize) -> L {
        L::splat(self.n[axis][i].0[k])
    }

    /// Slope weights of particle `k`: the gradient for the force, the affine moment for the momentum.
    #[inline(always)]
    fn slope<L: Lanes, const D: usize, const AFFINE: bool>(&self, axis: usize, i: usize, k: usize) -> L {
        let gradient = L::splat(self.gradient[axis][i].0[k]);
        if AFFINE { L::splat(self.moment[axis][i].0[k]).blend(gradient, force_lanes(D)) } else { gradient }
    }

    /// N of particle `k`, but the slope in the force lane of the axis.
    #[inline(always)]
    fn force<L: Lanes, const D: usize>(&self, axis: usize, i: usize, k: usize) -> L {
        self.n::<L>(axis, i, k).blend(L::splat(self.gradient[axis][i].0[k]), 1 << (1 + D + axis))
    }
}

/// The lanes of a record that hold the force.
#[inline(always)]
const fn force_lanes(dimension: usize) -> u8 {
    ((1 << dimension) - 1) << (1 + dimension)
}

/// Scatters a value and slopes of particle `k` of a group; `first` is the number of the first node of its support.
#[inline(always)]
pub(crate) fn scatter<L: Lanes, const W: usize, const D: usize, const AFFINE: bool>(
    tile: &mut Tile,
    (weights, k): (&WeightRows<W>, usize),
    first: usize,
    value: L,
    slopes: [L; D],
) {
    let zero = L::splat(0.0);
    let (mut xs, mut ys) = ([zero; W], [zero; W]);
    for i in 0..W {
        let along = weights.slope::<L, D, AFFINE>(0, i, k).mul(slopes[0]);
        xs[i] = weights.n::<L>(0, i, k).mul_add(value, along);
        ys[i] = weights.slope::<L, D, AFFINE>(1, i, k).mul(slopes[1]);
    }
    if D == 2 {
        return scatter_plane(tile, (weights, k), &xs, &ys, first);
    }
    for plane in 0..W {
        let nz = weights.n::<L>(2, plane, k);
        let z = weights.slope::<L, D, AFFINE>(2, plane, k).mul(slopes[D - 1]);
        let (mut plane_xs, mut plane_ys) = (xs, ys);
        for i in 0..W {
            plane_xs[i] = xs[i].mul(nz);
            plane_ys[i] = ys[i].mul_add(nz, z.mul(weights.n(1, i, k)));
        }
        scatter_plane(tile, (weights, k), &plane_xs, &plane_ys, first + tile_index(0, 0, plane));
    }
}

/// node(i, j) += N_j X_i + N_i Y_j.
#[inline(always)]
fn scatter_plane<L: Lanes, const W: usize>(
    tile: &mut Tile,
    (weights, k): (&WeightRows<W>, usize),
    xs: &[L; W],
    ys: &[L; W],
    first: usize,
) {
    // One bounds check for the whole support.
    let nodes = &mut tile[first..][..TILE * (W - 1) + W];
    for j in 0..W {
        let nj = weights.n::<L>(1, j, k);
        for i in 0..W {
            let node = &mut nodes[TILE * j + i].0;
            let sum = nj.mul_add(xs[i], L::load(node));
            ys[j].mul_add(weights.n(0, i, k), sum).store(node);
        }
    }
}

/// Scatters a particle without shear stress: every lane of V N_i N_j N_k is a product, with h ∂N/∂x in place of
/// N for the force along that axis. One multiply–add per node.
#[inline(always)]
pub(crate) fn scatter_simple<L: Lanes, const W: usize, const D: usize>(
    tile: &mut Tile,
    (weights, k): (&WeightRows<W>, usize),
    first: usize,
    value: L,
) {
    let (mut xs, mut ys) = ([value; W], [value; W]);
    for i in 0..W {
        xs[i] = weights.force::<L, D>(0, i, k);
        ys[i] = weights.force::<L, D>(1, i, k);
    }
    for plane in 0..if D == 3 { W } else { 1 } {
        let value = if D == 3 { weights.force::<L, D>(2, plane, k).mul(value) } else { value };
        let nodes = &mut tile[first + tile_index(0, 0, plane)..][..TILE * (W - 1) + W];
        for j in 0..W {
            let row = ys[j].mul(value);
            for i in 0..W {
                let node = &mut nodes[TILE * j + i].0;
                xs[i].mul_add(row, L::load(node)).store(node);
            }
        }
    }
}

/// Which sums a gather forms, as a type: unused ones are never computed.
pub(crate) trait Sums: Copy {
    /// The scalar slot.
    const SCALAR: bool;
    /// The acceleration.
    const ACCELERATION: bool;
    /// Slopes of the velocity: none, the gradient, or gradient and affine moment.
    const SLOPES: usize;
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
    fn add<Q: Sums>(&mut self, part: &Self, n: L, slopes: [L; 2], axis: usize) {
        for lane in used::<Q, D>() {
            self.value[lane] = part.value[lane].mul_add(n, self.value[lane]);
        }
        for kind in 0..Q::SLOPES {
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

/// The lanes of a record that a gather reads.
#[inline(always)]
fn used<Q: Sums, const D: usize>() -> std::ops::Range<usize> {
    usize::from(!Q::SCALAR)..if Q::ACCELERATION { 1 + 2 * D } else { 1 + D }
}

/// Gathers for eight particles whose supports begin at the tile's node `first`.
#[inline(always)]
pub(crate) fn gather<L: Lanes, Q: Sums, const W: usize, const D: usize>(
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
                for lane in used::<Q, D>() {
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
