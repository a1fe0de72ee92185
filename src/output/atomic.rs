//! Files that are either whole or not there: written to a temporary name, then renamed.

use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Appended to the name of a file that is still being written.
pub const TEMPORARY: &str = "partial";

/// Writes `path` in one piece: a reader sees the old contents or the new ones, never a part.
///
/// # Errors
/// Input/output errors; a file that was at `path` before is still there then, and no other file is left.
pub fn write(path: &Path, contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<()> {
    replace(path, contents, |_| Ok(()))
}

/// Like [`write()`](fn@write), and safe against a power failure: file and directory are synced to the disk.
///
/// # Errors
/// As [`write()`](fn@write).
pub fn write_synced(path: &Path, contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<()> {
    replace(path, contents, File::sync_all)?;
    let directory = directory_of(path);
    File::open(directory).and_then(|dir| dir.sync_all()).map_err(|error| Error::io(directory, error))
}

/// Creates a directory and those above it.
///
/// # Errors
/// Input/output errors.
pub fn create_directory(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(|error| Error::io(path, error))
}

fn replace(
    path: &Path,
    contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    sync: impl FnOnce(&File) -> io::Result<()>,
) -> Result<()> {
    let temporary = temporary_name(path);
    let written = File::create(&temporary).and_then(|file| {
        let mut writer = BufWriter::with_capacity(1 << 16, file);
        contents(&mut writer)?;
        writer.flush()?;
        sync(writer.get_ref())
    });
    written.and_then(|()| fs::rename(&temporary, path)).map_err(|error| {
        // The first error is the one to report; a temporary file that stays is harmless.
        let _ = fs::remove_file(&temporary);
        Error::io(path, error)
    })
}

fn temporary_name(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(TEMPORARY);
    PathBuf::from(name)
}

fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        write(&path, |out| out.write_all(b"old")).unwrap();
        let full = write_synced(&path, |out| {
            out.write_all(b"new, but only a p")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert!(matches!(full, Err(Error::Io { .. })));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_directory_is_an_error_with_its_path() {
        let error = write(Path::new("/nonexistent/state"), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("/nonexistent/state"), "{error}");
    }
}
