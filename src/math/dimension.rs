//! Dimensions: exponents of mass, length, time and temperature, and the names of those that occur in cases.

use std::fmt;

/// Exponents of mass [kg], length [m], time [s] and temperature [K].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dimension(pub [i8; 4]);

impl Dimension {
    /// A plain number.
    pub const NONE: Self = Self([0; 4]);
    /// A length.
    pub const LENGTH: Self = Self([0, 1, 0, 0]);
    /// A time.
    pub const TIME: Self = Self([0, 0, 1, 0]);

    /// The dimension of a product; `None` when an exponent becomes absurd.
    pub fn times(self, other: Self) -> Option<Self> {
        self.combine(other, 1)
    }

    /// The dimension of a quotient.
    pub fn over(self, other: Self) -> Option<Self> {
        self.combine(other, -1)
    }

    /// The dimension of a power.
    pub fn power(self, n: i32) -> Option<Self> {
        Self::NONE.combine(self, n)
    }

    /// The dimension of a square root, if there is one.
    pub fn root(self) -> Option<Self> {
        self.0.iter().all(|e| e % 2 == 0).then(|| Self(self.0.map(|e| e / 2)))
    }

    /// The dimension of `self · other^n`; `None` when an exponent becomes absurd.
    pub(super) fn combine(self, other: Self, n: i32) -> Option<Self> {
        let mut sum = self.0;
        for (a, b) in sum.iter_mut().zip(other.0) {
            let exponent = i32::from(*a) + n.checked_mul(i32::from(b))?;
            *a = i8::try_from(exponent).ok().filter(|e| e.abs() <= 24)?;
        }
        Some(Self(sum))
    }

    /// Common name and an example, for the dimensions that occur in cases.
    fn known(self) -> Option<(&'static str, &'static str)> {
        KNOWN.iter().find(|(dimension, ..)| *dimension == self.0).map(|&(_, name, example)| (name, example))
    }

    /// For example `a pressure (kg/(m s^2))`.
    pub fn describe(self) -> String {
        match self.known() {
            Some((name, _)) if self == Self::NONE => name.to_owned(),
            Some((name, _)) => format!("{name} ({self})"),
            None => format!("a quantity in {self}"),
        }
    }

    /// One as a case writes it, for example `"70 GPa"`.
    pub fn example(self) -> String {
        self.known().map_or_else(|| format!("\"1 {self}\""), |(_, example)| example.to_owned())
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = |sign: i8| -> Vec<String> {
            let exponents = self.0.iter().zip(["kg", "m", "s", "K"]).filter(|(e, _)| **e * sign > 0);
            exponents.map(|(e, n)| if e.abs() == 1 { n.to_owned() } else { format!("{n}^{}", e.abs()) }).collect()
        };
        let (above, below) = (side(1), side(-1));
        let above = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        match below.len() {
            0 => f.write_str(&above),
            1 => write!(f, "{above}/{}", below[0]),
            _ => write!(f, "{above}/({})", below.join(" ")),
        }
    }
}

/// Dimensions (kg, m, s, K) that have a name, and an example of each.
const KNOWN: &[([i8; 4], &str, &str)] = &[
    ([0, 0, 0, 0], "a plain number", "0.3"),
    ([1, 0, 0, 0], "a mass", "\"2 g\""),
    ([0, 1, 0, 0], "a length", "\"1 mm\""),
    ([0, 2, 0, 0], "an area", "\"1 mm^2\""),
    ([0, 3, 0, 0], "a volume", "\"1 mm^3\""),
    ([0, 0, 1, 0], "a time", "\"0.5 ms\""),
    ([0, 0, 0, 1], "a temperature", "\"300 K\""),
    ([0, 0, -1, 0], "a rate", "\"10 1/s\""),
    ([0, 1, -1, 0], "a velocity", "\"10 m/s\""),
    ([0, 1, -2, 0], "an acceleration", "\"-9.81 m/s^2\""),
    ([1, -3, 0, 0], "a density", "\"1000 kg/m^3\""),
    ([1, -2, 0, 0], "a mass per area", "\"0.1 kg/m^2\""),
    ([1, -1, -2, 0], "a pressure", "\"70 GPa\""),
    ([1, -1, -1, 0], "a viscosity", "\"1 mPa*s\""),
    ([0, 2, -1, 0], "a diffusivity", "\"1 mm^2/s\""),
    ([1, 1, -2, 0], "a force", "\"5 N\""),
    ([1, 0, -2, 0], "a force per length", "\"5 N/m\""),
    ([1, 1, -1, 0], "an impulse", "\"2 N*s\""),
    ([1, 2, -2, 0], "an energy", "\"3 J\""),
    ([1, 2, -3, 0], "a power", "\"3 W\""),
    ([0, 2, -2, 0], "an energy per mass", "\"2 kJ/kg\""),
    ([0, 2, -2, -1], "a specific heat", "\"718 J/(kg K)\""),
];
