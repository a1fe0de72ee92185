//! Constant viscosity (theory F.8).

use super::ViscousLaw;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Constant viscosity.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Newtonian {
    /// Density.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Viscosity µ.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa s", "minimum" = 0.0))]
    pub viscosity: f64,
}

impl ViscousLaw for Newtonian {
    fn density(&self) -> f64 {
        self.density
    }

    fn viscosity(&self, _shear_rate: f64) -> f64 {
        self.viscosity
    }

    fn is_newtonian(&self) -> bool {
        true
    }
}
