//! Soil: Drucker–Prager's yield surface with friction, cohesion, dilation and a tension limit (theory B.12).
//!
//! ```text
//! τ = √(½ s : s),   σ_m = ⅓ tr σ,   f = τ + q_φ σ_m − k ≤ 0,   σ_m ≤ σ_t
//! q_φ = 3 tan φ/√(9 + 12 tan² φ),   k = 3 c/√(9 + 12 tan² φ)        (Mohr–Coulomb in plane strain)
//! Δλ = f/(G + K q_φ q_ψ),   σ_m ← σ_m − K q_ψ Δλ,   τ ← k − q_φ σ_m
//! ```
//!
//! The trial mean stress is K (ln J − θ_p) with the volume strain θ_p of dilation only. Opening under tension
//! is not stored: soil that was pulled apart must close before it bears pressure again.

use super::elastic::{Elastic, Moduli};
use super::increment::{Increment, Point, Response};
use super::solid::Solid;
use super::{MaterialKind, PointState, StartState};
use crate::math::SymTensor;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Soil and other granular matter: elastic up to friction and cohesion.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DruckerPrager {
    /// Density, Young's modulus, Poisson's ratio, artificial bulk viscosity.
    #[serde(flatten)]
    pub elastic: Elastic,
    /// Angle of internal friction φ.
    #[schemars(extend("unit" = "rad", "minimum" = 0.0, "exclusiveMaximum" = std::f64::consts::FRAC_PI_2))]
    pub friction_angle: f64,
    /// Angle of dilation ψ, at most φ; 0: shear keeps the volume.
    #[serde(default)]
    #[schemars(extend("unit" = "rad", "minimum" = 0.0, "exclusiveMaximum" = std::f64::consts::FRAC_PI_2))]
    pub dilation_angle: f64,
    /// Cohesion c.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub cohesion: f64,
    /// Largest mean tension σ_t; it is never more than that of the cone's apex.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub tensile_strength: f64,
}

/// The yield surface in the plane of mean stress and shear.
#[derive(Debug, Clone, Copy)]
struct Cone {
    /// Friction q_φ.
    friction: f64,
    /// Dilation q_ψ.
    dilation: f64,
    /// Cohesion k [Pa].
    cohesion: f64,
    /// Tension limit σ_t [Pa].
    tension: f64,
}

/// A state on or inside the yield surface, and the volume strain of dilation on the way to it.
#[derive(Debug, Clone, Copy)]
struct Given {
    /// Mean stress σ_m [Pa].
    mean: f64,
    /// Shear τ [Pa].
    shear: f64,
    /// q_ψ Δλ.
    dilation: f64,
}

impl Cone {
    /// Shear strength at mean stress `mean` [Pa].
    #[inline(always)]
    fn strength(&self, mean: f64) -> f64 {
        (self.cohesion - self.friction * mean).max(0.0)
    }

    /// Returns trial values of mean stress and shear (σ_m, τ) [Pa] to the surface.
    #[inline(always)]
    fn give(&self, moduli: &Moduli, mean: f64, shear: f64) -> Given {
        let corner = self.strength(self.tension);
        // The bisector of the corner parts the states that slide from those that open.
        let slope = self.friction.hypot(1.0) - self.friction;
        let excess = shear + self.friction * mean - self.cohesion;
        let opens = mean > self.tension && shear <= corner + slope * (mean - self.tension);
        if opens {
            return Given { mean: self.tension, shear: shear.min(corner), dilation: 0.0 };
        }
        if excess <= 0.0 {
            return Given { mean, shear, dilation: 0.0 };
        }
        let multiplier = excess / (moduli.shear + moduli.bulk * self.friction * self.dilation);
        let dilation = self.dilation * multiplier;
        let mean = (mean - moduli.bulk * dilation).min(self.tension);
        Given { mean, shear: self.strength(mean), dilation }
    }
}

impl DruckerPrager {
    #[inline(always)]
    fn cone(&self) -> Cone {
        let (friction, dilation) = (self.friction_angle.tan(), self.dilation_angle.tan());
        let matched = |tan: f64| 3.0 / (9.0 + 12.0 * tan * tan).sqrt();
        let cohesion = self.cohesion * matched(friction);
        let (friction, dilation) = (friction * matched(friction), dilation * matched(dilation));
        let apex = if friction > 0.0 { cohesion / friction } else { f64::INFINITY };
        Cone { friction, dilation, cohesion, tension: self.tensile_strength.min(apex) }
    }
}

/// √(½ s : s).
#[inline(always)]
fn shear_stress(s: &SymTensor) -> f64 {
    (0.5 * s.contract(s)).sqrt()
}

impl Solid for DruckerPrager {
    const PHASE: MaterialKind = MaterialKind::Plastic;

    const HISTORY: &'static [&'static str] = &["plastic strain", "plastic volume strain"];

    fn elastic(&self) -> Elastic {
        self.elastic
    }

    fn start(&self, start: &StartState) -> Result<PointState, String> {
        if self.dilation_angle > self.friction_angle {
            return Err("the angle of dilation can't exceed the angle of friction".into());
        }
        let state = self.elastic.start(start)?;
        let (cone, mean) = (self.cone(), -state.pressure);
        let shear = shear_stress(&state.stress.deviator());
        if mean > cone.tension || shear > cone.strength(mean) {
            return Err(format!(
                "the stress at the start is beyond yield: mean {mean:e} Pa of {:e} Pa, shear {shear:e} Pa of {:e} Pa",
                cone.tension,
                cone.strength(mean)
            ));
        }
        Ok(state)
    }

    #[inline(always)]
    fn response(&self, increment: &Increment, point: Point<'_>) -> Response {
        let moduli = self.elastic.moduli();
        let s = moduli.deviator(increment, &point);
        let [plastic_strain, plastic_volume] = point.history else { unreachable!("two history variables") };
        let shear = shear_stress(&s);
        let mean = moduli.bulk * (increment.volume_ratio.ln() - *plastic_volume);

        let given = self.cone().give(&moduli, mean, shear);
        *plastic_volume += given.dilation;
        *plastic_strain += (shear - given.shear) / (3f64.sqrt() * moduli.shear);
        let s = if shear > 0.0 { s * (given.shear / shear) } else { s };
        Response { stress: s + SymTensor::isotropic(given.mean), modulus: moduli.wave() }
    }
}

#[cfg(test)]
mod tests {
    use super::DruckerPrager;
    use crate::material::elastic::Elastic;
    use crate::material::testing::{TestParticle, check_law};
    use crate::material::{PointLaw, StartState};
    use crate::math::{SymTensor, Tensor};

    fn soil(cohesion: f64, dilation: f64) -> DruckerPrager {
        DruckerPrager {
            elastic: Elastic::new(1800.0, 20e6, 0.3),
            friction_angle: 30f64.to_radians(),
            dilation_angle: dilation.to_radians(),
            cohesion,
            tensile_strength: 0.0,
        }
    }

    fn pressed(pressure: f64) -> StartState {
        StartState { pressure: Some(pressure), ..StartState::default() }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&soil(1e12, 0.0), pressed(1e5));
        check_law(&soil(1e12, 10.0), pressed(1e5));
    }

    /// Steady plane-strain flow with associated dilation ends on Mohr–Coulomb's surface,
    /// ½ (σ1 − σ3) = c cos φ − ½ (σ1 + σ3) sin φ.
    #[test]
    fn plane_strain_limit_is_mohr_coulomb() {
        let (law, phi) = (soil(5e3, 30.0), 30f64.to_radians());
        let mut sample = TestParticle::new(&law, pressed(1e5));
        let mut gradient = Tensor::ZERO;
        (gradient[0][0], gradient[1][1]) = (1.0 + phi.sin(), -(1.0 - phi.sin()));
        for _ in 0..4000 {
            sample.step(&law, gradient, 5e-5);
        }
        let [xx, yy, ..] = sample.stress[0].0;
        let limit = 5e3 * phi.cos() - 0.5 * (xx + yy) * phi.sin();
        assert!(xx - yy > 1e4, "the soil bears shear: {:?}", sample.stress[0]);
        assert!((0.5 * (xx - yy) / limit - 1.0).abs() < 1e-3, "{} {limit}", 0.5 * (xx - yy));
    }

    /// Shear without dilation keeps the pressure and is bounded by k + q_φ p.
    #[test]
    fn shear_is_bounded_by_friction() {
        let law = soil(0.0, 0.0);
        let mut sample = TestParticle::new(&law, pressed(1e5));
        let mut gradient = Tensor::ZERO;
        gradient[0][1] = 1.0;
        for _ in 0..500 {
            sample.step(&law, gradient, 1e-4);
        }
        let tan = 30f64.to_radians().tan();
        let strength = 3.0 * tan / (9.0 + 12.0 * tan * tan).sqrt() * 1e5;
        let s = sample.stress[0].deviator();
        assert!((sample.pressure[0] / 1e5 - 1.0).abs() < 1e-9);
        assert!(((0.5 * s.contract(&s)).sqrt() / strength - 1.0).abs() < 1e-12);
    }

    #[test]
    fn opened_soil_bears_nothing_until_it_closes() {
        let law = soil(0.0, 0.0);
        let mut sample = TestParticle::new(&law, pressed(1e3));
        let open = Tensor([[0.1, 0.05, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.03]]);
        sample.step(&law, open, 0.1);
        assert!(sample.stress[0].contract(&sample.stress[0]) == 0.0, "{:?}", sample.stress[0]);
        sample.step(&law, Tensor::identity() * -0.04, 0.1);
        assert_eq!(sample.pressure[0], 0.0);
        sample.step(&law, Tensor::identity() * -0.04, 0.1);
        assert!(sample.pressure[0] > 0.0);
    }

    #[test]
    fn starts_beyond_yield_are_refused() {
        assert!(soil(0.0, 0.0).initial(&pressed(-1.0)).unwrap_err().contains("yield"));
        let stress = SymTensor([-1e3, -1e3, -1e3, 1e3, 0.0, 0.0]);
        let sheared = StartState { stress: Some(stress), ..StartState::default() };
        assert!(soil(0.0, 0.0).initial(&sheared).unwrap_err().contains("yield"));
        assert!(soil(0.0, 40.0).initial(&pressed(1.0)).unwrap_err().contains("dilation"));
    }
}
