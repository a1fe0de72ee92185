//! Formulas in `x y z t`, with or without units.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = sign (("*" | "/") sign)*
//! sign    = ("-" | "+") sign | power
//! power   = atom ("^" sign)?                  −x^2 = −(x^2), 2^3^2 = 2^9
//! atom    = number unit? | variable | "{" name "}" | pi | function "(" sum ("," sum)* ")" | "(" sum ")"
//! ```
//! A formula in which no unit occurs is read in SI and its dimensions are not checked. As soon as one number
//! carries a unit, the whole formula is checked: `x y z` are lengths, `t` a time, a number without unit is a
//! plain number, and 0 fits everywhere. A unit follows its number directly and extends over `*` and `/` as
//! long as unit names (or powers of them) follow: `10 m/s * x` is (10 m/s)·x.
//!
//! A formula may be over other names instead, such as the columns of a table ([`Formula::over`]); names that
//! aren't plain words stand in braces: `{kinetic energy: water} / 2`.
//!
//! The parser is our own because the dimension check needs the tree with its positions, and because
//! the expression crates at hand read `-x^2` as (−x)².

mod function;
mod parse;

use super::units::Dimension;
use function::{Function, Function2, Rule};
use parse::Parser;
use std::ops::Range;

/// A formula, ready to be evaluated.
///
/// ```
/// use lateen::math::formula::Formula;
/// use lateen::math::units::Unit;
///
/// let pressure = Formula::parse("1 kPa * sin(2*pi*t / 1 ms)")?;
/// assert!((pressure.value([0.0; 3], 0.25e-3) - 1000.0).abs() < 1e-9);
/// assert_eq!(pressure.dimension()?, Unit::named("Pa").map(|unit| unit.dimension));
/// let wrong = Formula::parse("1 kPa + 2 m")?.dimension().unwrap_err();
/// assert!(!wrong.message.is_empty() && !wrong.span.is_empty(), "with its place in the text");
/// # Ok::<(), lateen::math::formula::FormulaError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Formula {
    source: String,
    root: FormulaNode,
    has_units: bool,
}

/// An error in a formula, with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormulaError {
    /// The problem.
    pub message: String,
    /// Bytes of the formula.
    pub span: Range<usize>,
}

type Parsed<T> = Result<T, FormulaError>;

#[derive(Debug, Clone)]
struct FormulaNode {
    kind: Kind,
    span: Range<usize>,
}

#[derive(Debug, Clone)]
enum Kind {
    Number(f64, Dimension),
    Variable(usize),
    Negate(Box<FormulaNode>),
    Binary(Operator, Box<[FormulaNode; 2]>),
    One(Function, Box<FormulaNode>),
    Two(Function2, Box<[FormulaNode; 2]>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

impl Formula {
    /// Parses `source`.
    ///
    /// # Errors
    /// The error with its place; dimensions are not yet checked (see [`Formula::dimension`]).
    pub fn parse(source: &str) -> Parsed<Self> {
        Self::over(source, &["x", "y", "z", "t"])
    }

    /// Parses `source`, in which `names` are the variables. Only formulas in `x y z t` know dimensions.
    ///
    /// # Errors
    /// The error with its place.
    pub fn over(source: &str, names: &[&str]) -> Parsed<Self> {
        let mut parser = Parser { source, names, at: 0, nodes: 0, depth: 0, has_units: false };
        let root = parser.sum()?;
        parser.skip_spaces();
        if parser.at < source.len() {
            return Err(parser.error_here("an operator is expected here"));
        }
        Ok(Self { source: source.to_owned(), root, has_units: parser.has_units })
    }

    /// The text it was made from.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// True if a unit occurs in it.
    pub fn has_units(&self) -> bool {
        self.has_units
    }

    /// The value at `x` [m] and `t` [s].
    #[inline]
    pub fn value(&self, x: [f64; 3], t: f64) -> f64 {
        self.root.value(&[x[0], x[1], x[2], t])
    }

    /// The value where the variables, in the order of their names, are `values`.
    ///
    /// # Panics
    /// When there are fewer values than names.
    pub fn at(&self, values: &[f64]) -> f64 {
        self.root.value(values)
    }

    /// The value if no variable occurs in it.
    pub fn constant(&self) -> Option<f64> {
        (!self.root.any(&|_| true)).then(|| self.value([0.0; 3], 0.0))
    }

    /// True if the variable of that number occurs in it: 3 is the time in a formula in `x y z t`.
    pub fn uses(&self, variable: usize) -> bool {
        self.root.any(&|i| i == variable)
    }

    /// The dimension of the result; `None` if it fits everywhere (a formula without units, or zero).
    ///
    /// # Errors
    /// The place where dimensions clash.
    pub fn dimension(&self) -> Parsed<Option<Dimension>> {
        if self.has_units { self.root.dimension() } else { Ok(None) }
    }
}

impl FormulaNode {
    fn value(&self, at: &[f64]) -> f64 {
        match &self.kind {
            Kind::Number(value, _) => *value,
            Kind::Variable(i) => at[*i],
            Kind::Negate(a) => -a.value(at),
            Kind::Binary(operator, ab) => operator.apply(ab[0].value(at), ab[1].value(at)),
            Kind::One(function, a) => (function.apply)(a.value(at)),
            Kind::Two(function, ab) => (function.apply)(ab[0].value(at), ab[1].value(at)),
        }
    }

    /// True if one of the variables in it is `wanted`.
    fn any(&self, wanted: &dyn Fn(usize) -> bool) -> bool {
        match &self.kind {
            Kind::Number(..) => false,
            Kind::Variable(i) => wanted(*i),
            Kind::Negate(a) | Kind::One(_, a) => a.any(wanted),
            Kind::Binary(_, ab) | Kind::Two(_, ab) => ab.iter().any(|node| node.any(wanted)),
        }
    }

    fn error<T>(&self, message: impl Into<String>) -> Parsed<T> {
        Err(FormulaError { message: message.into(), span: self.span.clone() })
    }

    fn dimension(&self) -> Parsed<Option<Dimension>> {
        match &self.kind {
            Kind::Number(value, dimension) => {
                Ok((*value != 0.0 || *dimension != Dimension::NONE).then_some(*dimension))
            }
            Kind::Variable(3) => Ok(Some(Dimension::TIME)),
            Kind::Variable(_) => Ok(Some(Dimension::LENGTH)),
            Kind::Negate(a) => a.dimension(),
            Kind::Binary(Operator::Power, ab) => self.power_dimension(ab),
            Kind::Binary(operator, ab) => self.binary_dimension(*operator, ab),
            Kind::One(function, a) => self.function_dimension(function.name, function.rule, a.dimension()?, a),
            Kind::Two(function, ab) => {
                let common = self.common_dimension(ab)?;
                self.function_dimension(function.name, function.rule, common, &ab[0])
            }
        }
    }

    fn common_dimension(&self, ab: &[Self; 2]) -> Parsed<Option<Dimension>> {
        match (ab[0].dimension()?, ab[1].dimension()?) {
            (Some(a), Some(b)) if a != b => {
                self.error(format!("{} and {} don't go together here", a.describe(), b.describe()))
            }
            (a, b) => Ok(a.or(b)),
        }
    }

    fn binary_dimension(&self, operator: Operator, ab: &[Self; 2]) -> Parsed<Option<Dimension>> {
        if matches!(operator, Operator::Add | Operator::Subtract) {
            return self.common_dimension(ab);
        }
        let (Some(a), Some(b)) = (ab[0].dimension()?, ab[1].dimension()?) else { return Ok(None) };
        let dimension = if operator == Operator::Multiply { a.times(b) } else { a.over(b) };
        dimension.map_or_else(|| self.error("the exponents of the units become too large"), |d| Ok(Some(d)))
    }

    fn power_dimension(&self, ab: &[Self; 2]) -> Parsed<Option<Dimension>> {
        if !matches!(ab[1].dimension()?, None | Some(Dimension::NONE)) {
            return ab[1].error("an exponent must be a plain number");
        }
        let Some(base) = ab[0].dimension()? else { return Ok(None) };
        if base == Dimension::NONE {
            return Ok(Some(base));
        }
        let exponent = if ab[1].any(&|_| true) { f64::NAN } else { ab[1].value(&[0.0; 4]) };
        let whole = (exponent.fract() == 0.0 && exponent.abs() <= 24.0).then_some(exponent as i32);
        match whole.and_then(|n| base.power(n)) {
            Some(dimension) => Ok(Some(dimension)),
            None => self.error("a quantity with a unit can only be raised to a small whole number"),
        }
    }

    fn function_dimension(
        &self,
        name: &str,
        rule: Rule,
        argument: Option<Dimension>,
        node: &Self,
    ) -> Parsed<Option<Dimension>> {
        match (rule, argument) {
            (Rule::Plain, Some(d)) if d != Dimension::NONE => {
                node.error(format!("`{name}` takes a plain number; this is {}", d.describe()))
            }
            (Rule::Plain | Rule::ToPlain, _) => Ok(Some(Dimension::NONE)),
            (Rule::Same, d) => Ok(d),
            (Rule::Root, None) => Ok(None),
            (Rule::Root, Some(d)) => match d.root() {
                Some(root) => Ok(Some(root)),
                None => node.error(format!("{} has no square root with a sensible unit", d.describe())),
            },
        }
    }
}

impl Operator {
    #[inline]
    fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => power(a, b),
        }
    }
}

/// a^b; small whole exponents by multiplication, so that (−2)^2 and 0^0 are what they should be.
fn power(a: f64, b: f64) -> f64 {
    if b.fract() == 0.0 && b.abs() <= 32.0 { a.powi(b as i32) } else { a.powf(b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::units::Unit;

    fn value(source: &str) -> f64 {
        Formula::parse(source).unwrap().value([2.0, 3.0, 5.0], 0.25)
    }

    #[test]
    fn arithmetic_follows_the_rules_of_mathematics() {
        let cases = [
            ("1+2*3", 7.0),
            ("(1+2)*3", 9.0),
            ("-x^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("x*y - z/t", 6.0 - 20.0),
            ("7 - 2 - 1", 4.0),
            ("8/4/2", 1.0),
            ("sin(pi/6)", 0.5),
            ("max(x, min(y, z))", 3.0),
            ("abs(-x) + sqrt(y*3)", 5.0),
            ("ramp(t, 0.5)", 0.5),
            ("ramp(z, 0.5)", 1.0),
            ("ramp(-x, 0.5)", 0.0),
            ("step(t) + step(-t)", 1.0),
            ("1.5*2*y*(0.41-y)/0.2025", 1.5 * 2.0 * 3.0 * (0.41 - 3.0) / 0.2025),
            ("exp(ln(x))", 2.0),
            ("10 m/s * x", 20.0),
            ("10 mm/ms*x / 2 m", 10.0),
            ("1 kN*m / y", 1000.0 / 3.0),
            ("5 mm + x", 2.005),
        ];
        for (source, expected) in cases {
            assert!((value(source) - expected).abs() < 1e-12, "{source} = {} instead of {expected}", value(source));
        }
    }

    #[test]
    fn a_unit_anywhere_checks_the_whole_formula() {
        let dimension = |source: &str| Formula::parse(source).unwrap().dimension();
        let velocity = Unit::parse("m/s").unwrap().dimension;
        assert_eq!(dimension("10 m/s * sin(2*pi*t / 1 ms)"), Ok(Some(velocity)));
        assert_eq!(dimension("x / 1 ms"), Ok(Some(velocity)));
        assert_eq!(dimension("sqrt(9.81 m/s^2 * y)"), Ok(Some(velocity)));
        assert_eq!(dimension("max(0, 1 m/s)"), Ok(Some(velocity)));
        assert_eq!(dimension("sin(t) + x"), Ok(None));
        assert_eq!(dimension("1 kPa * sin(t)").unwrap_err().span, 12..13);
        assert!(dimension("1 kPa * ramp(t, 0.001)").is_err());
        assert!(dimension("1 kPa + 1 N").is_err());
        assert!(dimension("(1 m)^t").is_err());
    }

    #[test]
    fn other_names_may_be_variables() {
        let names = ["time", "kinetic energy: water", "y"];
        let value = |source: &str| Formula::over(source, &names).map(|f| f.at(&[2.0, 3.0, 5.0]));
        assert_eq!(value("{kinetic energy: water}^2 + y * time"), Ok(19.0));
        assert_eq!(value("-{y}^2 / pi"), Ok(-25.0 / std::f64::consts::PI));
        assert!(value("x + y").unwrap_err().message.contains("known are `time`, `kinetic energy: water`, `y`"));
        assert!(value("{time + y").unwrap_err().message.contains("`}` is missing"));
    }

    #[test]
    fn errors_point_at_their_place() {
        let error = |source: &str| Formula::parse(source).unwrap_err();
        assert_eq!(error("2*(x").span, 4..4);
        assert_eq!(error("2*foo(x)").span, 2..5);
        assert_eq!(error("2 x").message, "write `*` between a number and `x`");
        assert!(error("ramp(t)").message.contains("2 arguments"));
        assert!(error(&"(".repeat(100_000)).message.contains("nested too deeply"));
        assert!(error(&"1+".repeat(100_000)).message.contains("too long"));
    }
}
