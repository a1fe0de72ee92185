//! Mie–Grüneisen liquid or solid with a linear shock velocity, u_s = c0 + s u_p (Lian (66); theory B.4).
//!
//! ```text
//! p_H = ρ0 c0² η (1 + η) / [1 − (s − 1) η]²
//! p   = p_H (1 − ½ γ η) + γ0 E,  γ = γ0 ρ0/ρ          η ≥ 0
//! p   = max(ρ0 c0² η + γ0 E, −strength)               η < 0   (`limited`)
//! p   = 0                                             η < 0   (`none`, the paper)
//! ```
//!
//! The paper's branch jumps by γ0 E at η = 0 once the material is heated; the limited one is continuous.

use super::{Coefficients, EquationOfState};
use crate::material::MaterialKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Mie–Grüneisen: strongly compressed liquids and solids, from the measured shock velocity c0 + s u_p.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct MieGruneisen {
    /// Speed of sound c0 at rest.
    #[schemars(extend("unit" = "m/s", "exclusiveMinimum" = 0.0))]
    pub sound_speed: f64,
    /// Slope s of the shock velocity over the particle velocity.
    #[schemars(extend("unit" = "1", "minimum" = 0.0))]
    pub slope: f64,
    /// Grüneisen's coefficient γ0 at rest.
    #[schemars(extend("unit" = "1", "minimum" = 0.0))]
    pub gruneisen: f64,
    /// Behaviour in tension, at less than the reference density.
    #[serde(default)]
    pub tension: Tension,
    /// Largest tension that the material bears, with `tension = "limited"`.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub tensile_strength: f64,
}

/// Behaviour below the reference density.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Tension {
    /// No pressure at all below the reference density.
    None,
    /// Linear and heated by E, but never below minus the tensile strength.
    #[default]
    Limited,
}

/// Least value of 1 − (s − 1) η: keeps the state away from the singularity of the Hugoniot.
const LEAST_DENOMINATOR: f64 = 0.1;

impl EquationOfState for MieGruneisen {
    fn phase(&self) -> MaterialKind {
        MaterialKind::Liquid
    }

    #[inline(always)]
    fn coefficients(&self, density: f64, eta: f64) -> Coefficients {
        let (slope, gruneisen) = (self.slope - 1.0, self.gruneisen);
        let modulus = density * self.sound_speed * self.sound_speed;
        let over = 1.0 / (1.0 - slope * eta).max(LEAST_DENOMINATOR);
        // A = p_H (1 − ½ γ0 η/(1 + η)) is, without the division, the polynomial below over [1 − (s − 1) η]².
        let polynomial = eta * (1.0 + (1.0 - 0.5 * gruneisen) * eta);
        let derivative = 1.0 + (2.0 - gruneisen) * eta;
        let squeezed = modulus * over * over;
        let stretched = eta < 0.0;
        let bears = if matches!(self.tension, Tension::None) { 0.0 } else { 1.0 };
        // Lian (66). Both branches are computed and one is chosen, so that the loop over a batch vectorises.
        Coefficients {
            a: if stretched { bears * modulus * eta } else { squeezed * polynomial },
            b: if stretched { bears * gruneisen } else { gruneisen },
            da: if stretched { modulus } else { squeezed * (derivative + 2.0 * slope * over * polynomial) },
            db: 0.0,
        }
    }

    fn least_pressure(&self) -> f64 {
        match self.tension {
            Tension::None => 0.0,
            Tension::Limited => -self.tensile_strength,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{MieGruneisen, Tension};
    use crate::material::eos::{EquationOfState, EquationsOfState};
    use crate::material::testing::{TestParticle, check_law, fluid};
    use crate::material::{Fluid, StartState};
    use crate::math::Tensor;

    fn water(tension: Tension) -> MieGruneisen {
        MieGruneisen { sound_speed: 1647.0, slope: 1.921, gruneisen: 0.1, tension, tensile_strength: 0.0 }
    }

    fn liquid(tension: Tension) -> Fluid {
        fluid(1000.0, EquationsOfState::MieGruneisen(water(tension)))
    }

    #[test]
    fn passes_the_common_checks() {
        let start = StartState { pressure: Some(5e7), ..StartState::default() };
        check_law(&liquid(Tension::Limited), start);
        check_law(&liquid(Tension::None), start);
    }

    /// A shock at particle velocity u meets the jump conditions: u_s = c0 + s u, p = ρ0 u_s u,
    /// η = u/(u_s − u), E = ½ ρ0 u².
    #[test]
    fn pressure_behind_a_shock() {
        for u in [10.0, 100.0, 500.0] {
            let shock = 1647.0 + 1.921 * u;
            let k = water(Tension::Limited).coefficients(1000.0, u / (shock - u));
            let pressure = k.pressure(0.5 * 1000.0 * u * u);
            assert!((pressure / (1000.0 * shock * u) - 1.0).abs() < 1e-13, "u = {u}: {pressure}");
        }
    }

    #[test]
    fn the_papers_liquid_jumps_and_the_limited_one_does_not() {
        let (below, above, energy) = (-1e-9, 1e-9, 1e6);
        let jump = |eos: MieGruneisen| {
            eos.coefficients(1000.0, above).pressure(energy) - eos.coefficients(1000.0, below).pressure(energy)
        };
        assert!((jump(water(Tension::None)) - 1e5).abs() < 10.0);
        assert!(jump(water(Tension::Limited)).abs() < 10.0);
    }

    #[test]
    fn stretched_water_bears_nothing() {
        for tension in [Tension::None, Tension::Limited] {
            let law = liquid(tension);
            let mut sample = TestParticle::new(&law, StartState::default());
            sample.step(&law, Tensor::identity() * 1e-3, 1.0);
            assert_eq!((sample.pressure[0], sample.energy[0]), (0.0, 0.0));
            assert!((sample.wave_speed[0] / 1647.0 - 1.0).abs() < 0.01);
        }
    }
}
