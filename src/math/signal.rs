//! A value that may vary in space and time: a constant, a formula in `x y z t`, or a table in `t`.

use super::formula::Formula;
use super::table::TimeTable;
use std::sync::Arc;

/// A value in space and time, in SI units. Cloning is cheap.
///
/// ```
/// use lateen::math::Signal;
///
/// let inflow = Signal::formula("4*y*(1 - y)")?;
/// assert_eq!(inflow.value([0.0, 0.5, 0.0], 7.0), 1.0);
/// assert!(inflow.is_steady() && !inflow.is_uniform());
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone)]
pub enum Signal {
    /// The same everywhere and always.
    Constant(f64),
    /// A formula in `x y z` [m] and `t` [s].
    Formula(Arc<Formula>),
    /// A table in `t` [s].
    Table(Arc<TimeTable>),
}

impl Signal {
    /// Zero.
    pub const ZERO: Self = Self::Constant(0.0);

    /// A formula such as `"10 m/s * sin(2*pi*t / 1 ms)"` or, in SI throughout, `"0.1*y*(0.41 - y)"`.
    ///
    /// # Errors
    /// A sentence about the error in the formula.
    pub fn formula(source: &str) -> Result<Self, String> {
        let formula = Formula::parse(source).map_err(|e| e.message)?;
        formula.dimension().map_err(|e| e.message)?;
        Ok(match formula.constant() {
            Some(value) => Self::Constant(value),
            None => Self::Formula(Arc::new(formula)),
        })
    }

    /// The value at position `x` [m] and time `t` [s]; not finite where the formula is not.
    #[inline]
    pub fn value(&self, x: [f64; 3], t: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Formula(formula) => formula.value(x, t),
            Self::Table(table) => table.value(t),
        }
    }

    /// True if the value is the same at all places.
    pub fn is_uniform(&self) -> bool {
        match self {
            Self::Constant(_) | Self::Table(_) => true,
            Self::Formula(formula) => !(0..3).any(|axis| formula.uses(axis)),
        }
    }

    /// True if the value is the same at all times.
    pub fn is_steady(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Formula(formula) => !formula.uses(3),
            Self::Table(_) => false,
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

impl PartialEq for Signal {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => a == b,
            (Self::Formula(a), Self::Formula(b)) => a.source() == b.source(),
            (Self::Table(a), Self::Table(b)) => a == b,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_without_variables_become_constants() {
        assert_eq!(Signal::formula("2*pi"), Ok(Signal::Constant(std::f64::consts::TAU)));
        assert_eq!(Signal::formula("1 kPa"), Ok(Signal::Constant(1000.0)));
        assert!(!Signal::formula("1/t").unwrap().value([0.0; 3], 0.0).is_finite());
    }

    #[test]
    fn a_formula_of_the_time_is_the_same_everywhere() {
        for (text, uniform, steady) in
            [("sin(t)", true, false), ("x", false, true), ("2*y*t", false, false), ("z/3", false, true)]
        {
            let signal = Signal::formula(text).unwrap();
            assert_eq!((signal.is_uniform(), signal.is_steady()), (uniform, steady), "{text}");
        }
    }
}
