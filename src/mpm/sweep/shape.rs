//! One-dimensional weights of all axes at once: the axes are lanes of `[f64; 4]`.
//!
//! With s the position in cells relative to the tile's first node, `weights` gives the first node of the
//! support, and per node N, h ∂N/∂x and (x_I − x_p)/h (theory 2.2).

use crate::mpm::Kernel;

/// One number per axis.
pub(crate) type Axes = [f64; 4];

/// Weights of `W` nodes per axis.
#[derive(Clone, Copy)]
pub(crate) struct Weights<const W: usize> {
    /// First node of the support, as a whole number.
    pub base: Axes,
    /// N.
    pub n: [Axes; W],
    /// h ∂N/∂x.
    pub dn: [Axes; W],
    /// (x_I − x_p) / h.
    pub offset: [Axes; W],
}

impl<const W: usize> Weights<W> {
    /// Makes Σ N offset over the nodes that ghosts beyond `plane` are folded to (u_g = 2 u_0 − u_1) that of these
    /// nodes' own places: N_0 d_0 + 2 N_g d_g → (N_0 + 2 N_g) d_0 and N_1 d_1 − N_g d_g → (N_1 − N_g) d_1. `inward` is
    /// the sign of the direction into the domain.
    #[inline(always)]
    pub fn fold_offsets(&mut self, axis: usize, plane: f64, inward: f64) {
        for g in 0..W {
            let ghost = self.base[axis] + g as f64 == plane - inward;
            let n = self.n[g][axis];
            if !ghost || n == 0.0 {
                continue;
            }
            for (depth, sign) in [(1, 1.0), (2, -1.0)] {
                let i = if inward > 0.0 { g + depth } else { g.wrapping_sub(depth) };
                if i < W && self.n[i][axis] > 0.0 {
                    self.offset[i][axis] += sign * inward * 2.0 * n / self.n[i][axis];
                }
            }
        }
    }
}

/// A shape function of `W` nodes per axis.
pub(crate) trait Shape<const W: usize>: Copy + Send + Sync {
    /// Weights at `s`, in cells.
    fn weights(self, s: Axes) -> Weights<W>;
}

#[inline(always)]
fn each(a: Axes, f: impl Fn(f64) -> f64) -> Axes {
    [f(a[0]), f(a[1]), f(a[2]), f(a[3])]
}

#[inline(always)]
fn minus(a: Axes, b: Axes) -> Axes {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

/// Tensor-product hat functions.
#[derive(Clone, Copy)]
pub(crate) struct Linear;

impl Shape<2> for Linear {
    #[inline(always)]
    fn weights(self, s: Axes) -> Weights<2> {
        let base = each(s, f64::floor);
        let f = minus(s, base);
        Weights {
            base,
            n: [each(f, |f| 1.0 - f), f],
            dn: [[-1.0; 4], [1.0; 4]],
            offset: [each(f, |f| -f), each(f, |f| 1.0 - f)],
        }
    }
}

/// Quadratic B-spline; f in [½, 3/2) from the first node.
#[derive(Clone, Copy)]
pub(crate) struct Quadratic;

impl Shape<3> for Quadratic {
    #[inline(always)]
    fn weights(self, s: Axes) -> Weights<3> {
        let base = each(s, |s| (s - 0.5).floor());
        let f = minus(s, base);
        Weights {
            base,
            n: [
                each(f, |f| 0.5 * (1.5 - f) * (1.5 - f)),
                each(f, |f| 0.75 - (f - 1.0) * (f - 1.0)),
                each(f, |f| 0.5 * (f - 0.5) * (f - 0.5)),
            ],
            dn: [each(f, |f| f - 1.5), each(f, |f| 2.0 - 2.0 * f), each(f, |f| f - 0.5)],
            offset: [each(f, |f| -f), each(f, |f| 1.0 - f), each(f, |f| 2.0 - f)],
        }
    }
}

/// Cubic B-spline; f in [1, 2) from the first node.
#[derive(Clone, Copy)]
pub(crate) struct Cubic;

impl Shape<4> for Cubic {
    #[inline(always)]
    fn weights(self, s: Axes) -> Weights<4> {
        let base = each(s, |s| s.floor() - 1.0);
        let f = minus(s, base);
        let outer = |r: f64| r * r * r / 6.0;
        let inner = |r: f64| 2.0 / 3.0 - r * r + 0.5 * r * r * r;
        Weights {
            base,
            n: [
                each(f, |f| outer(2.0 - f)),
                each(f, |f| inner(f - 1.0)),
                each(f, |f| inner(2.0 - f)),
                each(f, |f| outer(f - 1.0)),
            ],
            dn: [
                each(f, |f| -0.5 * (2.0 - f) * (2.0 - f)),
                each(f, |f| (f - 1.0) * (1.5 * (f - 1.0) - 2.0)),
                each(f, |f| -(2.0 - f) * (1.5 * (2.0 - f) - 2.0)),
                each(f, |f| 0.5 * (f - 1.0) * (f - 1.0)),
            ],
            offset: [each(f, |f| -f), each(f, |f| 1.0 - f), each(f, |f| 2.0 - f), each(f, |f| 3.0 - f)],
        }
    }
}

/// Uniform generalised interpolation with half length `l` of the particle in cells.
#[derive(Clone, Copy)]
pub(crate) struct Gimp {
    /// Half length of a particle, in cells, at most ½.
    pub half: f64,
}

impl Shape<3> for Gimp {
    /// Both branches of each weight are computed and one is chosen, so that the axes stay together.
    #[inline(always)]
    fn weights(self, s: Axes) -> Weights<3> {
        let base = each(s, |s| (s - 0.5).floor());
        let f = minus(s, base);
        let (l, per_l) = (self.half, 1.0 / self.half);
        let value = |k: f64| {
            each(f, move |f| {
                let r = (f - k).abs();
                let (core, rim) = ((l - r).max(0.0), (1.0 + l - r).max(0.0));
                let inner = 1.0 - r - 0.5 * per_l * core * core;
                if r <= 1.0 - l { inner } else { 0.25 * per_l * rim * rim }
            })
        };
        let slope = |k: f64| {
            each(f, move |f| {
                let (x, r) = (f - k, (f - k).abs());
                let rim = (1.0 + l - r).max(0.0);
                let inner = -x / r.max(l);
                if r <= 1.0 - l { inner } else { -x.signum() * 0.5 * per_l * rim }
            })
        };
        Weights {
            base,
            n: [value(0.0), value(1.0), value(2.0)],
            dn: [slope(0.0), slope(1.0), slope(2.0)],
            offset: [each(f, |f| -f), each(f, |f| 1.0 - f), each(f, |f| 2.0 - f)],
        }
    }
}

/// How far a particle may leave the window [4b + ½, 4b + 4½) of its block before the tile is too small, in cells.
pub(crate) fn slack(kernel: Kernel) -> f64 {
    match kernel {
        Kernel::Linear(_) => 1.5,
        Kernel::Quadratic(_) | Kernel::Gimp(_) => 1.0,
        Kernel::Cubic(_) => 0.5,
    }
}
