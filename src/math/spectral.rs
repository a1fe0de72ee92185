//! Principal values and directions of symmetric tensors, and functions of these.
//!
//! ```text
//! T = Σ λ_i n_i ⊗ n_i      f(T) = Σ f(λ_i) n_i ⊗ n_i      F = R U,  U² = Fᵀ F
//! ```
//!
//! Jacobi rotations find the principal values also where they coincide (the closed trigonometric formula
//! loses half of the digits there); the rotation R comes from Newton's iteration (Higham 1986).

use super::{SymTensor, Tensor, Vector};

/// Principal values and directions of a symmetric tensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrum {
    /// Principal values, the largest first.
    pub values: [f64; 3],
    /// Principal directions in the same order, orthonormal.
    pub directions: [Vector<3>; 3],
}

impl Spectrum {
    /// The tensor of the same directions with `f` of each principal value (square root, logarithm, …).
    pub fn map(&self, f: impl Fn(f64) -> f64) -> SymTensor {
        self.values.iter().zip(&self.directions).fold(SymTensor::ZERO, |sum, (&value, n)| {
            let f = f(value);
            let [x, y, z] = n.0;
            sum + SymTensor([x * x, y * y, z * z, x * y, y * z, z * x]) * f
        })
    }
}

impl SymTensor {
    /// Principal values and directions.
    pub fn spectrum(&self) -> Spectrum {
        /// Cyclic Jacobi converges quadratically: five sweeps reach the last bit, the rest is margin.
        const SWEEPS: usize = 12;
        let mut a = self.full();
        let mut v = Tensor::identity();
        for _ in 0..SWEEPS {
            if a[0][1] == 0.0 && a[1][2] == 0.0 && a[2][0] == 0.0 {
                break;
            }
            for (p, q) in [(0, 1), (1, 2), (0, 2)] {
                jacobi(&mut a, &mut v, p, q);
            }
        }
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
        Spectrum { values: order.map(|i| a[i][i]), directions: order.map(|i| Vector::from_fn(|row| v[row][i])) }
    }
}

/// One Jacobi rotation that makes `a[p][q]` vanish, accumulated in the columns of `v`.
fn jacobi(a: &mut Tensor<3>, v: &mut Tensor<3>, p: usize, q: usize) {
    let off = a[p][q];
    // An entry too small to change either diagonal entry is zero: this ends the iteration.
    if off.abs() <= f64::EPSILON * 0.1 * (a[p][p].abs().min(a[q][q].abs())) || off.abs() < f64::MIN_POSITIVE {
        (a[p][q], a[q][p]) = (0.0, 0.0);
        return;
    }
    let theta = 0.5 * (a[q][q] - a[p][p]) / off;
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    let r = 3 - p - q;
    let (rp, rq) = (a[r][p], a[r][q]);
    a[p][p] -= t * off;
    a[q][q] += t * off;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    (a[r][p], a[r][q]) = (c * rp - s * rq, s * rp + c * rq);
    (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
    for row in 0..3 {
        let (vp, vq) = (v[row][p], v[row][q]);
        (v[row][p], v[row][q]) = (c * vp - s * vq, s * vp + c * vq);
    }
}

impl Tensor<3> {
    /// The polar decomposition F = R U into a rotation and a stretch; `None` where det F ≤ 0.
    pub fn polar(&self) -> Option<(Self, SymTensor)> {
        /// Scaled Newton halves the error's exponent per iteration: ten serve condition numbers of 10¹⁵.
        const ITERATIONS: usize = 20;
        if self.determinant() <= 0.0 {
            return None;
        }
        let mut r = *self;
        for _ in 0..ITERATIONS {
            let inverse = r.inverse()?.transpose();
            let scale = (inverse.contract(&inverse) / r.contract(&r)).powf(0.25);
            let next = (r * scale + inverse * (1.0 / scale)) * 0.5;
            let change = next - r;
            r = next;
            if change.contract(&change) < 1e-30 {
                break;
            }
        }
        Some((r, r.transpose().dot(self).symmetric()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn full_of(matrix: &nalgebra::Matrix3<f64>) -> Tensor<3> {
        Tensor::from_fn(|i, j| matrix[(i, j)])
    }

    proptest! {
        #[test]
        fn spectrum_agrees_with_nalgebra(c in prop::array::uniform6(-10.0f64..10.0), scale in -9i32..9) {
            let t = SymTensor(c.map(|x| x * 10f64.powi(scale)));
            let size = t.contract(&t).sqrt();
            let spectrum = t.spectrum();
            let matrix = nalgebra::Matrix3::from_fn(|i, j| t.full()[i][j]);
            let mut reference: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
            reference.sort_by(|a, b| b.total_cmp(a));
            for (ours, theirs) in spectrum.values.iter().zip(&reference) {
                prop_assert!((ours - theirs).abs() <= 1e-13 * size);
            }
            let back = spectrum.map(|x| x) - t;
            prop_assert!(back.contract(&back).sqrt() <= 1e-14 * size);
        }

        #[test]
        fn polar_agrees_with_singular_values(c in prop::array::uniform9(-1.0f64..1.0)) {
            let matrix = nalgebra::Matrix3::from_row_slice(&c);
            prop_assume!(matrix.determinant() > 1e-3);
            let svd = matrix.svd(true, true);
            let rotation = full_of(&(svd.u.unwrap() * svd.v_t.unwrap()));
            let (r, u) = full_of(&matrix).polar().unwrap();
            prop_assert!((r - rotation).contract(&(r - rotation)).sqrt() < 1e-12);
            let back = r.dot(&u.full()) - full_of(&matrix);
            prop_assert!(back.contract(&back).sqrt() < 1e-13);
        }
    }

    #[test]
    fn coinciding_values_keep_all_digits() {
        let q = full_of(nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).matrix());
        let t = SymTensor([2.0, 2.0, 2.0 + 1e-9, 0.0, 0.0, 0.0]).rotated(&q);
        let values = t.spectrum().values;
        assert!((values[0] - 2.0 - 1e-9).abs() < 2e-15 && (values[2] - 2.0).abs() < 2e-15, "{values:?}");
        assert_eq!(SymTensor::ZERO.spectrum().values, [0.0; 3]);
    }

    #[test]
    fn functions_of_tensors() {
        let t = SymTensor([3.0, 2.0, 1.5, 0.4, -0.3, 0.2]);
        let root = t.spectrum().map(f64::sqrt);
        let difference = root.full().dot(&root.full()).symmetric() - t;
        assert!(difference.contract(&difference).sqrt() < 1e-14);
        let back = t.spectrum().map(f64::ln).spectrum().map(f64::exp) - t;
        assert!(back.contract(&back).sqrt() < 1e-14);
    }

    #[test]
    fn inverted_tensors_have_no_rotation() {
        assert_eq!((Tensor::<3>::identity() * -1.0).polar(), None);
    }
}
