//! Elastic laws linearised about a deformed state, for implicit systems in velocity and pressure (theory B.13).
//!
//! ```text
//! σ = s − p 1,      σ̇ = l σ + σ lᵀ − tr d σ + c : d,      l = ∂v/∂x,  d = sym l
//! ṗ = −h : d,       h = ⅓ (1 : c + 2 σ) + p 1,      κ = ⅓ tr h
//! c = A + κ β ⊗ β,  β = h/κ :       c : d = A : d − β ṗ,      β : d + ṗ/κ = 0
//! ```

use super::MaterialKind;
use super::elastic::Moduli;
use super::stiffness::Stiffness;
use crate::math::{SymTensor, Tensor};

/// A solid without memory of plastic flow: its stress and the tangent of that.
///
/// A law of material points lends it by [`PointLaw::elastic_law`](super::PointLaw::elastic_law).
///
/// ```
/// use lateen::material::{Elastic, ElasticLaw, ElasticState, StVenantKirchhoff};
/// use lateen::math::{SymTensor, Tensor};
///
/// let law = StVenantKirchhoff { elastic: Elastic::new(1000.0, 2.6e6, 0.3) };
/// let rest = ElasticState { deformation: Tensor::identity(), stress: SymTensor::ZERO };
/// let strain = law.linearised(&rest).plane_strain();
/// // Plane strain without the pressure: ⁴⁄₃ G, −⅔ G and G.
/// let deviatoric = strain.mixed().stiffness;
/// assert!((deviatoric[0][0] / 1e6 - 4.0 / 3.0).abs() < 1e-12);
/// assert!((deviatoric[0][1] / 1e6 + 2.0 / 3.0).abs() < 1e-12);
/// assert!((deviatoric[2][2] / 1e6 - 1.0).abs() < 1e-12);
/// ```
pub trait ElasticLaw: std::fmt::Debug + Send + Sync {
    /// Density in the reference state [kg/m³].
    fn reference_density(&self) -> f64;

    /// Moduli at zero strain.
    fn moduli(&self) -> Moduli;

    /// Stress and tangent in three dimensions.
    fn linearised(&self, state: &ElasticState) -> Linearised<6>;

    /// The thickness stretch λ3 that leaves no stress across a sheet whose deformation gradient in its plane is
    /// `in_plane`.
    ///
    /// # Errors
    /// A sentence, where there is none, and for rate laws, whose thickness is followed in time
    /// ([`Linearised::thickness_slope`]).
    fn thickness_stretch(&self, in_plane: &Tensor<2>) -> Result<f64, String>;

    /// Stored energy per reference volume [J/m³]; `None` for rate laws, whose stress depends on the path.
    fn strain_energy(&self, _state: &ElasticState) -> Option<f64> {
        None
    }
}

/// Why a law of another phase has no tangent.
pub(super) fn no_tangent(phase: MaterialKind) -> String {
    let reason = match phase {
        MaterialKind::Gas | MaterialKind::Liquid => "a fluid resists no shear strain",
        MaterialKind::Plastic => "the stress of a solid that yields depends on the plastic strain on the way",
        MaterialKind::Elastic => "this law gives no tangent",
    };
    format!("an implicit solid needs the tangent of an elastic law, but {reason}")
}

/// The state about which an elastic law is linearised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticState {
    /// Deformation gradient F from the reference state.
    pub deformation: Tensor<3>,
    /// Cauchy stress as it was carried here [Pa]. Rate laws take its deviator; others have their stress from F.
    pub stress: SymTensor,
}

/// Stress and tangent, with N = 6 components in three dimensions (order of [`SymTensor`]) or N = 3 in the plane (xx,
/// yy, xy).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearised<const N: usize> {
    /// Deviator s of the Cauchy stress [Pa], three-dimensional also in the plane. The Kirchhoff stress is J times as
    /// large.
    pub deviator: SymTensor,
    /// Pressure p = −⅓ tr σ [Pa].
    pub pressure: f64,
    /// Tangent c [Pa] of Truesdell's rate of σ: components c_ijkl, which as a matrix take shears twice.
    pub tangent: [[f64; N]; N],
    /// h = −∂ṗ/∂d [Pa]: κ 1 where the pressure is a function of the volume.
    pub pressure_slope: [f64; N],
    /// Bulk modulus κ = −∂p/∂ln J of the state [Pa]; in plane stress −∂p/∂ln A for an area A stretched evenly, at free
    /// thickness.
    pub bulk: f64,
}

/// The tangent without what the pressure, as an unknown of its own, brings to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mixed<const N: usize> {
    /// A = c − κ β ⊗ β [Pa]; symmetric where c is.
    pub stiffness: [[f64; N]; N],
    /// β = h/κ: 1 where the pressure is a function of the volume.
    pub coupling: [f64; N],
}

impl<const N: usize> Linearised<N> {
    /// The blocks of a system in velocity and pressure, symmetric where c is:
    /// Truesdell's rate of σ is A : d − β ṗ, and β : d + ṗ/κ = 0.
    pub fn mixed(&self) -> Mixed<N> {
        let beta = self.pressure_slope.map(|h| h / self.bulk);
        let dyad = |i: usize, j: usize| self.bulk * beta[i] * beta[j];
        // At rest Becker (27).
        let stiffness = std::array::from_fn(|i| std::array::from_fn(|j| self.tangent[i][j] - dyad(i, j)));
        Mixed { stiffness, coupling: beta }
    }

    /// The Cauchy stress σ = s − p 1 [Pa].
    pub fn stress(&self) -> SymTensor {
        self.deviator - SymTensor::isotropic(self.pressure)
    }
}

/// Places of xx, yy, xy among the six components, and that of zz.
const PLANE: [usize; 3] = [0, 1, 3];
const NORMAL: usize = 2;

impl Linearised<6> {
    /// The linearised law with the Cauchy stress σ [Pa] and the tangent c [Pa] of Truesdell's rate of it.
    pub fn new(stress: SymTensor, tangent: Stiffness) -> Self {
        let pressure = -stress.trace() / 3.0;
        let slope = (tangent.trace() + stress * 2.0) * (1.0 / 3.0) + SymTensor::isotropic(pressure);
        Self {
            deviator: stress.deviator(),
            pressure,
            tangent: tangent.0,
            pressure_slope: slope.0,
            bulk: slope.trace() / 3.0,
        }
    }

    /// Tangent c_s [Pa] of Truesdell's rate of the deviator, ṡ = l s + s lᵀ − tr d s + c_s : d:
    /// c_s = c − 1 ⊗ h − 2 p 1 ⊙ 1 + p 1 ⊗ 1. Not symmetric where the pressure depends on the shape.
    pub fn deviatoric_tangent(&self) -> Stiffness {
        let (one, p) = (SymTensor::isotropic(1.0), self.pressure);
        Stiffness(self.tangent) - Stiffness::dyad(&one, &SymTensor(self.pressure_slope))
            + (Stiffness::volumetric() - Stiffness::identity() * 2.0) * p
    }

    /// Plane strain: d_zz = 0, and no shear across the plane.
    pub fn plane_strain(&self) -> Linearised<3> {
        Linearised {
            deviator: self.deviator,
            pressure: self.pressure,
            tangent: PLANE.map(|i| PLANE.map(|j| self.tangent[i][j])),
            pressure_slope: PLANE.map(|i| self.pressure_slope[i]),
            bulk: self.bulk,
        }
    }

    /// Rates d_zz of the thickness per unit of d_xx, d_yy and 2 d_xy that keep a state of σ_zz = 0 so: −c_zzkl/c_zzzz.
    pub fn thickness_slope(&self) -> [f64; 3] {
        let row = &self.tangent[NORMAL];
        PLANE.map(|i| -row[i] / row[NORMAL])
    }

    /// Plane stress, about a state with σ_zz = 0: the thickness follows the strain in the plane.
    pub fn plane_stress(&self) -> Linearised<3> {
        let (c, h, follows) = (&self.tangent, &self.pressure_slope, self.thickness_slope());
        let slope: [f64; 3] = std::array::from_fn(|j| h[PLANE[j]] + h[NORMAL] * follows[j]);
        Linearised {
            deviator: self.deviator,
            pressure: self.pressure,
            tangent: PLANE.map(|i| std::array::from_fn(|j| c[i][PLANE[j]] + c[i][NORMAL] * follows[j])),
            pressure_slope: slope,
            bulk: 0.5 * (slope[0] + slope[1]),
        }
    }
}
