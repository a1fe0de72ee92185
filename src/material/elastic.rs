//! Moduli of isotropic elasticity (of incompressible solids: theory J.18), and the Jaumann-rate solid that the rate
//! laws start from.
//!
//! ```text
//! p = −K ln J,      s^{n+1} = Q (sⁿ + G D' Δt) Qᵀ + G D' Δt           (theory B.8)
//! ```
//!
//! Half of the strain increment is turned, because it happens before half of the rotation: this makes the
//! update second order, where adding the whole after the rotation is first order.
//! The pressure is a function of the volume, so that no path of increments makes it drift.

use super::bulk_viscosity::BulkViscosity;
use super::increment::{Increment, Point, Response};
use super::{PointState, StartState};
use crate::math::{SymTensor, Tensor};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bulk modulus over shear modulus of incompressible solids (theory J.18): a mean stress as large as the shear modulus
/// changes volumes by 10⁻⁴.
pub const INCOMPRESSIBLE: f64 = 1e4;

/// Keys of every elastic solid, written among those of the law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub struct Elastic {
    /// Density ρ0 in the reference state.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Young's modulus at zero strain.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub young: f64,
    /// Poisson's ratio at zero strain; 0.5, incompressible, for solids of `method = "pfem2"` on meshes of their own
    /// alone.
    #[schemars(extend("unit" = "1", "exclusiveMinimum" = -1.0, "maximum" = 0.5))]
    pub poisson: f64,
    /// Artificial bulk viscosity [q1, q2]; 0 for none.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub bulk_viscosity: BulkViscosity,
}

impl Elastic {
    /// A solid of `density` [kg/m³] with Young's modulus `young` [Pa] and Poisson's ratio `poisson`, without
    /// artificial viscosity.
    pub fn new(density: f64, young: f64, poisson: f64) -> Self {
        Self { density, young, poisson, bulk_viscosity: BulkViscosity::default() }
    }

    /// True with a Poisson's ratio of ½.
    #[inline(always)]
    pub fn is_incompressible(&self) -> bool {
        self.poisson >= 0.5
    }

    /// Moduli of the law; incompressible: the bulk modulus is [`INCOMPRESSIBLE`] times the shear modulus.
    #[inline(always)]
    pub fn moduli(&self) -> Moduli {
        let shear = self.young / (2.0 * (1.0 + self.poisson));
        let bulk = match self.is_incompressible() {
            true => INCOMPRESSIBLE * shear,
            false => self.young / (3.0 * (1.0 - 2.0 * self.poisson)),
        };
        Moduli { bulk, shear }
    }

    /// Speed of pressure waves at zero strain [m/s].
    pub fn sound_speed(&self) -> f64 {
        (self.moduli().wave() / self.density).sqrt()
    }

    /// First state of the rate laws: density and energy that go with the prescribed pressure or stress.
    ///
    /// # Errors
    /// A sentence, when an energy is prescribed.
    pub fn start(&self, start: &StartState) -> Result<PointState, String> {
        let Moduli { bulk, shear } = self.moduli();
        let stress = start_stress(start)?;
        let (pressure, s) = (-stress.trace() / 3.0, stress.deviator());
        let j = (-pressure / bulk).exp();
        // ∫ K ln J dJ of the volume, s : s/4G of the shape.
        let energy = bulk * (j * j.ln() - j + 1.0) + j * s.contract(&s) / (4.0 * shear);
        Ok(PointState {
            density: self.density / j,
            energy,
            pressure,
            stress,
            deformation: Tensor::identity() * j.cbrt(),
            sound_speed: self.sound_speed() * j.sqrt(),
        })
    }

    /// State at the start, as [`Elastic::start`], of a metal that yields at `yield_stress` [Pa].
    ///
    /// # Errors
    /// A sentence, when an energy is prescribed or a stress beyond yield.
    pub fn start_below_yield(&self, start: &StartState, yield_stress: f64) -> Result<PointState, String> {
        let state = self.start(start)?;
        let equivalent = state.stress.von_mises();
        if equivalent > yield_stress {
            return Err(format!(
                "the stress at the start is beyond yield: von Mises {equivalent:e} Pa, yield stress {yield_stress:e} Pa"
            ));
        }
        Ok(state)
    }
}

/// Moduli of isotropic elasticity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moduli {
    /// Bulk modulus K [Pa].
    pub bulk: f64,
    /// Shear modulus G [Pa].
    pub shear: f64,
}

impl Moduli {
    /// Lamé's first modulus λ = K − ⅔ G [Pa].
    #[inline(always)]
    pub fn lame(&self) -> f64 {
        self.bulk - 2.0 / 3.0 * self.shear
    }

    /// Young's modulus 9 K G/(3 K + G) [Pa].
    #[inline(always)]
    pub fn young(&self) -> f64 {
        9.0 * self.bulk * self.shear / (3.0 * self.bulk + self.shear)
    }

    /// Poisson's ratio (3 K − 2 G)/(6 K + 2 G).
    #[inline(always)]
    pub fn poisson(&self) -> f64 {
        (3.0 * self.bulk - 2.0 * self.shear) / (6.0 * self.bulk + 2.0 * self.shear)
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

    /// Deviator of the rate laws after an elastic increment [Pa], theory (B.16).
    #[inline(always)]
    pub fn deviator(&self, increment: &Increment, point: &Point<'_>) -> SymTensor {
        let half = increment.shear * self.shear;
        // Lian (25), with the turn of Lian (22) and the spin's sign corrected; theory (B.16).
        (point.deviator + half).rotated(&increment.rotation()) + half
    }

    /// Stress of the rate laws: deviator `s` [Pa] and the pressure of the volume; with the modulus of their waves.
    #[inline(always)]
    pub fn response(&self, s: SymTensor, volume_ratio: f64) -> Response {
        Response { stress: s - SymTensor::isotropic(self.pressure(volume_ratio)), modulus: self.wave() }
    }
}

/// Von Mises' stress √(3/2 s : s) of a deviator `s` [Pa].
#[inline(always)]
pub fn equivalent(s: &SymTensor) -> f64 {
    (1.5 * s.contract(s)).sqrt()
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
