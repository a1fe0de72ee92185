//! Eight particles at a time: columns of particles as lanes.

use crate::math::Vector;
use crate::math::simd::{Lanes, WIDTH};

/// Up to eight consecutive particles; lanes beyond the last repeat it.
#[derive(Clone, Copy)]
pub(crate) struct Group {
    first: usize,
    count: usize,
}

impl Group {
    /// The particles from `first` on, before `end`.
    #[inline(always)]
    pub fn new(first: usize, end: usize) -> Self {
        Self { first, count: (end - first).min(WIDTH) }
    }

    /// Number of particles.
    #[inline(always)]
    pub fn count(self) -> usize {
        self.count
    }

    /// A number of each particle.
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
            Some(all) if self.count == WIDTH => L::load(all),
            _ => self.each(|p| column[p]),
        }
    }

    /// A column of vectors, component by component.
    #[inline(always)]
    pub fn vectors<L: Lanes, const D: usize>(self, column: &[Vector<D>]) -> [L; D] {
        let numbers: &[[f64; D]] = bytemuck::cast_slice(column);
        match numbers[self.first..].first_chunk() {
            Some(all) if self.count == WIDTH => L::unzip(all),
            _ => {
                let mut lanes = [L::splat(0.0); D];
                for (axis, lane) in lanes.iter_mut().enumerate() {
                    *lane = self.each(|p| numbers[p][axis]);
                }
                lanes
            }
        }
    }
}
