//! Eight numbers as a plain array.

use super::lanes::{Lanes, WIDTH};

/// Plain arrays, for machines without wide registers.
///
/// On x86-64 these are processors without AVX2, from before 2013 and the smallest of later ones; they need the feature
/// `portable`. There the operations are calls: inlined eight times over they made up half of the code of all kernels,
/// and most of the time to compile them.
#[derive(Clone, Copy)]
pub(crate) struct Portable([f64; WIDTH]);

impl Portable {
    #[inline(always)]
    fn with(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for k in 0..WIDTH {
            self.0[k] = f(self.0[k], other.0[k]);
        }
        self
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; WIDTH])
    }
    #[inline(always)]
    fn load(from: &[f64; WIDTH]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; WIDTH]) {
        *to = self.0;
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn mul(self, factor: Self) -> Self {
        self.with(factor, |a, b| a * b)
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn div(self, divisor: Self) -> Self {
        self.with(divisor, |a, b| a / b)
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self.mul(factor).add(addend)
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn max(self, other: Self) -> Self {
        self.with(other, |a, b| if a > b { a } else { b })
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn min(self, other: Self) -> Self {
        self.with(other, |a, b| if a < b { a } else { b })
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn floor(self) -> Self {
        self.with(self, |a, _| a.floor())
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn if_at_most(self, bound: Self, yes: Self, no: Self) -> Self {
        let mut chosen = no;
        for k in 0..WIDTH {
            if self.0[k] <= bound.0[k] {
                chosen.0[k] = yes.0[k];
            }
        }
        chosen
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn blend(mut self, other: Self, mask: u8) -> Self {
        for k in 0..WIDTH {
            if mask >> k & 1 == 1 {
                self.0[k] = other.0[k];
            }
        }
        self
    }
    #[inline(always)]
    fn pair(a: f64, b: f64) -> Self {
        Self([a, a, a, a, b, b, b, b])
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn halves(self, other: Self) -> [Self; 2] {
        let (mut first, mut last) = (self, other);
        for k in 0..WIDTH / 2 {
            first.0[WIDTH / 2 + k] = other.0[k];
            last.0[k] = self.0[WIDTH / 2 + k];
        }
        [first, last]
    }
    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn transpose(rows: [Self; WIDTH]) -> [Self; WIDTH] {
        let mut columns = rows;
        for (k, column) in columns.iter_mut().enumerate() {
            for i in 0..WIDTH {
                column.0[i] = rows[i].0[k];
            }
        }
        columns
    }
}
