//! Polynomial, `p = c0 + c1 η + c2 η² + c3 η³ + (c4 + c5 η + c6 η²) E` (theory B.4).

use super::{Coefficients, EquationOfState};
use crate::material::MaterialKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Polynomial in the compression η = ρ/ρ0 − 1, linear in the energy.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Polynomial {
    /// Coefficients c0 to c3 of 1, η, η², η³ in the cold pressure.
    #[schemars(extend("unit" = "Pa"))]
    pub cold: [f64; 4],
    /// Coefficients c4 to c6 of 1, η, η² in the factor of the energy.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub thermal: [f64; 3],
    /// Largest tension that the material bears; 0: it parts as soon as it is pulled.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub tensile_strength: f64,
}

impl EquationOfState for Polynomial {
    fn phase(&self) -> MaterialKind {
        MaterialKind::Liquid
    }

    #[inline(always)]
    fn coefficients(&self, _density: f64, eta: f64) -> Coefficients {
        let ([c0, c1, c2, c3], [c4, c5, c6]) = (self.cold, self.thermal);
        Coefficients {
            a: c0 + eta * (c1 + eta * (c2 + eta * c3)),
            b: c4 + eta * (c5 + eta * c6),
            da: c1 + eta * (2.0 * c2 + eta * 3.0 * c3),
            db: c5 + eta * 2.0 * c6,
        }
    }

    fn least_pressure(&self) -> f64 {
        -self.tensile_strength
    }
}

#[cfg(test)]
mod tests {
    use super::Polynomial;
    use crate::material::StartState;
    use crate::material::eos::{EquationOfState, EquationsOfState, IdealGas};
    use crate::material::testing::{check_law, fluid};

    #[test]
    fn passes_the_common_checks() {
        let eos = Polynomial { cold: [0.0, 2.7e9, 7.7e9, 1.5e10], thermal: [0.1, 0.2, 0.05], tensile_strength: 0.0 };
        check_law(
            &fluid(1000.0, EquationsOfState::Polynomial(eos)),
            StartState { pressure: Some(5e7), ..StartState::default() },
        );
    }

    /// With c4 = c5 = γ − 1 the polynomial is the ideal gas.
    #[test]
    fn contains_the_ideal_gas() {
        let eos = Polynomial { cold: [0.0; 4], thermal: [0.4, 0.4, 0.0], tensile_strength: 0.0 };
        let (ours, gas) = (eos.coefficients(1.2, 0.7), IdealGas { gamma: 1.4 }.coefficients(1.2, 0.7));
        assert!((ours.pressure(2.5e5) / gas.pressure(2.5e5) - 1.0).abs() < 1e-14);
        assert!((ours.db - gas.db).abs() < 1e-14);
    }
}
