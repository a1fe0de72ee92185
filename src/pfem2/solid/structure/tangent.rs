//! Internal forces of an element of a solid and their tangent, as sums over its Gauss points (theory J.1).
//!
//! ```text
//! f_a  = ∫ σ g_a dv,      K_ab = ∫ B_aᵀ c B_b dv + ∫ (g_a · σ g_b) dv 1
//! ```

use crate::material::Stiffness;
use crate::math::{Tensor, Vector};

/// Internal forces of an element and their tangent.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementForces<const D: usize> {
    /// Internal force f_a at each node [N].
    pub internal: Vec<Vector<D>>,
    /// The part ∫ B_aᵀ c B_b dv of the tangent [N/m], row by row; symmetric. A rigid motion brings no force from it.
    pub material: Vec<Tensor<D>>,
    /// The part ∫ g_a · σ g_b dv of the tangent [N/m], the same along every axis; row by row, symmetric.
    pub geometric: Vec<f64>,
}

/// Contributions of the stress S of the last linear equations to a tangent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LastStress {
    /// ∫ G_a · S G_b dV [N/m], row by row.
    pub geometric: Vec<f64>,
    /// p J of S at the Gauss points [Pa].
    pub volumetric: Vec<f64>,
}

/// Stress and tangent at a point, times its volume in the deformed state.
pub(super) struct Weighted {
    /// σ dv [N m].
    pub stress: Tensor<3>,
    /// c dv [N m], with the components xx, yy, xy in the plane, those of `SymTensor` in space.
    pub tangent: [[f64; 6]; 6],
}

impl Weighted {
    /// A tangent c dv [N m], without a stress.
    pub fn of_tangent<const D: usize>(tangent: &Stiffness) -> Self {
        Self { stress: Tensor::ZERO, tangent: components::<D>(tangent) }
    }
}

/// The components of a tangent in D dimensions.
pub(super) fn components<const D: usize>(c: &Stiffness) -> [[f64; 6]; 6] {
    const PLANE: [usize; 6] = [0, 1, 3, 2, 4, 5];
    if D == 3 { c.0 } else { PLANE.map(|i| PLANE.map(|j| c.0[i][j])) }
}

/// The place of the component ij of a strain among those of the tangent in D dimensions.
#[inline(always)]
const fn component<const D: usize>(i: usize, j: usize) -> usize {
    if i == j {
        i
    } else if D == 2 {
        2
    } else {
        // xy, yz, zx
        [3, 5, 4][i + j - 1]
    }
}

impl<const D: usize> ElementForces<D> {
    /// No forces of `n` nodes.
    pub(super) fn zero(n: usize) -> Self {
        Self { internal: vec![Vector::ZERO; n], material: vec![Tensor::ZERO; n * n], geometric: vec![0.0; n * n] }
    }

    /// Adds a point with gradients g_a [1/m], above the diagonal of the tangent and on it.
    pub(super) fn add(&mut self, gradients: &[Vector<D>], point: &Weighted) {
        let n = gradients.len();
        add_geometric(&mut self.geometric, gradients, &point.stress);
        for (b, g) in gradients.iter().enumerate() {
            self.internal[b] += pull(&point.stress, *g);
            let columns = strain_columns(&point.tangent, *g);
            for (a, g) in gradients[..=b].iter().enumerate() {
                let block = &mut self.material[a * n + b];
                for k in 0..D {
                    for m in 0..D {
                        for l in 0..D {
                            block[k][l] += g[m] * columns[component::<D>(k, m)][l];
                        }
                    }
                }
            }
        }
    }

    /// Fills in the tangent below its diagonal.
    pub(super) fn mirror(&mut self) {
        let n = self.internal.len();
        mirror_scalars(&mut self.geometric, n);
        for a in 0..n {
            for b in 0..a {
                self.material[a * n + b] = self.material[b * n + a].transpose();
            }
        }
    }

    /// K_ab of two local nodes [N/m].
    pub fn tangent(&self, a: usize, b: usize) -> Tensor<D> {
        let entry = a * self.internal.len() + b;
        self.material[entry] + Tensor::identity() * self.geometric[entry]
    }
}

/// σ g.
#[inline(always)]
fn pull<const D: usize>(stress: &Tensor<3>, g: Vector<D>) -> Vector<D> {
    Vector::from_fn(|i| (0..D).map(|j| stress[i][j] * g[j]).sum())
}

/// Adds g_a · σ g_b of a point with the stress σ dv [N m], above the diagonal and on it.
pub(super) fn add_geometric<const D: usize>(geometric: &mut [f64], gradients: &[Vector<D>], stress: &Tensor<3>) {
    let n = gradients.len();
    for (b, g) in gradients.iter().enumerate() {
        let traction = pull(stress, *g);
        gradients[..=b].iter().enumerate().for_each(|(a, g)| geometric[a * n + b] += g.dot(traction));
    }
}

/// Fills in a symmetric matrix of n rows below its diagonal.
pub(super) fn mirror_scalars(matrix: &mut [f64], n: usize) {
    (0..n).for_each(|a| (0..a).for_each(|b| matrix[a * n + b] = matrix[b * n + a]));
}

/// c B: the stress of a unit velocity of the node with gradient `g` along each axis.
fn strain_columns<const D: usize>(tangent: &[[f64; 6]; 6], g: Vector<D>) -> [[f64; D]; 6] {
    tangent.map(|row| std::array::from_fn(|l| (0..D).map(|m| row[component::<D>(l, m)] * g[m]).sum()))
}
