//! Cubic B-splines (theory A.2).
//!
//! ```text
//! N = ⅔ − x² + ½ |x|³     |x| < 1
//!     (2 − |x|)³/6        1 ≤ |x| < 2
//! ```

use super::{AxisWeights, ShapeFunction, Weights};
use crate::math::simd::Lanes;

/// Cubic B-splines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic;

impl ShapeFunction<4> for Cubic {
    const INERTIA: Option<f64> = Some(1.0 / 3.0);
    const SMOOTH: bool = true;
    const WINDOW: f64 = 0.5;
    const SLACK: f64 = 0.5;

    fn of_particles(_half: f64) -> Self {
        Self
    }

    #[inline(always)]
    fn first(self, x: f64) -> i32 {
        x.floor() as i32 - 1
    }

    #[inline(always)]
    fn at(self, x: f64) -> AxisWeights<4> {
        let f = x - x.floor();
        let g = 1.0 - f;
        let outer = |d: f64| (d * d * d / 6.0, 0.5 * d * d);
        let inner = |d: f64| (2.0 / 3.0 - d * d + 0.5 * d * d * d, 2.0 * d - 1.5 * d * d);
        let ((w0, s0), (w1, s1), (w2, s2), (w3, s3)) = (outer(g), inner(f), inner(g), outer(f));
        AxisWeights { first: self.first(x), weight: [w0, w1, w2, w3], slope: [-s0, -s1, s2, s3] }
    }

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
