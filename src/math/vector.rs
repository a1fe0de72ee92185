//! Vectors of two or three components.

use bytemuck::{Pod, Zeroable};
use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

/// A vector of `D` components.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(transparent)]
pub struct Vector<const D: usize>(pub [f64; D]);

// SAFETY: a transparent wrapper of an array of f64: no padding, every bit pattern is valid.
#[allow(unsafe_code)]
unsafe impl<const D: usize> Zeroable for Vector<D> {}
// SAFETY: as above.
#[allow(unsafe_code)]
unsafe impl<const D: usize> Pod for Vector<D> {}

impl<const D: usize> Vector<D> {
    /// The zero vector.
    pub const ZERO: Self = Self([0.0; D]);

    /// A vector of equal components.
    #[inline(always)]
    pub const fn splat(value: f64) -> Self {
        Self([value; D])
    }

    /// The `axis`-th unit vector.
    #[inline(always)]
    pub fn unit(axis: usize) -> Self {
        let mut v = Self::ZERO;
        v[axis] = 1.0;
        v
    }

    /// Component by component.
    #[inline(always)]
    pub fn map(mut self, mut f: impl FnMut(f64) -> f64) -> Self {
        for i in 0..D {
            self.0[i] = f(self.0[i]);
        }
        self
    }

    /// Component by component, from the axis number.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        // A loop: what `std::array::from_fn` is made of takes the compiler several times as long.
        let mut v = Self::ZERO;
        for i in 0..D {
            v.0[i] = f(i);
        }
        v
    }

    /// Inner product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f64 {
        let mut sum = 0.0;
        for i in 0..D {
            sum += self.0[i] * other.0[i];
        }
        sum
    }

    /// Euclidean length.
    #[inline(always)]
    pub fn norm(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Square of the Euclidean length.
    #[inline(always)]
    pub fn norm_squared(self) -> f64 {
        self.dot(self)
    }

    /// The unit vector of this direction, or `None` for a vector that has none.
    #[inline(always)]
    pub fn normalized(self) -> Option<Self> {
        let norm = self.norm();
        (norm > f64::MIN_POSITIVE && norm.is_finite()).then(|| self / norm)
    }

    /// True if no component is infinite or NaN.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|c| c.is_finite())
    }

    /// Padded with zeros (or cut) to three components, for outputs and laws.
    #[inline(always)]
    pub fn to3(self) -> [f64; 3] {
        std::array::from_fn(|i| if i < D { self.0[i] } else { 0.0 })
    }

    /// The first `D` of three components.
    #[inline(always)]
    pub fn from3(v: [f64; 3]) -> Self {
        Self(std::array::from_fn(|i| v[i]))
    }
}

impl Vector<3> {
    /// Cross product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        let a = self.0;
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }
}

impl<const D: usize> Default for Vector<D> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const D: usize> From<[f64; D]> for Vector<D> {
    fn from(components: [f64; D]) -> Self {
        Self(components)
    }
}

impl<const D: usize> Index<usize> for Vector<D> {
    type Output = f64;
    #[inline(always)]
    fn index(&self, i: usize) -> &f64 {
        &self.0[i]
    }
}

impl<const D: usize> IndexMut<usize> for Vector<D> {
    #[inline(always)]
    fn index_mut(&mut self, i: usize) -> &mut f64 {
        &mut self.0[i]
    }
}

macro_rules! componentwise {
    ($Op:ident, $op:ident, $Assign:ident, $assign:ident, $t:tt) => {
        impl<const D: usize> $Op for Vector<D> {
            type Output = Self;
            #[inline(always)]
            fn $op(mut self, other: Self) -> Self {
                for i in 0..D {
                    self.0[i] $t other.0[i];
                }
                self
            }
        }
        impl<const D: usize> $Assign for Vector<D> {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                for i in 0..D {
                    self.0[i] $t other.0[i];
                }
            }
        }
    };
}
componentwise!(Add, add, AddAssign, add_assign, +=);
componentwise!(Sub, sub, SubAssign, sub_assign, -=);

impl<const D: usize> Mul<f64> for Vector<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, s: f64) -> Self {
        for i in 0..D {
            self.0[i] *= s;
        }
        self
    }
}

impl<const D: usize> Mul<Vector<D>> for f64 {
    type Output = Vector<D>;
    #[inline(always)]
    fn mul(self, v: Vector<D>) -> Vector<D> {
        v * self
    }
}

impl<const D: usize> MulAssign<f64> for Vector<D> {
    #[inline(always)]
    fn mul_assign(&mut self, s: f64) {
        *self = *self * s;
    }
}

impl<const D: usize> Div<f64> for Vector<D> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, s: f64) -> Self {
        for i in 0..D {
            self.0[i] /= s;
        }
        self
    }
}

impl<const D: usize> Neg for Vector<D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|c| -c)
    }
}

impl<const D: usize> std::iter::Sum for Vector<D> {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::ZERO, |a, b| a + b)
    }
}
