//! The first time at which a polynomial becomes negative (theory F.4).

/// Terms of a Taylor polynomial: Σ a_m t^m, m < `TERMS`.
pub(super) const TERMS: usize = 5;

/// Σ a_m t^m, summed in pairs: a chain of products would wait for each of them.
#[inline(always)]
pub(super) fn value(a: &[f64; TERMS], t: f64) -> f64 {
    let square = t * t;
    (a[0] + a[1] * t) + square * ((a[2] + a[3] * t) + square * a[4])
}

/// The time in 0..=`end` when p(t) = Σ a_m t^m leaves p ≥ 0, given p(0) ≥ 0 > p(`end`).
///
/// A trajectory that enters through the facet, p(0) = 0 < p'(0), leaves at the next root: p/t is searched.
pub(super) fn leaves(a: &[f64; TERMS], end: f64) -> f64 {
    if a[0] > 0.0 {
        return root(a, end);
    }
    let mut deflated = [0.0; TERMS];
    deflated[..TERMS - 1].copy_from_slice(&a[1..]);
    if deflated[0] > 0.0 { root(&deflated, end) } else { 0.0 }
}

/// Newton's method, kept in the bracket with p(0) > 0 > p(`end`). Its steps square their size, so that a small one
/// is the last.
fn root(a: &[f64; TERMS], end: f64) -> f64 {
    const ITERATIONS: usize = 60;
    const LAST: f64 = 1e-8;
    let (mut low, mut high) = (0.0, end);
    let mut t = end * a[0] / (a[0] - value(a, end));
    for _ in 0..ITERATIONS {
        let next = newton(a, t);
        if (next - t).abs() <= LAST * end {
            return next.clamp(0.0, end);
        }
        if value(a, t) > 0.0 {
            low = t
        } else {
            high = t
        }
        t = if next > low && next < high { next } else { 0.5 * (low + high) };
    }
    t
}

/// One step of Newton's method.
#[inline(always)]
pub(super) fn newton(a: &[f64; TERMS], t: f64) -> f64 {
    let square = t * t;
    let slope = (a[1] + 2.0 * a[2] * t) + square * (3.0 * a[3] + 4.0 * a[4] * t);
    t - value(a, t) / slope
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_root_of_known_factors_is_found() {
        // (1 − t)(3 − t)(1 + t²): roots 1 and 3.
        let p = [3.0, -4.0, 4.0, -4.0, 1.0];
        assert!((leaves(&p, 2.0) - 1.0).abs() < 1e-14);
        // t (2 − t): enters at 0, leaves at 2.
        assert!((leaves(&[0.0, 2.0, -1.0, 0.0, 0.0], 5.0) - 2.0).abs() < 1e-14);
        // −t: leaves at once.
        assert_eq!(leaves(&[0.0, -1.0, 0.0, 0.0, 0.0], 1.0), 0.0);
    }
}
