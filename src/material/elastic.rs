//! Moduli of isotropic elasticity, and the Jaumann-rate solid that the rate laws start from.
//!
//! ```text
//! p = −K ln J,      s^{n+1} = Q (sⁿ + G D' Δt) Qᵀ + G D' Δt           (theory 3.6)
//! ```
//!
//! Half of the strain increment is turned, because it happens before half of the rotation: this makes the
//! update second order, where adding the whole after the rotation is first order.
//! The pressure is a function of the volume, so that no path of increments makes it drift.

use super::solid::{Increment, Point};
use super::{PointState, StartState};
use crate::math::{SymTensor, Tensor};

/// Moduli of isotropic elasticity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moduli {
    /// Bulk modulus K [Pa].
    pub bulk: f64,
    /// Shear modulus G [Pa].
    pub shear: f64,
}

impl Moduli {
    /// From Young's modulus [Pa] and Poisson's ratio.
    #[inline(always)]
    pub fn new(young: f64, poisson: f64) -> Self {
        Self { bulk: young / (3.0 * (1.0 - 2.0 * poisson)), shear: young / (2.0 * (1.0 + poisson)) }
    }

    /// Lamé's first modulus λ = K − ⅔ G [Pa].
    #[inline(always)]
    pub fn lame(&self) -> f64 {
        self.bulk - 2.0 / 3.0 * self.shear
    }

    /// Modulus K + ⁴⁄₃ G of pressure waves [Pa].
    #[inline(always)]
    pub fn wave(&self) -> f64 {
        self.bulk + 4.0 / 3.0 * self.shear
    }

    /// Pressure of the rate laws, −K ln J [Pa].
    #[inline(always)]
    pub fn pressure(&self, volume_ratio: f64) -> f64 {
        -self.bulk * volume_ratio.ln()
    }

    /// Deviator of the rate laws after an elastic increment [Pa].
    #[inline(always)]
    pub fn deviator(&self, increment: &Increment, point: &Point<'_>) -> SymTensor {
        let half = increment.shear * self.shear;
        (point.deviator + half).rotated(&increment.rotation()) + half
    }

    /// First state of the rate laws: density and energy that go with the prescribed pressure or stress.
    ///
    /// # Errors
    /// A sentence, when an energy is prescribed.
    pub fn start(&self, density: f64, start: &StartState) -> Result<PointState, String> {
        let stress = start_stress(start)?;
        let (pressure, s) = (-stress.trace() / 3.0, stress.deviator());
        let j = (-pressure / self.bulk).exp();
        // ∫ K ln J dJ of the volume, s : s/4G of the shape.
        let energy = self.bulk * (j * j.ln() - j + 1.0) + j * s.contract(&s) / (4.0 * self.shear);
        Ok(PointState {
            density: density / j,
            energy,
            pressure,
            stress,
            deformation: Tensor::identity() * j.cbrt(),
            sound_speed: (self.wave() * j / density).sqrt(),
        })
    }
    /// As [`Moduli::start`], for a metal that yields at `yield_stress` [Pa].
    ///
    /// # Errors
    /// A sentence, when an energy is prescribed or a stress beyond yield.
    pub fn start_below_yield(&self, density: f64, start: &StartState, yield_stress: f64) -> Result<PointState, String> {
        let state = self.start(density, start)?;
        let equivalent = state.stress.von_mises();
        if equivalent > yield_stress {
            return Err(format!(
                "the stress at the start is beyond yield: von Mises {equivalent:e} Pa, yield stress {yield_stress:e} Pa"
            ));
        }
        Ok(state)
    }
}

/// The stress that a solid starts from.
///
/// # Errors
/// A sentence, when an energy is prescribed.
pub fn start_stress(start: &StartState) -> Result<SymTensor, String> {
    if start.energy.is_some() {
        return Err("a solid starts from a `pressure` or a `stress`, not from an energy".into());
    }
    Ok(start.stress.unwrap_or(SymTensor::isotropic(-start.pressure.unwrap_or(0.0))))
}
