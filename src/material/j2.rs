//! Elastic–plastic metal: von Mises yield surface, isotropic hardening, radial return (theory B.10).
//!
//! ```text
//! σ_y = A(ε_p) + H ε_pⁿ,                     A a number, or a curve and H = 0
//! s_tr = Q (sⁿ + G D' Δt) Qᵀ + G D' Δt,      σ_tr = √(3/2 s_tr : s_tr)
//! σ_tr − 3 G Δε_p = σ_y(ε_p + Δε_p)        if σ_tr > σ_y(ε_p)
//! s = s_tr (1 − 3 G Δε_p/σ_tr)
//! ```

use super::elastic::{Elastic, equivalent};
use super::increment::{Increment, Point, Response};
use super::solid::Solid;
use super::yield_curve::YieldCurve;
use super::{MaterialKind, PointState, StartState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elastic–plastic metal with yield stress A + H ε_pⁿ, or with a measured curve A(ε_p).
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct J2 {
    /// Density, Young's modulus, Poisson's ratio, artificial bulk viscosity.
    #[serde(flatten)]
    pub elastic: Elastic,
    /// First yield stress A, or a curve of the yield stress over plastic strain.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub yield_stress: YieldCurve,
    /// Hardening modulus H; 0: perfectly plastic.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub hardening: f64,
    /// Hardening exponent n; 1: linear.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub hardening_exponent: f64,
}

fn one() -> f64 {
    1.0
}

impl J2 {
    /// Yield stress at plastic strain `strain` [Pa].
    #[inline(always)]
    pub fn yield_stress_at(&self, strain: f64) -> f64 {
        self.yield_stress.yield_stress_at(strain) + self.hardening * power(strain, self.hardening_exponent)
    }

    /// The plastic strain increment that brings the trial stress `trial` [Pa] back to the yield surface.
    #[inline(always)]
    fn plastic_increment(&self, trial: f64, strain: f64, shear: f64) -> f64 {
        if !self.yield_stress.is_constant() {
            return self.yield_stress.plastic_increment(trial, strain, 3.0 * shear);
        }
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
        let (mut increment, first_yield) = (first, self.yield_stress.first_yield());
        for _ in 0..ITERATIONS {
            let hardening = self.hardening * power(strain + increment, self.hardening_exponent);
            let residual = trial - 3.0 * shear * increment - first_yield - hardening;
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
    const PHASE: MaterialKind = MaterialKind::Plastic;
    const HISTORY: &'static [&'static str] = &["plastic strain"];

    fn elastic(&self) -> Elastic {
        self.elastic
    }

    fn start(&self, start: &StartState) -> Result<PointState, String> {
        if self.hardening > 0.0 && !self.yield_stress.is_constant() {
            return Err("a curve as `yield-stress` holds the hardening already: leave out `hardening`".into());
        }
        self.elastic.start_below_yield(start, self.yield_stress.first_yield())
    }

    #[inline(always)]
    fn response(&self, increment: &Increment, point: Point<'_>) -> Response {
        let moduli = self.elastic.moduli();
        let mut s = moduli.deviator(increment, &point);
        let strain = &mut point.history[0];
        let trial = equivalent(&s);
        if trial > self.yield_stress_at(*strain) {
            let plastic = self.plastic_increment(trial, *strain, moduli.shear);
            s = s * (1.0 - 3.0 * moduli.shear * plastic / trial);
            *strain += plastic;
        }
        moduli.response(s, increment.volume_ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::J2;
    use crate::material::elastic::Elastic;
    use crate::material::testing::{TestParticle, check_law};
    use crate::material::{PointLaw, StartState, YieldCurve};
    use crate::math::{SymTensor, Tensor};

    fn copper(hardening: f64, hardening_exponent: f64) -> J2 {
        J2 { elastic: Elastic::new(8930.0, 117e9, 0.35), yield_stress: 400e6.into(), hardening, hardening_exponent }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&J2 { yield_stress: 1e12.into(), ..copper(1e8, 1.0) }, StartState::default());
        check_law(&J2 { yield_stress: 1e12.into(), ..copper(1e8, 0.4) }, StartState::default());
    }

    /// Confined compression ε in one direction: the axial deviator grows as ⅔·2Gε up to ⅔ A and then with
    /// the slope of 3G in series with H, so that |σ11| = K ε + ⅔ (A + H ε_p), ε_p = (2Gε − A)/(3G + H).
    #[test]
    fn confined_compression_with_linear_hardening() {
        let (law, strain, steps) = (copper(100e6, 1.0), 0.05, 500);
        let (bulk, g) = (117e9 / (3.0 * 0.3), 117e9 / 2.7);
        let mut sample = TestParticle::new(&law, StartState::default());
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
        let mut sample = TestParticle::new(&law, StartState::default());
        let gradient = Tensor([[0.4, 0.9, 0.0], [-0.2, -0.6, 0.3], [0.0, 0.8, 0.2]]);
        for _ in 0..20 {
            sample.step(&law, gradient, 1e-2);
            let surface = 400e6 + 300e6 * sample.history[0].powf(0.31);
            assert!((sample.stress[0].von_mises() / surface - 1.0).abs() < 1e-9);
        }
    }

    /// A straight curve is linear hardening, whose closed form is above; a bend in it is met to the digit.
    #[test]
    fn hardening_follows_a_yield_curve_exactly() {
        let bent = YieldCurve::try_from(vec![[0.0, 400e6], [0.01, 500e6], [0.02, 510e6]]).unwrap();
        let law = J2 { yield_stress: bent, ..copper(0.0, 1.0) };
        let mut sample = TestParticle::new(&law, StartState::default());
        let gradient = Tensor([[0.0, 1.0, 0.0], [0.0; 3], [0.0; 3]]);
        for (steps, strength) in [(20, 400e6..=500e6), (10, 500e6..=510e6), (100, 510e6..=510e6)] {
            (0..steps).for_each(|_| sample.step(&law, gradient, 1e-3));
            let (strain, stress) = (sample.history[0], sample.stress[0].von_mises());
            let exact = (400e6 + 1e10 * strain).min(500e6 + 1e9 * (strain - 0.01)).min(510e6);
            assert!((stress / exact - 1.0).abs() < 1e-9 && strength.contains(&exact), "{strain}: {stress} {exact}");
        }
        let both = J2 { hardening: 1e8, ..law };
        assert!(both.initial(&StartState::default()).unwrap_err().contains("leave out `hardening`"));
    }

    /// All the work of perfectly plastic shear beyond yield is heat: e = A²/6G + A ε_p.
    #[test]
    fn plastic_work_heats() {
        let (law, steps) = (copper(0.0, 1.0), 1000);
        let mut sample = TestParticle::new(&law, StartState::default());
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

    #[test]
    fn a_law_that_yields_has_no_tangent() {
        let refusal = copper(0.0, 1.0).elastic_law().unwrap_err();
        assert!(refusal.contains("tangent") && refusal.contains("plastic strain"), "{refusal}");
    }
}
