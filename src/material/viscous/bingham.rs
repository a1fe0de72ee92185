//! A yield stress and a constant plastic viscosity (theory F.8).

use super::{ViscousLaw, regularisation, yielding};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A yield stress and a constant plastic viscosity.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Bingham {
    /// Density.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Plastic viscosity.
    #[schemars(extend("unit" = "Pa s", "minimum" = 0.0))]
    pub viscosity: f64,
    /// Yield stress.
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub yield_stress: f64,
    /// Shear rate below which the law is regularised.
    #[serde(default = "regularisation")]
    #[schemars(extend("unit" = "1/s", "exclusiveMinimum" = 0.0))]
    pub regularisation: f64,
}

impl ViscousLaw for Bingham {
    fn density(&self) -> f64 {
        self.density
    }

    fn viscosity(&self, shear_rate: f64) -> f64 {
        self.viscosity + self.yield_stress / self.regularisation * yielding(shear_rate, self.regularisation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINGHAM: Bingham = Bingham { density: 1.0, viscosity: 2.0, yield_stress: 10.0, regularisation: 1e-3 };

    #[test]
    fn stress_is_that_of_the_law_well_above_the_regularisation() {
        for rate in [0.1, 1.0, 50.0] {
            assert!((BINGHAM.viscosity(rate) * rate - (10.0 + 2.0 * rate)).abs() < 1e-9);
        }
    }

    #[test]
    fn viscosity_is_finite_at_rest_and_falls_from_there() {
        assert!((BINGHAM.viscosity(0.0) - (2.0 + 1e4)).abs() < 1e-6);
        let rates: Vec<f64> = (0..60).map(|k| BINGHAM.viscosity(1e-6 * 1.5f64.powi(k))).collect();
        assert!(rates.windows(2).all(|pair| pair[1] <= pair[0]));
    }
}
