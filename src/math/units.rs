//! Units: `"0.75e-3 g/mm^3"` → 750 kg/m³, with its dimension.
//!
//! ```text
//! quantity = number unit?                 "0.3"   "70 GPa"   "-9.81 m/s^2"   "10 1/ms"
//! unit     = factor (("*" | "·" | "/" | " ") factor)*      from left to right: J/kg K = (J/kg)·K
//! factor   = (prefix? name | "1" | "(" unit ")") ("^"? integer | "²" | "³")?
//! ```
//! Powers of ten are kept as integers until the end, so that `"5.5 mm"` is the double nearest to 0.0055.

pub use super::dimension::Dimension;

/// A unit: `mantissa · 10^exponent` in SI base units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// The factor without powers of ten (1 for most units).
    pub mantissa: f64,
    /// Power of ten.
    pub exponent: i32,
    /// Its dimension.
    pub dimension: Dimension,
}

impl Unit {
    /// The plain number 1.
    pub const ONE: Self = Self { mantissa: 1.0, exponent: 0, dimension: Dimension::NONE };

    /// Reads a unit such as `kg/m^3`; empty text is the plain number 1.
    ///
    /// # Errors
    /// A sentence that names the part that is no unit.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut reader = UnitReader { rest: text.trim(), depth: 0 };
        if reader.rest.is_empty() {
            return Ok(Self::ONE);
        }
        let unit = reader.product()?;
        match reader.rest.chars().next() {
            None => Ok(unit),
            Some(c) => Err(format!("`{c}` is out of place in the unit `{}`", text.trim())),
        }
    }

    /// The unit named `name` (one name with an optional prefix, no exponent).
    pub fn named(name: &str) -> Option<Self> {
        if let Some((unit, _)) = find(name) {
            return Some(unit);
        }
        PREFIXES.iter().find_map(|&(prefix, power)| {
            let (unit, prefixable) = find(name.strip_prefix(prefix)?)?;
            prefixable.then_some(Self { exponent: unit.exponent + power, ..unit })
        })
    }

    /// `self · other^n`.
    pub fn times_power(self, other: Self, n: i32) -> Option<Self> {
        let shift = other.exponent.checked_mul(n)?;
        Some(Self {
            mantissa: self.mantissa * other.mantissa.powi(n),
            exponent: self.exponent.checked_add(shift).filter(|e| e.abs() <= 400)?,
            dimension: self.dimension.combine(other.dimension, n)?,
        })
    }

    /// `number` of this unit in SI, correctly rounded; `number` is decimal text such as `-0.75e-3`.
    pub fn in_si(&self, number: &str) -> Option<f64> {
        let (digits, power) = match number.find(['e', 'E']) {
            Some(at) => (&number[..at], number[at + 1..].parse::<i32>().ok()?),
            None => (number, 0),
        };
        let shifted: f64 = format!("{digits}e{}", power.checked_add(self.exponent)?).parse().ok()?;
        Some(shifted * self.mantissa)
    }
}

fn find(name: &str) -> Option<(Unit, bool)> {
    let &NamedUnit { mantissa, exponent, dimension, takes_prefixes, .. } =
        UNITS.iter().find(|unit| unit.name == name)?;
    Some((Unit { mantissa, exponent, dimension: Dimension(dimension) }, takes_prefixes))
}

const PREFIXES: &[(&str, i32)] = &[
    ("p", -12),
    ("n", -9),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("m", -3),
    ("c", -2),
    ("d", -1),
    ("h", 2),
    ("k", 3),
    ("M", 6),
    ("G", 9),
    ("T", 12),
];

/// A unit by its name.
struct NamedUnit {
    name: &'static str,
    mantissa: f64,
    /// Power of ten.
    exponent: i32,
    /// Exponents of kg, m, s and K.
    dimension: [i8; 4],
    takes_prefixes: bool,
}

/// A unit that takes prefixes: name, mantissa, power of ten, exponents of kg, m, s and K.
const fn prefixed(name: &'static str, mantissa: f64, exponent: i32, dimension: [i8; 4]) -> NamedUnit {
    NamedUnit { name, mantissa, exponent, dimension, takes_prefixes: true }
}

/// A unit without prefixes.
const fn single(name: &'static str, mantissa: f64, exponent: i32, dimension: [i8; 4]) -> NamedUnit {
    NamedUnit { name, mantissa, exponent, dimension, takes_prefixes: false }
}

const UNITS: &[NamedUnit] = &[
    prefixed("m", 1.0, 0, [0, 1, 0, 0]),
    prefixed("g", 1.0, -3, [1, 0, 0, 0]),
    single("tonne", 1.0, 3, [1, 0, 0, 0]),
    prefixed("s", 1.0, 0, [0, 0, 1, 0]),
    single("min", 60.0, 0, [0, 0, 1, 0]),
    single("h", 3600.0, 0, [0, 0, 1, 0]),
    prefixed("K", 1.0, 0, [0, 0, 0, 1]),
    prefixed("Hz", 1.0, 0, [0, 0, -1, 0]),
    prefixed("N", 1.0, 0, [1, 1, -2, 0]),
    prefixed("Pa", 1.0, 0, [1, -1, -2, 0]),
    prefixed("bar", 1.0, 5, [1, -1, -2, 0]),
    single("atm", 101_325.0, 0, [1, -1, -2, 0]),
    prefixed("J", 1.0, 0, [1, 2, -2, 0]),
    prefixed("W", 1.0, 0, [1, 2, -3, 0]),
    prefixed("L", 1.0, -3, [0, 3, 0, 0]),
    prefixed("l", 1.0, -3, [0, 3, 0, 0]),
    single("rad", 1.0, 0, [0, 0, 0, 0]),
    single("deg", std::f64::consts::PI / 180.0, 0, [0, 0, 0, 0]),
    single("%", 1.0, -2, [0, 0, 0, 0]),
];

struct UnitReader<'a> {
    rest: &'a str,
    depth: u32,
}

impl UnitReader<'_> {
    fn product(&mut self) -> Result<Unit, String> {
        let mut unit = Unit::ONE;
        let mut sign = 1;
        loop {
            let (factor, power) = self.factor()?;
            unit = unit.times_power(factor, sign * power).ok_or("the exponents of this unit are too large")?;
            self.rest = self.rest.trim_start();
            sign = match self.rest.chars().next() {
                None | Some(')') => return Ok(unit),
                Some(c @ ('*' | '·' | '/')) => {
                    self.rest = self.rest[c.len_utf8()..].trim_start();
                    if c == '/' { -1 } else { 1 }
                }
                Some(_) => 1,
            };
        }
    }

    fn factor(&mut self) -> Result<(Unit, i32), String> {
        let unit = if let Some(inner) = self.rest.strip_prefix('(') {
            self.depth += 1;
            if self.depth > 8 {
                return Err("too many parentheses in this unit".to_owned());
            }
            self.rest = inner.trim_start();
            let unit = self.product()?;
            self.rest = self.rest.strip_prefix(')').ok_or("a closing parenthesis is missing in this unit")?;
            unit
        } else {
            self.name()?
        };
        Ok((unit, self.power()?))
    }

    fn name(&mut self) -> Result<Unit, String> {
        if let Some(rest) = self.rest.strip_prefix('1').filter(|r| !r.starts_with(|c: char| c.is_ascii_digit())) {
            self.rest = rest;
            return Ok(Unit::ONE);
        }
        let length = self.rest.find(|c: char| !(is_name(c) || c == '%')).unwrap_or(self.rest.len());
        let name = &self.rest[..length];
        self.rest = &self.rest[length..];
        Unit::named(name).ok_or_else(|| match name {
            "" => "a unit is expected here".to_owned(),
            _ => format!("`{name}` is not a unit"),
        })
    }

    fn power(&mut self) -> Result<i32, String> {
        let (power, rest) = split_power(self.rest)?;
        self.rest = rest;
        Ok(power)
    }
}

/// True for characters of a unit's name.
pub(super) fn is_name(c: char) -> bool {
    c.is_alphabetic()
}

/// Splits an exponent such as `^-2`, `2` or `²` off the front; 1 if there is none.
pub(super) fn split_power(text: &str) -> Result<(i32, &str), String> {
    for (mark, power) in [('²', 2), ('³', 3)] {
        if let Some(rest) = text.strip_prefix(mark) {
            return Ok((power, rest));
        }
    }
    let (body, explicit) = text.strip_prefix('^').map_or((text, false), |body| (body, true));
    let sign = usize::from(body.starts_with(['-', '+']));
    let digits = body[sign..].find(|c: char| !c.is_ascii_digit()).unwrap_or(body.len() - sign);
    if digits == 0 {
        return if explicit { Err("a whole number must follow `^` in a unit".to_owned()) } else { Ok((1, text)) };
    }
    let (number, rest) = body.split_at(sign + digits);
    let power: i32 =
        number.parse().ok().filter(|n: &i32| n.abs() <= 24).ok_or("the exponents of this unit are too large")?;
    Ok((power, rest))
}

/// Length in bytes of the decimal number at the front of `text` (with sign), 0 if there is none.
pub(super) fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let mut end = sign + digits(sign);
    let mut count = end - sign;
    if bytes.get(end) == Some(&b'.') {
        let decimals = digits(end + 1);
        count += decimals;
        end += 1 + decimals;
    }
    if count == 0 {
        return 0;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = bytes.get(end + 1 + sign..).map_or(0, |_| digits(end + 1 + sign));
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    end
}

/// A number with its unit, in SI.
///
/// ```
/// use lateen::math::units::{Quantity, Unit};
///
/// let modulus = Quantity::parse("70 GPa")?;
/// assert_eq!((modulus.value, modulus.dimension), (70e9, Some(Unit::parse("kg m^-1 s^-2")?.dimension)));
/// assert_eq!(Quantity::parse("0.5")?.dimension, None);
/// assert!(Quantity::parse("3 parsec").unwrap_err().contains("parsec"));
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// The value in SI units.
    pub value: f64,
    /// Its dimension; `None` if no unit was written (the number is then taken as SI).
    pub dimension: Option<Dimension>,
}

impl Quantity {
    /// Reads `"70 GPa"`, `"1e-3"` or `"inf"`.
    ///
    /// # Errors
    /// A sentence about the part that can't be read.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if matches!(text, "inf" | "+inf" | "-inf") {
            return Ok(Self { value: text.parse().map_err(|_| "not a number")?, dimension: None });
        }
        let length = number_length(text);
        if length == 0 {
            return Err(format!("`{text}` does not begin with a number"));
        }
        let (number, rest) = text.split_at(length);
        let unit = Unit::parse(rest)?;
        let value = unit.in_si(number).filter(|v| v.is_finite());
        let value = value.ok_or_else(|| format!("`{text}` is too large for a number"))?;
        Ok(Self { value, dimension: (!rest.trim().is_empty()).then_some(unit.dimension) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Conversions from the SI brochure (9th edition, tables 7 and 8) and by hand.
    #[test]
    fn known_conversions() {
        let table: &[(&str, f64)] = &[
            ("0.75e-3 g/mm^3", 750.0),
            ("7.5e-4 g/mm^3", 750.0),
            ("1 g/cm^3", 1000.0),
            ("70 GPa", 70e9),
            ("70000 MPa", 70e9),
            ("10 m/s", 10.0),
            ("-10 mm/ms", -10.0),
            ("1647 mm/ms", 1647.0),
            ("5.5 mm", 0.0055),
            ("0.1mm", 0.0001),
            ("1.2 ms", 0.0012),
            ("1e-4 ms", 1e-7),
            ("3 1/ms", 3000.0),
            ("9.81 m/s^2", 9.81),
            ("9.81 m s^-2", 9.81),
            ("9.81 m/s²", 9.81),
            ("1000 kg m^-3", 1000.0),
            ("2 N*s", 2.0),
            ("2 N·s", 2.0),
            ("1 mPa*s", 1e-3),
            ("1 atm", 101_325.0),
            ("2 bar", 2e5),
            ("2 mbar", 200.0),
            ("3 L", 0.003),
            ("2 min", 120.0),
            ("1 h", 3600.0),
            ("36 km/h", 10.0),
            ("718 J/(kg K)", 718.0),
            ("5 µm", 5e-6),
            ("5 um", 5e-6),
            ("50 %", 0.5),
            ("180 deg", std::f64::consts::PI),
            ("234.375 g*mm^2/ms^2", 0.234_375),
            ("7", 7.0),
            ("-1.5E+3", -1500.0),
            (".5 m", 0.5),
        ];
        for &(text, expected) in table {
            let value = Quantity::parse(text).unwrap().value;
            assert!((value - expected).abs() <= 1e-15 * expected.abs(), "{text}: {value:e} instead of {expected:e}");
        }
    }

    #[test]
    fn dimensions_are_told_apart() {
        let dimension = |text: &str| Quantity::parse(text).unwrap().dimension;
        assert_eq!(dimension("1 Pa"), dimension("1 N/m^2"));
        assert_eq!(dimension("1 J"), dimension("1 kg m^2/s^2"));
        assert_ne!(dimension("1 Pa"), dimension("1 N"));
        assert_eq!(dimension("1"), None);
        assert_eq!(dimension("1 Pa").unwrap().describe(), "a pressure (kg/(m s^2))");
    }

    #[test]
    fn texts_that_are_no_quantity_are_refused() {
        for text in ["", "m", "1 parsec", "1 m^", "1 m/", "1 (m", "1 m)", "1 m^99", "1 m^2^2", "1e999 m", "1 mmin", "-"]
        {
            assert!(Quantity::parse(text).is_err(), "{text:?} was read as {:?}", Quantity::parse(text));
        }
    }
}
