//! Elements of nearly incompressible solids: the volume ratio is projected on linear functions (Simo, Taylor & Pister
//! 1985; theory J.1, J.18).
//!
//! ```text
//! Π = ∫ W(F̄) + p (J − θ) dV,      F̄ = (θ/J)^⅓ F,      θ, p = Σ_m ψ_m(X) θ_m, ψ_m(X) p_m,   ψ = 1, X, Y (, Z)
//! θ = projection of J,   p = projection of ⅓ tr σ(F̄),      τ̄ = θ σ(F̄),   τ = dev τ̄ + p J 1
//! f_a = ∫ τ g_a dV,      K_ab = ∫ B_aᵀ a B_b + (g_a · τ g_b) 1 dV + Σ_m (r_a ⊗ b_b + b_a ⊗ r_b)
//! a   = P θc P + 2 τ̄_m (1 ⊙ 1 − ⅓ 1 ⊗ 1) − ⅔ (1 ⊗ s + s ⊗ 1) + p J (1 ⊗ 1 − 2 · 1 ⊙ 1),   P: deviator,  s = dev τ̄,  τ̄_m = ⅓ tr τ̄
//! b_a = ∫ ψ_m J g_a dV,   r_a = ∫ ψ_m w g_a dV + ½ Σ_n q_mn b_a,n,
//! w   = (dev(1 : θc) + 2 s)/3θ,   q_mn = ∫ ψ_m ψ_n ((1 : θc : 1)/9θ² − τ̄_m/3θ²) dV
//! ```
//!
//! With biquadratic (triquadratic) displacements linear p is stable up to ν → ½, where displacements alone lock.
//! Functions ψ are orthonormal over the element in its reference state; as functions of place, not of ξ, they keep
//! the order of the approximation in distorted elements. θ and p follow from the displacement without iterations;
//! forces are the slopes of ∫ W(F̄) dV.

use super::deformation::{Deformed, ElementFault};
use super::tangent::{ElementForces, Weighted, components};
use crate::material::{ElasticLaw, ElasticState, Linearised, Stiffness};
use crate::math::{SymTensor, Tensor, Vector};
use crate::pfem2::solid::mesh::gauss::GaussPoint;

/// Functions ψ_m in three dimensions; one less in the plane.
const MODES: usize = 4;

/// The projected volume ratio of an element.
pub(in crate::pfem2::solid) struct Dilatation<'a, const D: usize> {
    samples: &'a [Deformed<D>],
    /// ψ_m at the Gauss points; zero beyond D.
    modes: Vec<[f64; MODES]>,
    /// θ at the Gauss points.
    ratio: Vec<f64>,
}

/// Contribution of the dilatation modes to the tangent.
struct ModeTangent<const D: usize> {
    /// b_a of each mode.
    volume: [Vec<Vector<D>>; MODES],
    /// ∫ ψ_m w g_a dV.
    shape: [Vec<Vector<D>>; MODES],
    /// q_mn.
    bulk: [[f64; MODES]; MODES],
}

impl<'a, const D: usize> Dilatation<'a, D> {
    /// Modes at the Gauss points of an element.
    ///
    /// # Errors
    /// The projected volume ratio is not positive at one of them.
    pub fn new(
        samples: &'a [Deformed<D>],
        displacement: &[Vector<D>],
        points: &[GaussPoint],
    ) -> Result<Self, ElementFault<D>> {
        let mut own = Self { samples, modes: modes(samples), ratio: Vec::new() };
        own.ratio = own.projected(|q| samples[q].deformation.determinant());
        match own.ratio.iter().position(|ratio| *ratio <= 0.0) {
            None => Ok(own),
            Some(q) => Err(ElementFault {
                what: "an element of the solid is turned inside out in the mean".into(),
                volume_ratio: own.ratio[q],
                position: samples[q].place + points[q].interpolate(displacement),
            }),
        }
    }

    /// The projection at the Gauss points of what has these values there.
    fn projected(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut amplitude = [0.0; MODES];
        for (q, (sample, modes)) in self.samples.iter().zip(&self.modes).enumerate() {
            amplitude.iter_mut().zip(modes).for_each(|(sum, mode)| *sum += mode * value(q) * sample.volume);
        }
        self.modes.iter().map(|modes| modes.iter().zip(&amplitude).map(|(mode, x)| mode * x).sum()).collect()
    }

    /// F̄ at a Gauss point.
    pub fn deformation(&self, q: usize) -> Tensor<3> {
        let f = self.samples[q].deformation;
        f * (self.ratio[q] / f.determinant()).cbrt()
    }

    /// Cauchy's stress at the Gauss points [Pa].
    pub fn stresses(&self, law: &dyn ElasticLaw) -> Vec<SymTensor> {
        let point = |q| law.linearised(&ElasticState { deformation: self.deformation(q), stress: SymTensor::ZERO });
        let points: Vec<Linearised<6>> = (0..self.samples.len()).map(point).collect();
        let mean = self.projected(|q| -points[q].pressure);
        let stress = |q: usize| {
            let volume_ratio = self.samples[q].deformation.determinant();
            points[q].deviator * (self.ratio[q] / volume_ratio) + SymTensor::isotropic(mean[q])
        };
        (0..points.len()).map(stress).collect()
    }

    /// Adds forces, and the tangent above its diagonal and on it, where `last` has p J of the last term of a at the
    /// Gauss points [Pa], if it is another than that of the forces.
    pub fn add_forces(&self, law: &dyn ElasticLaw, last: Option<&[f64]>, forces: &mut ElementForces<D>) {
        let point = |q| law.linearised(&ElasticState { deformation: self.deformation(q), stress: SymTensor::ZERO });
        let points: Vec<Linearised<6>> = (0..self.samples.len()).map(point).collect();
        let mean = self.projected(|q| -points[q].pressure);
        let mut tangent = ModeTangent::new(forces.internal.len());
        for (q, point) in points.iter().enumerate() {
            let (sample, ratio) = (&self.samples[q], self.ratio[q]);
            let volumetric = mean[q] * sample.deformation.determinant();
            let all = kirchhoff(point, ratio, last.map_or(volumetric, |last| last[q]));
            let stress = point.deviator * ratio + SymTensor::isotropic(volumetric);
            let weighted =
                Weighted { stress: stress.full() * sample.volume, tangent: components::<D>(&(all * sample.volume)) };
            forces.add(&sample.gradients, &weighted);
            tangent.add(sample, &self.modes[q], point, ratio);
        }
        tangent.finish(forces);
    }
}

impl<const D: usize> Dilatation<'_, D> {
    /// Adds K Σ_m b_a ⊗ b_b to the tangent above its diagonal and on it.
    pub fn add_bulk(&self, bulk: f64, forces: &mut ElementForces<D>) {
        let nodes = forces.internal.len();
        for m in 0..=D {
            let mut volume = vec![Vector::<D>::ZERO; nodes];
            for (sample, modes) in self.samples.iter().zip(&self.modes) {
                let current = sample.deformation.determinant() * sample.volume * modes[m];
                volume.iter_mut().zip(&sample.gradients).for_each(|(sum, g)| *sum += *g * current);
            }
            for first in 0..nodes {
                for second in first..nodes {
                    forces.material[first * nodes + second] += Tensor::outer(volume[first], volume[second]) * bulk;
                }
            }
        }
    }
}

/// a at a point.
fn kirchhoff(point: &Linearised<6>, ratio: f64, volumetric: f64) -> Stiffness {
    let (one, identity, dyad) = (SymTensor::isotropic(1.0), Stiffness::identity(), Stiffness::volumetric());
    let (c, s) = (Stiffness(point.tangent) * ratio, point.deviator * ratio);
    let trace = c.trace();
    let deviatoric = c - (Stiffness::dyad(&one, &trace) + Stiffness::dyad(&trace, &one)) * (1.0 / 3.0)
        + dyad * (trace.trace() / 9.0);
    deviatoric + (identity - dyad * (1.0 / 3.0)) * (-2.0 * point.pressure * ratio)
        - (Stiffness::dyad(&one, &s) + Stiffness::dyad(&s, &one)) * (2.0 / 3.0)
        + (dyad - identity * 2.0) * volumetric
}

/// Orthonormal linear functions of place at the Gauss points, by Gram and Schmidt.
fn modes<const D: usize>(samples: &[Deformed<D>]) -> Vec<[f64; MODES]> {
    let mut modes = vec![[0.0; MODES]; samples.len()];
    for m in 0..=D {
        for (mode, sample) in modes.iter_mut().zip(samples) {
            mode[m] = if m == 0 { 1.0 } else { sample.place[m - 1] };
        }
        let product = |modes: &[[f64; MODES]], n: usize| -> f64 {
            modes.iter().zip(samples).map(|(mode, sample)| mode[m] * mode[n] * sample.volume).sum()
        };
        for n in 0..m {
            let part = product(&modes, n);
            modes.iter_mut().for_each(|mode| mode[m] -= part * mode[n]);
        }
        let norm = product(&modes, m).sqrt();
        modes.iter_mut().for_each(|mode| mode[m] /= norm);
    }
    modes
}

impl<const D: usize> ModeTangent<D> {
    fn new(nodes: usize) -> Self {
        let none = || std::array::from_fn(|_| vec![Vector::ZERO; nodes]);
        Self { volume: none(), shape: none(), bulk: [[0.0; MODES]; MODES] }
    }

    /// Adds a Gauss point with the functions ψ_m.
    fn add(&mut self, sample: &Deformed<D>, modes: &[f64; MODES], point: &Linearised<6>, ratio: f64) {
        let trace = (Stiffness(point.tangent) * ratio).trace();
        let w = ((trace.deviator() + point.deviator * (2.0 * ratio)) * (1.0 / (3.0 * ratio))).full();
        let bulk = trace.trace() / (9.0 * ratio * ratio) + point.pressure / (3.0 * ratio);
        let current = sample.deformation.determinant() * sample.volume;
        for (m, mode) in modes.iter().enumerate().take(D + 1) {
            for (a, g) in sample.gradients.iter().enumerate() {
                self.volume[m][a] += *g * (mode * current);
                let along = Vector::from_fn(|i| (0..D).map(|j| w[i][j] * g[j]).sum());
                self.shape[m][a] += along * (mode * sample.volume);
            }
            for (n, other) in modes.iter().enumerate() {
                self.bulk[m][n] += mode * other * bulk * sample.volume;
            }
        }
    }

    /// Adds r_a ⊗ b_b + b_a ⊗ r_b.
    fn finish(mut self, forces: &mut ElementForces<D>) {
        let nodes = forces.internal.len();
        for m in 0..=D {
            for n in 0..=D {
                for a in 0..nodes {
                    self.shape[m][a] += self.volume[n][a] * (0.5 * self.bulk[m][n]);
                }
            }
            let (r, b) = (&self.shape[m], &self.volume[m]);
            for first in 0..nodes {
                for second in first..nodes {
                    forces.material[first * nodes + second] +=
                        Tensor::outer(r[first], b[second]) + Tensor::outer(b[first], r[second]);
                }
            }
        }
    }
}
