//! Equations of state: pressure from compression and internal energy.
//!
//! All of them are linear in the energy (theory B.3, B.4), with η = ρ/ρ0 − 1 and E the internal energy per
//! unit reference volume:
//!
//! ```text
//! p = A(η) + B(η) E,      ρ0 c² = A' + B' E + B p / (1 + η)²
//! ```
//!
//! so that the trapezoidal energy balance of a step solves for p without iteration. The second formula is
//! dp/dρ along an isentrope, on which dE = p dη / (1 + η)².

mod flow;
mod gas;
mod ideal_gas;
mod jwl;
mod linear;
mod mie_gruneisen;
mod polynomial;
mod stiffened_gas;
mod tait;

pub use flow::FlowProperties;
pub use ideal_gas::IdealGas;
pub use jwl::Jwl;
pub use linear::LinearLiquid;
pub use mie_gruneisen::{MieGruneisen, Tension};
pub use polynomial::Polynomial;
pub use stiffened_gas::StiffenedGas;
pub use tait::Tait;

use super::{MaterialKind, PointBatch, StartState};
use crate::math::nearest_root;
use crate::registry;

registry! {
    /// The equations of state, by the name that a case gives as `kind`.
    pub enum EquationsOfState: EquationOfState, tag = "kind" {
        "ideal-gas" => IdealGas,
        "stiffened-gas" => StiffenedGas,
        "mie-gruneisen" => MieGruneisen,
        "tait" => Tait,
        "linear" => LinearLiquid,
        "polynomial" => Polynomial,
        "jwl" => Jwl,
    }
}

/// A and B of `p = A(η) + B(η) E`, and their derivatives in η.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// A [Pa].
    pub a: f64,
    /// B [1].
    pub b: f64,
    /// A' [Pa].
    pub da: f64,
    /// B' [1].
    pub db: f64,
}

impl Coefficients {
    /// Pressure [Pa] at energy `e` per reference volume [J/m³].
    #[inline(always)]
    pub fn pressure(&self, e: f64) -> f64 {
        self.a + self.b * e
    }

    /// ρ0 c² [Pa] at energy `e` [J/m³] and pressure `p` [Pa]; `expansion` is V/V0 = 1/(1 + η).
    #[inline(always)]
    pub fn modulus(&self, e: f64, p: f64, expansion: f64) -> f64 {
        self.da + self.db * e + self.b * p * expansion * expansion
    }
}

/// State of a fluid at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluidState {
    /// Compression η = ρ/ρ0 − 1.
    pub compression: f64,
    /// Internal energy per reference volume [J/m³].
    pub energy: f64,
    /// Pressure [Pa].
    pub pressure: f64,
}

/// An equation of state `p = A(η) + B(η) E`.
///
/// ```
/// use lateen::material::eos::{EquationOfState, IdealGas, LinearLiquid};
///
/// // Air at rest: p = (γ − 1) E.
/// let air = IdealGas { gamma: 1.4 };
/// assert!((air.coefficients(1.2, 0.0).pressure(250e3) - 100e3).abs() < 1e-6);
/// // Water pressed together by 1 %: p = c0² (ρ − ρ0).
/// let water = LinearLiquid { sound_speed: 100.0, tensile_strength: 0.0 };
/// assert!((water.coefficients(1000.0, 0.01).pressure(0.0) - 1e5).abs() < 1e-6);
/// ```
pub trait EquationOfState: std::fmt::Debug + Send + Sync {
    /// A, B and their derivatives at compression `eta`, for the reference density ρ0 [kg/m³].
    fn coefficients(&self, density: f64, eta: f64) -> Coefficients;

    /// A gas or a liquid.
    fn phase(&self) -> MaterialKind;

    /// The pressure never falls below this value [Pa]; −∞ for a fluid that bears any tension.
    fn least_pressure(&self) -> f64 {
        f64::NEG_INFINITY
    }

    /// True if p is proportional to the energy per volume as it is now, p = (γ − 1) e/V.
    fn is_ideal_gas(&self) -> bool {
        false
    }

    /// The initial state for the values that the case prescribes: a liquid, which rests at η = 0, E = 0.
    ///
    /// # Errors
    /// A sentence that says why there is no such state.
    fn start(&self, density: f64, start: &StartState) -> Result<FluidState, String> {
        start_liquid(self, density, start)
    }

    /// Advances a batch. Provided so that there is a compiled loop for each equation of state.
    fn advance(&self, flow: &FlowProperties, batch: &mut PointBatch<'_>) {
        flow::advance(self, flow, batch);
    }
}

/// A liquid compressed from rest to a pressure. Its energy is the trapezoidal work of one increment,
/// E = ½ p η/(1+η) — the Hugoniot — hence p = A / (1 − ½ B η/(1+η)).
fn start_liquid<E: EquationOfState + ?Sized>(eos: &E, density: f64, start: &StartState) -> Result<FluidState, String> {
    if let Some(energy) = start.energy {
        let pressure = eos.coefficients(density, 0.0).pressure(energy).max(eos.least_pressure());
        return Ok(FluidState { compression: 0.0, energy, pressure });
    }
    let Some(pressure) = start.pressure else {
        let pressure = eos.coefficients(density, 0.0).pressure(0.0).max(eos.least_pressure());
        return Ok(FluidState { compression: 0.0, energy: 0.0, pressure });
    };
    if pressure < eos.least_pressure() {
        return Err(format!(
            "a pressure of {pressure:e} Pa is below the least pressure {:e} Pa that this liquid bears",
            eos.least_pressure()
        ));
    }
    let hugoniot = |x: f64| {
        let eta = x.exp_m1();
        let k = eos.coefficients(density, eta);
        k.a / (1.0 - 0.5 * k.b * eta * (-x).exp()) - pressure
    };
    let x = nearest_root(hugoniot, 1e-2, 3.0)
        .ok_or_else(|| format!("no density of this fluid gives a pressure of {pressure:e} Pa"))?;
    let compression = x.exp_m1();
    Ok(FluidState { compression, energy: 0.5 * pressure * compression * (-x).exp(), pressure })
}
