//! Shape functions N_I(x) as tensor products of one-dimensional weights (theory A.2).
//!
//! Coordinates are in cells: x = (x_p − origin)/h, node i lies at x = i. Every kernel here satisfies
//! Σ N_I = 1, Σ ∇N_I = 0 and Σ N_I x_I = x on the unbounded lattice; walls keep these through ghost
//! nodes (see `ghost`), so the weights themselves know nothing of walls.

use crate::mpm::KernelKind;

/// Weights and slopes of one axis: node `first + i` has `weight[i]` and derivative `slope[i]` per cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis<const S: usize> {
    /// First node of the support.
    pub first: i32,
    /// N_I.
    pub weight: [f64; S],
    /// dN_I/dx, x in cells.
    pub slope: [f64; S],
}

/// One-dimensional shape functions with a support of `S` nodes.
pub trait Shape<const S: usize>: Copy + Send + Sync {
    /// Second moment Σ N_I (x_I − x)² [cells²] where it is constant: the inertia D of APIC over h².
    const INERTIA: Option<f64>;

    /// First node of the support of a point at `x` [cells].
    fn first(self, x: f64) -> i32;

    /// Weights and slopes at `x` [cells].
    fn at(self, x: f64) -> Axis<S>;
}

/// Hat functions, N = 1 − |x|.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear;

/// Hat functions averaged over a particle of half length `half` [cells], at most ½ (uGIMP).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gimp {
    /// Half length l of the particle [cells].
    pub half: f64,
}

/// Quadratic B-splines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadratic;

/// Cubic B-splines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic;

impl Linear {
    /// The least weight, of the order of rounding. A particle on a plane of nodes takes its gradient from nodes to which it
    /// would give nothing: without mass they would have no velocity to take.
    pub const LEAST: f64 = f64::EPSILON;
}

impl Shape<2> for Linear {
    const INERTIA: Option<f64> = None;

    #[inline(always)]
    fn first(self, x: f64) -> i32 {
        x.floor() as i32
    }

    #[inline(always)]
    fn at(self, x: f64) -> Axis<2> {
        let f = (x - x.floor()).clamp(Self::LEAST, 1.0 - Self::LEAST);
        Axis { first: self.first(x), weight: [1.0 - f, f], slope: [-1.0, 1.0] }
    }
}

impl Gimp {
    /// N and dN/dx at the distance `x` from the node.
    #[inline(always)]
    fn hat(self, x: f64) -> (f64, f64) {
        let (l, r) = (self.half, x.abs());
        if r < l {
            (1.0 - (r * r + l * l) / (2.0 * l), -x / l)
        } else if r <= 1.0 - l {
            (1.0 - r, -x.signum())
        } else if r < 1.0 + l {
            let d = 1.0 + l - r;
            (d * d / (4.0 * l), -x.signum() * d / (2.0 * l))
        } else {
            (0.0, 0.0)
        }
    }
}

impl Shape<3> for Gimp {
    const INERTIA: Option<f64> = None;

    #[inline(always)]
    fn first(self, x: f64) -> i32 {
        (x - 0.5).floor() as i32
    }

    #[inline(always)]
    fn at(self, x: f64) -> Axis<3> {
        let first = self.first(x);
        let hats: [_; 3] = std::array::from_fn(|i| self.hat(x - f64::from(first + i as i32)));
        Axis { first, weight: hats.map(|(n, _)| n), slope: hats.map(|(_, dn)| dn) }
    }
}

impl Shape<3> for Quadratic {
    const INERTIA: Option<f64> = Some(0.25);

    #[inline(always)]
    fn first(self, x: f64) -> i32 {
        (x - 0.5).floor() as i32
    }

    #[inline(always)]
    fn at(self, x: f64) -> Axis<3> {
        let f = x - (x - 0.5).floor();
        let (a, b, c) = (1.5 - f, f - 1.0, f - 0.5);
        Axis { first: self.first(x), weight: [0.5 * a * a, 0.75 - b * b, 0.5 * c * c], slope: [-a, -2.0 * b, c] }
    }
}

impl Shape<4> for Cubic {
    const INERTIA: Option<f64> = Some(1.0 / 3.0);

    #[inline(always)]
    fn first(self, x: f64) -> i32 {
        x.floor() as i32 - 1
    }

    #[inline(always)]
    fn at(self, x: f64) -> Axis<4> {
        let f = x - x.floor();
        let g = 1.0 - f;
        let outer = |d: f64| (d * d * d / 6.0, 0.5 * d * d);
        let inner = |d: f64| (2.0 / 3.0 - d * d + 0.5 * d * d * d, 2.0 * d - 1.5 * d * d);
        let ((w0, s0), (w1, s1), (w2, s2), (w3, s3)) = (outer(g), inner(f), inner(g), outer(f));
        Axis { first: self.first(x), weight: [w0, w1, w2, w3], slope: [-s0, -s1, s2, s3] }
    }
}

/// A kernel chosen by the case; the transfers are compiled for each member.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kernel {
    /// See [`Linear`].
    Linear(Linear),
    /// See [`Gimp`].
    Gimp(Gimp),
    /// See [`Quadratic`].
    Quadratic(Quadratic),
    /// See [`Cubic`].
    Cubic(Cubic),
}

/// Runs an expression with the concrete [`Shape`] of a [`Kernel`].
macro_rules! with_shape {
    ($kernel:expr, $shape:ident => $run:expr) => {
        match $kernel {
            $crate::mpm::grid::Kernel::Linear($shape) => $run,
            $crate::mpm::grid::Kernel::Gimp($shape) => $run,
            $crate::mpm::grid::Kernel::Quadratic($shape) => $run,
            $crate::mpm::grid::Kernel::Cubic($shape) => $run,
        }
    };
}
pub(crate) use with_shape;

impl Kernel {
    /// The kernel of a case; `half` is the half length of a particle [cells], used by GIMP only.
    pub fn new(kind: KernelKind, half: f64) -> Self {
        match kind {
            KernelKind::Linear => Self::Linear(Linear),
            KernelKind::Gimp => Self::Gimp(Gimp { half: half.clamp(1e-3, 0.5) }),
            KernelKind::Quadratic => Self::Quadratic(Quadratic),
            KernelKind::Cubic => Self::Cubic(Cubic),
        }
    }

    /// Number of nodes S per axis.
    pub fn support(self) -> i32 {
        match self {
            Self::Linear(_) => 2,
            Self::Gimp(_) | Self::Quadratic(_) => 3,
            Self::Cubic(_) => 4,
        }
    }

    /// First node of the support along one axis of a point at `x` [cells].
    #[inline]
    pub fn first(self, x: f64) -> i32 {
        with_shape!(self, shape => shape.first(x))
    }

    /// The inertia D of APIC over h², where it is constant.
    pub fn inertia(self) -> Option<f64> {
        fn inertia<const S: usize, K: Shape<S>>(_: K) -> Option<f64> {
            K::INERTIA
        }
        with_shape!(self, shape => inertia(shape))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [f64; 9] = [0.0, 0.1, 0.25, 0.4999, 0.5, 0.75, 0.9, 3.3, -2.7];

    /// Σ N = 1, Σ N x_I = x, Σ N' = 0, Σ N' x_I = 1 and N' as the difference quotient of N.
    fn check<const S: usize>(shape: impl Shape<S>) {
        for x in POINTS {
            let at = shape.at(x);
            let node = |i: usize| f64::from(at.first + i as i32);
            let sum = |f: &dyn Fn(usize) -> f64| (0..S).map(f).sum::<f64>();
            assert!((sum(&|i| at.weight[i]) - 1.0).abs() < 1e-14);
            assert!((sum(&|i| at.weight[i] * node(i)) - x).abs() < 1e-14 * 4.0);
            assert!(sum(&|i| at.slope[i]).abs() < 1e-14);
            assert!((sum(&|i| at.slope[i] * node(i)) - 1.0).abs() < 1e-13);
            assert!(at.weight.iter().all(|&w| w >= 0.0));
            if x.fract().abs() > 0.01 && (x.fract().abs() - 0.5).abs() > 0.01 {
                let d = 1e-6;
                let (lower, upper) = (shape.at(x - d), shape.at(x + d));
                for i in 0..S {
                    assert!(((upper.weight[i] - lower.weight[i]) / (2.0 * d) - at.slope[i]).abs() < 1e-5);
                }
            }
            if let Some(inertia) = inertia_of(shape) {
                assert!((sum(&|i| at.weight[i] * (node(i) - x).powi(2)) - inertia).abs() < 1e-14);
            }
        }
    }

    fn inertia_of<const S: usize, K: Shape<S>>(_: K) -> Option<f64> {
        K::INERTIA
    }

    #[test]
    fn weights_reproduce_linear_functions() {
        check(Linear);
        check(Gimp { half: 0.25 });
        check(Gimp { half: 0.5 });
        check(Quadratic);
        check(Cubic);
    }

    /// The polynomial 7/8 at the centre of a uGIMP particle with two per cell.
    #[test]
    fn gimp_value_at_its_node() {
        assert_eq!(Gimp { half: 0.25 }.at(2.0).weight[1], 0.875);
    }
}
