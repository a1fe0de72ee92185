//! Damping in proportion to the stiffness: the viscous stress of Kelvin and Voigt (theory (J.5b)).
//!
//! ```text
//! C_ab = ∫ 2 G B_aᵀ P B_b dv + K Σ_m b_a ⊗ b_b,      P: deviator,   b_a = ∫ ψ_m J g_a dV of the projected dilatation
//! ```
//!
//! with the moduli of the law where F = 1; there C is the stiffness. It takes energy from every motion but rigid ones,
//! whatever the stress: the tangent of the stress doesn't, where a pressure is above G.

use super::Structure;
use super::deformation::{ElementFault, SolidLaw, deform};
use super::dilatation::Dilatation;
use super::tangent::{ElementForces, Weighted};
use crate::error::StepError;
use crate::linalg::SparseMatrix;
use crate::material::{Moduli, Stiffness};
use crate::math::{Tensor, Vector};
use crate::pfem2::solid::mesh::gauss::GaussPoint;

impl<const D: usize> Structure<D> {
    /// Adds β C of damped solids to a matrix, at a displacement [m].
    ///
    /// # Errors
    /// As [`Structure::equations`].
    pub(super) fn add_damping(&self, displacement: &[Vector<D>], matrix: &mut SparseMatrix) -> Result<(), StepError> {
        let is_damped = |solid: &usize| self.setups[*solid].damping.stiffness != 0.0;
        let of = |solid: usize, element: usize, law: SolidLaw<'_>| {
            let (_, [places, own]) = self.gather(solid, element, [&self.nodes, displacement]);
            damping_blocks(&self.points, law, &places, &own)
        };
        self.visit_elements(self.elastic().filter(is_damped), of, |solid, nodes, blocks| {
            let damping = self.setups[solid].damping.stiffness;
            let pairs = nodes.iter().flat_map(|&row| nodes.iter().map(move |&column| (row, column)));
            pairs.zip(blocks).for_each(|(pair, block)| self.add_block(matrix, pair, &(block * damping)));
        })
    }
}

/// C_ab of an element with nodes at `places` [m] in the reference state, moved by `displacement` [m]; in N/m, row by
/// row.
///
/// # Errors
/// As [`ElementForces::new`].
fn damping_blocks<const D: usize>(
    points: &[GaussPoint],
    law: SolidLaw<'_>,
    places: &[Vector<D>],
    displacement: &[Vector<D>],
) -> Result<Vec<Tensor<D>>, ElementFault<D>> {
    let samples = deform(points, law, places, displacement, |sample| sample.deformation(displacement))?;
    let moduli @ Moduli { bulk, shear } = law.law.moduli();
    let (identity, dyad) = (Stiffness::identity() * (2.0 * shear), Stiffness::volumetric());
    let is_free_across = law.is_free_across::<D>();
    // Without stress across the plane d_zz = −λ/(λ + 2G) (d_xx + d_yy).
    let in_plane = 2.0 * shear * moduli.lame() / (moduli.lame() + 2.0 * shear);
    let tangent = if is_free_across { identity + dyad * in_plane } else { identity - dyad * (2.0 / 3.0 * shear) };
    let mut forces = ElementForces::zero(places.len());
    for sample in &samples {
        let dv = sample.deformation.determinant() * sample.volume;
        forces.add(&sample.gradients, &Weighted::of_tangent::<D>(&(tangent * dv)));
    }
    if !is_free_across {
        Dilatation::new(&samples, displacement, points)?.add_bulk(bulk, &mut forces);
    }
    forces.mirror();
    Ok(forces.material)
}

#[cfg(test)]
mod tests {
    use super::super::super::mesh::SolidMesh;
    use super::*;
    use crate::material::{Elastic, NeoHookean};
    use crate::pfem2::solid::mesh::gauss::gauss_points;
    use crate::pfem2::solid::setup::Plane;
    use crate::pfem2::solid::surface::tests::number;

    fn check<const D: usize>(plane: Plane) {
        let places = SolidMesh::<D>::block(Vector::ZERO, Vector::from_fn(|i| 1.0 + i as f64), [1; D]).unwrap().nodes;
        let law = NeoHookean { elastic: Elastic::new(1.0, 1e6, 0.45) };
        let (law, points, count) = (SolidLaw { law: &law, plane }, gauss_points(D), places.len());
        let still = vec![Vector::ZERO; count];
        let own = damping_blocks(&points, law, &places, &still).unwrap();
        let exact = ElementForces::new(&points, law, &places, &still).unwrap();
        assert!(
            own.iter().zip(&exact.material).all(|(a, b)| (*a - *b).0.iter().flatten().all(|x| x.abs() < 1e-9 * 1e6))
        );
        // Compressed until the pressure is several times the shear modulus, and turned.
        let deformed = |x: Vector<D>| {
            let turned = Vector::from_fn(|i| {
                if i == 0 {
                    -x[1]
                } else if i == 1 {
                    x[0]
                } else {
                    x[i]
                }
            });
            turned * 0.7
        };
        let u: Vec<_> = places.iter().map(|x| deformed(*x) - *x).collect();
        let blocks = damping_blocks(&points, law, &places, &u).unwrap();
        let power = |v: &[Vector<D>]| -> f64 {
            let force = |a: usize| (0..count).map(|b| blocks[a * count + b].apply(v[b])).sum::<Vector<D>>();
            (0..count).map(|a| v[a].dot(force(a))).sum()
        };
        let mut seed = 5;
        for _ in 0..50 {
            let v: Vec<_> = (0..count).map(|_| Vector::from_fn(|_| number(&mut seed) - 0.5)).collect();
            assert!(power(&v) > 0.0);
        }
        let spin = |x: &Vector<D>| {
            Vector::from_fn(|i| {
                if i == 0 {
                    -x[1]
                } else if i == 1 {
                    x[0]
                } else {
                    0.0
                }
            })
        };
        let turning: Vec<_> = places.iter().map(|x| spin(&deformed(*x))).collect();
        assert!(power(&turning).abs() < 1e-9 * 1e6, "{}", power(&turning));
    }

    /// It is the stiffness where there is no strain, takes energy from every motion under a pressure of several times
    /// the shear modulus, and none from a turn.
    #[test]
    fn damping_takes_energy_whatever_the_stress() {
        check::<2>(Plane::Strain);
        check::<2>(Plane::Stress);
        check::<3>(Plane::Strain);
    }
}
