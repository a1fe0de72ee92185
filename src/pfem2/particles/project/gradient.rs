//! The gradient of what particles carry, and the correction that makes averages exact for linear fields.
//!
//! ```text
//! node i, group α, all particles p of the elements around, volume w_p:
//!   G_i = Cov(f, x) Cov(x, x)⁻¹           sure,   if Cov(x, x) > ε P, with P = Cov(x, x) of these elements   theory (G.25)
//!   G_i = Cov(f, x) (Cov(x, x) + ε P)⁻¹   unsure,  else: a drop, a film, the tip of a tongue                 theory (G.26)
//! element e:  G_e = mean of its nodes' sure G_i, of the unsure ones if none is sure
//!   R_k ← Σ_p N_k [f_p + G_e (x_k − x_p)] = R_k + G_e (x_k s_k − Σ_l S_kl x_l)
//! ```
//!
//! This is the affine kernel of theory (G.24), with the gradient taken from the particles. The correction vanishes when
//! summed over the nodes of an element, Σ_k (x_k s_k − Σ_l S_kl x_l) = 0, so that it moves no momentum: unlike
//! moving least squares per node, the result is exact for linear fields *and* conserves Σ m f. Gradients are taken
//! from the patch of a node rather than from one element because they then amplify no noise. A group that is a small
//! part of its patch would amplify it: the slope across a film of thickness δ, carried on to nodes at a distance h,
//! multiplies what its particles have against each other by h/δ. Fluids whose particles have no spread in a direction
//! are carried on as constants there.
//!
//! Nor may such a slope feed on itself. Particles beside a heavier fluid at rest lose what their nodes receive, v_p ←
//! v_p − Σ_k N_k R_k/s_k, which is a decay only if no eigenvalue of that map is below zero. On triangles with a few
//! particles each, cut by lines, films and drops at random, −0.05 comes up with ε = 0.01 and −0.001 with ε = 0.05, but
//! none with ε = 0.1. An interface that is nearly a plane keeps its exactness: one node of each element that it cuts
//! has the fluid all around it on its side.

use super::group_sums::{GroupSumTable, GroupSums};
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;
use crate::parallel;

/// Particles count as spread in all directions if det Cov ≥ this times (tr Cov / D)^D.
const FLATTEST: f64 = 1e-4;

/// Particles count as more than one if tr Cov ≥ this times their mean square distance from the node: what a single
/// particle leaves is rounding, whose shape means nothing.
const SINGLE: f64 = 1e-9;

/// ε: a slope counts up to three times the distance over which its particles are spread.
const LEAST_SPREAD: f64 = 0.1;

/// A gradient: ∂f_c/∂x of each component.
type Gradient<const K: usize, const D: usize> = [Vector<D>; K];

/// The gradient at a node, and whether it is sure.
type NodeGradient<const K: usize, const D: usize> = (Gradient<K, D>, bool);

impl<const K: usize, const N: usize> GroupSumTable<K, N> {
    /// Corrects R_k of every entry with the gradients of the groups `0..groups`; `is_shared` is true for nodes where
    /// a group may fill a small part of the elements around.
    pub fn make_linear<const D: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        groups: usize,
        is_shared: impl Fn(usize) -> bool + Sync,
    ) {
        let slopes: Vec<Vec<Option<NodeGradient<K, D>>>> =
            (0..groups).map(|group| self.slopes(mesh, group as u8, &is_shared)).collect();
        self.for_each(|e, entry| {
            let nodal = || mesh.elements()[e].iter().filter_map(|&i| slopes[entry.group as usize][i as usize].as_ref());
            let sure = mean(nodal().filter(|(_, sure)| *sure).map(|(gradient, _)| gradient));
            if let Some(gradient) = sure.or_else(|| mean(nodal().map(|(gradient, _)| gradient))) {
                correct(entry, &gradient, mesh.corners(e));
            }
        });
    }

    /// The gradients of a group; where nodes aren't shared it fills its patches.
    fn slopes<const D: usize>(
        &self,
        mesh: &Mesh<D, N>,
        group: u8,
        is_shared: &(impl Fn(usize) -> bool + Sync),
    ) -> Vec<Option<NodeGradient<K, D>>> {
        let slope = |node: usize| {
            let patch = self.patch(mesh, node, group)?;
            if is_shared(node) { patch.slope(&region(mesh, node)) } else { Some((patch.gradient()?, true)) }
        };
        parallel::collect(mesh.nodes().len(), 64, slope)
    }

    /// Sums over the particles around a node; `None` if there are none.
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
    fn add<const N: usize>(&mut self, entry: &GroupSums<K, N>, corners: [Vector<D>; N]) {
        let w = entry.weight;
        for k in 0..N {
            let sum = entry.sum(k);
            self.weight += w * sum;
            self.x += corners[k] * (w * sum);
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

    /// Σ w (x − x̄) ⊗ (x − x̄).
    fn spread(&self) -> Tensor<D> {
        let mean = self.x / self.weight;
        Tensor::from_fn(|i, j| self.xx[i][j] - self.x[i] * mean[j])
    }

    /// The gradient of a group that may be a small part of its patch, with Cov(x, x) `region` [m²].
    fn slope(&self, region: &Tensor<D>) -> Option<NodeGradient<K, D>> {
        let (spread, least) = (self.spread(), *region * (LEAST_SPREAD * self.weight));
        let sure = positive(&(spread - least)).then(|| self.over(&spread)).flatten();
        sure.map(|gradient| (gradient, true)).or_else(|| Some((self.over(&(spread + least))?, false)))
    }

    /// Cov(f, x) Cov(x, x)⁻¹; `None` if the particles lie on a line or plane, or if there is only one.
    fn gradient(&self) -> Option<Gradient<K, D>> {
        self.over(&self.spread())
    }

    /// Σ w f ⊗ (x − x̄) times the inverse of a tensor; `None` if that is flat.
    fn over(&self, spread: &Tensor<D>) -> Option<Gradient<K, D>> {
        let mean = self.x / self.weight;
        let size = spread.trace() / D as f64;
        let scaled = (*spread * (1.0 / size)).embed(1.0);
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

/// Cov(x, x) of the elements around a node [m²]: ∫x ⊗ x dV = V/(D + 1)(D + 2) (Σ_k x_k ⊗ x_k + Σ_k x_k ⊗ Σ_l x_l).
fn region<const D: usize, const N: usize>(mesh: &Mesh<D, N>, node: usize) -> Tensor<D> {
    let (mut volume, mut first, mut second) = (0.0, Vector::<D>::ZERO, Tensor::<D>::ZERO);
    for &e in mesh.elements_around(node) {
        let (own, corners) =
            (mesh.simplex(e as usize).volume, mesh.corners(e as usize).map(|x| x - mesh.nodes()[node]));
        let sum = corners.iter().copied().sum::<Vector<D>>();
        let weight = own / (N * (N + 1)) as f64;
        volume += own;
        first += sum * (own / N as f64);
        let squares = |i: usize, j: usize| corners.iter().map(|x| x[i] * x[j]).sum::<f64>();
        second += Tensor::from_fn(|i, j| weight * (squares(i, j) + sum[i] * sum[j]));
    }
    Tensor::from_fn(|i, j| (second[i][j] - first[i] * first[j] / volume) / volume)
}

/// True if a symmetric tensor is positive definite: its leading minors are positive.
fn positive<const D: usize>(a: &Tensor<D>) -> bool {
    let plane = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    a[0][0] > 0.0 && plane > 0.0 && a.embed(1.0).determinant() > 0.0
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
    entry: &mut GroupSums<K, N>,
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
