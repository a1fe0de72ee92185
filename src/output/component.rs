//! One number out of a vector or symmetric tensor.

use crate::error::Diagnostic;
use crate::math::SymTensor;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A component of a vector or symmetric tensor, or a measure of its size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Component {
    /// Of a vector.
    X,
    /// Of a vector.
    Y,
    /// Of a vector.
    Z,
    /// Of a tensor.
    Xx,
    /// Of a tensor.
    Yy,
    /// Of a tensor.
    Zz,
    /// Of a tensor.
    Xy,
    /// Of a tensor.
    Yz,
    /// Of a tensor.
    Zx,
    /// Euclidean norm; the absolute value of a scalar.
    Magnitude,
    /// √(3 J₂) of a stress.
    VonMises,
    /// Largest principal value of a tensor.
    LargestPrincipal,
    /// Smallest principal value of a tensor.
    SmallestPrincipal,
}

impl Component {
    /// As a case writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Xx => "xx",
            Self::Yy => "yy",
            Self::Zz => "zz",
            Self::Xy => "xy",
            Self::Yz => "yz",
            Self::Zx => "zx",
            Self::Magnitude => "magnitude",
            Self::VonMises => "von-mises",
            Self::LargestPrincipal => "largest-principal",
            Self::SmallestPrincipal => "smallest-principal",
        }
    }

    /// A quantity of that many numbers has no such component, which the key names.
    pub fn misfit(self, key: &str, quantity: &str, components: usize, dimension: usize) -> Option<Diagnostic> {
        if dimension == 2 && self == Self::Z {
            return Some(Diagnostic::error(key, "there is no `z` in two dimensions").help("take x or y"));
        }
        let message = || format!("`{quantity}` has {components} component(s), and no `{}`", self.name());
        let help = "x, y, z are components of vectors; xx … zx, von-mises, largest-principal and smallest-principal of tensors";
        (!self.fits(components)).then(|| Diagnostic::error(key, message()).help(help))
    }

    /// True if values of that many numbers have this component.
    pub fn fits(self, components: usize) -> bool {
        match self {
            Self::X | Self::Y | Self::Z => components == 3,
            Self::Magnitude => true,
            _ => components == 6,
        }
    }

    /// The component of one value; the value must fit.
    pub fn of(self, value: &[f64]) -> f64 {
        match self {
            Self::X | Self::Xx => value[0],
            Self::Y | Self::Yy => value[1],
            Self::Z | Self::Zz => value[2],
            Self::Xy => value[3],
            Self::Yz => value[4],
            Self::Zx => value[5],
            Self::Magnitude => magnitude(value),
            Self::VonMises => von_mises(value),
            Self::LargestPrincipal => principal(value)[0],
            Self::SmallestPrincipal => principal(value)[2],
        }
    }
}

/// Euclidean norm of a vector; Frobenius norm of a symmetric tensor.
fn magnitude(value: &[f64]) -> f64 {
    let square = |numbers: &[f64]| numbers.iter().map(|c| c * c).sum::<f64>();
    match value.len() {
        6 => (square(&value[..3]) + 2.0 * square(&value[3..])).sqrt(),
        _ => square(value).sqrt(),
    }
}

/// √(3 J₂) of xx yy zz xy yz zx.
fn von_mises(s: &[f64]) -> f64 {
    let normal = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    (0.5 * normal + 3.0 * shear).sqrt()
}

/// Principal values of xx yy zz xy yz zx, descending (Smith 1961).
fn principal(s: &[f64]) -> [f64; 3] {
    let tensor = SymTensor(std::array::from_fn(|k| s[k]));
    let mean = tensor.trace() / 3.0;
    let deviator = tensor.deviator();
    let size = (deviator.contract(&deviator) / 6.0).sqrt();
    if size == 0.0 {
        return [mean; 3];
    }
    let angle = (deviator.determinant() / (2.0 * size.powi(3))).clamp(-1.0, 1.0).acos() / 3.0;
    let third = 2.0 * std::f64::consts::PI / 3.0;
    [angle, angle - third, angle + third].map(|angle| mean + 2.0 * size * angle.cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniaxial tension and pure shear: textbook values.
    #[test]
    fn von_mises_is_the_tension_and_root_three_times_the_shear() {
        assert_eq!(Component::VonMises.of(&[5.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 5.0);
        assert_eq!(Component::VonMises.of(&[7.0, 7.0, 7.0, 0.0, 0.0, 0.0]), 0.0);
        assert!((Component::VonMises.of(&[0.0, 0.0, 0.0, 0.0, 2.0, 0.0]) - 12.0_f64.sqrt()).abs() < 1e-15);
    }

    /// A diagonal tensor, pure shear, and a turned one: x, y by 30° with the values 3 and −1.
    #[test]
    fn principal_values_of_simple_states() {
        for (tensor, expected) in [
            ([-2.0, 5.0, 1.0, 0.0, 0.0, 0.0], [5.0, 1.0, -2.0]),
            ([0.0, 0.0, 0.0, 0.0, 2.0, 0.0], [2.0, 0.0, -2.0]),
            ([2.0, 0.0, 0.5, 3.0_f64.sqrt(), 0.0, 0.0], [3.0, 0.5, -1.0]),
            ([4.0, 4.0, 4.0, 0.0, 0.0, 0.0], [4.0; 3]),
        ] {
            let found = principal(&tensor);
            assert!(found.iter().zip(&expected).all(|(a, b): (&f64, &f64)| (a - b).abs() < 1e-14), "{found:?}");
        }
        assert_eq!(
            Component::LargestPrincipal.of(&[-2.0, 5.0, 1.0, 0.0, 0.0, 0.0]),
            principal(&[-2.0, 5.0, 1.0, 0.0, 0.0, 0.0])[0]
        );
    }

    #[test]
    fn magnitudes_of_scalars_vectors_and_tensors() {
        assert_eq!(Component::Magnitude.of(&[-2.0]), 2.0);
        assert_eq!(Component::Magnitude.of(&[3.0, 4.0, 12.0]), 13.0);
        assert_eq!(Component::Magnitude.of(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]), 8.0_f64.sqrt());
    }
}
