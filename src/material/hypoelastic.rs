//! Isotropic hypoelastic solid with the Jaumann rate (Lian (22–25) with the spin's sign corrected; theory B.8).
//!
//! ```text
//! σ^∇ = 2 G D' + K tr D 1,      σ̇ = σ^∇ + Ω σ − σ Ω
//! ```
//!
//! For small strains at any rotation; in large shear γ the Jaumann rate answers G sin γ.

use super::MaterialKind;
use super::elastic::{Elastic, Moduli};
use super::increment::{Increment, Point, Response};
use super::linearised::{ElasticLaw, ElasticState, Linearised};
use super::solid::Solid;
use super::stiffness::Stiffness;
use crate::math::{SymTensor, Tensor};
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
    const PHASE: MaterialKind = MaterialKind::Elastic;

    fn elastic(&self) -> Elastic {
        self.elastic
    }

    fn linearisable(&self) -> Option<&dyn ElasticLaw> {
        Some(self)
    }

    #[inline(always)]
    fn response(&self, increment: &Increment, point: Point<'_>) -> Response {
        let moduli = self.elastic.moduli();
        let s = moduli.deviator(increment, &point);
        moduli.response(s, increment.volume_ratio)
    }
}

impl ElasticLaw for Hypoelastic {
    fn reference_density(&self) -> f64 {
        self.elastic.density
    }

    fn moduli(&self) -> Moduli {
        self.elastic.moduli()
    }

    /// The tangent of an increment as it goes to zero. Truesdell's rate is Jaumann's less d σ + σ d and with tr d σ:
    /// c = K 1 ⊗ 1 + 2 G (1 ⊙ 1 − ⅓ 1 ⊗ 1) − 2 (1 ⊙ σ) + σ ⊗ 1. The last makes it unsymmetric: no stored energy is
    /// behind it.
    fn linearised(&self, state: &ElasticState) -> Linearised<6> {
        let (moduli, one) = (self.elastic.moduli(), SymTensor::isotropic(1.0));
        let pressure = moduli.pressure(state.deformation.determinant());
        let stress = state.stress.deviator() - SymTensor::isotropic(pressure);
        let elastic = Stiffness::volumetric() * moduli.lame() + Stiffness::identity() * (2.0 * moduli.shear);
        // Becker (7).
        let turning = Stiffness::dyad(&stress, &one) - Stiffness::product(&one, &stress) * 2.0;
        Linearised::new(stress, elastic + turning)
    }

    fn thickness_stretch(&self, _in_plane: &Tensor<2>) -> Result<f64, String> {
        Err("the stress of a rate law is not a function of the deformation: its thickness is followed in time".into())
    }
}

#[cfg(test)]
mod tests {
    use super::Hypoelastic;
    use crate::material::elastic::Elastic;
    use crate::material::testing::elastic::{check_moduli_at_rest, check_plane_stress_increment, check_tangent};
    use crate::material::testing::{TestParticle, check_law};
    use crate::material::{ElasticLaw, ElasticState, StartState};
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
    fn tangents_are_those_of_small_increments() {
        let rest = ElasticState { deformation: Tensor::identity(), stress: SymTensor::ZERO };
        let strained = ElasticState {
            deformation: Tensor([[1.02, 0.03, 0.0], [-0.01, 0.97, 0.0], [0.0, 0.0, 1.01]]),
            stress: SymTensor([2e10, -1e10, -1e10, 7e9, -3e9, 5e9]),
        };
        check_moduli_at_rest(&steel());
        for state in [rest, strained] {
            check_tangent(&steel(), &steel(), &state);
        }
    }

    /// Of c only σ ⊗ 1 has no partner: c − cᵀ = σ ⊗ 1 − 1 ⊗ σ.
    #[test]
    fn the_unsymmetric_part_is_that_of_the_stress() {
        let stress = SymTensor([2e10, -1e10, -1e10, 7e9, -3e9, 5e9]);
        let c = steel().linearised(&ElasticState { deformation: Tensor::identity(), stress }).tangent;
        for i in 0..6 {
            for j in 0..6 {
                let unit = |k: usize| f64::from(u8::from(k < 3));
                let exact = stress.0[i] * unit(j) - unit(i) * stress.0[j];
                assert!((c[i][j] - c[j][i] - exact).abs() < 1e-4, "{i}{j}");
            }
        }
    }

    /// A strain in the plane with the thickness rate of plane stress leaves σ_zz zero to second order.
    #[test]
    fn thickness_follows_plane_stress() {
        let j: f64 = 0.99;
        // The deviator whose σ_zz is that of the pressure.
        let pressure = steel().elastic.moduli().pressure(j);
        let deviator = SymTensor([-0.3 * pressure, -0.7 * pressure, pressure, 8e8, 0.0, 0.0]);
        let state = ElasticState { deformation: Tensor::identity() * j.cbrt(), stress: deviator };
        check_plane_stress_increment(&steel(), &steel(), &state);
        assert!(steel().thickness_stretch(&Tensor::identity()).unwrap_err().contains("rate law"));
    }

    #[test]
    fn an_energy_is_no_start_for_a_solid() {
        use crate::material::PointLaw;
        let error = steel().initial(&StartState { energy: Some(1.0), ..StartState::default() }).unwrap_err();
        assert!(error.contains("pressure"), "{error}");
    }
}
