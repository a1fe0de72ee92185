//! The Gauss points of an element of a solid, in its reference state and deformed (theory J.1).
//!
//! ```text
//! F = 1 + Σ u_a ⊗ G_a,   G_a = ∂N_a/∂X,      g_a = F⁻ᵀ G_a,   dv = J dV
//! ```
//!
//! In the plane F_zz = 1 without strain across it, and the stretch that leaves no stress there otherwise.

use crate::material::ElasticLaw;
use crate::math::{Tensor, Vector};
use crate::pfem2::solid::mesh::gauss::GaussPoint;
use crate::pfem2::solid::setup::Plane;

/// An elastic law and the third direction.
#[derive(Debug, Clone, Copy)]
pub struct SolidLaw<'a> {
    /// The law.
    pub law: &'a dyn ElasticLaw,
    /// The third direction, in two dimensions.
    pub plane: Plane,
}

/// A state of an element that has no forces: it is turned inside out, or no thickness of it is free of stress.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementFault<const D: usize> {
    /// The event.
    pub what: String,
    /// Volume ratio J there.
    pub volume_ratio: f64,
    /// The Gauss point in the deformed state [m].
    pub position: Vector<D>,
}

/// A Gauss point of a deformed element.
pub(in crate::pfem2::solid) struct Deformed<const D: usize> {
    /// Place of the Gauss point in the reference state [m].
    pub place: Vector<D>,
    /// Volume of the Gauss point in the reference state [m³].
    pub volume: f64,
    /// The deformation gradient, with that of the third direction.
    pub deformation: Tensor<3>,
    /// g_a [1/m].
    pub gradients: Vec<Vector<D>>,
}

/// A Gauss point of an element in its reference state.
pub(super) struct ReferencePoint<const D: usize> {
    /// G_a [1/m].
    pub gradients: Vec<Vector<D>>,
    /// Volume of the Gauss point [m³].
    pub volume: f64,
}

impl<const D: usize> ReferencePoint<D> {
    /// `None` where the volume is not positive.
    pub fn new(point: &GaussPoint, places: &[Vector<D>]) -> Option<Self> {
        let jacobian = sum_of_dyads(places, &point.slopes).embed(1.0);
        let volume = point.weight * jacobian.determinant();
        let inverse = jacobian.inverse()?;
        let gradient = |slope: &[f64; 3]| Vector::from_fn(|i| (0..D).map(|k| inverse[k][i] * slope[k]).sum());
        (volume > 0.0).then(|| Self { gradients: point.slopes.iter().map(gradient).collect(), volume })
    }

    /// F = 1 + Σ u_a ⊗ G_a.
    pub fn deformation(&self, displacement: &[Vector<D>]) -> Tensor<D> {
        let mut f = Tensor::identity();
        for (u, g) in displacement.iter().zip(&self.gradients) {
            for i in 0..D {
                for j in 0..D {
                    f[i][j] += u[i] * g[j];
                }
            }
        }
        f
    }
}

/// Σ a_n ⊗ b_n, of as many components as there are dimensions.
pub(super) fn sum_of_dyads<const D: usize>(a: &[Vector<D>], b: &[[f64; 3]]) -> Tensor<D> {
    let both = || a.iter().zip(b);
    Tensor::from_fn(|i, j| both().map(|(a, b)| a[i] * b[j]).sum())
}

impl SolidLaw<'_> {
    /// The deformation gradient with its third direction.
    ///
    /// # Errors
    /// A sentence, where J is not positive or no thickness is free of stress.
    fn complete<const D: usize>(&self, deformation: &Tensor<D>) -> Result<Tensor<3>, String> {
        let strain = deformation.embed(1.0);
        let ratio = strain.determinant();
        if !(ratio > 0.0 && ratio.is_finite()) {
            return Err("an element of the solid is turned inside out".into());
        }
        if self.is_free_across::<D>() {
            let in_plane = Tensor::<2>::from_fn(|i, j| deformation[i][j]);
            return self.law.thickness_stretch(&in_plane).map(|stretch| deformation.embed(stretch));
        }
        Ok(strain)
    }

    /// True if the thickness follows the stress.
    pub(super) fn is_free_across<const D: usize>(&self) -> bool {
        D == 2 && self.plane == Plane::Stress
    }
}

/// The Gauss points of an element with nodes at `places` [m] in the reference state, moved by `displacement` [m], with
/// this deformation gradient.
///
/// # Errors
/// One of them is turned inside out, or has no thickness that is free of stress.
pub(super) fn deform<const D: usize>(
    points: &[GaussPoint],
    law: SolidLaw<'_>,
    places: &[Vector<D>],
    displacement: &[Vector<D>],
    gradient: impl Fn(&ReferencePoint<D>) -> Tensor<D>,
) -> Result<Vec<Deformed<D>>, ElementFault<D>> {
    let deformed = |point: &GaussPoint| {
        let sample = ReferencePoint::new(point, places).ok_or_else(|| unfit(point, places))?;
        let (place, volume) = (point.interpolate(places), sample.volume);
        let f = gradient(&sample);
        let deformation = law.complete(&f).map_err(|what| {
            let position = place + point.interpolate(displacement);
            ElementFault { what, volume_ratio: f.embed(1.0).determinant(), position }
        })?;
        let inverse = deformation.inverse().unwrap_or(Tensor::identity() * f64::NAN);
        let spatial = |g: &Vector<D>| Vector::from_fn(|i| (0..D).map(|k| inverse[k][i] * g[k]).sum());
        Ok(Deformed { place, volume, deformation, gradients: sample.gradients.iter().map(spatial).collect() })
    };
    points.iter().map(deformed).collect()
}

/// A Gauss point without a positive volume in the reference state.
pub(super) fn unfit<const D: usize>(point: &GaussPoint, places: &[Vector<D>]) -> ElementFault<D> {
    ElementFault {
        what: "an element of the solid has no positive volume in its reference state".into(),
        volume_ratio: point.weight * sum_of_dyads(places, &point.slopes).embed(1.0).determinant(),
        position: point.interpolate(places),
    }
}
