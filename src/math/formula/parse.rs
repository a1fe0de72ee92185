//! From text to the tree of a formula.

use super::function::{FUNCTIONS, FUNCTIONS_OF_TWO};
use super::{FormulaError, FormulaNode, Kind, Operator, Parsed};
use crate::math::units::{Dimension, Unit, is_name, number_length, split_power};

/// Formulas longer than this are refused: deep trees would exhaust the stack.
const MOST_NODES: usize = 512;
const MOST_DEPTH: usize = 64;

/// Reads a formula from left to right.
pub(super) struct Parser<'a> {
    pub source: &'a str,
    pub names: &'a [&'a str],
    pub at: usize,
    pub nodes: usize,
    pub depth: usize,
    pub has_units: bool,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.source[self.at..]
    }

    pub fn skip_spaces(&mut self) {
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

    pub fn error_here(&self, message: impl Into<String>) -> FormulaError {
        let length = self.rest().chars().next().map_or(0, char::len_utf8);
        FormulaError { message: message.into(), span: self.at..self.at + length }
    }

    fn node(&mut self, kind: Kind, start: usize) -> Parsed<FormulaNode> {
        self.nodes += 1;
        if self.nodes > MOST_NODES {
            return Err(FormulaError { message: "this formula is too long".to_owned(), span: 0..self.source.len() });
        }
        Ok(FormulaNode { kind, span: start..self.at })
    }

    /// A sum: the whole formula, an argument, or what stands in parentheses.
    pub fn sum(&mut self) -> Parsed<FormulaNode> {
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

    fn product(&mut self) -> Parsed<FormulaNode> {
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

    fn sign(&mut self) -> Parsed<FormulaNode> {
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

    fn power(&mut self) -> Parsed<FormulaNode> {
        self.skip_spaces();
        let start = self.at;
        let base = self.atom()?;
        if !self.accept('^') {
            return Ok(base);
        }
        let exponent = self.sign()?;
        self.node(Kind::Binary(Operator::Power, Box::new([base, exponent])), start)
    }

    fn atom(&mut self) -> Parsed<FormulaNode> {
        match self.peek() {
            None => Err(self.error_here("the formula ends too early")),
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                if self.accept(')') { Ok(inner) } else { Err(self.error_here("a closing parenthesis is missing")) }
            }
            Some('{') => self.braced_name(),
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if is_name(c) => self.name(),
            Some(c) => Err(self.error_here(format!("`{c}` is out of place here"))),
        }
    }

    fn number(&mut self) -> Parsed<FormulaNode> {
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

    fn name(&mut self) -> Parsed<FormulaNode> {
        let start = self.at;
        let rest = self.rest();
        let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let name = &rest[..length];
        self.at += length;
        if self.names.contains(&name) {
            return self.variable(name, start);
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
        self.variable(name, start)
    }

    fn braced_name(&mut self) -> Parsed<FormulaNode> {
        let start = self.at;
        let Some(length) = self.rest().find('}') else { return Err(self.error_here("a closing `}` is missing")) };
        let name = self.rest()[1..length].trim();
        self.at += length + 1;
        self.variable(name, start)
    }

    fn variable(&mut self, name: &str, start: usize) -> Parsed<FormulaNode> {
        match self.names.iter().position(|known| *known == name) {
            Some(variable) => self.node(Kind::Variable(variable), start),
            None => Err(FormulaError { message: unknown_name(name, self.names), span: start..self.at }),
        }
    }

    fn arguments<const N: usize>(&mut self, name: &str) -> Parsed<[FormulaNode; N]> {
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

fn unknown_name(name: &str, names: &[&str]) -> String {
    let functions = FUNCTIONS.iter().map(|f| f.name).chain(FUNCTIONS_OF_TWO.iter().map(|f| f.name));
    let known: Vec<String> = names.iter().copied().chain(["pi"]).chain(functions).map(|n| format!("`{n}`")).collect();
    format!("`{name}` is not known in formulas; known are {}", known.join(", "))
}
