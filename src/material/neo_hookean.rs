//! Compressible neo-Hookean solid (theory B.9).
//!
//! ```text
//! W = ½ G (tr b − 3) − G ln J + ½ λ ln² J,      J σ = τ = G (b − 1) + λ ln J 1,      b = F Fᵀ
//! ```

use super::elastic::{Elastic, Moduli};
use super::hyperelastic::{Hyperelastic, left_cauchy_green, principal_bounds};
use super::increment::Response;
use super::stiffness::Stiffness;
use crate::math::{SymTensor, Tensor, nearest_root};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rubber-like elastic solid, exact at any strain and rotation.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct NeoHookean {
    /// Density, Young's modulus, Poisson's ratio, artificial bulk viscosity.
    #[serde(flatten)]
    pub elastic: Elastic,
}

impl Hyperelastic for NeoHookean {
    const NAME: &'static str = "neo-Hookean";

    #[inline(always)]
    fn elastic(&self) -> Elastic {
        self.elastic
    }

    fn stored_energy(&self, deformation: &Tensor<3>) -> f64 {
        let moduli = self.elastic.moduli();
        let ln_j = deformation.determinant().ln();
        0.5 * moduli.shear * (deformation.contract(deformation) - 3.0) - moduli.shear * ln_j
            + 0.5 * moduli.lame() * ln_j * ln_j
    }

    /// Along the principal stretch λ_i ρ c² = ∂σ_i/∂ln λ_i = [G (λ_i² + 1) + λ (1 − ln J)]/J, with the largest λ_i²
    /// bounded by Gershgorin.
    #[inline(always)]
    fn stress(&self, deformation: &Tensor<3>) -> Response {
        let Moduli { shear, .. } = self.elastic.moduli();
        let lame = self.elastic.moduli().lame();
        let j = deformation.determinant();
        let (per_j, ln_j) = (1.0 / j, j.ln());
        let b = left_cauchy_green(deformation);
        let stress = (b * shear + SymTensor::isotropic(lame * ln_j - shear)) * per_j;
        let [_, largest] = principal_bounds(&b);
        Response { stress, modulus: (shear * (largest + 1.0) + lame * (1.0 - ln_j)).max(shear) * per_j }
    }

    /// J c = λ 1 ⊗ 1 + 2 (G − λ ln J) 1 ⊙ 1.
    fn tangent(&self, deformation: &Tensor<3>) -> Stiffness {
        let Moduli { shear, .. } = self.elastic.moduli();
        let (lame, j) = (self.elastic.moduli().lame(), deformation.determinant());
        let kirchhoff = Stiffness::volumetric() * lame + Stiffness::identity() * (2.0 * (shear - lame * j.ln()));
        kirchhoff * (1.0 / j)
    }

    /// In the principal axes of the stress λ_i² = 1 + (J σ_i − λ ln J)/G, where one unknown J is found from J² = Π
    /// λ_i².
    fn prestretch(&self, stress: &SymTensor) -> Option<Tensor<3>> {
        let Moduli { shear, .. } = self.elastic.moduli();
        let lame = self.elastic.moduli().lame();
        let square = |ln_j: f64, sigma: f64| 1.0 + (ln_j.exp() * sigma - lame * ln_j) / shear;
        let spectrum = stress.spectrum();
        let mismatch = |ln_j: f64| {
            let squares = spectrum.values.map(|sigma| square(ln_j, sigma));
            if squares.iter().all(|s| *s > 0.0) {
                squares.iter().map(|s| s.ln()).sum::<f64>() - 2.0 * ln_j
            } else {
                f64::NAN
            }
        };
        // In steps that leave λ_i² positive: a nearly incompressible solid bears its stress with next to no ln J.
        let ln_j = nearest_root(mismatch, (0.5 * shear / lame.abs()).min(1e-3), 3.0)?;
        Some(spectrum.map(|sigma| square(ln_j, sigma).sqrt()).full())
    }
}

#[cfg(test)]
mod tests {
    use super::NeoHookean;
    use crate::material::elastic::Elastic;
    use crate::material::hyperelastic::Hyperelastic;
    use crate::material::testing::check_law;
    use crate::material::testing::elastic::{check_hyperelastic, simple_shear};
    use crate::material::{PointLaw, StartState};
    use crate::math::SymTensor;

    fn rubber() -> NeoHookean {
        NeoHookean { elastic: Elastic::new(1100.0, 1e6, 0.4) }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&rubber(), StartState::default());
        let stress = SymTensor([2e5, -1e5, 5e4, 3e4, -2e4, 8e4]);
        check_law(&rubber(), StartState { stress: Some(stress), ..StartState::default() });
        check_hyperelastic(&rubber());
    }

    /// Simple shear has J = 1: σ_xy = G γ and σ_xx = G γ², alone.
    #[test]
    fn simple_shear_has_one_normal_stress() {
        let (shear, g) = (0.9, 1e6 / 2.8);
        let error = rubber().stress(&simple_shear(shear)).stress
            - SymTensor([g * shear * shear, 0.0, 0.0, g * shear, 0.0, 0.0]);
        assert!(error.contract(&error).sqrt() < 1e-9 * g);
    }

    #[test]
    fn the_state_at_the_start_has_the_given_stress() {
        let stress = SymTensor([2e5, -1e5, 5e4, 3e4, -2e4, 8e4]);
        let state = rubber().initial(&StartState { stress: Some(stress), ..StartState::default() }).unwrap();
        let error = state.stress - stress;
        assert!(error.contract(&error).sqrt() < 1e-6 && (state.pressure + stress.trace() / 3.0).abs() < 1e-6);
        assert!((state.density * state.deformation.determinant() - 1100.0).abs() < 1e-9);
        let hard = NeoHookean { elastic: Elastic::new(1100.0, 1e6, 0.5) };
        let state = hard.initial(&StartState { stress: Some(stress), ..StartState::default() }).unwrap();
        let error = state.stress - stress;
        assert!(error.contract(&error).sqrt() < 1e-4 && (state.deformation.determinant() - 1.0).abs() < 1e-4);
        let torn = StartState { pressure: Some(-1e9), ..StartState::default() };
        assert!(rubber().initial(&torn).unwrap_err().contains("no deformation"));
    }
}
