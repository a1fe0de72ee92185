//! Increments of rotation and deformation from the velocity gradient.
//!
//! L is the gradient over the positions at the start of the increment, so that 1 + Δt L is the motion itself.
//! Rates are taken over the positions in the middle: then a rotation of any size is without strain (Hughes &
//! Winget 1980; theory B.2).
//!
//! ```text
//! f = 1 + Δt L,      F^{n+1} = f Fⁿ
//! L½ = L (1 + ½ Δt L)⁻¹,      D = ½ (L½ + L½ᵀ),      Ω = ½ (L½ − L½ᵀ)
//! Q = (1 − ½ Δt Ω)⁻¹ (1 + ½ Δt Ω)
//! ```
//!
//! The spin has the sign that turns a stress with the body: σ̇ = Ω σ − σ Ω for a rigid rotation. Lian (22, 24)
//! and Lian (63) turn it the other way (theory B.15).

use crate::math::{Tensor, Vector};

/// The velocity gradient L½ over the positions in the middle of the increment. Not a number where the
/// increment is so large that it turns the material inside out.
#[inline(always)]
pub fn midpoint(gradient: &Tensor<3>, dt: f64) -> Tensor<3> {
    match (Tensor::identity() + *gradient * (0.5 * dt)).inverse() {
        Some(inverse) => gradient.dot(&inverse),
        None => Tensor::identity() * f64::NAN,
    }
}

/// The rotation Q of an increment, from the gradient in its middle.
#[inline(always)]
pub fn rotation(gradient: &Tensor<3>, dt: f64) -> Tensor<3> {
    // Ω of Lian (24), Lian (63). A skew A = ½ΔtΩ = [a]× obeys (1 − A)⁻¹(1 + A) = 1 + 2(A + A²)/(1 + a·a).
    let a = gradient.skew() * (0.5 * dt);
    let axis = Vector([a[2][1], a[0][2], a[1][0]]);
    Tensor::identity() + (a + a.dot(&a)) * (2.0 / (1.0 + axis.norm_squared()))
}

/// The deformation gradient f of an increment, scaled so that det f is `volume_ratio`: the
/// volume follows the solver's cure of locking (F̄), the shape follows L.
#[inline(always)]
pub fn deformation(gradient: &Tensor<3>, dt: f64, volume_ratio: f64) -> Tensor<3> {
    let f = Tensor::identity() + *gradient * dt;
    f * cube_root(volume_ratio / f.determinant())
}

/// Distance of a ratio from one within which its cube root is that of the series: that of an increment is.
const LARGEST_SERIES_ARGUMENT: f64 = 0.05;

/// ∛r, for a ratio that is nearly always close to one: the third-order series, whose error of (10/243) (r − 1)⁴
/// Halley's step cubes, to far below rounding. A general cube root takes a tenth of the step of an elastic solid.
#[inline(always)]
fn cube_root(r: f64) -> f64 {
    let e = r - 1.0;
    if e.abs() < LARGEST_SERIES_ARGUMENT {
        let y = 1.0 + e * (1.0 / 3.0 - e * (1.0 / 9.0 - e * (5.0 / 81.0)));
        let cube = y * y * y;
        y * (cube + 2.0 * r) / (2.0 * cube + r)
    } else {
        r.cbrt()
    }
}

#[cfg(test)]
mod tests {
    use super::{LARGEST_SERIES_ARGUMENT, cube_root, deformation, midpoint, rotation};
    use crate::math::{SymTensor, Tensor};

    fn spin(angle: f64) -> Tensor<3> {
        Tensor([[0.0, -angle, 0.0], [angle, 0.0, 0.0], [0.0, 0.0, 0.0]])
    }

    #[test]
    fn cube_roots_near_one_are_those_of_the_library() {
        assert_eq!(cube_root(1.0), 1.0);
        for k in -2000..=2000 {
            let r = 1.0 + 1.5 * LARGEST_SERIES_ARGUMENT * f64::from(k) / 2000.0;
            let (found, exact) = (cube_root(r), r.cbrt());
            assert!((found - exact).abs() <= 4.0 * f64::EPSILON, "{r}: {found} instead of {exact}");
        }
        assert!(cube_root(f64::NAN).is_nan() && cube_root(-1.0) == -1.0);
    }

    #[test]
    fn a_spin_about_z_turns_a_stress_with_the_body() {
        let q = rotation(&spin(1.0), 1e-3);
        let stress = SymTensor([5.0, 0.0, 0.0, 0.0, 0.0, 0.0]).rotated(&q);
        assert!((stress.0[3] / (5.0 * 1e-3) - 1.0).abs() < 1e-5, "σ12 = +ω σ1 Δt, not {}", stress.0[3]);
    }

    #[test]
    fn rotations_are_orthogonal_at_any_angle() {
        let gradient = Tensor([[0.3, -2.0, 0.7], [1.0, 0.1, 4.0], [-0.2, 0.5, -0.9]]);
        let q = rotation(&gradient, 0.8);
        let error = q.dot(&q.transpose()) - Tensor::identity();
        assert!(error.contract(&error).sqrt() < 1e-15);
        assert!((q.determinant() - 1.0).abs() < 1e-15);
        let turning = (q - Tensor::identity()) * (1.0 / 0.8);
        let middle = midpoint(&turning, 0.8);
        let strain = middle.symmetric();
        assert!(strain.contract(&strain).sqrt() < 1e-15, "a rotation is no strain");
        let again = rotation(&middle, 0.8);
        assert!((again - q).contract(&(again - q)).sqrt() < 1e-15);
    }

    #[test]
    fn the_volume_follows_the_solver() {
        let f = deformation(&Tensor([[0.3, -2.0, 0.7], [1.0, 0.1, 4.0], [-0.2, 0.5, -0.9]]), 0.1, 0.93);
        assert!((f.determinant() - 0.93).abs() < 1e-15);
    }
}
