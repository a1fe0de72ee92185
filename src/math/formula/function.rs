//! The functions that formulas know.

/// A function of one argument, and the rule for the dimension of its argument.
#[derive(Clone, Copy)]
pub(super) struct Function {
    pub name: &'static str,
    pub apply: fn(f64) -> f64,
    pub rule: Rule,
}

/// A function of two arguments.
#[derive(Clone, Copy)]
pub(super) struct Function2 {
    pub name: &'static str,
    pub apply: fn(f64, f64) -> f64,
    pub rule: Rule,
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

/// Rules for the dimensions of a function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rule {
    /// Plain number in, plain number out.
    Plain,
    /// Any in, the same out; two arguments must agree.
    Same,
    /// Any in (two arguments must agree), a plain number out.
    ToPlain,
    /// Square root.
    Root,
}

pub(super) const FUNCTIONS: &[Function] = &[
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

pub(super) const FUNCTIONS_OF_TWO: &[Function2] = &[
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
    let fraction = (t / duration).clamp(0.0, 1.0);
    0.5 * (1.0 - (std::f64::consts::PI * fraction).cos())
}
