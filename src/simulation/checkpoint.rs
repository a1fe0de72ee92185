//! The interface between the time loop and a store of checkpoints.

use super::Column;
use crate::error::Result;
use std::path::PathBuf;

/// Shows every named column of a run to a visitor, always in the same order.
///
/// A visitor that stores reads the columns; a visitor that restores replaces their contents.
pub type Columns<'a> = dyn FnMut(&mut dyn FnMut(&str, Column<'_>)) + 'a;

/// Keeps checkpoints: written whole or not at all, recognised when torn.
pub trait CheckpointStore {
    /// Stores all columns as the state after `step` steps at `time` [s]; returns where.
    ///
    /// # Errors
    /// Input/output errors; older checkpoints are still there then.
    fn save(&mut self, step: u64, time: f64, columns: &mut Columns<'_>) -> Result<PathBuf>;

    /// Restores the newest good checkpoint; returns which, or `None` if there is none at all.
    ///
    /// # Errors
    /// When checkpoints are there but none can be used: torn, corrupted, of another case or version.
    fn restore(&mut self, columns: &mut Columns<'_>) -> Result<Option<PathBuf>>;

    /// Damaged checkpoints that the last restore passed over.
    fn skipped(&self) -> &[String] {
        &[]
    }
}
