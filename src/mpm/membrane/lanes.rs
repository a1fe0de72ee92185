//! Eight numbers at a time: the element kernels treat one element per lane.
//!
//! Every operation is a plain loop over the lanes, which the compiler turns into whatever vector
//! instructions the surrounding function may use. No operation is fused or reordered, so that the result
//! doesn't depend on the machine.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Elements per block: as many as a sheet law treats in one call.
pub use crate::material::LANES;

/// One number of each of the [`LANES`] elements of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(transparent)]
pub struct ElementLanes(pub [f64; LANES]);

impl ElementLanes {
    /// The same value in every lane.
    #[inline(always)]
    pub const fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// Lane by lane.
    #[inline(always)]
    pub fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for k in 0..LANES {
            self.0[k] = f(self.0[k]);
        }
        self
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// The greater of the value and `bound`.
    #[inline(always)]
    pub fn max(self, bound: f64) -> Self {
        self.map(|a| if a > bound { a } else { bound })
    }

    /// Sum of the first `count` lanes, in order.
    #[inline(always)]
    pub fn sum(self, count: usize) -> f64 {
        self.0[..count].iter().sum()
    }
}

macro_rules! lane_by_lane {
    ($Op:ident, $op:ident, $t:tt, $assign:tt) => {
        impl $Op for ElementLanes {
            type Output = Self;
            #[inline(always)]
            fn $op(mut self, other: Self) -> Self {
                for k in 0..LANES {
                    self.0[k] $assign other.0[k];
                }
                self
            }
        }
        impl $Op<f64> for ElementLanes {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: f64) -> Self {
                self.map(|a| a $t other)
            }
        }
    };
}
lane_by_lane!(Add, add, +, +=);
lane_by_lane!(Sub, sub, -, -=);
lane_by_lane!(Mul, mul, *, *=);
lane_by_lane!(Div, div, /, /=);

impl Neg for ElementLanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

/// A spatial vector of each element of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneVector(pub [ElementLanes; 3]);

impl LaneVector {
    /// The zero vector.
    pub const ZERO: Self = Self([ElementLanes::splat(0.0); 3]);

    /// Inner product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> ElementLanes {
        self.0[0] * b.0[0] + self.0[1] * b.0[1] + self.0[2] * b.0[2]
    }

    /// Cross product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        let [[a0, a1, a2], [b0, b1, b2]] = [self.0, b.0];
        Self([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])
    }
}

impl Add for LaneVector {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self([self.0[0] + b.0[0], self.0[1] + b.0[1], self.0[2] + b.0[2]])
    }
}

impl Sub for LaneVector {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self([self.0[0] - b.0[0], self.0[1] - b.0[1], self.0[2] - b.0[2]])
    }
}

impl AddAssign for LaneVector {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl Neg for LaneVector {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1], -self.0[2]])
    }
}

impl Mul<ElementLanes> for LaneVector {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: ElementLanes) -> Self {
        Self([self.0[0] * s, self.0[1] * s, self.0[2] * s])
    }
}

impl Mul<f64> for LaneVector {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f64) -> Self {
        Self([self.0[0] * s, self.0[1] * s, self.0[2] * s])
    }
}
