//! Reference curves in tables beside a case.

use super::series::{Series, series};
use crate::error::Result;
use crate::output::history::HistoryTable;
use serde::Deserialize;

/// A published or computed curve in a table beside the case.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Curve {
    /// The table, relative to the case.
    pub file: String,
    /// The column of the time.
    pub x: String,
    /// The column (or formula) of the value.
    pub y: String,
    /// Factor from the unit of `x` to seconds.
    #[serde(default = "one")]
    pub x_scale: f64,
    /// Factor from the unit of `y` to that of the history.
    #[serde(default = "one")]
    pub y_scale: f64,
}

impl Curve {
    /// The curve in the units of the history.
    ///
    /// # Errors
    /// A table that can't be read, or lacks the columns.
    pub fn read(&self, read_table: impl Fn(&str) -> Result<HistoryTable>) -> Result<Series> {
        let series = series(&read_table(&self.file)?, &self.x, &self.y)?;
        let x = series.x.iter().map(|x| x * self.x_scale).collect();
        Ok(Series { x, ..series.map(|y| y * self.y_scale) })
    }
}

fn one() -> f64 {
    1.0
}
