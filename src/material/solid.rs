//! One increment of a solid: the part that all solid laws share.
//!
//! A law gives the Cauchy stress of one particle ([`Solid::response`]); the loop around it moves the volume
//! and the deformation gradient, adds the artificial bulk viscosity and balances the energy by the
//! trapezoidal rule with the total stress (theory B.8), plastic work included:
//!
//! ```text
//! e^{n+1} = eⁿ + V̄ ½(sⁿ + s^{n+1}) : D' Δt − ½ (Pⁿ + P^{n+1}) ΔV,      P = −⅓ tr σ + q
//! ```

use super::bulk_viscosity::Shock;
use super::elastic::Elastic;
use super::increment::{Increment, Point, Response};
use super::kinematics;
use super::linearised::{ElasticLaw, no_tangent};
use super::{MaterialKind, PointBatch, PointLaw, PointState, StartState, Storage};
use crate::math::{SymTensor, Tensor};
use std::ops::Range;

/// A law of a solid: what its author writes, for one particle. It makes a [`PointLaw`].
///
/// An increment of uniaxial strain, of which the stress is σ_xx = (K + ⁴⁄₃ G) ε to first order:
///
/// ```
/// use lateen::material::{Elastic, Hypoelastic, Increment, Point, Solid};
/// use lateen::math::{SymTensor, Tensor};
///
/// let law = Hypoelastic { elastic: Elastic::new(1000.0, 1e6, 0.25) };
/// let (dt, strain) = (1e-3, 1e-6);
/// let mut gradient = Tensor::ZERO;
/// gradient[0][0] = strain / dt;
/// let shear = gradient.symmetric().deviator() * dt;
/// let increment = Increment { dt, gradient, shear, volume_ratio: 1.0 + strain };
/// let point = Point { deviator: SymTensor::ZERO, deformation: Tensor::identity(), history: &mut [] };
/// let response = law.response(&increment, point);
/// assert!((response.stress.0[0] / (response.modulus * strain) - 1.0).abs() < 1e-6);
/// assert!((response.modulus - 1.2e6).abs() < 1e-6);
/// ```
pub trait Solid: std::fmt::Debug + Send + Sync {
    /// Elastic, or plastic for a law that yields.
    const PHASE: MaterialKind;
    /// Names of the history variables.
    const HISTORY: &'static [&'static str] = &[];
    /// True if the law needs the deformation gradient.
    const DEFORMATION: bool = false;

    /// Density, moduli at zero strain, artificial viscosity.
    fn elastic(&self) -> Elastic;

    /// The state of one particle at the start; the default is that of the rate laws.
    ///
    /// # Errors
    /// A sentence that says why the law can't start from this state.
    fn start(&self, start: &StartState) -> Result<PointState, String> {
        self.elastic().start(start)
    }

    /// The law as one that can be linearised; `None` where the stress depends on the path, as that of plastic flow
    /// does.
    fn linearisable(&self) -> Option<&dyn ElasticLaw> {
        None
    }

    /// The stress at the end of an increment, from the state at its start.
    fn response(&self, increment: &Increment, point: Point<'_>) -> Response;
}

impl<L: Solid> PointLaw for L {
    fn density(&self) -> f64 {
        self.elastic().density
    }

    fn storage(&self) -> Storage {
        Storage { stress: true, deformation: L::DEFORMATION, history: L::HISTORY }
    }

    fn initial(&self, start: &StartState) -> Result<PointState, String> {
        self.elastic().bulk_viscosity.check()?;
        self.start(start)
    }

    fn phase(&self) -> MaterialKind {
        L::PHASE
    }

    fn elastic_law(&self) -> Result<&dyn ElasticLaw, String> {
        self.linearisable().ok_or_else(|| no_tangent(L::PHASE))
    }

    fn update(&self, batch: &mut PointBatch<'_>) {
        advance(self, batch);
    }

    fn reference_sound_speed(&self) -> f64 {
        self.elastic().sound_speed()
    }
}

/// Advances a batch of a solid by one increment.
fn advance<L: Solid>(law: &L, batch: &mut PointBatch<'_>) {
    let Elastic { density, bulk_viscosity: q, .. } = law.elastic();
    let stride = L::HISTORY.len();
    for p in 0..batch.len() {
        let v = batch.volume[p] * batch.volume_ratio[p];
        let dv = v - batch.volume[p];
        let increment = increment(batch, p, v * density / batch.mass[p]);
        let deformation = if L::DEFORMATION { deform(batch, p) } else { Tensor::identity() };
        let deviator = batch.stress[p].deviator();
        let history = &mut batch.history[history_of(p, stride)];
        let response = law.response(&increment, Point { deviator, deformation, history });

        let rho = batch.mass[p] / v;
        let c_squared = response.modulus / rho;
        let shock = if q.is_zero() {
            Shock::NONE
        } else {
            q.shock(rho, c_squared.sqrt(), (batch.volume_ratio[p] - 1.0) / batch.dt, batch.length)
        };
        let stress = response.stress - SymTensor::isotropic(shock.pressure);
        let pressure = -stress.trace() / 3.0;

        let mean = (deviator + stress.deviator()) * 0.5;
        batch.energy[p] +=
            (batch.volume[p] + 0.5 * dv) * mean.contract(&increment.shear) - 0.5 * (batch.pressure[p] + pressure) * dv;
        batch.volume[p] = v;
        batch.pressure[p] = pressure;
        batch.stress[p] = stress;
        batch.wave_speed[p] = shock.wave_speed(c_squared);
    }
}

#[inline(always)]
fn increment(batch: &PointBatch<'_>, p: usize, volume_ratio: f64) -> Increment {
    // Lian (23), Lian (62): the strain increment is D Δt.
    let gradient = kinematics::midpoint(&batch.gradient[p], batch.dt);
    Increment { dt: batch.dt, gradient, shear: gradient.symmetric().deviator() * batch.dt, volume_ratio }
}

/// Moves the deformation gradient of particle `p` and returns it.
#[inline(always)]
fn deform(batch: &mut PointBatch<'_>, p: usize) -> Tensor<3> {
    let f = kinematics::deformation(&batch.gradient[p], batch.dt, batch.volume_ratio[p]);
    batch.deformation[p] = f.dot(&batch.deformation[p]);
    batch.deformation[p]
}

#[inline(always)]
fn history_of(p: usize, stride: usize) -> Range<usize> {
    p * stride..(p + 1) * stride
}
