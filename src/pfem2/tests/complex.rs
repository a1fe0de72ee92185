//! Complex numbers, for the closed solutions of oscillations.

/// A complex number: its real and its imaginary part.
pub type Complex = [f64; 2];

/// a + b.
pub fn plus(a: Complex, b: Complex) -> Complex {
    [a[0] + b[0], a[1] + b[1]]
}

/// a b.
pub fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// a times a real factor.
pub fn scaled(a: Complex, factor: f64) -> Complex {
    a.map(|x| x * factor)
}

/// a/b.
pub fn over(a: Complex, b: Complex) -> Complex {
    let square = b[0] * b[0] + b[1] * b[1];
    times(a, [b[0] / square, -b[1] / square])
}

/// √a, with a real part that is not negative.
pub fn root(a: Complex) -> Complex {
    let (size, angle) = (a[0].hypot(a[1]).sqrt(), 0.5 * a[1].atan2(a[0]));
    [size * angle.cos(), size * angle.sin()]
}
