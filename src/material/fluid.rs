//! Fluid: pressure from an equation of state, Newtonian shear viscosity with viscous heating
//! (paper's null material; theory 3.1, 3.2, 3.4).

use super::bulk_viscosity::BulkViscosity;
use super::eos::{Coefficients, EquationsOfState};
use super::flow::Flow;
use super::{PointBatch, PointLaw, PointState, StartState, Storage};
use crate::math::{SymTensor, Tensor};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Liquid or gas: σ = −(p + q) 1 + 2 μ dev D, with p from an equation of state.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Fluid {
    /// Density ρ0 in the reference state.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Shear viscosity μ; its work heats the fluid.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa*s", "minimum" = 0.0))]
    pub viscosity: f64,
    /// Artificial bulk viscosity [q1, q2] against shocks: 1.5, 0.06 for strong ones, 0 for none.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub bulk_viscosity: BulkViscosity,
    /// Equation of state.
    pub eos: EquationsOfState,
}

impl Fluid {
    fn flow(&self) -> Flow {
        Flow { density: self.density, viscosity: self.viscosity, bulk_viscosity: self.bulk_viscosity }
    }

    fn at_rest(&self) -> Coefficients {
        self.eos.as_dyn().coefficients(self.density, 0.0)
    }
}

impl PointLaw for Fluid {
    fn density(&self) -> f64 {
        self.density
    }

    fn storage(&self) -> Storage {
        Storage { stress: self.viscosity > 0.0, ..Storage::default() }
    }

    fn initial(&self, start: &StartState) -> Result<PointState, String> {
        self.bulk_viscosity.check()?;
        if start.stress.is_some() {
            return Err("a fluid starts from a `pressure` or an `energy`, not from a stress".into());
        }
        let eos = self.eos.as_dyn();
        let state = eos.start(self.density, start)?;
        let k = eos.coefficients(self.density, state.compression);
        let modulus = k.modulus(state.energy, state.pressure, 1.0 / (1.0 + state.compression));
        Ok(PointState {
            density: self.density * (1.0 + state.compression),
            energy: state.energy,
            pressure: state.pressure,
            stress: SymTensor::isotropic(-state.pressure),
            deformation: Tensor::identity() * (1.0 + state.compression).powf(-1.0 / 3.0),
            sound_speed: (modulus / self.density).sqrt(),
        })
    }

    fn update(&self, batch: &mut PointBatch<'_>) {
        self.eos.as_dyn().advance(&self.flow(), batch);
    }

    /// The cold speed of sound at ρ0; zero for a gas, whose speed depends on its state at the start.
    fn reference_sound_speed(&self) -> f64 {
        (self.at_rest().modulus(0.0, 0.0, 1.0) / self.density).sqrt()
    }

    fn diffusivity(&self) -> f64 {
        4.0 / 3.0 * self.viscosity / self.density
    }
}
