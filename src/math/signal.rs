//! A value that may vary in space and time: a constant, a formula in `x y z t`, or a table in `t`.

use super::formula::Formula;
use super::units::Unit;
use std::sync::Arc;

/// A value in space and time, in SI units. Cloning is cheap.
#[derive(Debug, Clone)]
pub enum Signal {
    /// The same everywhere and always.
    Constant(f64),
    /// A formula in `x y z` [m] and `t` [s].
    Formula(Arc<Formula>),
    /// A table in `t` [s].
    Table(Arc<Table>),
}

impl Signal {
    /// Zero.
    pub const ZERO: Self = Self::Constant(0.0);

    /// A formula such as `"10 m/s * sin(2*pi*t / 1 ms)"` or, in SI throughout, `"0.1*y*(0.41 - y)"`.
    ///
    /// # Errors
    /// A sentence about what is wrong with the formula.
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
        !matches!(self, Self::Formula(_))
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

/// A piecewise linear function of time, constant before its first and after its last row.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    time: Vec<f64>,
    value: Vec<f64>,
}

impl Table {
    /// A table of `(time [s], value)` rows.
    ///
    /// # Errors
    /// A sentence if there is no row, a number is not finite, or the times don't increase strictly.
    pub fn new(rows: &[(f64, f64)]) -> Result<Self, String> {
        if rows.is_empty() {
            return Err("the table has no rows".to_owned());
        }
        for (i, row) in rows.iter().enumerate() {
            if !(row.0.is_finite() && row.1.is_finite()) {
                return Err(format!("row {} holds a number that is not finite", i + 1));
            }
            if i > 0 && row.0 <= rows[i - 1].0 {
                let (a, b) = (rows[i - 1].0, row.0);
                return Err(format!("the times must increase: row {} has {b} s after {a} s", i + 1));
            }
        }
        let (time, value) = rows.iter().copied().unzip();
        Ok(Self { time, value })
    }

    /// Reads two columns of CSV text; a header may give units, as in `t [ms],p [kPa]`.
    /// Columns are chosen by name; by default the first is the time and the second the value.
    ///
    /// # Errors
    /// A sentence with the line number.
    pub fn from_csv(text: &str, time: Option<&str>, value: Option<&str>) -> Result<Self, String> {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
        let header = reader.headers().map_err(|e| format!("not a CSV file: {e}"))?.clone();
        let time = Column::find(&header, time, 0)?;
        let value = Column::find(&header, value, 1)?;
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| format!("not a CSV file: {e}"))?;
            let line = record.position().map_or(0, csv::Position::line);
            rows.push((time.read(&record, line)?, value.read(&record, line)?));
        }
        Self::new(&rows)
    }

    /// The value at `t` [s], linearly between rows.
    pub fn value(&self, t: f64) -> f64 {
        let after = self.time.partition_point(|&row| row <= t);
        if after == 0 {
            return self.value[0];
        }
        if after == self.time.len() {
            return self.value[after - 1];
        }
        let [a, b] = [after - 1, after];
        let share = (t - self.time[a]) / (self.time[b] - self.time[a]);
        self.value[a] + share * (self.value[b] - self.value[a])
    }
}

/// A column of a CSV file with the unit of its header.
struct Column {
    index: usize,
    unit: Unit,
}

impl Column {
    fn find(header: &csv::StringRecord, name: Option<&str>, default: usize) -> Result<Self, String> {
        let bare = |cell: &str| cell.split('[').next().unwrap_or_default().trim().to_owned();
        let index = match name {
            Some(name) => header.iter().position(|cell| cell == name || bare(cell) == name),
            None => (default < header.len()).then_some(default),
        };
        let names: Vec<String> = header.iter().map(bare).collect();
        let index = index.ok_or_else(|| match name {
            Some(name) => format!("there is no column `{name}`; the columns are {}", names.join(", ")),
            None => "two columns are needed, time and value".to_owned(),
        })?;
        let unit = header[index].split_once('[').map_or("", |(_, rest)| rest.trim_end().trim_end_matches(']'));
        Ok(Self { index, unit: Unit::parse(unit)? })
    }

    fn read(&self, record: &csv::StringRecord, line: u64) -> Result<f64, String> {
        let cell = record.get(self.index).unwrap_or_default();
        if cell.parse::<f64>().is_err() {
            return Err(format!("line {line}: `{cell}` is not a number"));
        }
        self.unit.in_si(cell).ok_or_else(|| format!("line {line}: `{cell}` is not a number"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_rows_and_constant_outside() {
        let table = Table::from_csv("t [ms], p [kPa]\n0, 1\n# a comment\n2, 3\n", None, None).unwrap();
        for (t, p) in [(-1.0, 1e3), (0.0, 1e3), (1e-3, 2e3), (1.5e-3, 2.5e3), (2e-3, 3e3), (9.0, 3e3)] {
            assert!((table.value(t) - p).abs() < 1e-9, "{t}: {}", table.value(t));
        }
    }

    #[test]
    fn bad_tables_are_refused_with_a_reason() {
        let error = |text: &str| Table::from_csv(text, None, None).unwrap_err();
        assert!(error("t,p\n0,1\n0,2\n").contains("row 2 has 0 s after 0 s"));
        assert!(error("t,p\n").contains("no rows"));
        assert!(error("t\n0\n").contains("two columns"));
        assert!(error("t,p\n0,one\n").contains("line 2: `one` is not a number"));
        assert!(error("t,p\n0,nan\n").contains("not"));
        assert!(Table::from_csv("t,p\n0,1\n", None, Some("q")).unwrap_err().contains("columns are t, p"));
    }

    #[test]
    fn formulas_without_variables_become_constants() {
        assert_eq!(Signal::formula("2*pi"), Ok(Signal::Constant(std::f64::consts::TAU)));
        assert_eq!(Signal::formula("1 kPa"), Ok(Signal::Constant(1000.0)));
        assert!(!Signal::formula("1/t").unwrap().value([0.0; 3], 0.0).is_finite());
    }
}
