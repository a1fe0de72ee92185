//! Internal forces and tangent of an element of a solid, from its reference state (theory J.1).
//!
//! ```text
//! F = 1 + Σ u_a ⊗ G_a,   G_a = ∂N_a/∂X,      g_a = F⁻ᵀ G_a,   dv = J dV
//! f_a  = ∫ P G_a dV = ∫ σ g_a dv
//! K_ab = ∫ B_aᵀ c B_b dv + ∫ (g_a · σ g_b) dv 1,      M_ab = ∫ ρ₀ N_a N_b dV
//! ```
//!
//! σ and the tangent c of Truesdell's rate of it are those of an elastic law (theory B.13), with the projected
//! dilatation of `dilatation.rs` except in plane stress. Integrals take three Gauss points along each axis. In
//! the plane they are per metre of depth in the reference state; F_zz = 1 without strain across the plane, and
//! the stretch that leaves no stress there otherwise.

use super::deformation::{Deformed, ElementFault, ReferencePoint, SolidLaw, deform, sum_of_dyads, unfit};
use super::dilatation::Dilatation;
use super::stress::NodalStress;
use super::tangent::{ElementForces, LastStress, Weighted, add_geometric, mirror_scalars};
use crate::material::ElasticState;
use crate::math::{SymTensor, Tensor, Vector};
use crate::pfem2::solid::mesh::gauss::GaussPoint;

impl<const D: usize> ElementForces<D> {
    /// Forces and tangent of the element with nodes at `places` [m] in the reference state, moved by `displacement`
    /// [m].
    ///
    /// # Errors
    /// A Gauss point is turned inside out, by itself or in the projection, or has no thickness that is free of stress.
    pub fn new(
        points: &[GaussPoint],
        law: SolidLaw<'_>,
        places: &[Vector<D>],
        displacement: &[Vector<D>],
    ) -> Result<Self, ElementFault<D>> {
        Self::with_last_stress(points, law, [places, displacement], None)
    }

    /// Forces of the element with nodes at these places in the reference state and this displacement [m], and their
    /// tangent, in which another stress stands where stress stands beside stiffness.
    ///
    /// # Errors
    /// As [`ElementForces::new`].
    pub(super) fn with_last_stress(
        points: &[GaussPoint],
        law: SolidLaw<'_>,
        [places, displacement]: [&[Vector<D>]; 2],
        last: Option<LastStress>,
    ) -> Result<Self, ElementFault<D>> {
        let mut forces = Self::zero(places.len());
        let samples = deform(points, law, places, displacement, |sample| sample.deformation(displacement))?;
        if law.is_free_across::<D>() {
            samples.iter().for_each(|point| forces.add(&point.gradients, &law.plane_stress(point)));
        } else {
            let volumetric = last.as_ref().map(|last| &last.volumetric[..]);
            Dilatation::new(&samples, displacement, points)?.add_forces(law.law, volumetric, &mut forces);
        }
        forces.mirror();
        if let Some(last) = last {
            forces.geometric = last.geometric;
        }
        Ok(forces)
    }
}

impl SolidLaw<'_> {
    /// Stress and tangent of plane stress.
    fn plane_stress<const D: usize>(&self, point: &Deformed<D>) -> Weighted {
        let dv = point.deformation.determinant() * point.volume;
        let state = ElasticState { deformation: point.deformation, stress: SymTensor::ZERO };
        let point = self.law.linearised(&state).plane_stress();
        let mut tangent = [[0.0; 6]; 6];
        for (row, own) in tangent.iter_mut().zip(&point.tangent) {
            row.iter_mut().zip(own).for_each(|(entry, c)| *entry = c * dv);
        }
        Weighted { stress: point.stress().full() * dv, tangent }
    }
}

/// Stored energy ∫ W dV of an element [J].
///
/// # Errors
/// As [`ElementForces::new`].
pub fn strain_energy<const D: usize>(
    points: &[GaussPoint],
    law: SolidLaw<'_>,
    places: &[Vector<D>],
    displacement: &[Vector<D>],
) -> Result<f64, ElementFault<D>> {
    let samples = deform(points, law, places, displacement, |sample| sample.deformation(displacement))?;
    let energy = |deformation: Tensor<3>| {
        law.law.strain_energy(&ElasticState { deformation, stress: SymTensor::ZERO }).unwrap_or(f64::NAN)
    };
    if law.is_free_across::<D>() {
        return Ok(samples.iter().map(|point| energy(point.deformation) * point.volume).sum());
    }
    let dilatation = Dilatation::new(&samples, displacement, points)?;
    Ok(samples.iter().enumerate().map(|(q, point)| energy(dilatation.deformation(q)) * point.volume).sum())
}

/// Stress and strain at the Gauss points of an element.
///
/// # Errors
/// As [`ElementForces::new`].
pub fn stresses<const D: usize>(
    points: &[GaussPoint],
    law: SolidLaw<'_>,
    places: &[Vector<D>],
    displacement: &[Vector<D>],
) -> Result<Vec<NodalStress>, ElementFault<D>> {
    let samples = deform(points, law, places, displacement, |sample| sample.deformation(displacement))?;
    let stresses = sample_stresses(points, law, displacement, &samples)?;
    let strain = |f: &Tensor<3>| (f.transpose().dot(f) - Tensor::identity()).symmetric() * 0.5;
    let both = stresses.into_iter().zip(&samples);
    Ok(both.map(|(stress, point)| NodalStress { stress, strain: strain(&point.deformation) }).collect())
}

/// Cauchy's stress at the Gauss points of an element [Pa].
fn sample_stresses<const D: usize>(
    points: &[GaussPoint],
    law: SolidLaw<'_>,
    displacement: &[Vector<D>],
    samples: &[Deformed<D>],
) -> Result<Vec<SymTensor>, ElementFault<D>> {
    if !law.is_free_across::<D>() {
        return Ok(Dilatation::new(samples, displacement, points)?.stresses(law.law));
    }
    let state = |deformation| ElasticState { deformation, stress: SymTensor::ZERO };
    let stress = |point: &Deformed<D>| law.law.linearised(&state(point.deformation)).plane_stress().stress();
    Ok(samples.iter().map(stress).collect())
}

/// The part ∫ G_a · S G_b dV of the tangent with the stress S that the linear equations of a step
/// had at its end, and the pressure of it: that of C = FᵀF − HᵀH, where F is the deformation gradient of `displacement`
/// and H the gradient of its `correction` u − u* [m]. (Their strain is linear in H, theory (J.5a).) It is the same in
/// every frame that turns with the element.
///
/// # Errors
/// As [`ElementForces::new`].
pub(super) fn last_stress<const D: usize>(
    points: &[GaussPoint],
    law: SolidLaw<'_>,
    places: &[Vector<D>],
    [displacement, correction]: [&[Vector<D>]; 2],
) -> Result<LastStress, ElementFault<D>> {
    let samples = deform(points, law, places, displacement, |sample| {
        let f = sample.deformation(displacement);
        let h = sample.deformation(correction) - Tensor::identity();
        let inverse = f.embed(1.0).inverse().unwrap_or(Tensor::identity() * f64::NAN);
        f - Tensor::from_fn(|i, j| inverse[j][i]).dot(&h.transpose().dot(&h)) * 0.5
    })?;
    let stresses = sample_stresses(points, law, displacement, &samples)?;
    let n = places.len();
    let mut last = LastStress { geometric: vec![0.0; n * n], volumetric: Vec::with_capacity(samples.len()) };
    for (point, stress) in samples.iter().zip(stresses) {
        let ratio = point.deformation.determinant();
        last.volumetric.push(stress.trace() / 3.0 * ratio);
        add_geometric(&mut last.geometric, &point.gradients, &(stress.full() * (ratio * point.volume)));
    }
    mirror_scalars(&mut last.geometric, n);
    Ok(last)
}

/// M_ab per unit of density, ∫ N_a N_b dV [m³], row by row.
///
/// # Errors
/// An element without a positive volume.
pub fn mass<const D: usize>(points: &[GaussPoint], places: &[Vector<D>]) -> Result<Vec<f64>, ElementFault<D>> {
    let n = places.len();
    let mut mass = vec![0.0; n * n];
    for point in points {
        let sample = ReferencePoint::new(point, places).ok_or_else(|| unfit(point, places))?;
        for a in 0..n {
            for b in 0..n {
                mass[a * n + b] += sample.volume * point.shape[a] * point.shape[b];
            }
        }
    }
    Ok(mass)
}

/// Volume of an element with nodes at `places` [m³].
pub fn volume<const D: usize>(points: &[GaussPoint], places: &[Vector<D>]) -> f64 {
    points.iter().map(|point| point.weight * sum_of_dyads(places, &point.slopes).embed(1.0).determinant()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Elastic, ElasticLaw, NeoHookean, StVenantKirchhoff};
    use crate::pfem2::solid::mesh::SolidMesh;
    use crate::pfem2::solid::mesh::gauss::gauss_points;
    use crate::pfem2::solid::setup::Plane;

    /// One element with its nodes moved from those of the unit square or cube, the edges curved, too.
    fn distorted<const D: usize>() -> Vec<Vector<D>> {
        let mesh = SolidMesh::block(Vector::ZERO, Vector::splat(1.0), [1; D]).unwrap();
        let moved = |x: Vector<D>| x + Vector::from_fn(|k| 0.05 * (3.0 * x[(k + 1) % D] + 2.0 * x[k] + k as f64).sin());
        mesh.nodes.into_iter().map(moved).collect()
    }

    /// A smooth displacement with strains of a tenth and more.
    fn moved<const D: usize>(places: &[Vector<D>]) -> Vec<Vector<D>> {
        let u = |x: &Vector<D>| Vector::from_fn(|k| 0.1 * (2.0 * x[(k + 1) % D] + x[k] * x[0] + k as f64).cos());
        places.iter().map(u).collect()
    }

    fn laws() -> [Box<dyn ElasticLaw>; 2] {
        let elastic = Elastic::new(1000.0, 1e6, 0.4);
        [Box::new(StVenantKirchhoff { elastic }), Box::new(NeoHookean { elastic })]
    }

    /// Forces are the slopes of the stored energy, and the tangent those of the forces.
    fn check_slopes<const D: usize>(plane: Plane) {
        let (points, places) = (gauss_points(D), distorted::<D>());
        let step = 1e-5;
        for law in &laws() {
            let law = SolidLaw { law: &**law, plane };
            let u = moved(&places);
            let forces = ElementForces::new(&points, law, &places, &u).unwrap();
            for b in 0..places.len() {
                for l in 0..D {
                    let [more, less] = [step, -step].map(|step| {
                        let mut u = u.clone();
                        u[b][l] += step;
                        let forces = ElementForces::new(&points, law, &places, &u).unwrap();
                        (forces.internal, strain_energy(&points, law, &places, &u).unwrap())
                    });
                    let force = (more.1 - less.1) / (2.0 * step);
                    assert!((force - forces.internal[b][l]).abs() < 1e-6 * 1e5, "{force} {}", forces.internal[b][l]);
                    for a in 0..places.len() {
                        let slope = (more.0[a] - less.0[a]) / (2.0 * step);
                        for k in 0..D {
                            let exact = forces.tangent(a, b)[k][l];
                            assert!((slope[k] - exact).abs() < 1e-6 * 1e6, "{a}{b}{k}{l}: {} {exact}", slope[k]);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn tangents_are_slopes_of_forces_and_these_of_the_energy() {
        check_slopes::<2>(Plane::Strain);
        check_slopes::<2>(Plane::Stress);
        check_slopes::<3>(Plane::Strain);
    }

    /// A rotation of 100° moves no stress into the element, and its velocity none into the part of the tangent from
    /// the stress.
    #[test]
    fn rotations_are_without_forces() {
        let (points, places) = (gauss_points(2), distorted::<2>());
        let (sin, cos) = 1.75f64.sin_cos();
        let turned = |x: &Vector<2>| Vector([cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]]);
        let u: Vec<_> = places.iter().map(|x| turned(x) - *x).collect();
        let spin: Vec<_> = places.iter().map(|x| Vector([-turned(x)[1], turned(x)[0]])).collect();
        for (law, plane) in laws().iter().flat_map(|law| [(law, Plane::Strain), (law, Plane::Stress)]) {
            let forces = ElementForces::new(&points, SolidLaw { law: &**law, plane }, &places, &u).unwrap();
            assert!(forces.internal.iter().all(|f| f.norm() < 1e-12 * 1e6), "{:?}", forces.internal);
            for a in 0..9 {
                let force: Vector<2> = (0..9).map(|b| forces.material[a * 9 + b].apply(spin[b])).sum();
                assert!(force.norm() < 1e-12 * 1e6, "{force:?}");
            }
        }
    }

    /// A bar stretched by λ in plane stress: S = E_Y E_xx between its ends, the force per reference area ½ E_Y (λ³ −
    /// λ).
    #[test]
    fn plane_stress_leaves_the_thickness_free() {
        let mesh = SolidMesh::<2>::block(Vector::ZERO, Vector([2.0, 0.5]), [1, 1]).unwrap();
        let (stretch, young, poisson) = (1.2f64, 1e6, 0.4);
        let across = (1.0 - poisson * (stretch * stretch - 1.0)).sqrt();
        let u: Vec<_> = mesh.nodes.iter().map(|x| Vector([(stretch - 1.0) * x[0], (across - 1.0) * x[1]])).collect();
        let law = StVenantKirchhoff { elastic: Elastic::new(1.0, young, poisson) };
        let law = SolidLaw { law: &law, plane: Plane::Stress };
        let forces = ElementForces::new(&gauss_points(2), law, &mesh.nodes, &u).unwrap();
        let end: f64 = [2, 5, 8].map(|a| forces.internal[a][0]).iter().sum();
        let exact = 0.5 * 0.5 * young * (stretch.powi(3) - stretch);
        assert!((end / exact - 1.0).abs() < 1e-9, "{end} {exact}");
        assert!(forces.internal.iter().all(|f| f[1].abs() < 1e-6 * exact));
    }

    #[test]
    fn masses_and_volumes_are_those_of_the_shape() {
        let mesh = SolidMesh::<3>::block(Vector::ZERO, Vector([2.0, 3.0, 5.0]), [1; 3]).unwrap();
        let mass = mass(&gauss_points(3), &mesh.nodes).unwrap();
        // ∫ L_0² = 4/15 and ∫ L_0 L_1 = 2/15 over [−1, 1]
        assert!((mass[0] / (30.0 * (2.0f64 / 15.0).powi(3)) - 1.0).abs() < 1e-13);
        assert!((mass[1] / (30.0 * (2.0f64 / 15.0).powi(2) / 15.0) - 1.0).abs() < 1e-13);
        assert!((volume(&gauss_points(3), &mesh.nodes) - 30.0).abs() < 1e-13);
    }

    #[test]
    fn an_element_turned_inside_out_is_an_error_with_its_place() {
        let mesh = SolidMesh::<2>::block(Vector::ZERO, Vector([1.0, 1.0]), [1, 1]).unwrap();
        let law = StVenantKirchhoff { elastic: Elastic::new(1.0, 1.0, 0.3) };
        let law = SolidLaw { law: &law, plane: Plane::Strain };
        let u: Vec<_> = mesh.nodes.iter().map(|x| Vector([-1.5 * x[0], 7.0])).collect();
        let fault = ElementForces::new(&gauss_points(2), law, &mesh.nodes, &u).unwrap_err();
        assert!((fault.volume_ratio + 0.5).abs() < 1e-12 && (7.0..8.0).contains(&fault.position[1]), "{fault:?}");
    }
}
