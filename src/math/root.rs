//! Roots of scalar functions.

/// The root of `f` nearest to zero, sought outwards in steps of `step` up to ±`limit` and bisected to
/// the last bit; `None` if `f` changes its sign nowhere there. Places where `f` is not finite are passed over.
pub fn nearest_root(f: impl Fn(f64) -> f64, step: f64, limit: f64) -> Option<f64> {
    let start = f(0.0);
    if start == 0.0 {
        return Some(0.0);
    }
    let mut last = [start; 2];
    let steps = (limit / step).ceil() as usize;
    for k in 1..=steps {
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let inner = sign * step * (k - 1) as f64;
            let outer = sign * step * k as f64;
            let value = f(outer);
            if value == 0.0 || last[side] * value < 0.0 {
                return Some(bisect(&f, inner, outer));
            }
            last[side] = value;
        }
    }
    None
}

/// The root of `f` between `a` and `b`, where it has different signs.
fn bisect(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let below = f(a) < 0.0;
    loop {
        let middle = 0.5 * (a + b);
        if middle == a || middle == b {
            return middle;
        }
        if (f(middle) < 0.0) == below {
            a = middle;
        } else {
            b = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::nearest_root;

    #[test]
    fn finds_the_nearer_of_two_roots() {
        let root = nearest_root(|x| (x - 0.3) * (x + 0.7), 0.01, 2.0).unwrap();
        assert!((root - 0.3).abs() < 1e-15, "{root}");
        let root = nearest_root(|x| x.exp() - 0.5, 0.01, 2.0).unwrap();
        assert!((root + std::f64::consts::LN_2).abs() < 1e-15, "{root}");
    }

    #[test]
    fn a_range_without_a_root_gives_none() {
        assert_eq!(nearest_root(|x| x * x + 1.0, 0.1, 10.0), None);
        assert_eq!(nearest_root(|x| x - 3.0, 0.1, 2.0), None);
        assert_eq!(nearest_root(|x| x, 0.1, 2.0), Some(0.0));
    }
}
