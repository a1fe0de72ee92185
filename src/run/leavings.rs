//! Files that a run leaves in its directory: how they are recognised, and removed without touching anything else.
//!
//! ```text
//! case.toml  resolved.toml  run.log  status.json  run.lock
//! history/<name>.csv                            plots/<name>.svg, .png
//! fields/<name>.pvd, fields/<name>/<number>.vtu, .vtp
//! pictures/<name>.csv, pictures/<name>/<number>.png
//! checkpoint/step-<number>.checkpoint, .damaged
//! ```
//!
//! A `<name>` is one of the resolved case (of a body, a probe, a boundary ...), or one that every run uses, alone or
//! with more behind a `-`. Everything else in the directory is the user's.

use crate::error::{Error, Result};
use crate::output::atomic::TEMPORARY;
use crate::output::label::file_name;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file that a run locks.
pub(super) const LOCK: &str = "run.lock";

/// Files that a run writes beside its folders.
const FILES: &[&str] = &["case.toml", "resolved.toml", "run.log", "status.json", LOCK];

/// A folder of a run.
struct FolderKind {
    name: &'static str,
    /// Endings of the files in it.
    files: &'static [&'static str],
    /// Endings of numbered files that fill folders.
    numbered: &'static [&'static str],
}

const FOLDERS: &[FolderKind] = &[
    FolderKind { name: "history", files: &["csv"], numbered: &[] },
    FolderKind { name: "plots", files: &["svg", "png"], numbered: &[] },
    FolderKind { name: "fields", files: &["pvd"], numbered: &["vtu", "vtp"] },
    FolderKind { name: "pictures", files: &["csv"], numbered: &["png"] },
    FolderKind { name: "checkpoint", files: &["checkpoint", "damaged"], numbered: &[] },
];

/// Names that the files of every run begin with.
const COMMON: &[&str] =
    &["balance", "closure", "counts", "contact", "wall", "obstacle", "support", "mesh", "interface", "walls", "step"];

/// True if one of these files of a directory says that a run of lateen has written there.
pub(super) fn is_from_a_run(status: &Path, resolved: &Path, log: &Path) -> bool {
    let first_line = |path: &Path| {
        fs::read_to_string(path).ok().and_then(|text| text.lines().next().map(str::to_owned)).unwrap_or_default()
    };
    let status = fs::read(status).ok();
    let status = status.and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
    let has_status =
        status.is_some_and(|status| ["state", "version", "process"].iter().all(|key| !status[key].is_null()));
    has_status || first_line(resolved).contains(", as run by lateen ") || first_line(log).starts_with("lateen ")
}

/// True if a run leaves a file or a folder of this name.
pub(super) fn is_one(name: &OsStr) -> bool {
    FILES.iter().copied().chain(FOLDERS.iter().map(|folder| folder.name)).any(|left| name == left)
}

/// Removes the files that a run has left in the directory `root`, by the names in its resolved case.
///
/// # Errors
/// A link where a run writes; input/output errors.
pub(super) fn remove(root: &Path, resolved: &Path) -> Result<()> {
    let names = names(resolved);
    let folders = FOLDERS.iter().map(|folder| folder.name);
    for path in FILES.iter().copied().chain(folders).map(|name| root.join(name)) {
        if path.is_symlink() {
            let message = "this is a link, and runs make none: take it away, or name another directory with --out";
            return Err(Error::io(&path, io::Error::new(io::ErrorKind::AlreadyExists, message)));
        }
    }
    for name in FILES {
        remove_file(&root.join(name))?;
        remove_file(&root.join(format!("{name}.{TEMPORARY}")))?;
    }
    FOLDERS.iter().try_for_each(|folder| folder.remove(&root.join(folder.name), &names))
}

impl FolderKind {
    /// Removes the files of a run, and the folder if nothing else is in it.
    fn remove(&self, folder: &Path, names: &[String]) -> Result<()> {
        for path in entries(folder)? {
            let Some(stem) = path.file_name().and_then(|name| name.to_str()) else { continue };
            if path.is_dir() && !path.is_symlink() && !self.numbered.is_empty() && is_of(names, stem) {
                for file in entries(&path)? {
                    let number = stem_of(&file, self.numbered);
                    if number.is_some_and(|stem| stem.bytes().all(|byte| byte.is_ascii_digit())) {
                        remove_file(&file)?;
                    }
                }
                remove_if_empty(&path)?;
            } else if stem_of(&path, self.files).is_some_and(|stem| is_of(names, stem)) {
                remove_file(&path)?;
            }
        }
        remove_if_empty(folder)
    }
}

/// Names that files of the run begin with: those of the resolved case, and those that every run uses.
fn names(resolved: &Path) -> Vec<String> {
    let text = fs::read_to_string(resolved).unwrap_or_default();
    let mut names = COMMON.iter().map(|&name| name.to_owned()).collect();
    let parts = text.parse::<toml::Table>().unwrap_or_default();
    // The name of the case itself is none of a file.
    parts.values().for_each(|part| gather(part, &mut names));
    names
}

/// Adds every name, and every list of parts of a boundary, as files have it.
fn gather(value: &toml::Value, names: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                match (key.as_str(), value) {
                    ("name" | "on", toml::Value::String(name)) => names.push(file_name(name)),
                    ("on", toml::Value::Array(parts)) => {
                        let parts: Vec<&str> = parts.iter().filter_map(toml::Value::as_str).collect();
                        names.push(file_name(&parts.join("+")));
                    }
                    _ => gather(value, names),
                }
            }
        }
        toml::Value::Array(values) => values.iter().for_each(|value| gather(value, names)),
        _ => {}
    }
}

/// True for one of the names, or one with more behind a `-`.
fn is_of(names: &[String], stem: &str) -> bool {
    names
        .iter()
        .any(|name| stem.strip_prefix(name.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('-')))
}

/// The name of a file without its ending, if that is one of `endings`, whole or not.
fn stem_of<'p>(path: &'p Path, endings: &[&str]) -> Option<&'p str> {
    let name = path.file_name()?.to_str()?;
    let name = name.strip_suffix(TEMPORARY).and_then(|name| name.strip_suffix('.')).unwrap_or(name);
    let (stem, ending) = name.rsplit_once('.')?;
    endings.contains(&ending).then_some(stem)
}

/// Entries of a folder; none if there is no folder.
fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    match fs::read_dir(folder) {
        Ok(entries) => Ok(entries.flatten().map(|entry| entry.path()).collect()),
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(Vec::new()),
        Err(error) => Err(Error::io(folder, error)),
    }
}

fn remove_file(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Error::io(path, error)),
        _ => Ok(()),
    }
}

fn remove_if_empty(folder: &Path) -> Result<()> {
    use io::ErrorKind::{DirectoryNotEmpty, NotADirectory, NotFound};
    match fs::remove_dir(folder) {
        Err(error) if !matches!(error.kind(), DirectoryNotEmpty | NotFound | NotADirectory) => {
            Err(Error::io(folder, error))
        }
        _ => Ok(()),
    }
}
