//! Axes: round ticks, and units with a prefix that keeps the numbers short.

/// A scale for showing numbers: `shown = factor × number`, in the unit `unit`.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// The factor of the numbers.
    pub factor: f64,
    /// The unit with its prefix, for example `mm`; or a power of ten where it can't have one.
    pub unit: String,
}

/// Prefixes with their powers of ten.
const PREFIXES: [(i32, &str); 9] =
    [(-12, "p"), (-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"), (9, "G"), (12, "T")];
/// Units that take a prefix; kilograms have one already, squares would square it.
const PREFIXABLE: [&str; 7] = ["s", "m", "N", "J", "Pa", "W", "Hz"];

impl Shown {
    /// A scale for numbers up to `largest` (absolute) in `unit`.
    pub fn new(largest: f64, unit: &str) -> Self {
        let exponent = if largest > 0.0 && largest.is_finite() { (largest * 1.0001).log10().floor() as i32 } else { 0 };
        let power = if exponent == -1 { 0 } else { exponent.div_euclid(3) * 3 };
        let factor = 10.0_f64.powi(-power);
        match prefix(unit, power) {
            Some(prefix) => Self { factor, unit: format!("{prefix}{unit}") },
            None if (-1..=3).contains(&exponent) => Self { factor: 1.0, unit: unit.to_owned() },
            None => Self { factor, unit: format!("10{} {unit}", superscript(power)).trim_end().to_owned() },
        }
    }

    /// The head of an axis: `time [ms]`.
    pub fn head(&self, name: &str) -> String {
        if self.unit.is_empty() { name.to_owned() } else { format!("{name} [{}]", self.unit) }
    }
}

/// The prefix for a power of ten, if the unit can have it.
fn prefix(unit: &str, power: i32) -> Option<&'static str> {
    let end = unit.find([' ', '/', '·', '^', '²', '³']).unwrap_or(unit.len());
    let (symbol, rest) = unit.split_at(end);
    // Nobody counts in kiloseconds.
    let usual = PREFIXABLE.contains(&symbol) && !rest.starts_with(['^', '²', '³']) && !(symbol == "s" && power > 0);
    PREFIXES.iter().find(|(p, _)| usual && *p == power).map(|(_, prefix)| *prefix)
}

fn superscript(number: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        other => char::from_u32(0x2070 + other.to_digit(10).unwrap_or(0)).unwrap_or(other),
    };
    number.to_string().chars().map(digit).collect()
}

/// Round numbers in a range, and how to write them.
#[derive(Debug, Clone, PartialEq)]
pub struct Ticks {
    /// The numbers, increasing.
    pub values: Vec<f64>,
    decimals: usize,
}

impl Ticks {
    /// Multiples of 1, 2 or 5 times a power of ten in `low..=high`, about `count` of them.
    pub fn new(low: f64, high: f64, count: usize) -> Self {
        let step = round_step((high - low) / count.max(1) as f64);
        if !(step.is_finite() && step > 0.0) {
            return Self { values: vec![low], decimals: 3 };
        }
        let slack = 1e-9 * step;
        let first = ((low - slack) / step).ceil() as i64;
        let last = ((high + slack) / step).floor() as i64;
        let decimals = (-(step * 1.0001).log10().floor()).max(0.0) as usize;
        Self { values: (first..=last).map(|i| i as f64 * step).collect(), decimals }
    }

    /// A tick as text, with a true minus sign.
    pub fn label(&self, value: f64) -> String {
        let text = format!("{value:.*}", self.decimals);
        let zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
        match text.strip_prefix('-') {
            Some(positive) if zero => positive.to_owned(),
            Some(positive) => format!("−{positive}"),
            None => text,
        }
    }
}

/// The least of 1, 2 or 5 times a power of ten that is not below `step`.
pub fn round_step(step: f64) -> f64 {
    let power = 10.0_f64.powf(step.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&s| s >= step * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let ticks = Ticks::new(-0.013, 0.1, 5);
        assert_eq!(ticks.values.iter().map(|&v| ticks.label(v)).collect::<Vec<_>>(), ["0.00", "0.05", "0.10"]);
        let ticks = Ticks::new(-3.0, 3.0, 6);
        assert_eq!(ticks.values.iter().map(|&v| ticks.label(v)).collect::<Vec<_>>().join(" "), "−3 −2 −1 0 1 2 3");
        assert_eq!(Ticks::new(2.0, 2.0, 5).values, [2.0]);
    }

    #[test]
    fn units_take_prefixes_where_they_can() {
        let shown = |largest, unit| {
            let shown = Shown::new(largest, unit);
            (format!("{:.6}", largest * shown.factor), shown.unit)
        };
        assert_eq!(shown(1.2e-3, "s"), ("1.200000".into(), "ms".into()));
        assert_eq!(shown(0.027, "m"), ("27.000000".into(), "mm".into()));
        assert_eq!(shown(5.0, "m/s"), ("5.000000".into(), "m/s".into()));
        assert_eq!(shown(6.0e10, "Pa"), ("60.000000".into(), "GPa".into()));
        assert_eq!(shown(4.0e-6, "kg"), ("4.000000".into(), "10⁻⁶ kg".into()));
        assert_eq!(shown(2.0e-6, "m^3"), ("2.000000".into(), "10⁻⁶ m^3".into()));
        assert_eq!(shown(2.0e5, ""), ("200.000000".into(), "10³".into()));
        assert_eq!(shown(0.0, "s"), ("0.000000".into(), "s".into()));
    }
}
