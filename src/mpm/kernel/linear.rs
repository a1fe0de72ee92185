//! Hat functions, N = 1 − |x|, |x| < 1 (Lian, Liu & Zhang 2014; theory A.2).

use super::{AxisWeights, ShapeFunction, Weights};
use crate::math::simd::Lanes;

/// Hat functions, N = 1 − |x|.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear;

impl Linear {
    /// The least weight, of the order of rounding. A particle on a plane of nodes takes its gradient from nodes to
    /// which it would give nothing: without mass they would have no velocity to take.
    pub const LEAST_WEIGHT: f64 = f64::EPSILON;
}

impl ShapeFunction<2> for Linear {
    const INERTIA: Option<f64> = None;
    const SMOOTH: bool = false;
    const WINDOW: f64 = 0.0;
    const SLACK: f64 = 1.0;

    fn of_particles(_half: f64) -> Self {
        Self
    }

    #[inline(always)]
    fn first(self, x: f64) -> i32 {
        x.floor() as i32
    }

    #[inline(always)]
    fn at(self, x: f64) -> AxisWeights<2> {
        let f = (x - x.floor()).clamp(Self::LEAST_WEIGHT, 1.0 - Self::LEAST_WEIGHT);
        AxisWeights { first: self.first(x), weight: [1.0 - f, f], slope: [-1.0, 1.0] }
    }

    #[inline(always)]
    fn base<L: Lanes>(self, s: L) -> L {
        s.floor()
    }

    #[inline(always)]
    fn weights<L: Lanes>(self, s: L, base: L) -> Weights<L, 2> {
        let (one, f, least) = (L::splat(1.0), s.sub(base), Self::LEAST_WEIGHT);
        let n = f.max(L::splat(least)).min(L::splat(1.0 - least));
        Weights::new(f, [one.sub(n), n], [L::splat(-1.0), one])
    }
}
