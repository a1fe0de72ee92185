//! Tables of numbers: two columns of a CSV file, and the function of time that they make.

use super::units::{Dimension, Unit};

/// A piecewise linear function of time, constant before its first and after its last row.
///
/// ```
/// use lateen::math::TimeTable;
///
/// let table = TimeTable::from_csv("t [ms],p [kPa]\n0,1\n10,3\n", None, None)?;
/// assert_eq!((table.value(-1.0), table.value(0.005), table.value(1.0)), (1000.0, 2000.0, 3000.0));
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TimeTable {
    time: Vec<f64>,
    value: Vec<f64>,
}

impl TimeTable {
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

    /// A table from two columns of CSV text: the time and the value, by name, or else the first and the second.
    ///
    /// # Errors
    /// A sentence with the line number.
    pub fn from_csv(text: &str, time: Option<&str>, value: Option<&str>) -> Result<Self, String> {
        let rows = CsvColumns::read(text, [time, value])?.rows;
        Self::new(&rows.iter().map(|row| (row[0], row[1])).collect::<Vec<_>>())
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
        let fraction = (t - self.time[a]) / (self.time[b] - self.time[a]);
        self.value[a] + fraction * (self.value[b] - self.value[a])
    }
}

/// Two columns of CSV text, in SI; a header may give units, as in `t [ms],p [kPa]`.
#[derive(Debug, Clone, PartialEq)]
pub struct CsvColumns {
    /// The rows.
    pub rows: Vec<[f64; 2]>,
    /// The dimensions of the columns; `None` where the header gives no unit.
    pub dimensions: [Option<Dimension>; 2],
}

impl CsvColumns {
    /// Reads the columns of these names; where none is given, the first and the second.
    ///
    /// # Errors
    /// A sentence with the line number.
    pub fn read(text: &str, names: [Option<&str>; 2]) -> Result<Self, String> {
        let mut reader = csv::ReaderBuilder::new();
        reader.trim(csv::Trim::All).comment(Some(b'#')).delimiter(separator(text));
        let mut reader = reader.from_reader(text.as_bytes());
        let header = reader.headers().map_err(|e| format!("not a CSV file: {e}"))?.clone();
        if header.iter().all(str::is_empty) {
            return Err(
                "the file is empty: it needs a row of names, such as `t [s],p [Pa]`, and rows of numbers".into()
            );
        }
        if !are_heads(header.iter()) {
            return Err("this is no table: its first row must name two columns or more, such as `t [s],p [Pa]`, with \
                        commas, semicolons or tabs between them"
                .into());
        }
        let columns = [CsvColumn::find(&header, names[0], 0)?, CsvColumn::find(&header, names[1], 1)?];
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| format!("not a CSV file: {e}"))?;
            let line = record.position().map_or(0, csv::Position::line);
            rows.push([columns[0].read(&record, line)?, columns[1].read(&record, line)?]);
        }
        Ok(Self { rows, dimensions: columns.map(|column| column.unit.map(|unit| unit.dimension)) })
    }
}

/// The separator of the columns of a CSV text: `;` or a tab if its first row has one of these and no comma.
pub fn separator(text: &str) -> u8 {
    let first = text.lines().find(|line| !(line.trim().is_empty() || line.starts_with('#'))).unwrap_or_default();
    [b',', b';', b'\t'].into_iter().find(|&mark| first.as_bytes().contains(&mark)).unwrap_or(b',')
}

/// True if these can be the heads of columns, so that a message may show them: not the first line of something else.
pub fn are_heads<'a>(cells: impl Iterator<Item = &'a str> + Clone) -> bool {
    const LONGEST_HEAD: usize = 60;
    let is_head = |cell: &str| cell.chars().count() <= LONGEST_HEAD && !cell.chars().any(char::is_control);
    cells.clone().nth(1).is_some() && cells.clone().all(is_head)
}

/// A column of a CSV file with the unit of its header.
struct CsvColumn {
    index: usize,
    unit: Option<Unit>,
}

impl CsvColumn {
    fn find(header: &csv::StringRecord, name: Option<&str>, default: usize) -> Result<Self, String> {
        let bare = |cell: &str| cell.split('[').next().unwrap_or_default().trim().to_owned();
        let index = match name {
            Some(name) => header.iter().position(|cell| cell == name || bare(cell) == name),
            None => (default < header.len()).then_some(default),
        };
        let names: Vec<String> = header.iter().map(bare).collect();
        let index = index.ok_or_else(|| match name {
            Some(name) => format!("there is no column `{name}`; the columns are {}", names.join(", ")),
            None => format!("{} columns are needed; there are {}", default + 1, header.len()),
        })?;
        let unit = header[index].split_once('[').map(|(_, rest)| Unit::parse(rest.trim_end().trim_end_matches(']')));
        Ok(Self { index, unit: unit.transpose()? })
    }

    fn read(&self, record: &csv::StringRecord, line: u64) -> Result<f64, String> {
        let cell = record.get(self.index).unwrap_or_default();
        let value = cell.parse::<f64>().ok().and(self.unit.unwrap_or(Unit::ONE).in_si(cell));
        let shown: String = cell.chars().take(40).flat_map(char::escape_debug).collect();
        let point = if cell.replacen(',', ".", 1).parse::<f64>().is_ok() { ": write a decimal point" } else { "" };
        value.ok_or_else(|| format!("line {line}: `{shown}` is not a number{point}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_rows_and_constant_outside() {
        let table = TimeTable::from_csv("t [ms], p [kPa]\n0, 1\n# a comment\n2, 3\n", None, None).unwrap();
        for (t, p) in [(-1.0, 1e3), (0.0, 1e3), (1e-3, 2e3), (1.5e-3, 2.5e3), (2e-3, 3e3), (9.0, 3e3)] {
            assert!((table.value(t) - p).abs() < 1e-9, "{t}: {}", table.value(t));
        }
    }

    #[test]
    fn columns_between_semicolons_or_tabs_are_read() {
        for text in ["t [ms];p [kPa]\n0;1\n2;3\n", "# a; b\n\nt [ms]\tp [kPa]\n0\t1\n2\t3\n"] {
            assert_eq!(TimeTable::from_csv(text, None, None).unwrap().value(1e-3), 2e3, "{text}");
        }
        let error = TimeTable::from_csv("t;p\n0;1,5\n", None, None).unwrap_err();
        assert!(error.contains("line 2: `1,5` is not a number: write a decimal point"), "{error}");
        let error = TimeTable::from_csv("t p\n0 1\n", None, None).unwrap_err();
        assert!(error.contains("commas, semicolons or tabs"), "{error}");
    }

    /// A path that was meant for something else must not bring its contents into a log.
    #[test]
    fn a_file_that_is_no_table_is_not_quoted() {
        let long = format!("secret,{}\n0,1\n", "x".repeat(100));
        for text in ["secret:x:0:0\n1\n", "secret\u{1b}[31m,p\n0,1\n", &long] {
            for name in [None, Some("p")] {
                let error = TimeTable::from_csv(text, None, name).unwrap_err();
                assert!(!error.contains("secret") && error.contains("no table"), "{error}");
            }
        }
    }

    #[test]
    fn bad_tables_are_refused_with_a_reason() {
        let error = |text: &str| TimeTable::from_csv(text, None, None).unwrap_err();
        assert!(error("t,p\n0,1\n0,2\n").contains("row 2 has 0 s after 0 s"));
        assert!(error("t,p\n").contains("no rows"));
        assert!(error("t\n0\n").contains("must name two columns"));
        for empty in ["", "\n\n", "# a comment\n"] {
            assert!(error(empty).contains("the file is empty"), "{empty:?}");
        }
        assert!(error("t,p\n0,one\n").contains("line 2: `one` is not a number"));
        assert!(error("t,p\n0,nan\n").contains("not"));
        assert!(TimeTable::from_csv("t,p\n0,1\n", None, Some("q")).unwrap_err().contains("columns are t, p"));
    }
}
