//! St. Venant–Kirchhoff solid: Hooke's law between Green's strain and the second Piola–Kirchhoff stress (theory B.9).
//!
//! ```text
//! S = λ tr E 1 + 2 G E,   E = ½ (Fᵀ F − 1),      J σ = τ = (½ λ (I1 − 3) − G) b + G b²,   b = F Fᵀ,  I1 = tr b
//! W = ½ λ tr² E + G E : E,      J c = λ b ⊗ b + 2 G b ⊙ b
//! ```

use super::elastic::{Elastic, Moduli};
use super::hyperelastic::{Hyperelastic, left_cauchy_green, principal_bounds, square};
use super::increment::Response;
use super::stiffness::Stiffness;
use crate::math::{SymTensor, Tensor};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elastic solid of large rotations and moderate strains. Not for compression by more than a tenth: it is unstable
/// there, under pressure from all sides below the stretch √((1 + ν)/(2 − ν)), in uniaxial strain below 1/√3, and a
/// stress at the start beyond that is refused.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct StVenantKirchhoff {
    /// Density, Young's modulus, Poisson's ratio, artificial bulk viscosity.
    #[serde(flatten)]
    pub elastic: Elastic,
}

impl Hyperelastic for StVenantKirchhoff {
    const NAME: &'static str = "St. Venant–Kirchhoff";

    #[inline(always)]
    fn elastic(&self) -> Elastic {
        self.elastic
    }

    fn stored_energy(&self, deformation: &Tensor<3>) -> f64 {
        let moduli = self.elastic.moduli();
        let strain = (deformation.transpose().dot(deformation).symmetric() - SymTensor::isotropic(1.0)) * 0.5;
        0.5 * moduli.lame() * strain.trace().powi(2) + moduli.shear * strain.contract(&strain)
    }

    /// For a wave along n with y = n·bn, J ρ c² is at most (λ + G) |bn|² + G B y + n·τn with the largest principal
    /// value B of b; since |bn|² ≤ B y that is at most y [(λ + 3 G) B + ½ λ (I1 − 3) − G], and the largest for y = B.
    #[inline(always)]
    fn stress(&self, deformation: &Tensor<3>) -> Response {
        let moduli = self.elastic.moduli();
        let Moduli { shear, .. } = moduli;
        let lame = moduli.lame();
        let per_j = 1.0 / deformation.determinant();
        let b = left_cauchy_green(deformation);
        let linear = 0.5 * lame * (b.trace() - 3.0) - shear;
        let stress = (b * linear + square(&b) * shear) * per_j;
        let [_, largest] = principal_bounds(&b);
        let modulus = largest * ((lame + 3.0 * shear) * largest + linear);
        Response { stress, modulus: modulus.max(shear) * per_j }
    }

    fn tangent(&self, deformation: &Tensor<3>) -> Stiffness {
        let moduli = self.elastic.moduli();
        let b = left_cauchy_green(deformation);
        let kirchhoff = Stiffness::dyad(&b, &b) * moduli.lame() + Stiffness::product(&b, &b) * (2.0 * moduli.shear);
        kirchhoff * (1.0 / deformation.determinant())
    }
}

#[cfg(test)]
mod tests {
    use super::StVenantKirchhoff;
    use crate::material::elastic::Elastic;
    use crate::material::hyperelastic::{Hyperelastic, principal_waves};
    use crate::material::testing::check_law;
    use crate::material::testing::elastic::{check_hyperelastic, diagonal, simple_shear};
    use crate::material::{ElasticLaw, PointLaw, StartState};
    use crate::math::{SymTensor, Tensor};

    const YOUNG: f64 = 1e6;
    const POISSON: f64 = 0.3;

    fn solid() -> StVenantKirchhoff {
        StVenantKirchhoff { elastic: Elastic::new(1100.0, YOUNG, POISSON) }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&solid(), StartState::default());
        check_hyperelastic(&solid());
        for stress in [[1e5, -5e4, 3e4, 2e4, -1e4, 4e4], [-5e4, -5e4, -5e4, 0.0, 0.0, 0.0]] {
            check_law(&solid(), StartState { stress: Some(SymTensor(stress)), ..StartState::default() });
        }
    }

    /// A bar: E_yy = −ν E_xx and σ = E_Y E_xx λ/λ_y², the force per reference area ½ E_Y (λ³ − λ).
    #[test]
    fn a_bar_has_the_force_of_the_cubic() {
        for stretch in [0.8_f64, 1.1, 1.6] {
            let across = (1.0 - POISSON * (stretch * stretch - 1.0)).sqrt();
            let [xx, yy, zz, ..] = solid().stress(&diagonal([stretch, across, across])).stress.0;
            let force = xx * across * across;
            assert!((force / (0.5 * YOUNG * (stretch.powi(3) - stretch)) - 1.0).abs() < 1e-12);
            assert!(yy.abs() + zz.abs() < 1e-9 * YOUNG);
        }
    }

    /// A sheet stretched evenly: S = E_Y E/(1 − ν), E_zz = −2 ν E/(1 − ν), σ = S/λ_z.
    #[test]
    fn a_sheet_stretched_evenly() {
        for stretch in [0.9_f64, 1.2, 1.4] {
            let strain = 0.5 * (stretch * stretch - 1.0);
            let thickness = (1.0 - 4.0 * POISSON / (1.0 - POISSON) * strain).sqrt();
            let found = solid().thickness_stretch(&Tensor([[stretch, 0.0], [0.0, stretch]])).unwrap();
            assert!((found - thickness).abs() < 1e-13, "{found} {thickness}");
            let [xx, yy, zz, ..] = solid().stress(&diagonal([stretch, stretch, thickness])).stress.0;
            assert!((xx / (YOUNG * strain / (1.0 - POISSON) / thickness) - 1.0).abs() < 1e-12);
            assert!((xx - yy).abs() + zz.abs() < 1e-9 * YOUNG);
        }
    }

    /// S = λ γ²/2 1 + 2 G E with E_xy = γ/2, E_yy = γ²/2, and σ = F S Fᵀ since J = 1.
    #[test]
    fn simple_shear_stiffens_with_the_cube() {
        let (moduli, shear) = (solid().elastic.moduli(), 0.7_f64);
        let (g, l) = (moduli.shear, moduli.lame());
        let [xx, yy, zz, xy, ..] = solid().stress(&simple_shear(shear)).stress.0;
        assert!((xy - g * shear - (0.5 * l + g) * shear.powi(3)).abs() < 1e-9 * g);
        assert!((yy - (0.5 * l + g) * shear.powi(2)).abs() < 1e-9 * g);
        assert!((zz - 0.5 * l * shear.powi(2)).abs() < 1e-9 * g);
        assert!((xx - (0.5 * l + 2.0 * g) * shear.powi(2) - (0.5 * l + g) * shear.powi(4)).abs() < 1e-9 * g);
    }

    /// The force ½ (λ + 2 G)(Λ³ − Λ) of uniaxial strain has its extremum at the stretch 1/√3.
    #[test]
    fn uniaxial_strain_is_unstable_below_one_over_the_root_of_three() {
        let along = |stretch: f64| principal_waves(&solid(), &diagonal([1.0, 1.0, stretch]))[2][2];
        changes_sign_at(3f64.sqrt().recip(), along);
    }

    /// Shear waves are lost sooner: G + (½ λ + G)(Λ² − 1) = 0 in uniaxial strain, G + (3/2 λ + 2 G)(Λ² − 1) = 0 in even
    /// compression.
    #[test]
    fn shear_is_unstable_sooner() {
        let uniaxial = |stretch: f64| principal_waves(&solid(), &diagonal([1.0, 1.0, stretch]))[2][0];
        changes_sign_at((POISSON / (1.0 - POISSON)).sqrt(), uniaxial);
        let even = |stretch: f64| principal_waves(&solid(), &(Tensor::identity() * stretch))[2][0];
        changes_sign_at(((1.0 + POISSON) / (2.0 - POISSON)).sqrt(), even);
    }

    fn changes_sign_at(limit: f64, modulus: impl Fn(f64) -> f64) {
        assert!(modulus(limit).abs() < 1e-9 * YOUNG, "{}", modulus(limit));
        assert!(modulus(limit + 1e-3) > 0.0 && modulus(limit - 1e-3) < 0.0);
    }

    #[test]
    fn an_unstable_start_is_refused() {
        let start = |stretch: f64| {
            let stress = solid().stress(&(Tensor::identity() * stretch)).stress;
            solid().initial(&StartState { stress: Some(stress), ..StartState::default() })
        };
        let error = start(0.87).unwrap_err();
        assert!(error.contains("unstable") && error.contains("0.870") && error.contains("`neo-hookean`"), "{error}");
        assert!((start(0.88).unwrap().deformation[0][0] - 0.88).abs() < 1e-12);
    }
}
