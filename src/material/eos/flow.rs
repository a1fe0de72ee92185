//! One increment of a fluid: viscous stress, artificial bulk viscosity, pressure and energy.
//!
//! The energy balance is the trapezoidal rule with the total stress (theory B.3): what the grid forces
//! Σ V σ ∇N take from the motion is what the particles gain, to second order and without iteration.
//!
//! ```text
//! s^{n+1} = 2 μ dev D                                                            (theory B.5)
//! e*      = eⁿ + V̄ ½(sⁿ + s^{n+1}) : D Δt − ½ (pⁿ + qⁿ + q^{n+1}) ΔV
//! p^{n+1} = (A + B e*/V0) / (1 + ½ B ΔV/V0),      e^{n+1} = e* − ½ p^{n+1} ΔV
//! ```
//!
//! **Separation.** Where the pressure would fall below the least that the liquid bears, it parts: it keeps its volume
//! V, and what the motion opens is a void of θ V between its parts, which must close before it resists again,
//!
//! ```text
//! V^{n+1} = V^n,      1 + θ^{n+1} = min((1 + θ^n) ΔJ, max(h^D/V, 2)),      ΔV = V^n (ΔJ − 1)
//! ```
//!
//! Of a particle alone the motion says nothing about voids: its affine velocity would blow it up without end. Where
//! it and its void fill a cell it has come apart from its neighbours, and what opens beyond is forgotten. The energy is
//! that of the force −p V: the work against the least pressure, on all that opens, stays in the internal energy.

use super::EquationOfState;
use crate::material::PointBatch;
use crate::material::bulk_viscosity::{BulkViscosity, Shock};
use crate::math::SymTensor;
use crate::math::simd::{Lanes, Task, widest};

/// Properties of a fluid besides its equation of state.
#[derive(Debug, Clone, Copy)]
pub struct FlowProperties {
    /// Density in the reference state ρ0 [kg/m³].
    pub density: f64,
    /// Shear viscosity μ [Pa s].
    pub viscosity: f64,
    /// Artificial bulk viscosity.
    pub bulk_viscosity: BulkViscosity,
}

/// Advances a batch by one increment.
pub fn advance<E: EquationOfState + ?Sized>(eos: &E, flow: &FlowProperties, batch: &mut PointBatch<'_>) {
    let (dt, length, q) = (batch.dt, batch.length, flow.bulk_viscosity);
    if flow.viscosity > 0.0 {
        shear(flow, batch);
    }
    let density = flow.density;
    let shock = (!q.is_zero()).then_some(|rho, c, growth| q.shock(rho, c, growth / dt, length));
    if batch.history.is_empty() {
        compress(eos, density, batch, Whole, shock);
    } else {
        let voids = Voids(std::mem::take(&mut batch.history));
        let Voids(voids) = compress(eos, density, batch, voids, shock);
        batch.history = voids;
    }
    if flow.viscosity > 0.0 {
        collect(flow, batch);
    }
}

/// Viscous stress and viscous heating, theory B.5. Leaves the deviator s^{n+1} in the stress.
fn shear(flow: &FlowProperties, batch: &mut PointBatch<'_>) {
    for p in 0..batch.len() {
        let rate = batch.gradient[p].symmetric().deviator();
        // Lian (26) without the pressure.
        let s = rate * (2.0 * flow.viscosity);
        let mean = (batch.stress[p].deviator() + s) * 0.5;
        let volume = 0.5 * batch.volume[p] * (1.0 + batch.volume_ratio[p]);
        batch.energy[p] += volume * batch.dt * mean.contract(&rate);
        batch.stress[p] = s;
    }
}

/// The void ratio θ of a liquid that is pulled apart at its tension limit: the volume of the void over that of the
/// liquid.
trait VoidRatio {
    /// Void ratio of particle `p`.
    fn void(&self, p: usize) -> f64;
    /// Sets it.
    fn set(&mut self, p: usize, void: f64);
}

/// Gases, and liquids that bear any tension.
struct Whole;

impl VoidRatio for Whole {
    #[inline(always)]
    fn void(&self, _: usize) -> f64 {
        0.0
    }

    #[inline(always)]
    fn set(&mut self, _: usize, _: f64) {}
}

/// Liquids with a least pressure: θ by particle.
struct Voids<'a>(&'a mut [f64]);

impl VoidRatio for Voids<'_> {
    #[inline(always)]
    fn void(&self, p: usize) -> f64 {
        self.0[p]
    }

    #[inline(always)]
    fn set(&mut self, p: usize, void: f64) {
        self.0[p] = void;
    }
}

/// Compresses a batch, with artificial viscosity `shock` unless there is none; gives the voids back.
fn compress<E: EquationOfState + ?Sized, O: VoidRatio>(
    eos: &E,
    density: f64,
    batch: &mut PointBatch<'_>,
    voids: O,
    shock: Option<impl Fn(f64, f64, f64) -> Shock>,
) -> O {
    match shock {
        Some(shock) => widest(Compress { eos, density, batch, voids, shock }),
        None => widest(Compress { eos, density, batch, voids, shock: |_, _, _| Shock::NONE }),
    }
}

/// Volume, pressure, energy and wave speed, with the artificial viscosity `shock(ρ, c, ΔV/V)`.
struct Compress<'a, 'b, E: ?Sized, O, Q> {
    eos: &'a E,
    density: f64,
    batch: &'a mut PointBatch<'b>,
    voids: O,
    shock: Q,
}

impl<E: EquationOfState + ?Sized, O: VoidRatio, Q: Fn(f64, f64, f64) -> Shock> Task for Compress<'_, '_, E, O, Q> {
    type Output = O;

    /// Nothing branches inside the loop, so that it becomes vectors.
    #[inline(always)]
    fn run<L: Lanes>(self) -> O {
        let Self { eos, density, batch, mut voids, shock } = self;
        let (n, room) = (batch.len(), batch.room);
        let (mass, volume_ratio) = (&batch.mass[..n], &batch.volume_ratio[..n]);
        let (volume, energy) = (&mut batch.volume[..n], &mut batch.energy[..n]);
        let (pressure, wave_speed) = (&mut batch.pressure[..n], &mut batch.wave_speed[..n]);
        let (least, per_density) = (eos.least_pressure(), 1.0 / density);
        for p in 0..n {
            let per_v0 = density / mass[p];
            let own = volume[p];
            let v = own * (1.0 + voids.void(p)) * volume_ratio[p];
            let dv = own * volume_ratio[p] - own;
            let expansion = v * per_v0;
            let k = eos.coefficients(density, 1.0 / expansion - 1.0);

            let e = energy[p] * per_v0;
            let c_squared = k.modulus(e, k.pressure(e), expansion) * per_density;
            let shock = shock(mass[p] / v, c_squared.max(0.0).sqrt(), volume_ratio[p] - 1.0);

            let e_star = energy[p] - 0.5 * (pressure[p] + shock.pressure) * dv;
            let trial = k.pressure(e_star * per_v0) / (1.0 + 0.5 * k.b * dv * per_v0);
            let p_new = if trial < least { least } else { trial };
            let e_new = e_star - 0.5 * p_new * dv;

            let kept = if trial < least && own < v { own } else { v };
            let most = if room > 2.0 * kept { room } else { 2.0 * kept };
            voids.set(p, (if v > most { most } else { v }) / kept - 1.0);
            volume[p] = kept;
            energy[p] = e_new;
            pressure[p] = p_new + shock.pressure;
            wave_speed[p] = shock.wave_speed(k.modulus(e_new * per_v0, p_new, expansion) * per_density);
        }
        voids
    }
}

/// Full stress σ = s − (p + q) 1, and the viscous part of the wave speed: Δt ≤ ρ h²/(2 d ⁴⁄₃ μ) with d = 3.
fn collect(flow: &FlowProperties, batch: &mut PointBatch<'_>) {
    for p in 0..batch.len() {
        batch.stress[p] -= SymTensor::isotropic(batch.pressure[p]);
        let viscous = 8.0 * flow.viscosity * batch.volume[p] / (batch.mass[p] * batch.length);
        batch.wave_speed[p] = batch.wave_speed[p].max(viscous);
    }
}
