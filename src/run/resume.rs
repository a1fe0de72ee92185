//! Checks before a run is resumed: its histories are those that it left.

use super::RunDirectory;
use crate::case::Case;
use crate::error::{Error, Result};
use crate::input;
use crate::output::label::file_name;
use crate::simulation::Snapshot;
use std::collections::BTreeSet;
use std::io;

/// Names that a message lists at most.
const LISTED: usize = 10;

/// The histories that the run has written are there: rows that are gone can't be computed anew.
///
/// # Errors
/// Histories that are not there, by name.
pub(super) fn check_histories(case: &Case, directory: &RunDirectory, initial: &Snapshot<'_>) -> Result<()> {
    // Another case may have other histories; it is refused by its hash.
    if !differences(case, directory).is_empty() {
        return Ok(());
    }
    let before = probes_before(directory);
    let probes = case.file.probe.iter().map(|probe| probe.name.as_str());
    let probes = probes.filter(|name| before.as_ref().is_none_or(|before| before.contains(*name)));
    let counts = (!initial.counts.is_empty()).then_some("counts");
    let forces = initial.forces.iter().map(|(name, _)| name.as_str());
    let written = std::iter::once("balance").chain(counts).chain(forces).chain(probes);
    let files: BTreeSet<String> = written.map(|name| format!("{}.csv", file_name(name))).collect();
    let has_heads =
        |file: &String| input::read(&directory.history().join(file)).is_ok_and(|text| text.contains(&b'\n'));
    let gone: Vec<&str> = files.iter().filter(|file| !has_heads(file)).map(String::as_str).collect();
    if gone.is_empty() {
        return Ok(());
    }
    let more = if gone.len() > LISTED { format!(" and {} more", gone.len() - LISTED) } else { String::new() };
    let message = format!(
        "the run that goes on has written {}{more} here, which can't be read: put back what is gone, or begin anew with \
         --force",
        gone[..gone.len().min(LISTED)].join(", ")
    );
    Err(Error::io(directory.history(), io::Error::new(io::ErrorKind::NotFound, message)))
}

/// The probes of the run so far; `None` where that can't be told.
fn probes_before(directory: &RunDirectory) -> Option<BTreeSet<String>> {
    let resolved: toml::Table = input::text(&directory.resolved()).ok()?.parse().ok()?;
    let probes = resolved.get("probe").and_then(toml::Value::as_array).into_iter().flatten();
    Some(probes.filter_map(|probe| Some(probe.get("name")?.as_str()?.to_owned())).collect())
}

/// Keys of the case with changed values; none if the former ones can't be read.
fn differences(case: &Case, directory: &RunDirectory) -> Vec<String> {
    input::text(&directory.resolved()).map_or(Vec::new(), |resolved| case.differences(&resolved))
}

/// Adds to the refusal of a checkpoint the keys of the case with changed values.
pub(super) fn explained(error: Error, case: &Case, directory: &RunDirectory) -> Error {
    let Error::Checkpoint { path, message } = error else { return error };
    let differences = differences(case, directory);
    let more = differences.len().saturating_sub(LISTED);
    let list: String = differences.iter().take(LISTED).map(|key| format!("\n  {key}")).collect();
    let more = if more > 0 { format!("\n  … and {more} more") } else { String::new() };
    Error::Checkpoint { path, message: format!("{message}{list}{more}") }
}
