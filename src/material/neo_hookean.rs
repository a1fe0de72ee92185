//! Compressible neo-Hookean solid (theory B.9).
//!
//! ```text
//! W = ½ G (tr b − 3) − G ln J + ½ λ ln² J,      J σ = τ = G (b − 1) + λ ln J 1,      b = F Fᵀ
//! ```

use super::elastic::{Elastic, Moduli, start_stress};
use super::increment::{Increment, Point, Response};
use super::solid::Solid;
use super::{Phase, PointState, StartState};
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

impl NeoHookean {
    /// Stored energy W per reference volume [J/m³].
    pub fn stored_energy(&self, deformation: &Tensor<3>) -> f64 {
        let moduli = self.elastic.moduli();
        let ln_j = deformation.determinant().ln();
        0.5 * moduli.shear * (deformation.contract(deformation) - 3.0) - moduli.shear * ln_j
            + 0.5 * moduli.lame() * ln_j * ln_j
    }

    /// Cauchy stress [Pa] and the modulus ρ c² of the fastest wave [Pa]: along the principal stretch λ_i
    /// ρ c² = ∂σ_i/∂ln λ_i = [G (λ_i² + 1) + λ (1 − ln J)]/J, with the largest λ_i² bounded by Gershgorin.
    #[inline(always)]
    fn stress(&self, deformation: &Tensor<3>) -> Response {
        let Moduli { shear, .. } = self.elastic.moduli();
        let lame = self.elastic.moduli().lame();
        let j = deformation.determinant();
        let (per_j, ln_j) = (1.0 / j, j.ln());
        let b = deformation.dot(&deformation.transpose()).symmetric();
        let stress = (b * shear + SymTensor::isotropic(lame * ln_j - shear)) * per_j;
        let [xx, yy, zz, xy, yz, zx] = b.0;
        let (xy, yz, zx) = (xy.abs(), yz.abs(), zx.abs());
        let largest = (xx + xy + zx).max(yy + xy + yz).max(zz + yz + zx);
        Response { stress, modulus: (shear * (largest + 1.0) + lame * (1.0 - ln_j)).max(shear) * per_j }
    }

    /// A symmetric deformation gradient that carries `stress`: in its principal axes
    /// λ_i² = 1 + (J σ_i − λ ln J)/G, where J is found from J² = Π λ_i².
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
        let ln_j = nearest_root(mismatch, 1e-3, 3.0)?;
        Some(spectrum.map(|sigma| square(ln_j, sigma).sqrt()).full())
    }
}

impl Solid for NeoHookean {
    const PHASE: Phase = Phase::Elastic;
    const DEFORMATION: bool = true;

    fn elastic(&self) -> &Elastic {
        &self.elastic
    }

    fn start(&self, start: &StartState) -> Result<PointState, String> {
        let stress = start_stress(start)?;
        let deformation = self
            .prestretch(&stress)
            .ok_or_else(|| format!("no deformation of this neo-Hookean solid carries the stress {:?} Pa", stress.0))?;
        let density = self.elastic.density / deformation.determinant();
        let Response { stress, modulus } = self.stress(&deformation);
        Ok(PointState {
            density,
            energy: self.stored_energy(&deformation),
            pressure: -stress.trace() / 3.0,
            stress,
            deformation,
            sound_speed: (modulus / density).sqrt(),
        })
    }

    #[inline(always)]
    fn response(&self, _increment: &Increment, point: Point<'_>) -> Response {
        self.stress(&point.deformation)
    }
}

#[cfg(test)]
mod tests {
    use super::NeoHookean;
    use crate::material::elastic::Elastic;
    use crate::material::testing::{TestParticle, check_law, smooth_path};
    use crate::material::{PointLaw, StartState};
    use crate::math::{SymTensor, Tensor};

    fn rubber() -> NeoHookean {
        NeoHookean { elastic: Elastic::new(1100.0, 1e6, 0.4) }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&rubber(), StartState::default());
        let stress = SymTensor([2e5, -1e5, 5e4, 3e4, -2e4, 8e4]);
        check_law(&rubber(), StartState { stress: Some(stress), ..StartState::default() });
    }

    /// J σ Fᵀ⁻¹ = ∂W/∂F, by central differences.
    #[test]
    fn stress_is_the_derivative_of_the_stored_energy() {
        let (law, step) = (rubber(), 1e-6);
        let f = Tensor([[1.2, 0.3, -0.1], [0.05, 0.8, 0.2], [-0.15, 0.1, 1.1]]);
        let piola = law.stress(&f).stress.full().dot(&f.inverse().unwrap().transpose()) * f.determinant();
        for i in 0..3 {
            for j in 0..3 {
                let (mut ahead, mut back) = (f, f);
                ahead[i][j] += step;
                back[i][j] -= step;
                let slope = (law.stored_energy(&ahead) - law.stored_energy(&back)) / (2.0 * step);
                assert!((slope - piola[i][j]).abs() < 1e-3, "{i}{j}: {slope} {}", piola[i][j]);
            }
        }
    }

    /// The trapezoidal energy converges to W with second order, from a stressed start too.
    #[test]
    fn energy_follows_the_stored_energy() {
        let law = rubber();
        let start = StartState { pressure: Some(3e4), ..StartState::default() };
        let error = |steps| {
            let mut sample = TestParticle::new(&law, start);
            smooth_path(&mut sample, &law, steps, 0.5);
            sample.energy[0] / sample.reference_volume(&law) - law.stored_energy(&sample.deformation[0])
        };
        let (coarse, fine) = (error(200), error(400));
        assert!(fine.abs() < 1.0 && (coarse / fine - 4.0).abs() < 0.2, "{coarse:e} {fine:e}");
    }

    #[test]
    fn prestress_is_met() {
        let stress = SymTensor([2e5, -1e5, 5e4, 3e4, -2e4, 8e4]);
        let state = rubber().initial(&StartState { stress: Some(stress), ..StartState::default() }).unwrap();
        let error = state.stress - stress;
        assert!(error.contract(&error).sqrt() < 1e-6 && (state.pressure + stress.trace() / 3.0).abs() < 1e-6);
        assert!((state.density * state.deformation.determinant() - 1100.0).abs() < 1e-9);
        let torn = StartState { pressure: Some(-1e9), ..StartState::default() };
        assert!(rubber().initial(&torn).unwrap_err().contains("no deformation"));
    }
}
