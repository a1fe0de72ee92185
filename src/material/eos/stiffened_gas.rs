//! Stiffened gas, `p = (γ − 1) ρ e − γ p∞` (theory B.4), with the energy counted from rest.
//!
//! With E = ρ0 e − γ p∞/(γ − 1), the energy above that of the state p = 0, ρ = ρ0:
//!
//! ```text
//! p = γ p∞ η + (γ − 1) (1 + η) E,      ρ0 c² = γ (p + p∞)/(1 + η)
//! ```

use super::{Coefficients, EquationOfState};
use crate::material::MaterialKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Stiffened gas: liquids under strong compression and heating; water: γ = 6.1–7.15, p∞ = 300–600 MPa.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct StiffenedGas {
    /// Exponent γ.
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 1.0))]
    pub gamma: f64,
    /// Stiffness p∞.
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub stiffness: f64,
    /// Largest tension that the liquid bears; 0: it parts as soon as it is pulled.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub tensile_strength: f64,
}

impl EquationOfState for StiffenedGas {
    fn phase(&self) -> MaterialKind {
        MaterialKind::Liquid
    }

    #[inline(always)]
    fn coefficients(&self, _density: f64, eta: f64) -> Coefficients {
        let (excess, stiffness) = (self.gamma - 1.0, self.gamma * self.stiffness);
        Coefficients { a: stiffness * eta, b: excess * (1.0 + eta), da: stiffness, db: excess }
    }

    fn least_pressure(&self) -> f64 {
        -self.tensile_strength
    }
}

#[cfg(test)]
mod tests {
    use super::StiffenedGas;
    use crate::material::StartState;
    use crate::material::eos::EquationsOfState;
    use crate::material::testing::{TestParticle, check_law, fluid};
    use crate::math::Tensor;

    const WATER: EquationsOfState =
        EquationsOfState::StiffenedGas(StiffenedGas { gamma: 7.15, stiffness: 3e8, tensile_strength: 0.0 });

    #[test]
    fn passes_the_common_checks() {
        check_law(&fluid(1000.0, WATER), StartState { pressure: Some(1e7), ..StartState::default() });
    }

    /// On an isentrope from rest (p + p∞) V^γ is constant.
    #[test]
    fn an_isentrope_is_a_power_law() {
        let law = fluid(1000.0, WATER);
        let mut sample = TestParticle::new(&law, StartState::default());
        for _ in 0..400 {
            sample.step(&law, Tensor::identity() * (0.9f64.ln() / 1200.0), 1.0);
        }
        let exact = 3e8 * (0.9f64.powf(-7.15) - 1.0);
        assert!((sample.pressure[0] / exact - 1.0).abs() < 1e-6, "{}", sample.pressure[0] / exact);
        let density = 1000.0 / sample.volume[0];
        let speed = (7.15 * (sample.pressure[0] + 3e8) / density).sqrt();
        assert!((sample.wave_speed[0] / speed - 1.0).abs() < 1e-6);
    }
}
