//! Laws of viscosity μ(γ̇), with the shear rate γ̇ = √(2 d:d).
//!
//! ```text
//! Newton             μ
//! Herschel–Bulkley   k γ̇ⁿ⁻¹ + τ_y (1 − e^(−γ̇/γ̇_0))/γ̇       regularised (Papanastasiou 1987); n = 1: Bingham
//! ```
//!
//! Below γ̇_0 the yield stress acts as the large but finite viscosity τ_y/γ̇_0; the power law keeps its value there.

/// A law of viscosity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Viscosity {
    /// Constant μ [Pa s].
    Newtonian(f64),
    /// A yield stress and a power law.
    HerschelBulkley {
        /// Consistency k [Pa sⁿ]; the plastic viscosity [Pa s] of a Bingham fluid.
        consistency: f64,
        /// Exponent n; 1: Bingham.
        index: f64,
        /// Yield stress τ_y [Pa].
        yield_stress: f64,
        /// Shear rate γ̇_0 below which the law is regularised [1/s].
        regularisation: f64,
    },
}

impl Viscosity {
    /// μ [Pa s] at a shear rate [1/s].
    pub fn at(&self, shear_rate: f64) -> f64 {
        match *self {
            Self::Newtonian(viscosity) => viscosity,
            Self::HerschelBulkley { consistency, index, yield_stress, regularisation } => {
                let ratio = shear_rate / regularisation;
                // (1 − e⁻ʳ)/r → 1
                let plastic = if ratio > 1e-8 { -(-ratio).exp_m1() / ratio } else { 1.0 };
                let power = shear_rate.max(regularisation).powf(index - 1.0);
                consistency * power + yield_stress / regularisation * plastic
            }
        }
    }

    /// True if it depends on the shear rate.
    pub fn varies(&self) -> bool {
        !matches!(self, Self::Newtonian(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINGHAM: Viscosity =
        Viscosity::HerschelBulkley { consistency: 2.0, index: 1.0, yield_stress: 10.0, regularisation: 1e-3 };

    #[test]
    fn stress_is_that_of_the_law_well_above_the_regularisation() {
        for rate in [0.1, 1.0, 50.0] {
            assert!((BINGHAM.at(rate) * rate - (10.0 + 2.0 * rate)).abs() < 1e-9);
        }
        let law = Viscosity::HerschelBulkley { consistency: 3.0, index: 0.5, yield_stress: 4.0, regularisation: 1e-4 };
        assert!((law.at(9.0) * 9.0 - (4.0 + 3.0 * 3.0)).abs() < 1e-9);
    }

    #[test]
    fn viscosity_is_finite_at_rest_and_falls_from_there() {
        assert!((BINGHAM.at(0.0) - (2.0 + 1e4)).abs() < 1e-6);
        let rates: Vec<f64> = (0..60).map(|k| BINGHAM.at(1e-6 * 1.5f64.powi(k))).collect();
        assert!(rates.windows(2).all(|pair| pair[1] <= pair[0]));
    }
}
