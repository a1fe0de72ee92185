//! Ideal gas, `p = (γ − 1) (ρ/ρ0) E` (Lian (67); theory B.4).

use super::{Coefficients, EquationOfState, FluidState, gas};
use crate::material::{MaterialKind, StartState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Ideal gas: p = (γ − 1) (ρ/ρ0) E, so that c² = γ p/ρ.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct IdealGas {
    /// Ratio of specific heats γ.
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 1.0))]
    pub gamma: f64,
}

impl EquationOfState for IdealGas {
    fn phase(&self) -> MaterialKind {
        MaterialKind::Gas
    }

    #[inline(always)]
    fn coefficients(&self, _density: f64, eta: f64) -> Coefficients {
        let excess = self.gamma - 1.0;
        // Lian (67), p = B E.
        Coefficients { a: 0.0, b: excess * (1.0 + eta), da: 0.0, db: excess }
    }

    fn is_ideal_gas(&self) -> bool {
        true
    }

    fn start(&self, density: f64, start: &StartState) -> Result<FluidState, String> {
        gas::start(self, density, start)
    }
}

#[cfg(test)]
mod tests {
    use super::IdealGas;
    use crate::material::eos::EquationsOfState;
    use crate::material::testing::{TestParticle, check_law, fluid};
    use crate::material::{PointLaw, StartState};
    use crate::math::Tensor;

    const GAS: EquationsOfState = EquationsOfState::IdealGas(IdealGas { gamma: 1.4 });

    fn start() -> StartState {
        StartState { pressure: Some(1e5), ..StartState::default() }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&fluid(1.2, GAS), start());
    }

    #[test]
    fn sound_speed_of_air() {
        let law = fluid(1.2, GAS);
        let mut sample = TestParticle::new(&law, start());
        sample.step(&law, Tensor::ZERO, 1e-6);
        assert!((sample.wave_speed[0] - (1.4f64 * 1e5 / 1.2).sqrt()).abs() < 1e-9);
    }

    /// The isentrope p V^γ = const. (Poisson) is met with second order.
    #[test]
    fn isentrope_converges_with_second_order() {
        let law = fluid(1.2, GAS);
        let error = |steps: usize| {
            let mut sample = TestParticle::new(&law, start());
            let ratio = 2f64.powf(-1.0 / (3.0 * steps as f64));
            for _ in 0..steps {
                sample.step(&law, Tensor::identity() * ratio.ln(), 1.0);
            }
            assert!((sample.volume[0] - 0.5).abs() < 1e-12);
            (sample.pressure[0] / (1e5 * 2f64.powf(1.4)) - 1.0).abs()
        };
        let (coarse, fine) = (error(20), error(40));
        assert!(fine < 1e-4 && (coarse / fine - 4.0).abs() < 0.1, "{coarse:e} {fine:e}");
    }

    #[test]
    fn a_gas_without_state_is_refused() {
        let error = fluid(1.2, GAS).initial(&StartState::default()).unwrap_err();
        assert!(error.contains("pressure"), "{error}");
        let vacuum = StartState { pressure: Some(-1.0), ..StartState::default() };
        assert!(fluid(1.2, GAS).initial(&vacuum).is_err());
    }
}
