//! Shape functions N_I(x) as tensor products of one-dimensional weights (theory A.2).
//!
//! Coordinates are in cells: x = (x_p − origin)/h, node i lies at x = i. Every kernel here satisfies
//! Σ N_I = 1, Σ ∇N_I = 0 and Σ N_I x_I = x on the unbounded lattice; walls keep these through ghost
//! nodes (see `grid::ghost`), so the weights themselves know nothing of walls.
//!
//! A kernel is one file, with its weights for one particle (the specification) and for eight (the transfers), and one
//! line in the list below.

mod cubic;
mod gimp;
mod linear;
mod quadratic;
mod weights;

pub use cubic::Cubic;
pub use gimp::Gimp;
pub use linear::Linear;
pub use quadratic::Quadratic;
pub(crate) use weights::Weights;

use crate::math::simd::Lanes;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declares the kernels: the choice of the case file, the shape functions of a body, and the macro `with_shape`, which
/// runs an expression with the concrete [`ShapeFunction`] of a [`Kernel`]. The `$` is for the macro that is declared
/// within.
macro_rules! kernels {
    ($d:tt $( $(#[$doc:meta])* $Name:ident ),+ $(,)?) => {
        /// Shape functions.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
        #[serde(rename = "KernelSpec", rename_all = "kebab-case")]
        pub enum KernelKind {
            $( $(#[$doc])* $Name ),+
        }

        impl KernelKind {
            /// All kernels, in the order of the list.
            pub const ALL: &'static [Self] = &[$( Self::$Name ),+];
        }

        /// The kernel of a body; the transfers are compiled for each member.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Kernel {
            $(
                #[doc = concat!("See [`", stringify!($Name), "`].")]
                $Name($Name)
            ),+
        }

        impl Kernel {
            /// The kernel of a case for particles of half length `half` [cells].
            pub fn new(kind: KernelKind, half: f64) -> Self {
                match kind {
                    $( KernelKind::$Name => Self::$Name(ShapeFunction::of_particles(half)) ),+
                }
            }
        }

        macro_rules! with_shape {
            ($d kernel:expr, $d shape:ident => $d run:expr) => {
                match $d kernel {
                    $( $crate::mpm::kernel::Kernel::$Name($d shape) => $d run ),+
                }
            };
        }
    };
}

kernels! { $
    /// Hat functions (the paper).
    Linear,
    /// Uniform generalised interpolation.
    Gimp,
    /// Quadratic B-spline.
    Quadratic,
    /// Cubic B-spline.
    Cubic,
}
pub(crate) use with_shape;

/// Weights and slopes of one axis: node `first + i` has `weight[i]` and derivative `slope[i]` per cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisWeights<const S: usize> {
    /// First node of the support.
    pub first: i32,
    /// N_I.
    pub weight: [f64; S],
    /// dN_I/dx, x in cells.
    pub slope: [f64; S],
}

/// One-dimensional shape functions with a support of `S` nodes.
pub(crate) trait ShapeFunction<const S: usize>: Copy + Send + Sync {
    /// Second moment Σ N_I (x_I − x)² [cells²] where it is constant: the inertia D of APIC over h².
    const INERTIA: Option<f64>;
    /// True if the slope vanishes with the function at the ends of its support.
    const SMOOTH: bool;
    /// The first position of block 0 [cells]: that at which the support of a particle begins, as far as a tile allows.
    const WINDOW: f64;
    /// Distance by which a particle may leave its block before its support leaves the block's tile [cells]
    /// (`bins`).
    const SLACK: f64;

    /// The shape functions of particles of half length `half` [cells].
    fn of_particles(half: f64) -> Self;

    /// First node of the support of a point at `x` [cells].
    fn first(self, x: f64) -> i32;

    /// Weights and slopes at `x` [cells].
    fn at(self, x: f64) -> AxisWeights<S>;

    /// First nodes of the supports of eight points at `s` [cells].
    fn base<L: Lanes>(self, s: L) -> L;

    /// Weights of eight points at `s` [cells] in supports that begin at `base`.
    fn weights<L: Lanes>(self, s: L, base: L) -> Weights<L, S>;
}

impl Kernel {
    /// Number of nodes S per axis.
    pub fn support(self) -> i32 {
        fn support<const S: usize>(_: impl ShapeFunction<S>) -> i32 {
            S as i32
        }
        with_shape!(self, shape => support(shape))
    }

    /// First node of the support along one axis of a point at `x` [cells].
    #[inline]
    pub fn first(self, x: f64) -> i32 {
        with_shape!(self, shape => shape.first(x))
    }

    /// The inertia D of APIC over h², where it is constant.
    pub fn inertia(self) -> Option<f64> {
        fn inertia<const S: usize, K: ShapeFunction<S>>(_: K) -> Option<f64> {
            K::INERTIA
        }
        with_shape!(self, shape => inertia(shape))
    }

    /// True if the slopes vanish with the functions at the ends of their supports.
    pub fn is_smooth(self) -> bool {
        fn is_smooth<const S: usize, K: ShapeFunction<S>>(_: K) -> bool {
            K::SMOOTH
        }
        with_shape!(self, shape => is_smooth(shape))
    }

    /// The first position of block 0 [cells] (`ShapeFunction::WINDOW`).
    pub fn window(self) -> f64 {
        fn window<const S: usize, K: ShapeFunction<S>>(_: K) -> f64 {
            K::WINDOW
        }
        with_shape!(self, shape => window(shape))
    }

    /// Distance by which a particle may leave its block [cells] (`ShapeFunction::SLACK`).
    pub fn slack(self) -> f64 {
        fn slack<const S: usize, K: ShapeFunction<S>>(_: K) -> f64 {
            K::SLACK
        }
        with_shape!(self, shape => slack(shape))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [f64; 9] = [0.0, 0.1, 0.25, 0.4999, 0.5, 0.75, 0.9, 3.3, -2.7];

    /// Σ N = 1, Σ N x_I = x, Σ N' = 0, Σ N' x_I = 1 and N' as the difference quotient of N.
    fn check<const S: usize>(shape: impl ShapeFunction<S>) {
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

    fn inertia_of<const S: usize, K: ShapeFunction<S>>(_: K) -> Option<f64> {
        K::INERTIA
    }

    #[test]
    fn weights_reproduce_linear_functions() {
        for &kind in KernelKind::ALL {
            for half in [0.25, 0.5] {
                with_shape!(Kernel::new(kind, half), shape => check(shape));
            }
        }
    }

    /// The polynomial 7/8 at the centre of a uGIMP particle with two per cell.
    #[test]
    fn gimp_value_at_its_node() {
        assert_eq!(Gimp { half: 0.25 }.at(2.0).weight[1], 0.875);
    }
}
