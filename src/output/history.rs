//! Histories: CSV tables over time whose first row names the columns with their units (theory H.10).
//!
//! A row is written with one call and never left half: after a failed write the file is cut back, and
//! a run that was killed in the middle of a row drops that row when it is resumed. Numbers are written
//! with the fewest digits that read back to the same bits. The file is open for no longer than a row takes: a run may
//! have more histories than a process may have files.

use super::atomic::create_directory;
use crate::error::{Error, Result};
use crate::input;
use crate::math::separator;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A CSV table that grows by one row per sample.
#[derive(Debug)]
pub struct History {
    path: PathBuf,
    /// True once the file has its first row.
    begun: bool,
    /// The first row of a table that goes on.
    resumed: Option<Vec<u8>>,
    last_time: f64,
}

impl History {
    /// A history at `path`; the file is made with the first row.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), begun: false, resumed: None, last_time: f64::NEG_INFINITY }
    }

    /// Path of the table.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends a row, whose first number is the time; a time that is there already is skipped. A file that was taken
    /// away begins anew.
    ///
    /// # Errors
    /// Input/output errors; a table that goes on with other columns.
    pub fn append(&mut self, heads: &[String], row: &[f64]) -> Result<()> {
        assert_eq!(heads.len(), row.len(), "a row of {} has as many numbers as heads", self.path.display());
        let time = row[0];
        if time <= self.last_time {
            return Ok(());
        }
        if let Some(first) = self.resumed.take() {
            self.same_columns(&first, &csv_line(heads))?;
        }
        self.begin(heads)?;
        let line = csv_line(row.iter().map(|number| format!("{number:?}")));
        if let Err(error) = append_whole(&self.path, &line) {
            if error.kind() != io::ErrorKind::NotFound {
                return Err(Error::io(&self.path, error));
            }
            self.create(heads)?;
            append_whole(&self.path, &line).map_err(|error| Error::io(&self.path, error))?;
        }
        self.last_time = time;
        Ok(())
    }

    /// Makes the file with its first row, where it isn't there yet: a history that another run goes on with was begun.
    ///
    /// # Errors
    /// Input/output errors.
    pub fn begin(&mut self, heads: &[String]) -> Result<()> {
        if !self.begun {
            self.create(heads)?;
            self.begun = true;
        }
        Ok(())
    }

    /// Prepares for rows after `time` [s]: cuts the table behind the last whole row up to `time`, but for rounding.
    ///
    /// # Errors
    /// Input/output errors.
    pub fn resume(&mut self, time: f64) -> Result<()> {
        let text = match input::read(&self.path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(Error::io(&self.path, error)),
        };
        let (keep, last_time) = rows_until(&text, time);
        if keep == 0 {
            return Ok(());
        }
        let cut = OpenOptions::new().write(true).open(&self.path).and_then(|file| file.set_len(keep));
        cut.map_err(|error| Error::io(&self.path, error))?;
        self.begun = true;
        self.resumed = text.split_inclusive(|&byte| byte == b'\n').next().map(<[u8]>::to_vec);
        self.last_time = last_time;
        Ok(())
    }

    /// A table that was begun with other columns can't go on.
    fn same_columns(&self, before: &[u8], now: &[u8]) -> Result<()> {
        if before == now {
            return Ok(());
        }
        let [before, now] = [before, now].map(String::from_utf8_lossy);
        let message = format!(
            "the run that goes on wrote the columns {} here, and the case now asks for {}: give what is measured another \
             name, or start anew with --force",
            before.trim_end(),
            now.trim_end()
        );
        Err(Error::io(&self.path, io::Error::new(io::ErrorKind::InvalidData, message)))
    }

    fn create(&self, heads: &[String]) -> Result<()> {
        if let Some(directory) = self.path.parent() {
            create_directory(directory)?;
        }
        let created = File::create(&self.path).and_then(|_| append_whole(&self.path, &csv_line(heads)));
        created.map_err(|error| Error::io(&self.path, error))
    }
}

/// Values at the start of a step, for rows between both of its ends.
#[derive(Debug, Clone, Default)]
pub struct StepStart {
    time: f64,
    values: Vec<f64>,
}

impl StepStart {
    /// Keeps the values at the start of a step at `time` [s].
    pub fn keep(&mut self, time: f64, values: Vec<f64>) {
        *self = Self { time, values };
    }

    /// The values at the time `due` [s], on the straight line to those at the end of the step at `time` [s]; those at
    /// the end, where `due` is that time, or none were kept.
    pub fn between(&self, due: f64, time: f64, end: Vec<f64>) -> Vec<f64> {
        if self.values.len() != end.len() || !(self.time < due && due < time) {
            return end;
        }
        let part = (due - self.time) / (time - self.time);
        self.values.iter().zip(end).map(|(start, end)| start + part * (end - start)).collect()
    }
}

/// A history read back: heads and rows.
///
/// ```
/// use lateen::output::history::HistoryTable;
///
/// let table = HistoryTable::parse(b"time [s],p [Pa]\n0,1\n0.5,3\n")?;
/// assert_eq!(table.column("p"), Some(&[1.0, 3.0][..]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HistoryTable {
    /// First row: names with units.
    pub heads: Vec<String>,
    /// One vector of numbers per column.
    pub columns: Vec<Vec<f64>>,
}

impl HistoryTable {
    /// The sum with another history, `name`, of the columns that both have and the rows of the shorter one.
    #[must_use]
    pub fn plus(&self, other: &Self, name: &str) -> Self {
        let (heads, columns) = (self.heads.iter().zip(&self.columns), other.names());
        let both = heads.skip(1).filter_map(|(head, own)| {
            let (column, unit) = head.strip_suffix(']')?.rsplit_once(" [")?;
            let added = &other.columns[columns.iter().position(|other| *other == column)?];
            let sum = own.iter().zip(added).map(|(a, b)| a + b).collect();
            Some((format!("{column} [{unit} and {name}]"), sum))
        });
        let (mut names, mut sums): (Vec<String>, Vec<Vec<f64>>) = both.unzip();
        names.insert(0, self.heads.first().cloned().unwrap_or_default());
        sums.insert(0, self.columns.first().cloned().unwrap_or_default());
        let rows = sums.iter().map(Vec::len).min().unwrap_or_default();
        sums.iter_mut().for_each(|column| column.truncate(rows));
        Self { heads: names, columns: sums }
    }

    /// Reads a history; empty if there is none yet.
    ///
    /// # Errors
    /// Input/output errors, and anything in the table that is not a number.
    pub fn read(path: &Path) -> Result<Self> {
        let text = match input::read(path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(Error::io(path, error)),
        };
        let invalid = |error| Error::io(path, io::Error::new(io::ErrorKind::InvalidData, error));
        Self::parse(&text).map_err(invalid)
    }

    /// Reads a table from text; lines that start with `#` are comments.
    ///
    /// # Errors
    /// Anything in the table that is not a number, and rows of another length than the first.
    pub fn parse(text: &[u8]) -> Result<Self, csv::Error> {
        let mut reader = csv::ReaderBuilder::new();
        reader.comment(Some(b'#')).trim(csv::Trim::All).delimiter(separator(&String::from_utf8_lossy(text)));
        let mut reader = reader.from_reader(text);
        let heads: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        let mut columns = vec![Vec::new(); heads.len()];
        for row in reader.deserialize::<Vec<f64>>() {
            for (column, number) in columns.iter_mut().zip(row?) {
                column.push(number);
            }
        }
        Ok(Self { heads, columns })
    }

    /// The heads without their units.
    pub fn names(&self) -> Vec<&str> {
        let bare = |head: &'_ String| head.rfind(" [").filter(|_| head.ends_with(']')).unwrap_or(head.len());
        self.heads.iter().map(|head| &head[..bare(head)]).collect()
    }

    /// The column whose head is `name`, with or without a unit in brackets.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let is_head = |head: &String| {
            head == name || head.strip_prefix(name).is_some_and(|rest| rest.starts_with(" [") && rest.ends_with(']'))
        };
        self.heads.iter().position(is_head).map(|c| &self.columns[c][..])
    }
}

/// One CSV row, quoted where needed, with its newline.
fn csv_line<S: AsRef<[u8]>>(cells: impl IntoIterator<Item = S>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(cells).expect("writing to memory does not fail");
    writer.into_inner().expect("writing to memory does not fail")
}

/// Writes a line at the end of a file, or nothing of it.
fn append_whole(path: &Path, line: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().append(true).open(path)?;
    let end = file.metadata()?.len();
    file.write_all(line).inspect_err(|_| {
        // If cutting fails as well, a resumed run still drops the half row.
        let _ = file.set_len(end);
    })
}

/// Times closer than this part of them are the same: a row has the time that it is due at, a step the sum of the steps.
const SAME_TIME: f64 = 1e-9;

/// Bytes up to the end of the last whole row not after `time`, and that row's time.
/// Zero bytes if not even the heads are whole.
fn rows_until(text: &[u8], time: f64) -> (u64, f64) {
    let whole = text.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
    let (mut keep, mut last_time) = (0, f64::NEG_INFINITY);
    let mut reader = csv::Reader::from_reader(&text[..whole]);
    if whole == 0 || reader.headers().is_err() {
        return (keep, last_time);
    }
    keep = reader.position().byte();
    let mut row = csv::StringRecord::new();
    while let Ok(true) = reader.read_record(&mut row) {
        match row[0].parse::<f64>() {
            Ok(t) if t <= time * (1.0 + SAME_TIME) => (keep, last_time) = (reader.position().byte(), t),
            _ => break,
        }
    }
    (keep, last_time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn heads() -> Vec<String> {
        vec!["time [s]".into(), "uz [m]".into()]
    }

    fn history_of_ten(path: &Path) -> String {
        let mut history = History::new(path);
        for i in 0..10 {
            history.append(&heads(), &[f64::from(i) * 0.1, 1.0 / f64::from(i + 3)]).unwrap();
        }
        fs::read_to_string(path).unwrap()
    }

    #[test]
    fn values_within_a_step_are_on_the_straight_line() {
        let mut start = StepStart::default();
        assert_eq!(start.between(1.5, 2.0, vec![7.0]), [7.0], "nothing was kept");
        start.keep(1.0, vec![2.0, -1.0]);
        assert_eq!(start.between(1.25, 2.0, vec![4.0, -1.0]), [2.5, -1.0]);
        assert_eq!(start.between(2.0, 2.0, vec![4.0, -1.0]), [4.0, -1.0]);
        assert_eq!(start.between(2.5, 3.0, vec![4.0]), [4.0], "other columns");
    }

    #[test]
    fn the_first_row_names_columns_and_numbers_read_back_exactly() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("history/probe.csv");
        let text = history_of_ten(&path);
        assert!(text.starts_with("time [s],uz [m]\n0.0,0.3333333333333333\n"), "{text}");
        let table = HistoryTable::read(&path).unwrap();
        assert_eq!(table.column("uz").unwrap()[4], 1.0 / 7.0);
        assert_eq!(table.column("time").unwrap().len(), 10);
        assert!(table.column("u").is_none());
    }

    #[test]
    fn resuming_drops_later_and_half_rows_and_repeats_the_rest_exactly() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("probe.csv");
        let whole = history_of_ten(&path);
        for cut in 0..whole.len() {
            fs::write(&path, &whole[..cut]).unwrap();
            let mut history = History::new(&path);
            history.resume(0.45).unwrap();
            for i in 0..10 {
                history.append(&heads(), &[f64::from(i) * 0.1, 1.0 / f64::from(i + 3)]).unwrap();
            }
            assert_eq!(fs::read_to_string(&path).unwrap(), whole, "cut at byte {cut}");
        }
    }

    #[test]
    fn a_table_that_was_taken_away_begins_anew() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("history/probe.csv");
        let mut history = History::new(&path);
        history.append(&heads(), &[0.0, 1.0]).unwrap();
        fs::remove_dir_all(path.parent().unwrap()).unwrap();
        history.append(&heads(), &[0.5, 2.0]).unwrap();
        history.append(&heads(), &[1.0, 3.0]).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "time [s],uz [m]\n0.5,2.0\n1.0,3.0\n");
    }

    /// A process may have a thousand files open, a run of 50 bodies has more histories of contact forces.
    #[cfg(target_os = "linux")]
    #[test]
    fn histories_hold_no_files_open() {
        let dir = tempfile::tempdir().unwrap();
        let home = fs::canonicalize(dir.path()).unwrap();
        let mut histories: Vec<History> = (0..20).map(|i| History::new(home.join(format!("{i}.csv")))).collect();
        histories.iter_mut().for_each(|history| history.append(&heads(), &[0.0, 1.0]).unwrap());
        let mut resumed = History::new(home.join("0.csv"));
        resumed.resume(0.0).unwrap();
        // Other tests open and close files meanwhile.
        let open = fs::read_dir("/proc/self/fd").unwrap().filter_map(|file| fs::read_link(file.ok()?.path()).ok());
        assert_eq!(open.filter(|path| path.starts_with(&home)).count(), 0);
        assert_eq!(fs::read_dir(&home).unwrap().count(), 20);
    }

    #[test]
    fn names_with_commas_are_quoted() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("balance.csv");
        let heads = vec!["time [s]".to_owned(), "kinetic energy: a, \"b\" [J]".to_owned()];
        History::new(&path).append(&heads, &[0.0, 1.5]).unwrap();
        assert_eq!(HistoryTable::read(&path).unwrap().heads, heads);
    }

    #[test]
    fn a_full_disk_is_an_error_with_the_path() {
        if Path::new("/dev/full").exists() {
            let error = History::new("/dev/full").append(&heads(), &[0.0, 1.0]).unwrap_err();
            assert!(error.to_string().contains("/dev/full"), "{error}");
        }
    }
}
