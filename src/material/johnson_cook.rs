//! Metal under impact: Johnson & Cook's (1983) yield stress with radial return (theory B.11).
//!
//! ```text
//! σ_y = (A + B ε_pⁿ) (1 + C ln max(1, ε̇_p/ε̇_0)) (1 − T*^m),      T* = (T − T_r)/(T_m − T_r)
//! σ_tr − 3 G Δε_p = σ_y(ε_p + Δε_p, Δε_p/Δt, T)
//! ΔT = χ σ_y Δε_p/(ρ c_v)
//! ```

use super::elastic::{Elastic, equivalent};
use super::increment::{Increment, Point, Response};
use super::solid::Solid;
use super::{MaterialKind, PointState, StartState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Metal whose yield stress depends on plastic strain, its rate, and the heat that it makes.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct JohnsonCook {
    /// Density, Young's modulus, Poisson's ratio, artificial bulk viscosity.
    #[serde(flatten)]
    pub elastic: Elastic,
    /// First yield stress A.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub yield_stress: f64,
    /// Hardening B.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub hardening: f64,
    /// Hardening exponent n.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub hardening_exponent: f64,
    /// Rate coefficient C.
    #[serde(default)]
    #[schemars(extend("unit" = "1", "minimum" = 0.0))]
    pub rate_coefficient: f64,
    /// Reference rate ε̇_0 of plastic strain.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "1/s", "exclusiveMinimum" = 0.0))]
    pub reference_rate: f64,
    /// Softening exponent m.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 0.0))]
    pub softening_exponent: f64,
    /// Rise of temperature from the start to melting, T_m − T_r.
    #[schemars(extend("unit" = "K", "exclusiveMinimum" = 0.0))]
    pub melting_rise: f64,
    /// Specific heat c_v.
    #[schemars(extend("unit" = "J/(kg*K)", "exclusiveMinimum" = 0.0))]
    pub specific_heat: f64,
    /// Part χ of the plastic work that becomes heat.
    #[serde(default = "nine_tenths")]
    #[schemars(extend("unit" = "1", "minimum" = 0.0, "maximum" = 1.0))]
    pub heat_fraction: f64,
}

fn one() -> f64 {
    1.0
}

fn nine_tenths() -> f64 {
    0.9
}

impl JohnsonCook {
    /// Yield stress [Pa] at plastic strain `strain`, its rate `rate` [1/s] and the rise of temperature `rise` [K].
    pub fn yield_stress_at(&self, strain: f64, rate: f64, rise: f64) -> f64 {
        let hardened = self.yield_stress + self.hardening * strain.powf(self.hardening_exponent);
        let hurried = 1.0 + self.rate_coefficient * (rate / self.reference_rate).max(1.0).ln();
        let homologous = (rise / self.melting_rise).clamp(0.0, 1.0);
        hardened * hurried * (1.0 - homologous.powf(self.softening_exponent))
    }

    /// The plastic strain increment that brings the trial stress [Pa] back to the yield surface: the residual
    /// falls steadily from its positive value at zero, and the Illinois rule finds its zero.
    fn plastic_increment(&self, trial: f64, residual: impl Fn(f64) -> f64) -> f64 {
        /// The rule is of order 1.44: ten iterations serve, the rest is margin.
        const ITERATIONS: usize = 60;
        let (mut low, mut high) = (0.0, trial / (3.0 * self.elastic.moduli().shear));
        let (mut above, mut below) = (residual(low), residual(high));
        let mut middle = high;
        for _ in 0..ITERATIONS {
            middle = (low * below - high * above) / (below - above);
            let value = residual(middle);
            if value.abs() <= 1e-12 * trial {
                break;
            }
            if value > 0.0 {
                (low, above, below) = (middle, value, 0.5 * below);
            } else {
                (high, below, above) = (middle, value, 0.5 * above);
            }
        }
        middle
    }
}

impl Solid for JohnsonCook {
    const PHASE: MaterialKind = MaterialKind::Plastic;
    const HISTORY: &'static [&'static str] = &["plastic strain", "temperature rise"];

    fn elastic(&self) -> Elastic {
        self.elastic
    }

    fn start(&self, start: &StartState) -> Result<PointState, String> {
        self.elastic.start_below_yield(start, self.yield_stress)
    }

    #[inline(always)]
    fn response(&self, increment: &Increment, point: Point<'_>) -> Response {
        let moduli = self.elastic.moduli();
        let mut s = moduli.deviator(increment, &point);
        let [strain, rise] = point.history else { unreachable!("two history variables") };
        let trial = equivalent(&s);
        if trial > self.yield_stress_at(*strain, 0.0, *rise) {
            let residual = |plastic: f64| {
                let strength = self.yield_stress_at(*strain + plastic, plastic / increment.dt, *rise);
                trial - 3.0 * moduli.shear * plastic - strength
            };
            let plastic = self.plastic_increment(trial, residual);
            let stress = trial - 3.0 * moduli.shear * plastic;
            s = s * (stress / trial);
            *strain += plastic;
            *rise += self.heat_fraction * stress * plastic * increment.volume_ratio
                / (self.elastic.density * self.specific_heat);
        }
        moduli.response(s, increment.volume_ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::JohnsonCook;
    use crate::material::StartState;
    use crate::material::elastic::Elastic;
    use crate::material::testing::{TestParticle, check_law};
    use crate::math::Tensor;

    /// OFHC copper (Johnson & Cook 1983).
    fn copper() -> JohnsonCook {
        JohnsonCook {
            elastic: Elastic::new(8960.0, 124e9, 0.34),
            yield_stress: 90e6,
            hardening: 292e6,
            hardening_exponent: 0.31,
            rate_coefficient: 0.025,
            reference_rate: 1.0,
            softening_exponent: 1.09,
            melting_rise: 1063.0,
            specific_heat: 383.0,
            heat_fraction: 0.9,
        }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&JohnsonCook { yield_stress: 1e12, ..copper() }, StartState::default());
    }

    /// Fast isochoric stretching to ε = 0.5 ends on the formula, written out here, at the rate that was
    /// imposed, and the heat is nine tenths of the work.
    #[test]
    fn fast_stretching_ends_on_the_formula() {
        let (law, rate, steps) = (copper(), 1e4, 2000);
        let mut sample = TestParticle::new(&law, StartState::default());
        let gradient = Tensor([[rate, 0.0, 0.0], [0.0, -0.5 * rate, 0.0], [0.0, 0.0, -0.5 * rate]]);
        for _ in 0..steps {
            sample.step(&law, gradient, 0.5 / rate / f64::from(steps));
        }
        let [strain, rise] = sample.history[..] else { panic!("two history variables") };
        let stress = sample.stress[0].von_mises();
        let formula =
            (90e6 + 292e6 * strain.powf(0.31)) * (1.0 + 0.025 * 1e4f64.ln()) * (1.0 - (rise / 1063.0).powf(1.09));
        assert!((strain - 0.5).abs() < 0.01 && (stress / formula - 1.0).abs() < 1e-3, "{strain} {stress} {formula}");
        let heat = 0.9 * sample.energy[0] / (8960.0 * 383.0);
        assert!((rise / heat - 1.0).abs() < 0.01 && rise > 30.0, "{rise} K of {heat} K");
    }
}
