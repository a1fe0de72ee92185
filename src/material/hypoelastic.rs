//! Isotropic hypoelastic solid with the Jaumann rate (Lian (22–25) with the spin's sign corrected; theory B.8).
//!
//! ```text
//! σ^∇ = 2 G D' + K tr D 1,      σ̇ = σ^∇ + Ω σ − σ Ω
//! ```
//!
//! For small strains at any rotation; in large shear γ the Jaumann rate answers G sin γ.

use super::Phase;
use super::elastic::Elastic;
use super::increment::{Increment, Point, Response};
use super::solid::Solid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elastic solid in rate form, for small strains: the paper's elastic bodies.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Hypoelastic {
    /// Density, Young's modulus, Poisson's ratio, artificial bulk viscosity.
    #[serde(flatten)]
    pub elastic: Elastic,
}

impl Solid for Hypoelastic {
    const PHASE: Phase = Phase::Elastic;

    fn elastic(&self) -> &Elastic {
        &self.elastic
    }

    #[inline(always)]
    fn response(&self, increment: &Increment, point: Point<'_>) -> Response {
        let moduli = self.elastic.moduli();
        let s = moduli.deviator(increment, &point);
        moduli.response(s, increment.volume_ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::Hypoelastic;
    use crate::material::StartState;
    use crate::material::elastic::Elastic;
    use crate::material::testing::{TestParticle, check_law};
    use crate::math::{SymTensor, Tensor};

    fn steel() -> Hypoelastic {
        Hypoelastic { elastic: Elastic::new(7800.0, 210e9, 0.3) }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&steel(), StartState::default());
        let stress = SymTensor([2e8, -1e8, 5e7, 3e7, -2e7, 8e7]);
        check_law(&steel(), StartState { stress: Some(stress), ..StartState::default() });
    }

    /// Simple shear γ (Dienes 1979): σ12 = G sin γ, σ11 = −σ22 = G (1 − cos γ).
    #[test]
    fn simple_shear_oscillates() {
        let (law, shear, steps) = (steel(), 3.0, 2000);
        let g = 210e9 / 2.6;
        let mut sample = TestParticle::new(&law, StartState::default());
        let mut gradient = Tensor::ZERO;
        gradient[0][1] = shear;
        for _ in 0..steps {
            sample.step(&law, gradient, 1.0 / f64::from(steps));
        }
        let [xx, yy, zz, xy, yz, zx] = sample.stress[0].0;
        assert!((xy / g - shear.sin()).abs() < 1e-6, "{}", xy / g);
        assert!((xx / g - (1.0 - shear.cos())).abs() < 1e-6 && (xx + yy).abs() < 1e-6 * g);
        assert!(zz.abs() + yz.abs() + zx.abs() < 1e-6 * g);
        // The work of that stress, ∫ G sin γ dγ.
        assert!((sample.energy[0] / g - (1.0 - shear.cos())).abs() < 1e-6);
    }

    #[test]
    fn an_energy_is_no_start_for_a_solid() {
        use crate::material::PointLaw;
        let error = steel().initial(&StartState { energy: Some(1.0), ..StartState::default() }).unwrap_err();
        assert!(error.contains("pressure"), "{error}");
    }
}
