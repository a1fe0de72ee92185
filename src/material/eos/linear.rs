//! Linear liquid, `p = c0² (ρ − ρ0)` (theory B.4).

use super::{Coefficients, EquationOfState};
use crate::material::MaterialKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Linear liquid: p = c0² (ρ − ρ0); the energy does not act back.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename = "Linear", rename_all = "kebab-case", deny_unknown_fields)]
pub struct LinearLiquid {
    /// Speed of sound c0. Ten times the largest speed keeps changes of density below 1 %.
    #[schemars(extend("unit" = "m/s", "exclusiveMinimum" = 0.0))]
    pub sound_speed: f64,
    /// Largest tension that the liquid bears; 0: it parts as soon as it is pulled.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub tensile_strength: f64,
}

impl EquationOfState for LinearLiquid {
    fn phase(&self) -> MaterialKind {
        MaterialKind::Liquid
    }

    #[inline(always)]
    fn coefficients(&self, density: f64, eta: f64) -> Coefficients {
        let modulus = density * self.sound_speed * self.sound_speed;
        Coefficients { a: modulus * eta, b: 0.0, da: modulus, db: 0.0 }
    }

    fn least_pressure(&self) -> f64 {
        -self.tensile_strength
    }
}

#[cfg(test)]
mod tests {
    use super::LinearLiquid;
    use crate::material::StartState;
    use crate::material::eos::EquationsOfState;
    use crate::material::testing::{TestParticle, check_law, fluid};
    use crate::math::Tensor;

    #[test]
    fn passes_the_common_checks() {
        let eos = LinearLiquid { sound_speed: 30.0, tensile_strength: 0.0 };
        check_law(
            &fluid(1000.0, EquationsOfState::LinearLiquid(eos)),
            StartState { pressure: Some(1e4), ..StartState::default() },
        );
    }

    #[test]
    fn tension_ends_at_the_strength() {
        let eos = LinearLiquid { sound_speed: 30.0, tensile_strength: 500.0 };
        let law = fluid(1000.0, EquationsOfState::LinearLiquid(eos));
        let mut sample = TestParticle::new(&law, StartState::default());
        sample.step(&law, Tensor::identity() * 1e-4, 1.0);
        let exact = 900.0 * 1000.0 * ((-3e-4f64).exp() - 1.0);
        assert!((sample.pressure[0] - exact).abs() < 1e-6, "{} {exact}", sample.pressure[0]);
        sample.step(&law, Tensor::identity() * 1e-2, 1.0);
        assert_eq!(sample.pressure[0], -500.0);
    }
}
