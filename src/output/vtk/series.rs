//! `.pvd`: which file shows which time.

use super::array::escape;
use crate::error::{Error, Result};
use crate::input;
use crate::output::atomic;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A list of files over time, written whole after each addition.
#[derive(Debug)]
pub struct FileSeries {
    path: PathBuf,
    entries: Vec<(f64, String)>,
}

impl FileSeries {
    /// An empty list that will be at `path`.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), entries: vec![] }
    }

    /// Number of files.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The time of the last file [s].
    pub fn last_time(&self) -> Option<f64> {
        self.entries.last().map(|(time, _)| *time)
    }

    /// The last file, relative to the list.
    pub fn last_file(&self) -> Option<&str> {
        self.entries.last().map(|(_, file)| file.as_str())
    }

    /// Adds a file, named relative to the list, and writes the list.
    ///
    /// # Errors
    /// Input/output errors; the older list is still there then.
    pub fn add(&mut self, time: f64, file: String) -> Result<()> {
        self.entries.push((time, file));
        atomic::write(&self.path, |out| {
            writeln!(out, "<?xml version=\"1.0\"?>")?;
            writeln!(out, "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>")?;
            for (time, file) in &self.entries {
                writeln!(out, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{}\"/>", escape(file))?;
            }
            writeln!(out, "</Collection>\n</VTKFile>")
        })
    }

    /// Reads the list that an earlier run left, without entries later than `time` [s].
    ///
    /// # Errors
    /// Input/output errors.
    pub fn resume(&mut self, time: f64) -> Result<()> {
        let text = match input::text(&self.path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(Error::io(&self.path, error)),
        };
        self.entries = text.lines().filter_map(entry).filter(|(t, _)| *t <= time).collect();
        Ok(())
    }

    /// Path of the list.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Time and file of a line that [`FileSeries::add`] wrote.
fn entry(line: &str) -> Option<(f64, String)> {
    let (time, rest) = line.strip_prefix("<DataSet timestep=\"")?.split_once('"')?;
    let (_, rest) = rest.split_once("file=\"")?;
    let (file, _) = rest.split_once('"')?;
    let file = file.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    Some((time.parse().ok()?, file))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_resumed_list_is_the_list_of_an_uninterrupted_run() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a&b.pvd");
        let file = |i: i32| format!("a&b/{i}.vtu");
        let mut series = FileSeries::new(&path);
        (0..6).for_each(|i| series.add(f64::from(i) * 0.1, file(i)).unwrap());
        let whole = fs::read_to_string(&path).unwrap();

        let mut resumed = FileSeries::new(&path);
        resumed.resume(0.2).unwrap();
        assert_eq!((resumed.len(), resumed.last_time()), (3, Some(0.2)));
        (3..6).for_each(|i| resumed.add(f64::from(i) * 0.1, file(i)).unwrap());
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
    }
}
