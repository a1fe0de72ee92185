//! A fluid as a run starts with it.

use crate::material::ViscousLaw;
use std::sync::Arc;

/// A fluid.
#[derive(Debug, Clone)]
pub struct FluidSetup {
    /// Name.
    pub name: String,
    /// Density [kg/m³].
    pub density: f64,
    /// Law of viscosity.
    pub law: Arc<dyn ViscousLaw>,
}

impl FluidSetup {
    /// A fluid with a law.
    pub fn new(name: impl Into<String>, law: Box<dyn ViscousLaw>) -> Self {
        Self { name: name.into(), density: law.density(), law: law.into() }
    }
}

/// True for a fluid that is a gas beside another one: less than a tenth as dense [kg/m³].
pub fn is_gas(density: f64, heaviest: f64) -> bool {
    density < 0.1 * heaviest
}
