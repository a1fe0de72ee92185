//! Solids with a stored energy W(F): what their laws share (theory B.9).
//!
//! ```text
//! J σ = τ = ∂W/∂F Fᵀ,      ρ c² = c_nnnn + σ_nn along the principal axis n
//! ```

use super::elastic::{Elastic, Moduli, start_stress};
use super::increment::{Increment, Point, Response};
use super::linearised::{ElasticLaw, ElasticState, Linearised};
use super::solid::Solid;
use super::stiffness::Stiffness;
use super::{MaterialKind, PointState, StartState};
use crate::math::{SymTensor, Tensor};

/// An isotropic solid whose stress is the slope of a stored energy: what its author writes. It makes a [`Solid`] and an
/// [`ElasticLaw`].
pub trait Hyperelastic: std::fmt::Debug + Send + Sync {
    /// Name of the law in messages.
    const NAME: &'static str;

    /// Density, moduli at zero strain, artificial viscosity.
    fn elastic(&self) -> Elastic;

    /// Stored energy W per reference volume [J/m³].
    fn stored_energy(&self, deformation: &Tensor<3>) -> f64;

    /// Cauchy stress [Pa] and an upper bound of the modulus ρ c² of all waves [Pa], which is exact where all principal
    /// stretches are the same.
    fn stress(&self, deformation: &Tensor<3>) -> Response;

    /// Tangent c [Pa] of Truesdell's rate of the Cauchy stress.
    fn tangent(&self, deformation: &Tensor<3>) -> Stiffness;

    /// A symmetric deformation gradient that carries the Cauchy stress `stress` [Pa], if there is one.
    fn prestretch(&self, stress: &SymTensor) -> Option<Tensor<3>> {
        principal_prestretch(self, stress)
    }
}

impl<L: Hyperelastic> Solid for L {
    const PHASE: MaterialKind = MaterialKind::Elastic;
    const DEFORMATION: bool = true;

    #[inline(always)]
    fn elastic(&self) -> Elastic {
        Hyperelastic::elastic(self)
    }

    fn start(&self, start: &StartState) -> Result<PointState, String> {
        let stress = start_stress(start)?;
        let deformation = self
            .prestretch(&stress)
            .ok_or_else(|| format!("no deformation of this {} solid carries the stress {:?} Pa", L::NAME, stress.0))?;
        is_stable(self, &deformation)?;
        let density = Hyperelastic::elastic(self).density / deformation.determinant();
        let Response { stress, modulus } = self.stress(&deformation);
        Ok(PointState {
            density,
            energy: self.stored_energy(&deformation),
            pressure: -stress.trace() / 3.0,
            stress,
            deformation,
            sound_speed: (modulus / density).sqrt(),
        })
    }

    #[inline(always)]
    fn response(&self, _increment: &Increment, point: Point<'_>) -> Response {
        self.stress(&point.deformation)
    }

    fn linearisable(&self) -> Option<&dyn ElasticLaw> {
        Some(self)
    }
}

impl<L: Hyperelastic> ElasticLaw for L {
    fn reference_density(&self) -> f64 {
        Hyperelastic::elastic(self).density
    }

    fn moduli(&self) -> Moduli {
        Hyperelastic::elastic(self).moduli()
    }

    fn linearised(&self, state: &ElasticState) -> Linearised<6> {
        Linearised::new(self.stress(&state.deformation).stress, self.tangent(&state.deformation))
    }

    fn thickness_stretch(&self, in_plane: &Tensor<2>) -> Result<f64, String> {
        free_thickness(self, in_plane).ok_or_else(|| {
            format!("no thickness of this {} solid is free of stress at the deformation {:?}", L::NAME, in_plane.0)
        })
    }

    fn strain_energy(&self, state: &ElasticState) -> Option<f64> {
        Some(self.stored_energy(&state.deformation))
    }
}

/// Logarithms of stretches move by at most this much in one of Newton's steps.
const LARGEST_STEP: f64 = 0.2;

/// Newton's method converges quadratically from zero strain; many steps are short only far away from it.
const ITERATIONS: usize = 100;

/// Residuals as small as this, relative to moduli, are rounding: Newton's step from there ends the iteration.
const ROUNDING: f64 = 1e-13;

/// [`Hyperelastic::prestretch`] in the principal axes of the stress, by Newton's method in the logarithms of the
/// stretches:
/// ∂σ_i/∂ln λ_j = c_iijj + (2 δ_ij − 1) σ_i.
fn principal_prestretch<L: Hyperelastic + ?Sized>(law: &L, stress: &SymTensor) -> Option<Tensor<3>> {
    let spectrum = stress.spectrum();
    let scale = law.elastic().moduli().wave() + spectrum.values[0].abs().max(spectrum.values[2].abs());
    let mut logs = [0.0f64; 3];
    for _ in 0..ITERATIONS {
        let [x, y, z] = logs.map(f64::exp);
        let f = Tensor([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]);
        let (sigma, c) = (law.stress(&f).stress.0, law.tangent(&f).0);
        let slope = Tensor::from_fn(|i, j| c[i][j] + if i == j { sigma[i] } else { -sigma[i] });
        let inverse = slope.inverse()?;
        let residual: [f64; 3] = std::array::from_fn(|i| spectrum.values[i] - sigma[i]);
        let step: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| inverse[i][j] * residual[j]).sum());
        let largest = step.iter().fold(0.0f64, |most, s| most.max(s.abs()));
        let part = (LARGEST_STEP / largest).min(1.0);
        logs = std::array::from_fn(|i| logs[i] + part * step[i]);
        if residual.iter().all(|r| r.abs() <= ROUNDING * scale) && logs.iter().all(|log| log.is_finite()) {
            let stretched = crate::math::Spectrum { values: logs.map(f64::exp), directions: spectrum.directions };
            return Some(stretched.map(|stretch| stretch).full());
        }
    }
    None
}

/// Newton's method for ln λ3 of σ_zz = 0, with ∂σ_zz/∂ln λ3 = c_zzzz + σ_zz, from the thickness of small strains.
fn free_thickness<L: Hyperelastic>(law: &L, in_plane: &Tensor<2>) -> Option<f64> {
    let moduli = Hyperelastic::elastic(law).moduli();
    let area = in_plane[0][0] * in_plane[1][1] - in_plane[0][1] * in_plane[1][0];
    let mut log = -moduli.lame() / (moduli.lame() + 2.0 * moduli.shear) * area.ln();
    for _ in 0..ITERATIONS {
        let f = in_plane.embed(log.exp());
        let (sigma, c) = (law.stress(&f).stress.0[2], law.tangent(&f).0[2][2]);
        let step = -sigma / (c + sigma);
        log += step.clamp(-LARGEST_STEP, LARGEST_STEP);
        if step.abs() <= ROUNDING.sqrt() && log.is_finite() {
            return Some(log.exp());
        }
    }
    None
}

/// A state is stable if waves of all polarisations run along all principal axes (theory B.9).
///
/// # Errors
/// A sentence that says so, and which laws bear more.
fn is_stable<L: Hyperelastic>(law: &L, deformation: &Tensor<3>) -> Result<(), String> {
    if principal_waves(law, deformation).iter().flatten().all(|modulus| *modulus > 0.0) {
        return Ok(());
    }
    let [.., stretch] = principal_stretches(deformation);
    Err(format!(
        "this {} solid is unstable under the stress at the start, with the least stretch {stretch:.3}: \
         `neo-hookean` and `mooney-rivlin` bear large compression",
        L::NAME
    ))
}

/// Principal stretches λ_i, the largest first.
pub(super) fn principal_stretches(deformation: &Tensor<3>) -> [f64; 3] {
    deformation.dot(&deformation.transpose()).symmetric().spectrum().values.map(f64::sqrt)
}

/// Places of c_ijij among the components of a stiffness.
const POLARISED: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// ρ c² of the waves along the principal axis i with polarisation j, c_ijij + σ_ii [Pa]; negative where the material is
/// unstable.
pub(super) fn principal_waves<L: Hyperelastic>(law: &L, deformation: &Tensor<3>) -> [[f64; 3]; 3] {
    let [x, y, z] = principal_stretches(deformation);
    let f = Tensor([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]);
    let (stress, c) = (law.stress(&f).stress, law.tangent(&f));
    std::array::from_fn(|i| POLARISED[i].map(|place| c.0[place][place] + stress.0[i]))
}

/// Bounds of the principal values of a symmetric tensor, the least and the largest, by Gershgorin's circles.
#[inline(always)]
pub(super) fn principal_bounds(tensor: &SymTensor) -> [f64; 2] {
    let [xx, yy, zz, xy, yz, zx] = tensor.0;
    let (xy, yz, zx) = (xy.abs(), yz.abs(), zx.abs());
    let largest = (xx + xy + zx).max(yy + xy + yz).max(zz + yz + zx);
    let least = (xx - xy - zx).min(yy - xy - yz).min(zz - yz - zx);
    [least, largest]
}

/// b = F Fᵀ.
#[inline(always)]
pub(super) fn left_cauchy_green(deformation: &Tensor<3>) -> SymTensor {
    deformation.dot(&deformation.transpose()).symmetric()
}

/// b², for a symmetric b.
#[inline(always)]
pub(super) fn square(b: &SymTensor) -> SymTensor {
    let full = b.full();
    full.dot(&full).symmetric()
}
