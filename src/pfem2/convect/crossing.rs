//! When does a polynomial become negative?

/// Terms of a Taylor polynomial: Σ a_m t^m, m < `TERMS`.
pub(super) const TERMS: usize = 5;

/// Σ a_m t^m.
#[inline(always)]
pub(super) fn value(a: &[f64; TERMS], t: f64) -> f64 {
    let mut sum = a[TERMS - 1];
    for m in (0..TERMS - 1).rev() {
        sum = sum * t + a[m];
    }
    sum
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

/// Newton's method, kept in the bracket with p(0) > 0 > p(`end`).
fn root(a: &[f64; TERMS], end: f64) -> f64 {
    const ITERATIONS: usize = 30;
    const ROUNDING: f64 = 4.0 * f64::EPSILON;
    let (mut low, mut high) = (0.0, end);
    let mut t = end * a[0] / (a[0] - value(a, end));
    for _ in 0..ITERATIONS {
        let (p, slope) = value_and_slope(a, t);
        let newton = t - p / slope;
        if (newton - t).abs() <= ROUNDING * end {
            return t;
        }
        if p > 0.0 {
            low = t
        } else {
            high = t
        }
        t = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    t
}

#[inline(always)]
fn value_and_slope(a: &[f64; TERMS], t: f64) -> (f64, f64) {
    let (mut p, mut slope) = (a[TERMS - 1], 0.0);
    for m in (0..TERMS - 1).rev() {
        slope = slope * t + p;
        p = p * t + a[m];
    }
    (p, slope)
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
