//! One increment of a fluid: viscous stress, artificial bulk viscosity, pressure and energy.
//!
//! The energy balance is the trapezoidal rule with the total stress (theory 3.2): what the grid forces
//! Σ V σ ∇N take from the motion is what the particles gain, to second order and without iteration.
//!
//! ```text
//! s^{n+1} = 2 μ dev D                                                            (theory 3.4)
//! e*      = eⁿ + V̄ ½(sⁿ + s^{n+1}) : D Δt − ½ (pⁿ + qⁿ + q^{n+1}) ΔV
//! p^{n+1} = (A + B e*/V0) / (1 + ½ B ΔV/V0),      e^{n+1} = e* − ½ p^{n+1} ΔV
//! ```

use super::PointBatch;
use super::bulk_viscosity::{BulkViscosity, Shock};
use super::eos::EquationOfState;
use crate::math::SymTensor;
use crate::math::simd::{Lanes, Task, widest};

/// What a fluid has besides its equation of state.
#[derive(Debug, Clone, Copy)]
pub struct Flow {
    /// Density in the reference state ρ0 [kg/m³].
    pub density: f64,
    /// Shear viscosity μ [Pa s].
    pub viscosity: f64,
    /// Artificial bulk viscosity.
    pub bulk_viscosity: BulkViscosity,
}

/// Advances a batch by one increment.
pub fn advance<E: EquationOfState + ?Sized>(eos: &E, flow: &Flow, batch: &mut PointBatch<'_>) {
    let (dt, length, q) = (batch.dt, batch.length, flow.bulk_viscosity);
    if flow.viscosity > 0.0 {
        shear(flow, batch);
    }
    let density = flow.density;
    if q.is_zero() {
        widest(Compress { eos, density, batch, shock: |_, _, _| Shock::NONE });
    } else {
        widest(Compress { eos, density, batch, shock: |rho, c, growth| q.shock(rho, c, growth / dt, length) });
    }
    if flow.viscosity > 0.0 {
        collect(flow, batch);
    }
}

/// Viscous stress and viscous heating. Leaves the deviator s^{n+1} in the stress.
fn shear(flow: &Flow, batch: &mut PointBatch<'_>) {
    for p in 0..batch.len() {
        let rate = batch.gradient[p].symmetric().deviator();
        let s = rate * (2.0 * flow.viscosity);
        let mean = (batch.stress[p].deviator() + s) * 0.5;
        let volume = 0.5 * batch.volume[p] * (1.0 + batch.stretch[p]);
        batch.energy[p] += volume * batch.dt * mean.contract(&rate);
        batch.stress[p] = s;
    }
}

/// Volume, pressure, energy and signal speed, with the artificial viscosity `shock(ρ, c, ΔV/V)`.
struct Compress<'a, 'b, E: ?Sized, Q> {
    eos: &'a E,
    density: f64,
    batch: &'a mut PointBatch<'b>,
    shock: Q,
}

impl<E: EquationOfState + ?Sized, Q: Fn(f64, f64, f64) -> Shock> Task for Compress<'_, '_, E, Q> {
    type Output = ();

    /// Nothing branches inside the loop, so that it becomes vectors.
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { eos, density, batch, shock } = self;
        let n = batch.len();
        let (mass, stretch) = (&batch.mass[..n], &batch.stretch[..n]);
        let (volume, energy) = (&mut batch.volume[..n], &mut batch.energy[..n]);
        let (pressure, signal) = (&mut batch.pressure[..n], &mut batch.signal[..n]);
        let (least, per_density) = (eos.least_pressure(), 1.0 / density);
        for p in 0..n {
            let per_v0 = density / mass[p];
            let v = volume[p] * stretch[p];
            let dv = v - volume[p];
            let expansion = v * per_v0;
            let k = eos.coefficients(density, 1.0 / expansion - 1.0);

            let e = energy[p] * per_v0;
            let c_squared = k.modulus(e, k.pressure(e), expansion) * per_density;
            let shock = shock(mass[p] / v, c_squared.max(0.0).sqrt(), stretch[p] - 1.0);

            let e_star = energy[p] - 0.5 * (pressure[p] + shock.pressure) * dv;
            let trial = k.pressure(e_star * per_v0) / (1.0 + 0.5 * k.b * dv * per_v0);
            let p_new = if trial < least { least } else { trial };
            let e_new = e_star - 0.5 * p_new * dv;

            volume[p] = v;
            energy[p] = e_new;
            pressure[p] = p_new + shock.pressure;
            signal[p] = shock.signal(k.modulus(e_new * per_v0, p_new, expansion) * per_density);
        }
    }
}

/// Full stress σ = s − (p + q) 1, and the viscous part of the signal: Δt ≤ ρ h²/(2 d ⁴⁄₃ μ) with d = 3.
fn collect(flow: &Flow, batch: &mut PointBatch<'_>) {
    for p in 0..batch.len() {
        batch.stress[p] -= SymTensor::isotropic(batch.pressure[p]);
        let viscous = 8.0 * flow.viscosity * batch.volume[p] / (batch.mass[p] * batch.length);
        batch.signal[p] = batch.signal[p].max(viscous);
    }
}
