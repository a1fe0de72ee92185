//! A yield stress and a power law (theory F.8).

use super::{ViscousLaw, regularisation, yielding};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A yield stress and a power law k γ̇ⁿ.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct HerschelBulkley {
    /// Density.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Consistency k [Pa sⁿ], in SI.
    #[schemars(extend("minimum" = 0.0))]
    pub consistency: f64,
    /// Exponent n.
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = 0.0, "maximum" = 3.0))]
    pub index: f64,
    /// Yield stress.
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub yield_stress: f64,
    /// Shear rate below which the law is regularised.
    #[serde(default = "regularisation")]
    #[schemars(extend("unit" = "1/s", "exclusiveMinimum" = 0.0))]
    pub regularisation: f64,
}

impl ViscousLaw for HerschelBulkley {
    fn density(&self) -> f64 {
        self.density
    }

    fn viscosity(&self, shear_rate: f64) -> f64 {
        let power = shear_rate.max(self.regularisation).powf(self.index - 1.0);
        self.consistency * power + self.yield_stress / self.regularisation * yielding(shear_rate, self.regularisation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Bingham;

    #[test]
    fn stress_is_that_of_the_law_well_above_the_regularisation() {
        let yield_stress = 4.0;
        let law = HerschelBulkley { density: 1.0, consistency: 3.0, index: 0.5, yield_stress, regularisation: 1e-4 };
        assert!((law.viscosity(9.0) * 9.0 - (4.0 + 3.0 * 3.0)).abs() < 1e-9);
    }

    #[test]
    fn an_exponent_of_one_is_the_law_of_bingham() {
        let (density, yield_stress, regularisation) = (1.0, 10.0, 1e-3);
        let law = HerschelBulkley { density, consistency: 2.0, index: 1.0, yield_stress, regularisation };
        let bingham = Bingham { density, viscosity: 2.0, yield_stress, regularisation };
        for rate in [0.0, 1e-9, 1e-3, 0.4, 70.0] {
            assert_eq!(law.viscosity(rate), bingham.viscosity(rate));
        }
    }
}
