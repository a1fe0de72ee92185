//! Elastic–plastic metal: von Mises yield surface, isotropic hardening, radial return (theory 3.6).
//!
//! ```text
//! σ_y = A + H ε_pⁿ
//! s_tr = Q (sⁿ + G D' Δt) Qᵀ + G D' Δt,      σ_tr = √(3/2 s_tr : s_tr)
//! σ_tr − 3 G Δε_p = σ_y(ε_p + Δε_p)        if σ_tr > σ_y(ε_p)
//! s = s_tr (1 − 3 G Δε_p/σ_tr)
//! ```

use super::bulk_viscosity::BulkViscosity;
use super::elastic::Moduli;
use super::solid::{self, Increment, Point, Response, Solid};
use super::{PointBatch, PointLaw, PointState, StartState, Storage};
use crate::math::SymTensor;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elastic–plastic metal with yield stress A + H ε_pⁿ.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct J2 {
    /// Density ρ0 in the reference state.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Young's modulus.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub young: f64,
    /// Poisson's ratio.
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = -1.0, "exclusiveMaximum" = 0.5))]
    pub poisson: f64,
    /// First yield stress A.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub yield_stress: f64,
    /// Hardening modulus H; 0: perfectly plastic.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub hardening: f64,
    /// Hardening exponent n; 1: linear.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub hardening_exponent: f64,
    /// Artificial bulk viscosity [q1, q2]; 0 for none.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub bulk_viscosity: BulkViscosity,
}

fn one() -> f64 {
    1.0
}

impl J2 {
    fn moduli(&self) -> Moduli {
        Moduli::new(self.young, self.poisson)
    }

    /// Yield stress at plastic strain `strain` [Pa].
    #[inline(always)]
    pub fn yield_stress_at(&self, strain: f64) -> f64 {
        self.yield_stress + self.hardening * power(strain, self.hardening_exponent)
    }

    /// The plastic strain increment that brings the trial stress `trial` [Pa] back to the yield surface.
    #[inline(always)]
    fn plastic_increment(&self, trial: f64, strain: f64, shear: f64) -> f64 {
        let excess = trial - self.yield_stress_at(strain);
        if self.hardening_exponent == 1.0 {
            return excess / (3.0 * shear + self.hardening);
        }
        self.power_increment(trial, strain, excess / (3.0 * shear), shear)
    }

    /// Newton's method for n < 1 from above, where the residual σ_tr − 3GΔ − σ_y(ε + Δ) is convex in Δ: one
    /// step crosses the root, the others rise to it.
    fn power_increment(&self, trial: f64, strain: f64, first: f64, shear: f64) -> f64 {
        /// Quadratic convergence needs five or six; the rest is margin.
        const ITERATIONS: usize = 30;
        let mut increment = first;
        for _ in 0..ITERATIONS {
            let hardening = self.hardening * power(strain + increment, self.hardening_exponent);
            let residual = trial - 3.0 * shear * increment - self.yield_stress - hardening;
            let slope = -3.0 * shear - self.hardening_exponent * hardening / (strain + increment);
            let next = (increment - residual / slope).max(0.1 * increment);
            if (next - increment).abs() <= 1e-14 * first {
                return next;
            }
            increment = next;
        }
        increment
    }
}

/// εⁿ, without the cost of a power for linear hardening.
#[inline(always)]
fn power(strain: f64, exponent: f64) -> f64 {
    if exponent == 1.0 { strain } else { strain.powf(exponent) }
}

impl Solid for J2 {
    fn bulk_viscosity(&self) -> BulkViscosity {
        self.bulk_viscosity
    }

    #[inline(always)]
    fn response(&self, increment: &Increment, point: Point<'_>) -> Response {
        let moduli = self.moduli();
        let mut s = moduli.deviator(increment, &point);
        let strain = &mut point.history[0];
        let trial = (1.5 * s.contract(&s)).sqrt();
        if trial > self.yield_stress_at(*strain) {
            let plastic = self.plastic_increment(trial, *strain, moduli.shear);
            s = s * (1.0 - 3.0 * moduli.shear * plastic / trial);
            *strain += plastic;
        }
        let pressure = moduli.pressure(increment.volume_ratio);
        Response { stress: s - SymTensor::isotropic(pressure), modulus: moduli.wave() }
    }
}

impl PointLaw for J2 {
    fn density(&self) -> f64 {
        self.density
    }

    fn storage(&self) -> Storage {
        Storage { stress: true, history: &["plastic strain"], ..Storage::default() }
    }

    fn initial(&self, start: &StartState) -> Result<PointState, String> {
        self.bulk_viscosity.check()?;
        self.moduli().start_below_yield(self.density, start, self.yield_stress)
    }

    fn update(&self, batch: &mut PointBatch<'_>) {
        solid::advance(self, batch);
    }

    fn reference_sound_speed(&self) -> f64 {
        (self.moduli().wave() / self.density).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::J2;
    use crate::material::bulk_viscosity::BulkViscosity;
    use crate::material::testing::{Sample, check_law};
    use crate::material::{PointLaw, StartState};
    use crate::math::{SymTensor, Tensor};

    fn copper(hardening: f64, hardening_exponent: f64) -> J2 {
        let bulk_viscosity = BulkViscosity::default();
        let (density, young, poisson, yield_stress) = (8930.0, 117e9, 0.35, 400e6);
        J2 { density, young, poisson, yield_stress, hardening, hardening_exponent, bulk_viscosity }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&J2 { yield_stress: 1e12, ..copper(1e8, 1.0) }, StartState::default());
        check_law(&J2 { yield_stress: 1e12, ..copper(1e8, 0.4) }, StartState::default());
    }

    /// Confined compression ε in one direction: the axial deviator grows as ⅔·2Gε up to ⅔ A and then with
    /// the slope of 3G in series with H, so that |σ11| = K ε + ⅔ (A + H ε_p), ε_p = (2Gε − A)/(3G + H).
    #[test]
    fn confined_compression_with_linear_hardening() {
        let (law, strain, steps) = (copper(100e6, 1.0), 0.05, 500);
        let (bulk, g) = (117e9 / (3.0 * 0.3), 117e9 / 2.7);
        let mut sample = Sample::new(&law, StartState::default());
        let mut gradient = Tensor::ZERO;
        gradient[0][0] = -strain;
        for _ in 0..steps {
            sample.step(&law, gradient, 1.0 / f64::from(steps));
        }
        let plastic = (2.0 * g * strain - 400e6) / (3.0 * g + 100e6);
        let exact = bulk * strain + 2.0 / 3.0 * (400e6 + 100e6 * plastic);
        assert!((sample.history[0] / plastic - 1.0).abs() < 1e-12, "{} {plastic}", sample.history[0]);
        assert!((-sample.stress[0].0[0] / exact - 1.0).abs() < 1e-12);
    }

    #[test]
    fn power_hardening_ends_on_the_yield_surface() {
        let law = copper(300e6, 0.31);
        let mut sample = Sample::new(&law, StartState::default());
        let gradient = Tensor([[0.4, 0.9, 0.0], [-0.2, -0.6, 0.3], [0.0, 0.8, 0.2]]);
        for _ in 0..20 {
            sample.step(&law, gradient, 1e-2);
            let surface = 400e6 + 300e6 * sample.history[0].powf(0.31);
            assert!((sample.stress[0].von_mises() / surface - 1.0).abs() < 1e-9);
        }
    }

    /// All the work of perfectly plastic shear beyond yield is heat: e = A²/6G + A ε_p.
    #[test]
    fn plastic_work_heats() {
        let (law, steps) = (copper(0.0, 1.0), 1000);
        let mut sample = Sample::new(&law, StartState::default());
        let gradient = Tensor([[0.1, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, 0.0]]);
        for _ in 0..steps {
            sample.step(&law, gradient, 1.0 / f64::from(steps));
        }
        let g = 117e9 / 2.7;
        let exact = 400e6f64.powi(2) / (6.0 * g) + 400e6 * sample.history[0];
        assert!((sample.energy[0] / exact - 1.0).abs() < 1e-4, "{}", sample.energy[0] / exact);
    }

    #[test]
    fn a_start_beyond_yield_is_refused() {
        let stress = SymTensor([0.0, 0.0, 0.0, 3e8, 0.0, 0.0]);
        let error = copper(0.0, 1.0).initial(&StartState { stress: Some(stress), ..StartState::default() });
        assert!(error.unwrap_err().contains("yield"));
    }
}
