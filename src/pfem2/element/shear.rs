//! The shear rate of an element, on which viscosity may depend (theory F.8).

use crate::math::{Tensor, Vector};

/// γ̇ = √(2 d:d) [1/s] of an element with these gradients of shape functions and nodal velocities.
pub fn shear_rate<const D: usize, const N: usize>(gradient: &[Vector<D>; N], velocity: &[Vector<D>; N]) -> f64 {
    let mut l = Tensor::<D>::ZERO;
    for (g, v) in gradient.iter().zip(velocity) {
        for i in 0..D {
            for j in 0..D {
                l.0[i][j] += v[i] * g[j];
            }
        }
    }
    // d = sym ∇v
    let d = Tensor::<D>::from_fn(|i, j| 0.5 * (l[i][j] + l[j][i]));
    (2.0 * d.contract(&d)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shear_rate_of_simple_shear_is_exact() {
        let gradient = [Vector([-1.0, -1.0]), Vector([1.0, 0.0]), Vector([0.0, 1.0])];
        // v = (3 y, 0)
        let velocity = [Vector([0.0, 0.0]), Vector([0.0, 0.0]), Vector([3.0, 0.0])];
        assert!((shear_rate(&gradient, &velocity) - 3.0).abs() < 1e-15);
    }
}
