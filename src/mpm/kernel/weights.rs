//! One-dimensional weights of eight particles along one axis, as the lanes of registers (theory A.2).

use crate::math::simd::Lanes;

/// Weights of `W` nodes along an axis.
#[derive(Clone, Copy)]
pub(crate) struct Weights<L, const W: usize> {
    /// N.
    pub n: [L; W],
    /// h ∂N/∂x.
    pub gradient: [L; W],
    /// N (x_I − x_p) / h.
    pub moment: [L; W],
}

impl<L: Lanes, const W: usize> Weights<L, W> {
    /// Weights with N and h ∂N/∂x of nodes at −f, 1 − f, … from the particle, which give the moments.
    #[inline(always)]
    pub(super) fn new(f: L, n: [L; W], gradient: [L; W]) -> Self {
        let mut moment = n;
        for (i, moment) in moment.iter_mut().enumerate() {
            *moment = moment.mul(L::splat(i as f64).sub(f));
        }
        Self { n, gradient, moment }
    }

    /// Corrects the moments N d, d the distance from the particle, for ghosts beyond the wall at `plane`, which are folded
    /// by u_g = 2 u_0 − u_1: the weights that nodes 0 and 1 get from a ghost g count with the place of the node and not
    /// with that of the ghost. After folding the sums are (N_0 + 2 N_g) d_0, not N_0 d_0 + 2 N_g d_g, and
    /// (N_1 − N_g) d_1, not N_1 d_1 − N_g d_g. Supports begin at `base`; `inward` is the sign of the direction into the
    /// domain.
    #[inline(always)]
    pub fn fold_moments(&mut self, base: L, plane: f64, inward: f64) {
        let (zero, ghost) = (L::splat(0.0), L::splat(plane - inward));
        for g in 0..W {
            let node = base.add(L::splat(g as f64));
            let n = node.if_at_most(ghost, ghost.if_at_most(node, self.n[g], zero), zero);
            for (depth, change) in [(1, 2.0 * inward), (2, -2.0 * inward)] {
                let i = if inward > 0.0 { g + depth } else { g.wrapping_sub(depth) };
                if i < W {
                    self.moment[i] = n.mul_add(L::splat(change), self.moment[i]);
                }
            }
        }
    }

    /// Both slope weights of node `i`.
    #[inline(always)]
    pub fn slopes(&self, i: usize) -> [L; 2] {
        [self.gradient[i], self.moment[i]]
    }
}
