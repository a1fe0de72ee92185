//! Eight particles at a time: columns of particles as lanes.

use crate::math::Vector;
use crate::math::simd::{Lanes, WIDTH};

/// Up to eight consecutive particles. Lanes beyond the last hold numbers of neighbours, or of the same.
#[derive(Clone, Copy)]
pub(crate) struct LaneGroup {
    first: usize,
    count: usize,
}

impl LaneGroup {
    /// `count` particles from `first` on, at most eight.
    #[inline(always)]
    pub fn new(first: usize, count: usize) -> Self {
        Self { first, count: count.min(WIDTH) }
    }

    /// A number of each particle; lanes beyond the last repeat it.
    #[inline(always)]
    pub fn each<L: Lanes>(self, number: impl Fn(usize) -> f64) -> L {
        let mut row = [0.0; WIDTH];
        for (k, entry) in row.iter_mut().enumerate() {
            *entry = number(self.first + k.min(self.count - 1));
        }
        L::load(&row)
    }

    /// A column of numbers.
    #[inline(always)]
    pub fn scalars<L: Lanes>(self, column: &[f64]) -> L {
        match column[self.first..].first_chunk() {
            Some(all) => L::load(all),
            None => self.each(|p| column[p]),
        }
    }

    /// A column of vectors, component by component.
    #[inline(always)]
    pub fn vectors<L: Lanes, const D: usize>(self, column: &[Vector<D>]) -> [L; D] {
        let numbers: &[[f64; D]] = bytemuck::cast_slice(column);
        match numbers[self.first..].first_chunk() {
            Some(all) => L::unzip(all),
            None => {
                let mut lanes = [L::splat(0.0); D];
                for (axis, lane) in lanes.iter_mut().enumerate() {
                    *lane = self.each(|p| numbers[p][axis]);
                }
                lanes
            }
        }
    }

    /// A column of `N` numbers per particle, number by number.
    #[inline(always)]
    pub fn numbers<L: Lanes, const N: usize>(self, column: &[[f64; N]]) -> [L; N] {
        let numbers = column.as_flattened();
        let mut rows = [L::splat(0.0); WIDTH];
        for (k, row) in rows.iter_mut().enumerate() {
            let first = (self.first + k.min(self.count - 1)) * N;
            *row = match numbers[first..].first_chunk() {
                Some(all) => L::load(all),
                None => {
                    let mut padded = [0.0; WIDTH];
                    let last = &numbers[first..];
                    padded[..last.len()].copy_from_slice(last);
                    L::load(&padded)
                }
            };
        }
        let columns = L::transpose(rows);
        let mut lanes = [L::splat(0.0); N];
        for (i, lane) in lanes.iter_mut().enumerate() {
            *lane = if i < WIDTH { columns[i] } else { self.each(|p| column[p][i]) };
        }
        lanes
    }
}
