//! Formulas in `x y z t`, with or without units.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = sign (("*" | "/") sign)*
//! sign    = ("-" | "+") sign | power
//! power   = atom ("^" sign)?                  −x^2 = −(x^2), 2^3^2 = 2^9
//! atom    = number unit? | variable | pi | function "(" sum ("," sum)* ")" | "(" sum ")"
//! ```
//! A formula in which no unit occurs is read in SI and its dimensions are not checked. As soon as one number
//! carries a unit, the whole formula is checked: `x y z` are lengths, `t` a time, a number without unit is a
//! plain number, and 0 fits everywhere. A unit follows its number directly and extends over `*` and `/` as
//! long as unit names (or powers of them) follow: `10 m/s * x` is (10 m/s)·x.
//!
//! The parser is our own because the dimension check needs the tree with its positions, and because
//! the expression crates at hand read `-x^2` as (−x)².

use super::units::{Dimension, Unit, is_name, number_length, split_power};
use std::ops::Range;

/// A formula, ready to be evaluated.
#[derive(Debug, Clone)]
pub struct Formula {
    source: String,
    root: Node,
    has_units: bool,
}

/// What is wrong with a formula and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormulaError {
    /// What is wrong.
    pub message: String,
    /// Bytes of the formula.
    pub span: Range<usize>,
}

type Parsed<T> = Result<T, FormulaError>;

#[derive(Debug, Clone)]
struct Node {
    kind: Kind,
    span: Range<usize>,
}

#[derive(Debug, Clone)]
enum Kind {
    Number(f64, Dimension),
    Variable(usize),
    Negate(Box<Node>),
    Binary(Operator, Box<[Node; 2]>),
    One(Function, Box<Node>),
    Two(Function2, Box<[Node; 2]>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// A function of one argument, and what it asks of its argument's dimension.
#[derive(Clone, Copy)]
struct Function {
    name: &'static str,
    apply: fn(f64) -> f64,
    rule: Rule,
}

/// A function of two arguments.
#[derive(Clone, Copy)]
struct Function2 {
    name: &'static str,
    apply: fn(f64, f64) -> f64,
    rule: Rule,
}

impl std::fmt::Debug for Function {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl std::fmt::Debug for Function2 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// What a function does to dimensions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// Plain number in, plain number out.
    Plain,
    /// Any in, the same out; two arguments must agree.
    Same,
    /// Any in (two arguments must agree), a plain number out.
    ToPlain,
    /// Square root.
    Root,
}

const FUNCTIONS: &[Function] = &[
    Function { name: "sin", apply: f64::sin, rule: Rule::Plain },
    Function { name: "cos", apply: f64::cos, rule: Rule::Plain },
    Function { name: "tan", apply: f64::tan, rule: Rule::Plain },
    Function { name: "asin", apply: f64::asin, rule: Rule::Plain },
    Function { name: "acos", apply: f64::acos, rule: Rule::Plain },
    Function { name: "atan", apply: f64::atan, rule: Rule::Plain },
    Function { name: "sinh", apply: f64::sinh, rule: Rule::Plain },
    Function { name: "cosh", apply: f64::cosh, rule: Rule::Plain },
    Function { name: "tanh", apply: f64::tanh, rule: Rule::Plain },
    Function { name: "exp", apply: f64::exp, rule: Rule::Plain },
    Function { name: "ln", apply: f64::ln, rule: Rule::Plain },
    Function { name: "sqrt", apply: f64::sqrt, rule: Rule::Root },
    Function { name: "abs", apply: f64::abs, rule: Rule::Same },
    Function { name: "step", apply: step, rule: Rule::ToPlain },
];

const FUNCTIONS_OF_TWO: &[Function2] = &[
    Function2 { name: "min", apply: minimum, rule: Rule::Same },
    Function2 { name: "max", apply: maximum, rule: Rule::Same },
    Function2 { name: "atan2", apply: f64::atan2, rule: Rule::ToPlain },
    Function2 { name: "ramp", apply: ramp, rule: Rule::ToPlain },
];

/// The smaller of two; unlike `f64::min` it does not hide an undefined argument.
fn minimum(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) }
}

/// The larger of two.
fn maximum(a: f64, b: f64) -> f64 {
    -minimum(-a, -b)
}

/// 0 before zero, 1 from zero on.
fn step(t: f64) -> f64 {
    if t < 0.0 { 0.0 } else { t * 0.0 + 1.0 }
}

/// The smooth start (1 − cos(π t/T))/2 up to T, then 1.
fn ramp(t: f64, duration: f64) -> f64 {
    let share = (t / duration).clamp(0.0, 1.0);
    0.5 * (1.0 - (std::f64::consts::PI * share).cos())
}

impl Formula {
    /// Parses `source`.
    ///
    /// # Errors
    /// What is wrong and where, dimensions not yet checked (see [`Formula::dimension`]).
    pub fn parse(source: &str) -> Parsed<Self> {
        let mut parser = Parser { source, at: 0, nodes: 0, depth: 0, has_units: false };
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

    /// The value if no variable occurs in it.
    pub fn constant(&self) -> Option<f64> {
        (!self.root.varies()).then(|| self.value([0.0; 3], 0.0))
    }

    /// The dimension of the result; `None` if it fits everywhere (a formula without units, or zero).
    ///
    /// # Errors
    /// Where dimensions clash.
    pub fn dimension(&self) -> Parsed<Option<Dimension>> {
        if self.has_units { self.root.dimension() } else { Ok(None) }
    }
}

impl Node {
    fn value(&self, at: &[f64; 4]) -> f64 {
        match &self.kind {
            Kind::Number(value, _) => *value,
            Kind::Variable(i) => at[*i],
            Kind::Negate(a) => -a.value(at),
            Kind::Binary(operator, ab) => operator.apply(ab[0].value(at), ab[1].value(at)),
            Kind::One(function, a) => (function.apply)(a.value(at)),
            Kind::Two(function, ab) => (function.apply)(ab[0].value(at), ab[1].value(at)),
        }
    }

    fn varies(&self) -> bool {
        match &self.kind {
            Kind::Number(..) => false,
            Kind::Variable(_) => true,
            Kind::Negate(a) | Kind::One(_, a) => a.varies(),
            Kind::Binary(_, ab) | Kind::Two(_, ab) => ab.iter().any(Self::varies),
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
        let exponent = if ab[1].varies() { f64::NAN } else { ab[1].value(&[0.0; 4]) };
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

/// Formulas longer than this are refused: deep trees would exhaust the stack.
const MOST_NODES: usize = 512;
const MOST_DEPTH: usize = 64;

struct Parser<'a> {
    source: &'a str,
    at: usize,
    nodes: usize,
    depth: usize,
    has_units: bool,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.source[self.at..]
    }

    fn skip_spaces(&mut self) {
        self.at = self.source.len() - self.rest().trim_start().len();
    }

    fn peek(&mut self) -> Option<char> {
        self.skip_spaces();
        self.rest().chars().next()
    }

    fn accept(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        if found {
            self.at += c.len_utf8();
        }
        found
    }

    fn error_here(&self, message: impl Into<String>) -> FormulaError {
        let length = self.rest().chars().next().map_or(0, char::len_utf8);
        FormulaError { message: message.into(), span: self.at..self.at + length }
    }

    fn node(&mut self, kind: Kind, start: usize) -> Parsed<Node> {
        self.nodes += 1;
        if self.nodes > MOST_NODES {
            return Err(FormulaError { message: "this formula is too long".to_owned(), span: 0..self.source.len() });
        }
        Ok(Node { kind, span: start..self.at })
    }

    fn sum(&mut self) -> Parsed<Node> {
        self.skip_spaces();
        let start = self.at;
        let mut left = self.product()?;
        loop {
            let operator = match self.peek() {
                Some('+') => Operator::Add,
                Some('-') => Operator::Subtract,
                _ => return Ok(left),
            };
            self.at += 1;
            let right = self.product()?;
            left = self.node(Kind::Binary(operator, Box::new([left, right])), start)?;
        }
    }

    fn product(&mut self) -> Parsed<Node> {
        self.skip_spaces();
        let start = self.at;
        let mut left = self.sign()?;
        loop {
            let operator = match self.peek() {
                Some('*' | '·') => Operator::Multiply,
                Some('/') => Operator::Divide,
                _ => return Ok(left),
            };
            self.at += self.rest().chars().next().map_or(0, char::len_utf8);
            let right = self.sign()?;
            left = self.node(Kind::Binary(operator, Box::new([left, right])), start)?;
        }
    }

    fn sign(&mut self) -> Parsed<Node> {
        self.skip_spaces();
        let start = self.at;
        self.depth += 1;
        if self.depth > MOST_DEPTH {
            return Err(self.error_here("this formula is nested too deeply"));
        }
        let node = if self.accept('-') {
            let inner = self.sign()?;
            self.node(Kind::Negate(Box::new(inner)), start)?
        } else if self.accept('+') {
            self.sign()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(node)
    }

    fn power(&mut self) -> Parsed<Node> {
        self.skip_spaces();
        let start = self.at;
        let base = self.atom()?;
        if !self.accept('^') {
            return Ok(base);
        }
        let exponent = self.sign()?;
        self.node(Kind::Binary(Operator::Power, Box::new([base, exponent])), start)
    }

    fn atom(&mut self) -> Parsed<Node> {
        match self.peek() {
            None => Err(self.error_here("the formula ends too early")),
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                if self.accept(')') { Ok(inner) } else { Err(self.error_here("a closing parenthesis is missing")) }
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if is_name(c) => self.name(),
            Some(c) => Err(self.error_here(format!("`{c}` is out of place here"))),
        }
    }

    fn number(&mut self) -> Parsed<Node> {
        let start = self.at;
        let length = number_length(self.rest());
        if length == 0 {
            return Err(self.error_here("a number is expected here"));
        }
        self.at += length;
        let number = &self.source[start..self.at];
        let unit = self.unit()?;
        match unit.in_si(number).filter(|v| v.is_finite()) {
            Some(value) => self.node(Kind::Number(value, unit.dimension), start),
            None => Err(FormulaError { message: "this number is too large".to_owned(), span: start..self.at }),
        }
    }

    /// The longest unit that follows a number.
    fn unit(&mut self) -> Parsed<Unit> {
        let mut unit = Unit::ONE;
        let mut first = true;
        loop {
            let before = self.at;
            let sign = match self.peek() {
                Some(c) if is_name(c) || c == '%' => 1,
                Some(c @ ('*' | '·' | '/')) if !first => {
                    self.at += c.len_utf8();
                    self.skip_spaces();
                    if c == '/' { -1 } else { 1 }
                }
                _ => {
                    self.at = before;
                    return Ok(unit);
                }
            };
            let name = self.word();
            let Some(factor) = Unit::named(name).filter(|_| !self.rest()[name.len()..].starts_with('(')) else {
                self.at = before;
                return if first { Err(self.no_unit(name)) } else { Ok(unit) };
            };
            self.at += name.len();
            let (power, rest) = split_power(self.rest()).map_err(|message| self.error_here(message))?;
            self.at = self.source.len() - rest.len();
            let product = unit.times_power(factor, sign * power);
            unit = product.ok_or_else(|| self.error_here("the exponents of this unit are too large"))?;
            self.has_units = true;
            first = false;
        }
    }

    fn no_unit(&mut self, name: &str) -> FormulaError {
        self.skip_spaces();
        let message = match name {
            "x" | "y" | "z" | "t" | "pi" => format!("write `*` between a number and `{name}`"),
            _ => format!("`{name}` is not a unit"),
        };
        FormulaError { message, span: self.at..self.at + name.len() }
    }

    /// The letters (and digits after them, as in `atan2`) at the front.
    fn word(&self) -> &'a str {
        let rest = self.rest();
        if rest.starts_with('%') {
            return &rest[..1];
        }
        &rest[..rest.find(|c: char| !is_name(c)).unwrap_or(rest.len())]
    }

    fn name(&mut self) -> Parsed<Node> {
        let start = self.at;
        let rest = self.rest();
        let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let name = &rest[..length];
        self.at += length;
        if let Some(variable) = ["x", "y", "z", "t"].iter().position(|v| *v == name) {
            return self.node(Kind::Variable(variable), start);
        }
        if name == "pi" {
            return self.node(Kind::Number(std::f64::consts::PI, Dimension::NONE), start);
        }
        if let Some(function) = FUNCTIONS.iter().find(|f| f.name == name) {
            let [argument] = self.arguments(name)?;
            return self.node(Kind::One(*function, Box::new(argument)), start);
        }
        if let Some(function) = FUNCTIONS_OF_TWO.iter().find(|f| f.name == name) {
            let arguments = self.arguments(name)?;
            return self.node(Kind::Two(*function, Box::new(arguments)), start);
        }
        Err(FormulaError { message: unknown_name(name), span: start..self.at })
    }

    fn arguments<const N: usize>(&mut self, name: &str) -> Parsed<[Node; N]> {
        let plural = if N == 1 { "" } else { "s" };
        let wrong = |parser: &Self| parser.error_here(format!("`{name}` takes {N} argument{plural} in parentheses"));
        if !self.accept('(') {
            return Err(wrong(self));
        }
        let mut arguments = vec![self.sum()?];
        while self.accept(',') {
            arguments.push(self.sum()?);
        }
        if !self.accept(')') {
            return Err(self.error_here("a closing parenthesis is missing"));
        }
        arguments.try_into().map_err(|_| wrong(self))
    }
}

fn unknown_name(name: &str) -> String {
    let known = FUNCTIONS.iter().map(|f| f.name).chain(FUNCTIONS_OF_TWO.iter().map(|f| f.name));
    let names: Vec<&str> = ["x", "y", "z", "t", "pi"].into_iter().chain(known).collect();
    format!("`{name}` is not known in formulas; known are {}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

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
