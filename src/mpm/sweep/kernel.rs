//! One particle's transfers on a tile, as whole records.
//!
//! With the weights N_i of the axes, the shape function is a product, and a scatter of a value V and of
//! slopes H_d along the axes is a sum over nodes (i, j, k)
//!
//! ```text
//! node += N_i N_j N_k V + K_i N_j N_k H_x + N_i K_j N_k H_y + N_i N_j K_k H_z
//! ```
//!
//! where K is h ∂N/∂x in the force lanes (internal force, 17) and N (x_I − x_p)/h in the momentum lanes (APIC).
//! A gather is its adjoint.

use super::lanes::{Lanes, Record};
use super::shape::Weights;
use super::tile::{Extent, TILE, Tile, tile_index};

/// `std::array::from_fn` that is certain to be inlined, and so compiled for the registers of its caller.
#[inline(always)]
pub(crate) fn array<T: Copy, const N: usize>(first: T, at: impl Fn(usize) -> T) -> [T; N] {
    let mut array = [first; N];
    for (i, entry) in array.iter_mut().enumerate() {
        *entry = at(i);
    }
    array
}

/// Weights of the slope along one axis: h ∂N/∂x, and N (x_I − x_p)/h.
#[inline(always)]
fn slope<const W: usize>(w: &Weights<W>, i: usize, axis: usize) -> [f64; 2] {
    [w.dn[i][axis], w.n[i][axis] * w.offset[i][axis]]
}

/// One number in the lanes of the momentum (velocity), another in those of the force (the velocity's copy).
#[inline(always)]
fn pair<L: Lanes, const D: usize>(momentum: f64, force: f64) -> L {
    L::set(array(0.0, |lane| match lane {
        0 => 0.0,
        _ if lane <= D => momentum,
        _ if lane <= 2 * D => force,
        _ => 0.0,
    }))
}

/// Slope weights of a scatter: affine for the momentum, the gradient for the force.
#[inline(always)]
fn scatter_slope<L: Lanes, const W: usize, const D: usize, const AFFINE: bool>(
    w: &Weights<W>,
    i: usize,
    axis: usize,
) -> L {
    let [gradient, affine] = slope(w, i, axis);
    if AFFINE { pair::<L, D>(affine, gradient) } else { L::splat(gradient) }
}

/// Slope weights of a gather: the gradient of the velocity, the affine moment of its copy.
#[inline(always)]
fn gather_slope<L: Lanes, const W: usize, const D: usize, const AFFINE: bool>(
    w: &Weights<W>,
    i: usize,
    axis: usize,
) -> L {
    let [gradient, affine] = slope(w, i, axis);
    if AFFINE { pair::<L, D>(gradient, affine) } else { L::splat(gradient) }
}

/// First node of the support along an axis.
#[inline(always)]
fn first<const W: usize>(w: &Weights<W>, axis: usize) -> usize {
    // A particle beyond the slack is caught before a sweep; the clamp keeps a bug from reading elsewhere.
    (w.base[axis] as usize).min(TILE - W)
}

/// Scatters a value and slopes of one particle; returns the first node of its support.
#[inline(always)]
pub(crate) fn scatter<L: Lanes, const W: usize, const D: usize, const AFFINE: bool>(
    tile: &mut Tile,
    w: &Weights<W>,
    value: L,
    slopes: [L; D],
) -> [usize; 3] {
    let [i0, j0] = [first(w, 0), first(w, 1)];
    let xs: [L; W] = array(L::splat(0.0), |i| {
        scatter_slope::<L, W, D, AFFINE>(w, i, 0).mul_add(slopes[0], L::splat(w.n[i][0]).mul(value))
    });
    let ys: [L; W] = array(L::splat(0.0), |j| scatter_slope::<L, W, D, AFFINE>(w, j, 1).mul(slopes[1]));
    if D == 2 {
        scatter_plane(tile, w, &xs, &ys, tile_index(i0, j0, 0));
        return [i0, j0, 0];
    }
    let k0 = first(w, 2);
    for k in 0..W {
        let nz = L::splat(w.n[k][2]);
        let z = scatter_slope::<L, W, D, AFFINE>(w, k, 2).mul(slopes[D - 1]);
        let xs: [L; W] = array(nz, |i| xs[i].mul(nz));
        let ys: [L; W] = array(L::splat(0.0), |j| ys[j].mul_add(nz, z.mul(L::splat(w.n[j][1]))));
        scatter_plane(tile, w, &xs, &ys, tile_index(i0, j0, k0 + k));
    }
    [i0, j0, k0]
}

/// node(i, j) += N_j X_i + N_i Y_j.
#[inline(always)]
fn scatter_plane<L: Lanes, const W: usize>(tile: &mut Tile, w: &Weights<W>, xs: &[L; W], ys: &[L; W], base: usize) {
    // One bounds check for the whole support.
    let nodes = &mut tile[base..][..TILE * (W - 1) + W];
    for j in 0..W {
        let nj = L::splat(w.n[j][1]);
        for i in 0..W {
            let node = &mut nodes[TILE * j + i];
            let sum = nj.mul_add(xs[i], L::load(node));
            ys[j].mul_add(L::splat(w.n[i][0]), sum).store(node);
        }
    }
}

/// Gathers Σ N R of the records R around a particle.
#[inline(always)]
pub(crate) fn gather_value<L: Lanes, const W: usize, const D: usize>(tile: &Tile, w: &Weights<W>) -> L {
    let [i0, j0] = [first(w, 0), first(w, 1)];
    let k0 = if D == 3 { first(w, 2) } else { 0 };
    let mut sum = L::splat(0.0);
    for k in 0..if D == 3 { W } else { 1 } {
        let nodes = &tile[tile_index(i0, j0, k0 + k)..][..TILE * (W - 1) + W];
        let mut plane = L::splat(0.0);
        for j in 0..W {
            let mut row = L::splat(0.0);
            for i in 0..W {
                row = L::load(&nodes[TILE * j + i]).mul_add(L::splat(w.n[i][0]), row);
            }
            plane = row.mul_add(L::splat(w.n[j][1]), plane);
        }
        sum = if D == 3 { plane.mul_add(L::splat(w.n[k][2]), sum) } else { plane };
    }
    sum
}

/// Gathers Σ N R and, per axis, Σ K R (h times the gradient; affine moments where asked).
#[inline(always)]
pub(crate) fn gather<L: Lanes, const W: usize, const D: usize, const AFFINE: bool>(
    tile: &Tile,
    w: &Weights<W>,
) -> (L, [L; D]) {
    let [i0, j0] = [first(w, 0), first(w, 1)];
    let k0 = if D == 3 { first(w, 2) } else { 0 };
    let zero = L::splat(0.0);
    let kx: [L; W] = array(L::splat(0.0), |i| gather_slope::<L, W, D, AFFINE>(w, i, 0));
    let ky: [L; W] = array(L::splat(0.0), |j| gather_slope::<L, W, D, AFFINE>(w, j, 1));
    let (mut value, mut slopes) = (zero, [zero; D]);
    for k in 0..if D == 3 { W } else { 1 } {
        let nodes = &tile[tile_index(i0, j0, k0 + k)..][..TILE * (W - 1) + W];
        let (mut plane, mut plane_x, mut plane_y) = (zero, zero, zero);
        for j in 0..W {
            let (mut row, mut row_x) = (zero, zero);
            for i in 0..W {
                let node = L::load(&nodes[TILE * j + i]);
                row = node.mul_add(L::splat(w.n[i][0]), row);
                row_x = node.mul_add(kx[i], row_x);
            }
            let nj = L::splat(w.n[j][1]);
            plane = row.mul_add(nj, plane);
            plane_x = row_x.mul_add(nj, plane_x);
            plane_y = row.mul_add(ky[j], plane_y);
        }
        if D == 2 {
            (value, slopes[0], slopes[1]) = (plane, plane_x, plane_y);
        } else {
            let nk = L::splat(w.n[k][2]);
            value = plane.mul_add(nk, value);
            slopes[0] = plane_x.mul_add(nk, slopes[0]);
            slopes[1] = plane_y.mul_add(nk, slopes[1]);
            slopes[D - 1] = plane.mul_add(gather_slope::<L, W, D, AFFINE>(w, k, 2), slopes[D - 1]);
        }
    }
    (value, slopes)
}

/// Scatters a particle without shear stress: every lane of V N_i N_j N_k is a product, with h ∂N/∂x in place of
/// N for the force along that axis. One multiply–add per node.
#[inline(always)]
pub(crate) fn scatter_simple<L: Lanes, const W: usize, const D: usize>(
    tile: &mut Tile,
    w: &Weights<W>,
    value: L,
) -> [usize; 3] {
    let [i0, j0] = [first(w, 0), first(w, 1)];
    let xs: [L; W] = array(value, |i| force_lane::<L, D>(w.n[i][0], w.dn[i][0], 0));
    let ys: [L; W] = array(value, |j| force_lane::<L, D>(w.n[j][1], w.dn[j][1], 1));
    let k0 = if D == 3 { first(w, 2) } else { 0 };
    for k in 0..if D == 3 { W } else { 1 } {
        let plane = if D == 3 { force_lane::<L, D>(w.n[k][2], w.dn[k][2], 2).mul(value) } else { value };
        let nodes = &mut tile[tile_index(i0, j0, k0 + k)..][..TILE * (W - 1) + W];
        for j in 0..W {
            let row = ys[j].mul(plane);
            for i in 0..W {
                let node = &mut nodes[TILE * j + i];
                xs[i].mul_add(row, L::load(node)).store(node);
            }
        }
    }
    [i0, j0, k0]
}

/// N in all lanes, the slope in the force lane of `axis`.
#[inline(always)]
fn force_lane<L: Lanes, const D: usize>(n: f64, dn: f64, axis: usize) -> L {
    let (n, dn) = (L::splat(n), L::splat(dn));
    match 1 + D + axis {
        3 => n.with_lane::<3>(dn),
        4 => n.with_lane::<4>(dn),
        5 => n.with_lane::<5>(dn),
        _ => n.with_lane::<6>(dn),
    }
}

/// Lanes as numbers.
#[inline(always)]
pub(crate) fn numbers<L: Lanes>(lanes: L) -> [f64; 8] {
    let mut r = Record::default();
    lanes.store(&mut r);
    r.0
}

impl Extent {
    /// Nothing yet.
    pub const EMPTY: Self = Self { from: [usize::MAX; 3], to: [0; 3] };

    /// Grows to a support of `W` nodes per axis from `first`.
    #[inline(always)]
    pub fn include<const W: usize, const D: usize>(&mut self, first: [usize; 3]) {
        for (a, first) in first.into_iter().enumerate() {
            self.from[a] = self.from[a].min(first);
            self.to[a] = self.to[a].max(first + if a < D { W } else { 1 });
        }
    }
}
