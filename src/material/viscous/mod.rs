//! Laws of incompressible fluids on a mesh: the viscosity μ(γ̇) at the shear rate γ̇ = √(2 d:d) (theory F.8).
//!
//! ```text
//! Newton             μ
//! Bingham            k + τ_y (1 − e^(−γ̇/γ̇_0))/γ̇
//! Herschel–Bulkley   k γ̇ⁿ⁻¹ + τ_y (1 − e^(−γ̇/γ̇_0))/γ̇       regularised (Papanastasiou 1987)
//! ```
//!
//! Below γ̇_0 the yield stress acts as the large but finite viscosity τ_y/γ̇_0; the power law keeps its value there.

mod bingham;
mod herschel_bulkley;
mod newtonian;

pub use bingham::Bingham;
pub use herschel_bulkley::HerschelBulkley;
pub use newtonian::Newtonian;

use crate::registry;

registry! {
    /// Laws of fluids on a mesh, for `method = "pfem2"`.
    pub enum ViscousLaws: ViscousLaw, tag = "law" {
        "newtonian" => Newtonian,
        "bingham" => Bingham,
        "herschel-bulkley" => HerschelBulkley,
    }
}

/// A law of an incompressible fluid, as PFEM-2 calls it.
///
/// ```
/// use lateen::material::{Bingham, Newtonian, ViscousLaw};
///
/// let water = Newtonian { density: 1000.0, viscosity: 1e-3 };
/// assert_eq!(water.viscosity(100.0), 1e-3);
/// // Well above the regularised rates the shear stress is that of the law, τ_y + μ γ̇.
/// let paste = Bingham { density: 1500.0, viscosity: 2.0, yield_stress: 10.0, regularisation: 1e-3 };
/// assert!((paste.viscosity(5.0) * 5.0 - (10.0 + 2.0 * 5.0)).abs() < 1e-9);
/// ```
pub trait ViscousLaw: std::fmt::Debug + Send + Sync {
    /// Density [kg/m³].
    fn density(&self) -> f64;

    /// Viscosity μ [Pa s] at a shear rate γ̇ [1/s].
    fn viscosity(&self, shear_rate: f64) -> f64;

    /// True if the viscosity is the same at all shear rates.
    fn is_newtonian(&self) -> bool {
        false
    }
}

/// Part (1 − e⁻ʳ)/r of the viscosity at rest τ_y/γ̇_0 that the yield stress keeps at the ratio r = γ̇/γ̇_0.
fn yielding(shear_rate: f64, regularisation: f64) -> f64 {
    let ratio = shear_rate / regularisation;
    // (1 − e⁻ʳ)/r → 1
    if ratio > 1e-8 { -(-ratio).exp_m1() / ratio } else { 1.0 }
}

/// Regularisation of yield stresses where a case gives none, γ̇_0 [1/s].
fn regularisation() -> f64 {
    1e-2
}
