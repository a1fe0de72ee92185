//! Tait (Murnaghan) liquid, `p = (ρ0 c0²/n) [(ρ/ρ0)ⁿ − 1]` (theory B.4).

use super::flow::{self, FlowProperties};
use super::{Coefficients, EquationOfState};
use crate::material::MaterialKind;
use crate::material::PointBatch;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Tait liquid: p = (ρ0 c0²/n) [(ρ/ρ0)ⁿ − 1]; the energy does not act back.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Tait {
    /// Speed of sound c0 at rest. Ten times the largest speed keeps changes of density below 1 %.
    #[schemars(extend("unit" = "m/s", "exclusiveMinimum" = 0.0))]
    pub sound_speed: f64,
    /// Exponent n; 7 for water.
    #[serde(default = "seven")]
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 0.0))]
    pub exponent: f64,
    /// Largest tension that the liquid bears; 0: it parts as soon as it is pulled.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub tensile_strength: f64,
}

fn seven() -> f64 {
    7.0
}

impl Tait {
    /// The coefficients, with (ρ/ρ0)^(n−1) from `power`.
    #[inline(always)]
    fn with_power(&self, density: f64, eta: f64, power: impl Fn(f64) -> f64) -> Coefficients {
        let modulus = density * self.sound_speed * self.sound_speed;
        let power = power(1.0 + eta);
        let a = modulus / self.exponent * (power * (1.0 + eta) - 1.0);
        Coefficients { a, b: 0.0, da: modulus * power, db: 0.0 }
    }
}

impl EquationOfState for Tait {
    fn phase(&self) -> MaterialKind {
        MaterialKind::Liquid
    }

    #[inline(always)]
    fn coefficients(&self, density: f64, eta: f64) -> Coefficients {
        self.with_power(density, eta, |x| x.powf(self.exponent - 1.0))
    }

    fn least_pressure(&self) -> f64 {
        -self.tensile_strength
    }

    fn advance(&self, flow: &FlowProperties, batch: &mut PointBatch<'_>) {
        if self.exponent == 7.0 {
            flow::advance(&Water(self), flow, batch);
        } else {
            flow::advance(self, flow, batch);
        }
    }
}

/// The exponent of water by products, which vectorise where a general power does not.
#[derive(Debug)]
struct Water<'a>(&'a Tait);

impl EquationOfState for Water<'_> {
    fn phase(&self) -> MaterialKind {
        self.0.phase()
    }

    #[inline(always)]
    fn coefficients(&self, density: f64, eta: f64) -> Coefficients {
        let cube = |x: f64| x * x * x;
        self.0.with_power(density, eta, |x| cube(x) * cube(x))
    }

    fn least_pressure(&self) -> f64 {
        self.0.least_pressure()
    }
}

#[cfg(test)]
mod tests {
    use super::Tait;
    use crate::material::StartState;
    use crate::material::eos::{EquationOfState, EquationsOfState};
    use crate::material::testing::{check_law, fluid};

    #[test]
    fn passes_the_common_checks() {
        for exponent in [7.0, 4.2] {
            let eos = Tait { sound_speed: 1480.0, exponent, tensile_strength: 0.0 };
            check_law(
                &fluid(998.0, EquationsOfState::Tait(eos)),
                StartState { pressure: Some(1e7), ..StartState::default() },
            );
        }
    }

    /// Cole (1948): water at 25 % compression, B = ρ0 c0²/n = 312.3 MPa for c0 = 1480 m/s.
    #[test]
    fn pressure_of_compressed_water() {
        let eos = Tait { sound_speed: 1480.0, exponent: 7.0, tensile_strength: 0.0 };
        let k = eos.coefficients(998.0, 0.25);
        let exact = 998.0 * 1480.0 * 1480.0 / 7.0 * (1.25f64.powi(7) - 1.0);
        assert!((k.a / exact - 1.0).abs() < 1e-14);
        assert!((k.da / (998.0 * 1480.0 * 1480.0 * 1.25f64.powi(6)) - 1.0).abs() < 1e-14);
    }
}
