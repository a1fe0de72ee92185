//! Uniform generalised interpolation: hat functions averaged over a particle of half length l (uGIMP; Bardenhagen &
//! Kober 2004; theory A.2).
//!
//! ```text
//! N = 1 − (x² + l²)/(2 l)       |x| < l
//!     1 − |x|                   l ≤ |x| ≤ 1 − l
//!     (1 + l − |x|)²/(4 l)      1 − l < |x| < 1 + l
//! ```

use super::{AxisWeights, ShapeFunction, Weights};
use crate::math::simd::Lanes;

/// Hat functions averaged over a particle of half length `half` [cells], at most ½ (uGIMP).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gimp {
    /// Half length l of the particle [cells].
    pub half: f64,
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

    /// N and h ∂N/∂x at the distance `x` from the node. All branches are computed and one is chosen.
    #[inline(always)]
    fn hats<L: Lanes>(self, x: L) -> [L; 2] {
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

impl ShapeFunction<3> for Gimp {
    const INERTIA: Option<f64> = None;
    const SMOOTH: bool = true;
    const WINDOW: f64 = 0.5;
    const SLACK: f64 = 1.0;

    fn of_particles(half: f64) -> Self {
        Self { half: half.clamp(1e-3, 0.5) }
    }

    #[inline(always)]
    fn first(self, x: f64) -> i32 {
        (x - 0.5).floor() as i32
    }

    #[inline(always)]
    fn at(self, x: f64) -> AxisWeights<3> {
        let first = self.first(x);
        let hats: [_; 3] = std::array::from_fn(|i| self.hat(x - f64::from(first + i as i32)));
        AxisWeights { first, weight: hats.map(|(n, _)| n), slope: hats.map(|(_, dn)| dn) }
    }

    #[inline(always)]
    fn base<L: Lanes>(self, s: L) -> L {
        s.sub(L::splat(0.5)).floor()
    }

    #[inline(always)]
    fn weights<L: Lanes>(self, s: L, base: L) -> Weights<L, 3> {
        let f = s.sub(base);
        let [n0, d0] = self.hats(f);
        let [n1, d1] = self.hats(f.sub(L::splat(1.0)));
        let [n2, d2] = self.hats(f.sub(L::splat(2.0)));
        Weights::new(f, [n0, n1, n2], [d0, d1, d2])
    }
}
