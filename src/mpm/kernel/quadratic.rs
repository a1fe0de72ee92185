//! Quadratic B-splines (theory A.2).
//!
//! ```text
//! N = ¾ − x²              |x| < ½
//!     ½ (3/2 − |x|)²      ½ ≤ |x| < 3/2
//! ```

use super::{AxisWeights, ShapeFunction, Weights};
use crate::math::simd::Lanes;

/// Quadratic B-splines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadratic;

impl ShapeFunction<3> for Quadratic {
    const INERTIA: Option<f64> = Some(0.25);
    const SMOOTH: bool = true;
    const WINDOW: f64 = 0.5;
    const SLACK: f64 = 1.0;

    fn of_particles(_half: f64) -> Self {
        Self
    }

    #[inline(always)]
    fn first(self, x: f64) -> i32 {
        (x - 0.5).floor() as i32
    }

    #[inline(always)]
    fn at(self, x: f64) -> AxisWeights<3> {
        let f = x - (x - 0.5).floor();
        let (a, b, c) = (1.5 - f, f - 1.0, f - 0.5);
        AxisWeights { first: self.first(x), weight: [0.5 * a * a, 0.75 - b * b, 0.5 * c * c], slope: [-a, -2.0 * b, c] }
    }

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
