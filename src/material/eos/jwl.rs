//! Jones–Wilkins–Lee products of an explosive, detonated all at once (theory B.4).
//!
//! ```text
//! p = C1 (1 − ω/(R1 v)) e^(−R1 v) + C2 (1 − ω/(R2 v)) e^(−R2 v) + ω E/v,      v = ρ0/ρ
//! ```

use super::{Coefficients, EquationOfState, FluidState, gas};
use crate::material::{MaterialKind, StartState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Jones–Wilkins–Lee: gas that an explosive turned into; its `energy` at the start is the heat of detonation.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Jwl {
    /// Pressures C1 and C2.
    #[schemars(extend("unit" = "Pa"))]
    pub pressures: [f64; 2],
    /// Rates R1 and R2.
    #[schemars(extend("unit" = "1"))]
    pub rates: [f64; 2],
    /// Exponent ω of the expanded gas.
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 0.0))]
    pub omega: f64,
}

impl EquationOfState for Jwl {
    fn phase(&self) -> MaterialKind {
        MaterialKind::Gas
    }

    #[inline(always)]
    fn coefficients(&self, _density: f64, eta: f64) -> Coefficients {
        let v = 1.0 / (1.0 + eta);
        let (mut a, mut slope) = (0.0, 0.0);
        for (pressure, rate) in self.pressures.into_iter().zip(self.rates) {
            let decay = pressure * (-rate * v).exp();
            let ratio = self.omega / (rate * v);
            a += (1.0 - ratio) * decay;
            slope += (ratio / v - rate * (1.0 - ratio)) * decay;
        }
        // dv/dη = −v².
        Coefficients { a, b: self.omega / v, da: -v * v * slope, db: self.omega }
    }

    fn start(&self, density: f64, start: &StartState) -> Result<FluidState, String> {
        gas::start(self, density, start)
    }
}

#[cfg(test)]
mod tests {
    use super::Jwl;
    use crate::material::StartState;
    use crate::material::eos::{EquationOfState, EquationsOfState};
    use crate::material::testing::{check_law, fluid};

    /// TNT (Dobratz & Crawford 1985).
    const TNT: Jwl = Jwl { pressures: [371.2e9, 3.231e9], rates: [4.15, 0.95], omega: 0.30 };

    #[test]
    fn passes_the_common_checks() {
        check_law(
            &fluid(1630.0, EquationsOfState::Jwl(TNT)),
            StartState { energy: Some(7e9), ..StartState::default() },
        );
    }

    /// The Chapman–Jouguet state of TNT: p = 21 GPa behind a front of 6930 m/s, v = 1 − p/(ρ0 D²), and
    /// E = E0 + ½ p (1 − v), as tabulated with the constants.
    #[test]
    fn chapman_jouguet_pressure() {
        let v = 1.0 - 21e9 / (1630.0 * 6930.0f64.powi(2));
        let k = TNT.coefficients(1630.0, 1.0 / v - 1.0);
        let pressure = k.pressure(7e9 + 0.5 * 21e9 * (1.0 - v));
        assert!((pressure / 21e9 - 1.0).abs() < 0.01, "{pressure:e}");
    }
}
