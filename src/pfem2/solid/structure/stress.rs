//! Stress and strain of solids at their nodes, for outputs (theory J.6).
//!
//! ```text
//! σ = dev τ̄/J + p 1 (see `dilatation.rs`), E = ½ (Fᵀ F − 1)        at the Gauss points
//! s_a = Σ_q Π_k ℓ_{q_k}(ξ_a,k) s_q                                  at the nodes of an element: the biquadratic functions through the points
//! ```
//!
//! ℓ are Lagrange's polynomials of the three Gauss points along an axis. A node has the mean of the elements around it.

use super::Structure;
use crate::math::SymTensor;
use crate::pfem2::solid::mesh::gauss::to_nodes;

/// Stress and strain at a node.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NodalStress {
    /// Cauchy's stress σ [Pa].
    pub stress: SymTensor,
    /// Green's strain E.
    pub strain: SymTensor,
}

impl<const D: usize> Structure<D> {
    /// Stress and strain at the nodes of a solid, in its present state; not a number where an element is turned inside
    /// out.
    pub fn nodal_stresses(&self, solid: usize) -> Vec<NodalStress> {
        let mesh = &self.setups()[solid].mesh;
        let weights = to_nodes(D);
        let mut sums = vec![(NodalStress::default(), 0.0); mesh.nodes.len()];
        for (element, nodes) in mesh.elements.iter().enumerate() {
            let points = self.point_stresses(solid, element);
            for (&node, weights) in nodes.iter().zip(&weights) {
                let (sum, count) = &mut sums[node as usize];
                for (point, &weight) in points.iter().zip(weights) {
                    sum.stress += point.stress * weight;
                    sum.strain += point.strain * weight;
                }
                *count += 1.0;
            }
        }
        let mean = |(sum, count): (NodalStress, f64)| NodalStress {
            stress: sum.stress * (1.0 / count),
            strain: sum.strain * (1.0 / count),
        };
        sums.into_iter().map(mean).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Elastic, StVenantKirchhoff};
    use crate::math::Vector;
    use crate::pfem2::solid::mesh::SolidMesh;
    use crate::pfem2::solid::setup::{Plane, SolidSetup};

    const YOUNG: f64 = 2e6;
    const POISSON: f64 = 0.3;

    /// A bar of 4 × 1 elements, bent to the curvature κ = 10⁻⁶/m: u = (−κ x y, ½ κ (x² + n y²)), n = ν/(1 − ν) in plane
    /// strain and ν in plane stress.
    fn bent(plane: Plane) -> (Structure<2>, f64) {
        let kappa = 1e-6;
        let mesh = SolidMesh::block(Vector([0.0, -0.1]), Vector([1.0, 0.1]), [4, 1]).unwrap();
        let across = if plane == Plane::Strain { POISSON / (1.0 - POISSON) } else { POISSON };
        let u = |x: &Vector<2>| Vector([-kappa * x[0] * x[1], 0.5 * kappa * (x[0] * x[0] + across * x[1] * x[1])]);
        let displacement = mesh.nodes.iter().map(u).collect();
        let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, YOUNG, POISSON) });
        let setup = SolidSetup { plane, ..SolidSetup::free("bar", mesh, law) };
        let mut structure = Structure::new(vec![setup]).unwrap();
        structure.state.displacement = displacement;
        (structure, kappa)
    }

    /// σ_xx = −E' κ y with E' = E/(1 − ν²) or E, and nothing along y; across the plane ν σ_xx or nothing; ε_xx = −κ y.
    #[test]
    fn a_bent_bar_has_the_stress_of_a_beam_at_its_nodes() {
        for (plane, young, across) in
            [(Plane::Strain, YOUNG / (1.0 - POISSON * POISSON), POISSON), (Plane::Stress, YOUNG, 0.0)]
        {
            let (structure, kappa) = bent(plane);
            let largest = young * kappa * 0.1;
            let nodes = structure.setups()[0].mesh.nodes.clone();
            for (node, found) in nodes.iter().zip(structure.nodal_stresses(0)) {
                let bending = -young * kappa * node[1];
                let expected = SymTensor([bending, 0.0, across * bending, 0.0, 0.0, 0.0]);
                for k in 0..6 {
                    let error = found.stress.0[k] - expected.0[k];
                    assert!(error.abs() < 1e-4 * largest, "{plane:?} {node:?}: {:?}", found.stress);
                }
                assert!((found.strain.0[0] + kappa * node[1]).abs() < 1e-4 * kappa * 0.1, "{:?}", found.strain);
            }
        }
    }
}
