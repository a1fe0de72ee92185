//! The gradient of what particles carry, and the correction that makes averages exact for linear fields.
//!
//! ```text
//! node i, group α, all particles p of the elements around, volume w_p:
//!   G_i = Cov(f, x) Cov(x, x)⁻¹
//! element e:  G_e = mean of its nodes' G_i
//!   R_k ← Σ_p N_k [f_p + G_e (x_k − x_p)] = R_k + G_e (x_k s_k − Σ_l S_kl x_l)
//! ```
//!
//! This is the affine kernel of theory 4.3a, with the gradient taken from the particles. The correction vanishes when
//! summed over the nodes of an element, Σ_k (x_k s_k − Σ_l S_kl x_l) = 0, so that it moves no momentum: unlike
//! moving least squares per node, the result is exact for linear fields *and* conserves Σ m f. Gradients are taken
//! from the patch of a node rather than from one element because they then amplify no noise.

use super::moments::{Moments, Table};
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;
use rayon::prelude::*;

/// Particles count as spread in all directions if det Cov ≥ this times (tr Cov / D)^D.
const FLATTEST: f64 = 1e-4;

/// They count as more than one if tr Cov ≥ this times their mean square distance from the node: what a single particle
/// leaves is rounding, whose shape means nothing.
const SINGLE: f64 = 1e-9;

/// A gradient: ∂f_c/∂x of each component.
type Gradient<const K: usize, const D: usize> = [Vector<D>; K];

impl<const K: usize, const N: usize> Table<K, N> {
    /// Corrects R_k of every entry with the gradients of the groups `0..groups`.
    pub fn make_linear<const D: usize>(&mut self, mesh: &Mesh<D, N>, groups: usize) {
        let gradients: Vec<Vec<Option<Gradient<K, D>>>> =
            (0..groups).map(|group| self.gradients(mesh, group as u8)).collect();
        self.for_each(|e, entry| {
            let nodal = &gradients[entry.group as usize];
            if let Some(gradient) = mean(mesh.elements()[e].iter().filter_map(|&node| nodal[node as usize].as_ref())) {
                correct(entry, &gradient, mesh.corners(e));
            }
        });
    }

    fn gradients<const D: usize>(&self, mesh: &Mesh<D, N>, group: u8) -> Vec<Option<Gradient<K, D>>> {
        let nodes = 0..mesh.nodes().len();
        nodes.into_par_iter().map(|node| self.patch(mesh, node, group).and_then(|patch| patch.gradient())).collect()
    }

    /// What lies around a node; `None` if nothing does.
    fn patch<const D: usize>(&self, mesh: &Mesh<D, N>, node: usize, group: u8) -> Option<Patch<K, D>> {
        let mut patch =
            Patch { weight: 0.0, x: Vector::ZERO, f: Vector::ZERO, xx: Tensor::ZERO, fx: [Vector::ZERO; K] };
        for &e in mesh.elements_around(node) {
            for entry in self.of(e as usize).iter().filter(|entry| entry.group == group) {
                patch.add(entry, mesh.corners(e as usize).map(|x| x - mesh.nodes()[node]));
            }
        }
        (patch.weight > 0.0).then_some(patch)
    }
}

/// Weighted sums over the particles around a node.
struct Patch<const K: usize, const D: usize> {
    weight: f64,
    x: Vector<D>,
    f: Vector<K>,
    xx: Tensor<D>,
    fx: Gradient<K, D>,
}

impl<const K: usize, const D: usize> Patch<K, D> {
    #[inline(always)]
    fn add<const N: usize>(&mut self, entry: &Moments<K, N>, corners: [Vector<D>; N]) {
        let w = entry.weight;
        for k in 0..N {
            let share = entry.sum(k);
            self.weight += w * share;
            self.x += corners[k] * (w * share);
            self.f += entry.values[k] * w;
            let place = weighted(&entry.shape[k], &corners);
            for (i, row) in self.xx.0.iter_mut().enumerate() {
                for (j, xx) in row.iter_mut().enumerate() {
                    *xx += w * place[i] * corners[k][j];
                }
            }
            for (c, fx) in self.fx.iter_mut().enumerate() {
                *fx += corners[k] * (w * entry.values[k][c]);
            }
        }
    }

    /// Cov(f, x) Cov(x, x)⁻¹; `None` if the particles lie on a line or plane, or if there is only one.
    fn gradient(&self) -> Option<Gradient<K, D>> {
        let mean = self.x / self.weight;
        let spread = Tensor::<D>::from_fn(|i, j| self.xx[i][j] - self.x[i] * mean[j]);
        let size = spread.trace() / D as f64;
        let scaled = (spread * (1.0 / size)).embed(1.0);
        let single = SINGLE * self.xx.trace() / D as f64;
        if !(size > single && scaled.determinant() >= FLATTEST) {
            return None;
        }
        let inverse = scaled.inverse()?;
        Some(std::array::from_fn(|c| {
            let with = (self.fx[c] - mean * self.f[c]) / size;
            Vector::from_fn(|i| (0..D).map(|j| with[j] * inverse[j][i]).sum())
        }))
    }
}

/// Σ_l S_kl x_l.
#[inline(always)]
fn weighted<const D: usize, const N: usize>(shape: &[f64; N], corners: &[Vector<D>; N]) -> Vector<D> {
    let mut sum = Vector::ZERO;
    for l in 0..N {
        sum += corners[l] * shape[l];
    }
    sum
}

fn mean<'a, const K: usize, const D: usize>(
    gradients: impl Iterator<Item = &'a Gradient<K, D>>,
) -> Option<Gradient<K, D>> {
    let add =
        |(sum, count): (Gradient<K, D>, usize), g: &Gradient<K, D>| (std::array::from_fn(|c| sum[c] + g[c]), count + 1);
    let (sum, count) = gradients.fold(([Vector::ZERO; K], 0), add);
    (count > 0).then(|| sum.map(|g| g / count as f64))
}

fn correct<const K: usize, const D: usize, const N: usize>(
    entry: &mut Moments<K, N>,
    gradient: &Gradient<K, D>,
    corners: [Vector<D>; N],
) {
    // Relative to the first corner: differences of large coordinates would lose digits.
    let corners = corners.map(|x| x - corners[0]);
    for k in 0..N {
        let away = corners[k] * entry.sum(k) - weighted(&entry.shape[k], &corners);
        entry.values[k] += Vector::from_fn(|c| gradient[c].dot(away));
    }
}
