//! Laws of fluids on a mesh.

use crate::material::Viscosity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Laws of fluids on a mesh, for `method = "pfem2"`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum FlowLaw {
    /// Constant viscosity.
    Newtonian {
        /// Density.
        #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
        density: f64,
        /// Viscosity µ.
        #[serde(default)]
        #[schemars(extend("unit" = "Pa s", "minimum" = 0.0))]
        viscosity: f64,
    },
    /// A yield stress and a constant plastic viscosity.
    Bingham {
        /// Density.
        #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
        density: f64,
        /// Plastic viscosity.
        #[schemars(extend("unit" = "Pa s", "minimum" = 0.0))]
        viscosity: f64,
        /// Yield stress.
        #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
        yield_stress: f64,
        /// Shear rate below which the law is regularised.
        #[serde(default = "regularisation")]
        #[schemars(extend("unit" = "1/s", "exclusiveMinimum" = 0.0))]
        regularisation: f64,
    },
    /// A yield stress and a power law k γ̇ⁿ.
    HerschelBulkley {
        /// Density.
        #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
        density: f64,
        /// Consistency k [Pa sⁿ], in SI.
        #[schemars(extend("minimum" = 0.0))]
        consistency: f64,
        /// Exponent n.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 3.0))]
        index: f64,
        /// Yield stress.
        #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
        yield_stress: f64,
        /// Shear rate below which the law is regularised.
        #[serde(default = "regularisation")]
        #[schemars(extend("unit" = "1/s", "exclusiveMinimum" = 0.0))]
        regularisation: f64,
    },
}

fn regularisation() -> f64 {
    1e-2
}

impl FlowLaw {
    /// The names that a case may use.
    pub const NAMES: &'static [&'static str] = &["newtonian", "bingham", "herschel-bulkley"];

    /// Its name, as a case writes it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Newtonian { .. } => "newtonian",
            Self::Bingham { .. } => "bingham",
            Self::HerschelBulkley { .. } => "herschel-bulkley",
        }
    }

    /// Density [kg/m³] and law of viscosity.
    pub fn parts(&self) -> (f64, Viscosity) {
        match *self {
            Self::Newtonian { density, viscosity } => (density, Viscosity::Newtonian(viscosity)),
            Self::Bingham { density, viscosity, yield_stress, regularisation } => {
                let law =
                    Viscosity::HerschelBulkley { consistency: viscosity, index: 1.0, yield_stress, regularisation };
                (density, law)
            }
            Self::HerschelBulkley { density, consistency, index, yield_stress, regularisation } => {
                (density, Viscosity::HerschelBulkley { consistency, index, yield_stress, regularisation })
            }
        }
    }
}
