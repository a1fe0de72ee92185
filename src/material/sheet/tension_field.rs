//! Tension-field theory: stress of a sheet that wrinkles instead of carrying compression (theory C.7).

use super::SheetState;

/// Principal values (greater first) and the unit vector (cos θ, sin θ) of the first, of a plane symmetric tensor.
#[inline(always)]
pub fn principal([s11, s22, s12]: [f64; 3]) -> ([f64; 2], [f64; 2]) {
    let (mean, half) = (0.5 * (s11 + s22), 0.5 * (s11 - s22));
    let radius = (half * half + s12 * s12).sqrt();
    if radius <= f64::EPSILON * mean.abs() {
        return ([mean, mean], [1.0, 0.0]);
    }
    // Half angles without cancellation: the greater of cos² θ and sin² θ comes first.
    let large = (0.5 * (1.0 + half.abs() / radius)).sqrt();
    let small = 0.5 * s12 / (radius * large);
    let axis = if half >= 0.0 { [large, small] } else { [small, large] };
    ([mean + radius, mean - radius], axis)
}

/// The tensor s1 e⊗e + s2 e⊥⊗e⊥ with e = (cos θ, sin θ).
#[inline(always)]
pub fn compose([s1, s2]: [f64; 2], [cos, sin]: [f64; 2]) -> [f64; 3] {
    [s1 * cos * cos + s2 * sin * sin, s1 * sin * sin + s2 * cos * cos, (s1 - s2) * cos * sin]
}

/// State of an isotropic total law after wrinkling. Where the sheet is narrower across the first principal
/// direction than it would hang freely, that natural width replaces the actual one (relaxed energy, Pipkin 1986);
/// where it is shorter than stress-free in both directions it is slack.
///
/// `width(c1)` is C22 of uniaxial tension at C11 = c1; `response` the law of the flat sheet.
#[inline(always)]
pub fn relaxed(c: [f64; 3], width: impl Fn(f64) -> f64, response: impl Fn([f64; 3]) -> SheetState) -> SheetState {
    let ([c1, c2], axis) = principal(c);
    if c1 <= 1.0 {
        return SheetState { stress: [0.0; 3], energy: 0.0, thickness: 1.0, volume: 1.0 };
    }
    let natural = width(c1);
    if c2 >= natural {
        return response(c);
    }
    let uniaxial = response([c1, natural, 0.0]);
    SheetState { stress: compose([uniaxial.stress[0], 0.0], axis), ..uniaxial }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_axes_rebuild_the_tensor() {
        for s in
            [[3.0, -1.0, 2.0], [-1.0, 3.0, 2.0], [-1.0, 3.0, -2.0], [2.0, 2.0, 0.0], [0.0, 0.0, -1.0], [1.0, 4.0, 1e-9]]
        {
            let (values, axis) = principal(s);
            let rebuilt = compose(values, axis);
            for i in 0..3 {
                assert!((rebuilt[i] - s[i]).abs() < 1e-14, "{s:?}: {rebuilt:?}");
            }
        }
    }
}
