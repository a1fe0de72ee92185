//! Fourth-order tensors that map a rate of strain to a stress rate, as 6 × 6 matrices (theory B.13).
//!
//! ```text
//! (a ⊗ b)_ijkl = a_ij b_kl,      (a ⊙ b)_ijkl = ¼ (a_ik b_jl + a_il b_jk + a_jk b_il + a_jl b_ik)
//! ```
//!
//! (a ⊙ a) : d = a d a, and 1 ⊙ 1 is the identity of symmetric tensors.

use crate::math::SymTensor;
use std::ops::{Add, Mul, Sub};

/// Components c_ijkl of a fourth-order tensor with both minor symmetries, c_ijkl = c_jikl = c_ijlk: rows ij and columns
/// kl in the order xx, yy, zz, xy, yz, zx of [`SymTensor`]. As a matrix it takes strains whose shears count twice
/// (engineering strains).
///
/// ```
/// use lateen::material::Stiffness;
/// use lateen::math::SymTensor;
///
/// let d = SymTensor([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
/// assert_eq!(Stiffness::identity().contract(&d), d);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffness(pub [[f64; 6]; 6]);

/// The two indices of a row.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

impl Stiffness {
    /// The dyad a ⊗ b.
    pub fn dyad(a: &SymTensor, b: &SymTensor) -> Self {
        Self(a.0.map(|a| b.0.map(|b| a * b)))
    }

    /// The symmetrised product a ⊙ b.
    pub fn product(a: &SymTensor, b: &SymTensor) -> Self {
        let (a, b) = (a.full(), b.full());
        Self(PAIRS.map(|[i, j]| {
            PAIRS.map(|[k, l]| 0.25 * (a[i][k] * b[j][l] + a[i][l] * b[j][k] + a[j][k] * b[i][l] + a[j][l] * b[i][k]))
        }))
    }

    /// The identity of symmetric tensors, 1 ⊙ 1.
    pub fn identity() -> Self {
        Self::product(&SymTensor::isotropic(1.0), &SymTensor::isotropic(1.0))
    }

    /// The dyad 1 ⊗ 1: its part in c is the bulk modulus.
    pub fn volumetric() -> Self {
        Self::dyad(&SymTensor::isotropic(1.0), &SymTensor::isotropic(1.0))
    }

    /// c : d.
    pub fn contract(&self, d: &SymTensor) -> SymTensor {
        let [xx, yy, zz, xy, yz, zx] = d.0;
        let d = [xx, yy, zz, 2.0 * xy, 2.0 * yz, 2.0 * zx];
        SymTensor(self.0.map(|row| row.iter().zip(&d).map(|(c, d)| c * d).sum()))
    }

    /// 1 : c, the slopes of the trace.
    pub fn trace(&self) -> SymTensor {
        let [x, y, z, ..] = self.0;
        SymTensor(std::array::from_fn(|kl| x[kl] + y[kl] + z[kl]))
    }
}

impl Add for Stiffness {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| std::array::from_fn(|j| self.0[i][j] + other.0[i][j])))
    }
}

impl Sub for Stiffness {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| std::array::from_fn(|j| self.0[i][j] - other.0[i][j])))
    }
}

impl Mul<f64> for Stiffness {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self(self.0.map(|row| row.map(|c| c * s)))
    }
}

#[cfg(test)]
mod tests {
    use super::Stiffness;
    use crate::math::SymTensor;

    /// (a ⊙ b) : d = ½ (a d b + b d a), and the dyad gives a (b : d).
    #[test]
    fn products_contract_as_tensors() {
        let a = SymTensor([1.2, 0.7, -0.4, 0.3, -0.2, 0.9]);
        let b = SymTensor([0.5, -1.1, 0.8, 0.2, 0.6, -0.3]);
        let d = SymTensor([-0.6, 0.4, 1.3, 0.1, -0.7, 0.25]);
        let (fa, fb, fd) = (a.full(), b.full(), d.full());
        let exact = (fa.dot(&fd).dot(&fb) + fb.dot(&fd).dot(&fa)).symmetric() * 0.5;
        let error = Stiffness::product(&a, &b).contract(&d) - exact;
        assert!(error.contract(&error).sqrt() < 1e-15);
        let error = Stiffness::dyad(&a, &b).contract(&d) - a * b.contract(&d);
        assert!(error.contract(&error).sqrt() < 1e-15);
        assert!((Stiffness::product(&a, &b).trace().contract(&d) - exact.trace()).abs() < 1e-15);
    }
}
