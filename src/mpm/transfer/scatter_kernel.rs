//! The scatter of a run of particles with the same support into a tile.
//!
//! With the weights N_i of the axes, the shape function is a product, and a scatter of a value V and of
//! slopes H_d along the axes is a sum over nodes (i, j, k)
//!
//! ```text
//! node += N_i N_j N_k V + K_i N_j N_k H_x + N_i K_j N_k H_y + N_i N_j K_k H_z
//!       = N_j [N_k X_i + N_i K_k H_z] + N_k K_j H_y N_i,      X_i = N_i V + K_i H_x
//! ```
//!
//! where K is h ∂N/∂x for forces (internal force, Lian (17)) and N (x_I − x_p)/h for momentum (APIC). Without slopes,
//! and for forces of a pressure, every lane is a product of one-dimensional weights.
//!
//! A record's lanes hold the numbers of a node. Where they are four, two particles are taken at a time and their sums
//! are added at the end. The nodes of a plane stay in registers while all particles of the run add to them.

use crate::math::simd::{Lanes, Row, WIDTH};
use crate::mpm::grid::tile::{ScalarTile, TILE, Tile, tile_index};
use crate::mpm::kernel::Weights;

/// The places of particles' numbers in the lanes of a record.
pub(crate) trait Packing {
    /// Particles per record.
    const PARTICLES: usize;

    /// A number of each particle of record `record` in its lanes.
    fn spread<L: Lanes>(numbers: &Row, record: usize) -> L;

    /// The lanes of the force along `axis` in `dimension` dimensions.
    fn force_lanes(axis: usize, dimension: usize) -> u8;
}

/// One particle: (m, p, f).
pub(crate) struct Alone;

impl Packing for Alone {
    const PARTICLES: usize = 1;

    #[inline(always)]
    fn spread<L: Lanes>(numbers: &Row, record: usize) -> L {
        L::splat(numbers.0[record])
    }

    #[inline(always)]
    fn force_lanes(axis: usize, dimension: usize) -> u8 {
        1 << (1 + dimension + axis)
    }
}

/// Two particles: (m, p) or (0, f) of each.
pub(crate) struct Paired;

impl Packing for Paired {
    const PARTICLES: usize = 2;

    #[inline(always)]
    fn spread<L: Lanes>(numbers: &Row, record: usize) -> L {
        L::pair(numbers.0[2 * record], numbers.0[2 * record + 1])
    }

    #[inline(always)]
    fn force_lanes(axis: usize, _dimension: usize) -> u8 {
        0b10_0010 << axis
    }
}

/// The weights that the slopes of a scatter take.
#[derive(Clone, Copy)]
pub(crate) enum Slope {
    /// None: the values alone.
    Value,
    /// h ∂N/∂x.
    Gradient,
    /// N (x_I − x_p)/h.
    Moment,
}

/// One or two particles as factors of the axes and their slopes, a record per node.
#[derive(Clone, Copy)]
struct Factors<const W: usize> {
    x: [Row; W],
    y: [Row; W],
    z: [Row; W],
    /// Factors of weights along x and y: N_i of sloped records and K_j H_y. Along z: K_k H_z.
    slopes: [[Row; W]; 3],
}

/// A run of particles, weighted and packed into records.
pub(crate) struct ScatterKernel<const W: usize> {
    /// N and slope weights per axis and node, of eight particles.
    n: [[Row; W]; 3],
    slope: [[Row; W]; 3],
    records: [Factors<W>; WIDTH],
}

impl<const W: usize> Default for ScatterKernel<W> {
    fn default() -> Self {
        let rows = [Row::default(); W];
        let record = Factors { x: rows, y: rows, z: rows, slopes: [rows; 3] };
        Self { n: [rows; 3], slope: [rows; 3], records: [record; WIDTH] }
    }
}

impl<const W: usize> ScatterKernel<W> {
    /// Takes the weights of a run.
    #[inline(always)]
    pub fn weigh<L: Lanes, const D: usize>(&mut self, weights: &[Weights<L, W>; D], slope: Slope) {
        for axis in 0..D {
            for i in 0..W {
                let all = &weights[axis];
                all.n[i].store(&mut self.n[axis][i].0);
                let slope = match slope {
                    Slope::Value => all.n[i],
                    Slope::Gradient => all.gradient[i],
                    Slope::Moment => all.moment[i],
                };
                slope.store(&mut self.slope[axis][i].0);
            }
        }
    }

    /// N of a record's particles, but the slope weight in the force lanes of the axis.
    #[inline(always)]
    fn product_weight<L: Lanes, P: Packing, const D: usize>(&self, axis: usize, i: usize, record: usize) -> L {
        let slope = P::spread::<L>(&self.slope[axis][i], record);
        P::spread::<L>(&self.n[axis][i], record).blend(slope, P::force_lanes(axis, D))
    }

    /// Makes records of values that are multiplied by one weight of each axis.
    #[inline(always)]
    pub fn pack_products<L: Lanes, P: Packing, const D: usize>(&mut self, values: &[L]) {
        for (k, value) in values.iter().enumerate() {
            for i in 0..W {
                let x = self.product_weight::<L, P, D>(0, i, k);
                let y = self.product_weight::<L, P, D>(1, i, k);
                let z = if D == 3 { self.product_weight::<L, P, D>(2, i, k).mul(*value) } else { *value };
                let record = &mut self.records[k];
                x.store(&mut record.x[i].0);
                y.store(&mut record.y[i].0);
                z.store(&mut record.z[i].0);
            }
        }
    }

    /// Makes records of pairs of particles from values and slopes along the axes.
    #[inline(always)]
    pub fn pack_slopes<L: Lanes, const D: usize>(&mut self, values: &[L], slopes: &[[L; WIDTH / 2]; D]) {
        for (k, value) in values.iter().enumerate() {
            for i in 0..W {
                let n = Paired::spread::<L>(&self.n[0][i], k);
                let x = n.mul_add(*value, Paired::spread::<L>(&self.slope[0][i], k).mul(slopes[0][k]));
                let y = Paired::spread::<L>(&self.n[1][i], k);
                let by_y = Paired::spread::<L>(&self.slope[1][i], k).mul(slopes[1][k]);
                let record = &mut self.records[k];
                x.store(&mut record.x[i].0);
                y.store(&mut record.y[i].0);
                n.store(&mut record.slopes[0][i].0);
                by_y.store(&mut record.slopes[1][i].0);
                if D == 3 {
                    let by_z = Paired::spread::<L>(&self.slope[2][i], k).mul(slopes[D - 1][k]);
                    Paired::spread::<L>(&self.n[2][i], k).store(&mut record.z[i].0);
                    by_z.store(&mut record.slopes[2][i].0);
                }
            }
        }
    }

    /// node(i, j, k) += X_i Y_j Z_k of the first `count` records; `first` is the first node of their support.
    #[inline(always)]
    pub fn add_products<L: Lanes, const D: usize>(&self, tile: &mut Tile, first: usize, count: usize) {
        for k in 0..if D == 3 { W } else { 1 } {
            let mut sums = SupportPlane::<L, W>::load(tile, first + tile_index(0, 0, k));
            for record in &self.records[..count] {
                let z = L::load(&record.z[k].0);
                for j in 0..W {
                    let row = L::load(&record.y[j].0).mul(z);
                    for i in 0..W {
                        sums.0[j][i] = L::load(&record.x[i].0).mul_add(row, sums.0[j][i]);
                    }
                }
            }
            sums.store(tile, first + tile_index(0, 0, k));
        }
    }

    /// The sum of values and slopes of the first `count` records; `first` is the first node of their support.
    #[inline(always)]
    pub fn add_slopes<L: Lanes, const D: usize>(&self, tile: &mut Tile, first: usize, count: usize) {
        for k in 0..if D == 3 { W } else { 1 } {
            let mut sums = SupportPlane::<L, W>::load(tile, first + tile_index(0, 0, k));
            for record in &self.records[..count] {
                let (z, by_z) = (L::load(&record.z[k].0), L::load(&record.slopes[2][k].0));
                let mut n = [z; W];
                let mut x = n;
                for i in 0..W {
                    n[i] = L::load(&record.slopes[0][i].0);
                    x[i] = L::load(&record.x[i].0);
                    if D == 3 {
                        x[i] = x[i].mul_add(z, n[i].mul(by_z));
                    }
                }
                for j in 0..W {
                    let (y, by_y) = (L::load(&record.y[j].0), L::load(&record.slopes[1][j].0));
                    let by_y = if D == 3 { by_y.mul(z) } else { by_y };
                    for i in 0..W {
                        sums.0[j][i] = by_y.mul_add(n[i], y.mul_add(x[i], sums.0[j][i]));
                    }
                }
            }
            sums.store(tile, first + tile_index(0, 0, k));
        }
    }
}

/// The nodes of a plane of a support.
struct SupportPlane<L, const W: usize>([[L; W]; W]);

impl<L: Lanes, const W: usize> SupportPlane<L, W> {
    #[inline(always)]
    fn load(tile: &Tile, first: usize) -> Self {
        // One bounds check for the whole plane.
        let nodes = &tile[first..][..TILE * (W - 1) + W];
        let mut sums = [[L::splat(0.0); W]; W];
        for j in 0..W {
            for i in 0..W {
                sums[j][i] = L::load(&nodes[TILE * j + i].0);
            }
        }
        Self(sums)
    }

    #[inline(always)]
    fn store(self, tile: &mut Tile, first: usize) {
        let nodes = &mut tile[first..][..TILE * (W - 1) + W];
        for j in 0..W {
            for i in 0..W {
                self.0[j][i].store(&mut nodes[TILE * j + i].0);
            }
        }
    }
}

/// Adds two scalars of each of `count` particles with the same support: four nodes along x, with both numbers each, are
/// the lanes.
#[inline(always)]
pub(crate) fn add_scalars<L: Lanes, const W: usize, const D: usize>(
    tile: &mut ScalarTile,
    weights: &[Weights<L, W>; D],
    first: usize,
    scalars: [L; 2],
    count: usize,
) {
    let mut rows = [L::splat(0.0); WIDTH];
    for i in 0..W {
        rows[2 * i] = weights[0].n[i].mul(scalars[0]);
        rows[2 * i + 1] = weights[0].n[i].mul(scalars[1]);
    }
    let along_x = L::transpose(rows);
    for k in 0..if D == 3 { W } else { 1 } {
        let mut across = [Row::default(); W];
        let mut sums = [L::splat(0.0); W];
        let start = first + tile_index(0, 0, k);
        let nodes = tile[start..][..TILE * (W - 1) + 4].as_flattened_mut();
        for j in 0..W {
            let weight = if D == 3 { weights[1].n[j].mul(weights[D - 1].n[k]) } else { weights[1].n[j] };
            weight.store(&mut across[j].0);
            sums[j] = L::load(nodes[2 * TILE * j..].first_chunk().expect("four nodes"));
        }
        for (p, x) in along_x.iter().enumerate().take(count) {
            for j in 0..W {
                sums[j] = x.mul_add(L::splat(across[j].0[p]), sums[j]);
            }
        }
        for j in 0..W {
            sums[j].store(nodes[2 * TILE * j..].first_chunk_mut().expect("four nodes"));
        }
    }
}
