//! Artificial bulk viscosity, which spreads shocks over a few cells (theory B.6).
//!
//! ```text
//! q = ρ l (q1 l (tr D)² − q2 c tr D)        where tr D < 0, else 0
//! Q = q2 c + q1 l |tr D|,   Δt ≤ l / (Q + √(Q² + c²))
//! ```

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Coefficients [q1, q2] of the quadratic and the linear part; [0, 0] switches the viscosity off.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
#[schemars(inline)]
pub struct BulkViscosity(pub [f64; 2]);

/// The viscosity of one particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shock {
    /// Viscous pressure q [Pa].
    pub pressure: f64,
    /// Viscous speed Q [m/s].
    pub spread: f64,
}

impl Shock {
    /// No viscosity.
    pub const NONE: Self = Self { pressure: 0.0, spread: 0.0 };

    /// Speed that bounds the step, Q + √(Q² + c²) [m/s], for the square of the sound speed [m²/s²].
    #[inline(always)]
    pub fn wave_speed(&self, c_squared: f64) -> f64 {
        let c_squared = if c_squared < 0.0 { 0.0 } else { c_squared };
        self.spread + (self.spread * self.spread + c_squared).sqrt()
    }
}

impl BulkViscosity {
    /// True if there is none.
    pub fn is_zero(&self) -> bool {
        self.0 == [0.0, 0.0]
    }

    /// The viscosity at density `rho` [kg/m³], sound speed `c` [m/s], volume rate
    /// `rate` = tr D [1/s] and cell size `length` [m].
    #[inline(always)]
    pub fn shock(&self, rho: f64, c: f64, rate: f64, length: f64) -> Shock {
        let [q1, q2] = self.0;
        let closing = if rate < 0.0 { -rate * length } else { 0.0 };
        let linear = if rate < 0.0 { q2 * c } else { 0.0 };
        let spread = q1 * closing + linear;
        Shock { pressure: rho * closing * spread, spread }
    }

    /// Why the coefficients are wrong, if they are.
    ///
    /// # Errors
    /// A sentence, for negative coefficients.
    pub fn check(&self) -> Result<(), String> {
        if self.0.iter().all(|q| *q >= 0.0) {
            Ok(())
        } else {
            Err("the coefficients of the bulk viscosity can't be negative".into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BulkViscosity;

    #[test]
    fn acts_in_compression_only() {
        let q = BulkViscosity([1.5, 0.06]);
        let shock = q.shock(2.0, 10.0, -3.0, 0.5);
        assert!((shock.pressure - 2.0 * 0.5 * (1.5 * 0.5 * 9.0 + 0.06 * 10.0 * 3.0)).abs() < 1e-14);
        let spread: f64 = 0.06 * 10.0 + 1.5 * 0.5 * 3.0;
        assert!((shock.wave_speed(100.0) - (spread + spread.hypot(10.0))).abs() < 1e-14);
        let release = q.shock(2.0, 10.0, 3.0, 0.5);
        assert_eq!((release.pressure, release.wave_speed(100.0)), (0.0, 10.0));
    }

    #[test]
    fn negative_coefficients_are_refused() {
        assert!(BulkViscosity([-1.0, 0.0]).check().is_err());
        assert!(BulkViscosity([1.0, 0.0]).check().is_ok());
    }
}
