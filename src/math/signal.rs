//! A value that may vary in space and time: a constant, a formula in `x y z t`, or a table in `t`.

/// A value in space and time, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub enum Signal {
    /// The same everywhere and always.
    Constant(f64),
}

impl Signal {
    /// Zero.
    pub const ZERO: Self = Self::Constant(0.0);

    /// The value at position `x` [m] and time `t` [s]; not finite where the formula is not.
    #[inline]
    pub fn value(&self, _x: [f64; 3], _t: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
        }
    }

    /// True if the value is zero everywhere and always.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Constant(value) if *value == 0.0)
    }
}

impl Default for Signal {
    fn default() -> Self {
        Self::ZERO
    }
}

impl From<f64> for Signal {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}
