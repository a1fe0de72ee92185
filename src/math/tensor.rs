//! Second-order tensors: general (`Tensor`) and symmetric in three dimensions (`SymTensor`).

use super::Vector;
use bytemuck::{Pod, Zeroable};
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

/// A `D` × `D` tensor, row by row: `t[i][j]` is row `i`, column `j`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(transparent)]
pub struct Tensor<const D: usize>(pub [[f64; D]; D]);

// SAFETY: a transparent wrapper of arrays of f64: no padding, every bit pattern is valid.
#[allow(unsafe_code)]
unsafe impl<const D: usize> Zeroable for Tensor<D> {}
// SAFETY: as above.
#[allow(unsafe_code)]
unsafe impl<const D: usize> Pod for Tensor<D> {}

impl<const D: usize> Tensor<D> {
    /// The zero tensor.
    pub const ZERO: Self = Self([[0.0; D]; D]);

    /// The identity.
    #[inline(always)]
    pub fn identity() -> Self {
        Self::from_fn(|i, j| if i == j { 1.0 } else { 0.0 })
    }

    /// Component by component.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize, usize) -> f64) -> Self {
        let mut t = Self::ZERO;
        for i in 0..D {
            for j in 0..D {
                t.0[i][j] = f(i, j);
            }
        }
        t
    }

    /// The dyad a ⊗ b.
    #[inline(always)]
    pub fn outer(a: Vector<D>, b: Vector<D>) -> Self {
        Self::from_fn(|i, j| a[i] * b[j])
    }

    /// Sum of the diagonal.
    #[inline(always)]
    pub fn trace(&self) -> f64 {
        let mut sum = 0.0;
        for i in 0..D {
            sum += self.0[i][i];
        }
        sum
    }

    /// Rows and columns exchanged.
    #[inline(always)]
    pub fn transpose(&self) -> Self {
        Self::from_fn(|i, j| self.0[j][i])
    }

    /// The skew-symmetric part ½(T − Tᵀ); of a velocity gradient, the spin Ω.
    #[inline(always)]
    pub fn skew(&self) -> Self {
        Self::from_fn(|i, j| 0.5 * (self.0[i][j] - self.0[j][i]))
    }

    /// Tensor product, self · other.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> Self {
        // Plain loops: iterator sums are not inlined here.
        let mut product = Self::ZERO;
        for i in 0..D {
            for j in 0..D {
                for k in 0..D {
                    product.0[i][j] += self.0[i][k] * other.0[k][j];
                }
            }
        }
        product
    }

    /// Double contraction, self : other.
    #[inline(always)]
    pub fn contract(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for i in 0..D {
            for j in 0..D {
                sum += self.0[i][j] * other.0[i][j];
            }
        }
        sum
    }

    /// self · v.
    #[inline(always)]
    pub fn apply(&self, v: Vector<D>) -> Vector<D> {
        let mut product = Vector::ZERO;
        for i in 0..D {
            for j in 0..D {
                product[i] += self.0[i][j] * v[j];
            }
        }
        product
    }

    /// Embedded in three dimensions, with `diagonal` in the missing diagonal places
    /// (0 for a velocity gradient, 1 for a deformation gradient: plane strain).
    #[inline(always)]
    pub fn embed(&self, diagonal: f64) -> Tensor<3> {
        Tensor::<3>::from_fn(|i, j| {
            if i < D && j < D {
                self.0[i][j]
            } else if i == j {
                diagonal
            } else {
                0.0
            }
        })
    }
}

impl Tensor<3> {
    /// The determinant.
    #[inline(always)]
    pub fn determinant(&self) -> f64 {
        let [a, b, c] = self.0;
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    }

    /// The inverse, or `None` when the determinant is zero or not finite.
    #[inline(always)]
    pub fn inverse(&self) -> Option<Self> {
        let det = self.determinant();
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let m = &self.0;
        let cofactor = |i: usize, j: usize| {
            let (r, s) = ((i + 1) % 3, (i + 2) % 3);
            let (p, q) = ((j + 1) % 3, (j + 2) % 3);
            m[r][p] * m[s][q] - m[r][q] * m[s][p]
        };
        Some(Self::from_fn(|i, j| cofactor(j, i) / det))
    }

    /// The symmetric part ½(T + Tᵀ).
    #[inline(always)]
    pub fn symmetric(&self) -> SymTensor {
        let t = &self.0;
        SymTensor([
            t[0][0],
            t[1][1],
            t[2][2],
            0.5 * (t[0][1] + t[1][0]),
            0.5 * (t[1][2] + t[2][1]),
            0.5 * (t[2][0] + t[0][2]),
        ])
    }
}

impl<const D: usize> Default for Tensor<D> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const D: usize> Index<usize> for Tensor<D> {
    type Output = [f64; D];
    #[inline(always)]
    fn index(&self, row: usize) -> &[f64; D] {
        &self.0[row]
    }
}

impl<const D: usize> IndexMut<usize> for Tensor<D> {
    #[inline(always)]
    fn index_mut(&mut self, row: usize) -> &mut [f64; D] {
        &mut self.0[row]
    }
}

impl<const D: usize> Add for Tensor<D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::from_fn(|i, j| self.0[i][j] + other.0[i][j])
    }
}

impl<const D: usize> AddAssign for Tensor<D> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const D: usize> std::iter::Sum for Tensor<D> {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::ZERO, |a, b| a + b)
    }
}

impl<const D: usize> Sub for Tensor<D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::from_fn(|i, j| self.0[i][j] - other.0[i][j])
    }
}

impl<const D: usize> Mul<f64> for Tensor<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f64) -> Self {
        Self::from_fn(|i, j| self.0[i][j] * s)
    }
}

impl<const D: usize> Neg for Tensor<D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}

/// A symmetric 3 × 3 tensor: `[xx, yy, zz, xy, yz, zx]`.
///
/// ```
/// use lateen::math::SymTensor;
///
/// let uniaxial = SymTensor([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// assert_eq!(uniaxial.deviator(), SymTensor([2.0, -1.0, -1.0, 0.0, 0.0, 0.0]));
/// assert!((uniaxial.von_mises() - 3.0).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct SymTensor(pub [f64; 6]);

impl SymTensor {
    /// The zero tensor.
    pub const ZERO: Self = Self([0.0; 6]);

    /// `value` times the identity.
    #[inline(always)]
    pub const fn isotropic(value: f64) -> Self {
        Self([value, value, value, 0.0, 0.0, 0.0])
    }

    /// Sum of the diagonal.
    #[inline(always)]
    pub fn trace(&self) -> f64 {
        self.0[0] + self.0[1] + self.0[2]
    }

    /// The deviator, T − ⅓ tr T 1.
    #[inline(always)]
    pub fn deviator(&self) -> Self {
        *self - Self::isotropic(self.trace() / 3.0)
    }

    /// Double contraction (off-diagonal terms count twice).
    #[inline(always)]
    pub fn contract(&self, other: &Self) -> f64 {
        let (a, b) = (&self.0, &other.0);
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
    }

    /// The determinant.
    #[inline(always)]
    pub fn determinant(&self) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx)
    }

    /// Von Mises' equivalent of a stress, √(3/2 s:s) of its deviator s.
    #[inline(always)]
    pub fn von_mises(&self) -> f64 {
        let s = self.deviator();
        (1.5 * s.contract(&s)).sqrt()
    }

    /// The same tensor with all nine components.
    #[inline(always)]
    pub fn full(&self) -> Tensor<3> {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        Tensor([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    }

    /// Q · T · Qᵀ.
    #[inline(always)]
    pub fn rotated(&self, q: &Tensor<3>) -> Self {
        q.dot(&self.full()).dot(&q.transpose()).symmetric()
    }
}

impl Add for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl AddAssign for SymTensor {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl SubAssign for SymTensor {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Mul<f64> for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f64) -> Self {
        Self(self.0.map(|c| c * s))
    }
}

impl Neg for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix(t: &Tensor<3>) -> nalgebra::Matrix3<f64> {
        nalgebra::Matrix3::from_fn(|i, j| t[i][j])
    }

    fn tensors() -> impl Strategy<Value = Tensor<3>> {
        prop::array::uniform3(prop::array::uniform3(-2.0f64..2.0)).prop_map(Tensor)
    }

    proptest! {
        #[test]
        fn algebra_agrees_with_nalgebra(a in tensors(), b in tensors()) {
            let (ma, mb) = (matrix(&a), matrix(&b));
            prop_assert!((matrix(&a.dot(&b)) - ma * mb).norm() < 1e-13);
            prop_assert!((matrix(&a.transpose()) - ma.transpose()).norm() == 0.0);
            prop_assert!((a.contract(&b) - ma.dot(&mb)).abs() < 1e-13);
            prop_assert!((a.determinant() - ma.determinant()).abs() < 1e-12);
            prop_assert!((matrix(&(a.symmetric().full() + a.skew())) - ma).norm() < 1e-14);
            prop_assume!(ma.determinant().abs() > 1e-2);
            prop_assert!((matrix(&a.inverse().unwrap()) - ma.try_inverse().unwrap()).norm() < 1e-9);
        }

        #[test]
        fn symmetric_algebra_agrees_with_full(a in tensors(), b in tensors()) {
            let (s, t) = (a.symmetric(), b.symmetric());
            prop_assert!((s.contract(&t) - s.full().contract(&t.full())).abs() < 1e-13);
            prop_assert!((s.determinant() - s.full().determinant()).abs() < 1e-13);
            let rotated = matrix(&b) * matrix(&s.full()) * matrix(&b).transpose();
            prop_assert!((matrix(&s.rotated(&b).full()) - rotated).norm() < 1e-12);
        }
    }

    #[test]
    fn von_mises_of_simple_states() {
        assert!((SymTensor([5.0, 0.0, 0.0, 0.0, 0.0, 0.0]).von_mises() - 5.0).abs() < 1e-15);
        assert!((SymTensor([0.0, 0.0, 0.0, 2.0, 0.0, 0.0]).von_mises() - 2.0 * 3f64.sqrt()).abs() < 1e-15);
        assert_eq!(SymTensor::isotropic(7.0).von_mises(), 0.0);
    }

    #[test]
    fn a_plane_tensor_is_embedded() {
        let f = Tensor::<2>([[1.0, 2.0], [3.0, 4.0]]).embed(1.0);
        assert_eq!(f, Tensor([[1.0, 2.0, 0.0], [3.0, 4.0, 0.0], [0.0, 0.0, 1.0]]));
        assert_eq!(Tensor::<3>::ZERO.inverse(), None);
    }
}
