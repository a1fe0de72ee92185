//! One-dimensional weights of eight particles along one axis.
//!
//! With s the position in cells relative to the tile's first node, `weights` gives the first node of the
//! support, and per node N, h ∂N/∂x and N (x_I − x_p)/h (theory A.2).

use crate::math::simd::Lanes;
use crate::mpm::Kernel;
use crate::mpm::grid::kernel;

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
    /// With the moments of nodes at −f, 1 − f, …
    #[inline(always)]
    fn new(f: L, n: [L; W], gradient: [L; W]) -> Self {
        let mut moment = n;
        for (i, moment) in moment.iter_mut().enumerate() {
            *moment = moment.mul(L::splat(i as f64).sub(f));
        }
        Self { n, gradient, moment }
    }

    /// Makes the moments of the nodes that ghosts beyond `plane` are folded to (u_g = 2 u_0 − u_1) those of these nodes'
    /// own places: N_0 d_0 + 2 N_g d_g → (N_0 + 2 N_g) d_0 and N_1 d_1 − N_g d_g → (N_1 − N_g) d_1, for supports that
    /// begin at `base`. `inward` is the sign of the direction into the domain.
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

/// A shape function of `W` nodes per axis.
pub(crate) trait Shape<const W: usize>: Copy + Send + Sync {
    /// First node of the support at `s`, in cells.
    fn base<L: Lanes>(self, s: L) -> L;
    /// Weights at `s`, in cells, of the support that begins at `base`.
    fn weights<L: Lanes>(self, s: L, base: L) -> Weights<L, W>;
}

/// Tensor-product hat functions.
#[derive(Clone, Copy)]
pub(crate) struct Linear;

impl Shape<2> for Linear {
    #[inline(always)]
    fn base<L: Lanes>(self, s: L) -> L {
        s.floor()
    }

    #[inline(always)]
    fn weights<L: Lanes>(self, s: L, base: L) -> Weights<L, 2> {
        let (one, f, least) = (L::splat(1.0), s.sub(base), kernel::Linear::LEAST);
        let n = f.max(L::splat(least)).min(L::splat(1.0 - least));
        Weights::new(f, [one.sub(n), n], [L::splat(-1.0), one])
    }
}

/// Quadratic B-spline; f in [½, 3/2) from the first node.
#[derive(Clone, Copy)]
pub(crate) struct Quadratic;

impl Shape<3> for Quadratic {
    #[inline(always)]
    fn base<L: Lanes>(self, s: L) -> L {
        s.sub(L::splat(0.5)).floor()
    }

    #[inline(always)]
    fn weights<L: Lanes>(self, s: L, base: L) -> Weights<L, 3> {
        let (half, f) = (L::splat(0.5), s.sub(base));
        let (a, b, c) = (L::splat(1.5).sub(f), f.sub(L::splat(1.0)), f.sub(half));
        let n = [half.mul(a).mul(a), L::splat(0.75).sub(b.mul(b)), half.mul(c).mul(c)];
        Weights::new(f, n, [f.sub(L::splat(1.5)), b.mul(L::splat(-2.0)), c])
    }
}

/// Cubic B-spline; f in [1, 2) from the first node.
#[derive(Clone, Copy)]
pub(crate) struct Cubic;

impl Shape<4> for Cubic {
    #[inline(always)]
    fn base<L: Lanes>(self, s: L) -> L {
        s.floor().sub(L::splat(1.0))
    }

    #[inline(always)]
    fn weights<L: Lanes>(self, s: L, base: L) -> Weights<L, 4> {
        let f = s.sub(base);
        // Distances from the second and to the third node.
        let (r, q) = (f.sub(L::splat(1.0)), L::splat(2.0).sub(f));
        let [n0, d0] = outer(q);
        let [n1, d1] = inner(r);
        let [n2, d2] = inner(q);
        let [n3, d3] = outer(r);
        let minus = |d: L| L::splat(0.0).sub(d);
        Weights::new(f, [n0, n1, n2, n3], [minus(d0), d1, minus(d2), d3])
    }
}

/// d³/6 and its derivative.
#[inline(always)]
fn outer<L: Lanes>(d: L) -> [L; 2] {
    let square = d.mul(d);
    [square.mul(d).mul(L::splat(1.0 / 6.0)), square.mul(L::splat(0.5))]
}

/// ⅔ − d² + ½ d³ and its derivative.
#[inline(always)]
fn inner<L: Lanes>(d: L) -> [L; 2] {
    let square = d.mul(d);
    let n = square.mul_add(d.mul(L::splat(0.5)).sub(L::splat(1.0)), L::splat(2.0 / 3.0));
    [n, d.mul(d.mul(L::splat(1.5)).sub(L::splat(2.0)))]
}

/// Uniform generalised interpolation with half length `l` of the particle in cells.
#[derive(Clone, Copy)]
pub(crate) struct Gimp {
    /// Half length of a particle, in cells, at most ½.
    pub half: f64,
}

impl Gimp {
    /// N and h ∂N/∂x at the distance `x` from the node. All branches are computed and one is chosen.
    #[inline(always)]
    fn hat<L: Lanes>(self, x: L) -> [L; 2] {
        let (zero, one, l) = (L::splat(0.0), L::splat(1.0), L::splat(self.half));
        let r = x.max(zero.sub(x));
        let core = l.sub(r).max(zero);
        let rim = one.add(l).sub(r).max(zero);
        let inner = one.sub(r).sub(core.mul(core).mul(L::splat(0.5 / self.half)));
        let outer = rim.mul(rim).mul(L::splat(0.25 / self.half));
        // min(r, l)/l is the slope inside, rim/2l outside; its sign is opposite to that of x.
        let per_l = L::splat(1.0 / self.half);
        let steepness = r.if_at_most(one.sub(l), r.min(l).mul(per_l), rim.mul(L::splat(0.5 / self.half)));
        let slope = x.if_at_most(zero, steepness, zero.sub(steepness));
        [r.if_at_most(one.sub(l), inner, outer), slope]
    }
}

impl Shape<3> for Gimp {
    #[inline(always)]
    fn base<L: Lanes>(self, s: L) -> L {
        s.sub(L::splat(0.5)).floor()
    }

    #[inline(always)]
    fn weights<L: Lanes>(self, s: L, base: L) -> Weights<L, 3> {
        let f = s.sub(base);
        let [n0, d0] = self.hat(f);
        let [n1, d1] = self.hat(f.sub(L::splat(1.0)));
        let [n2, d2] = self.hat(f.sub(L::splat(2.0)));
        Weights::new(f, [n0, n1, n2], [d0, d1, d2])
    }
}

/// How far a particle may leave the window of its block (see [`super::bins`]) before the tile is too small, in cells.
pub(crate) fn slack(kernel: Kernel) -> f64 {
    match kernel {
        Kernel::Linear(_) | Kernel::Quadratic(_) | Kernel::Gimp(_) => 1.0,
        Kernel::Cubic(_) => 0.5,
    }
}

/// Where the window of block 0 begins, in cells: where the support of a particle begins, as far as the tile allows.
pub(crate) fn window(kernel: Kernel) -> f64 {
    match kernel {
        Kernel::Linear(_) => 0.0,
        Kernel::Quadratic(_) | Kernel::Gimp(_) | Kernel::Cubic(_) => 0.5,
    }
}
