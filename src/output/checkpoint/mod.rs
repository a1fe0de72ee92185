//! Checkpoints: two generations of a self-describing file, written whole or not at all.
//!
//! A file starts with a text header that names every column (kind, components, bytes) and places its
//! blocks, then holds the columns, each from a multiple of 64 bytes on, as LZ4 blocks of at most 1 MiB:
//!
//! ```text
//! lateen checkpoint 7 header 0000001234 crc 89abcdef
//! program 0.1.0
//! case "5be0cd19137e2179"
//! step 1200
//! time 0.00012
//! column f64 components 3 bytes 00000000000000024000 blocks 00000001 name "water.position"
//! block at 00000000000000000448 stored 00018023 raw 00024000 crc 0f1e2d3c
//! ```
//!
//! The header's checksum covers the header, each block has one, and what lies between blocks is zero:
//! so a changed, missing or added byte anywhere is recognised, and the older generation is used.

mod header;
mod read;
mod write;

use super::atomic;
use crate::error::{Error, Result};
use crate::simulation::{CheckpointStore, Columns};
use header::Origin;
use read::{Reader, Trouble};
use std::fs;
use std::path::{Path, PathBuf};

/// Version of the file format and of the columns of the methods. Columns with other names, kinds or sizes are
/// recognised; one that means something else than before needs another number.
const FORMAT: u32 = 7;
/// Version of the program.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Bytes per block before compression.
const BLOCK: usize = 1 << 20;
/// Columns start at multiples of this many bytes.
const ALIGNMENT: u64 = 64;
/// Number of checkpoints that are kept.
const GENERATIONS: usize = 2;
/// The extension of checkpoint files.
const EXTENSION: &str = "checkpoint";

/// Keeps the two newest checkpoints of one case in a directory.
///
/// ```
/// use lateen::output::Checkpoints;
/// use lateen::simulation::{CheckpointStore, Column};
///
/// let directory = tempfile::tempdir().unwrap();
/// let mut store = Checkpoints::new(directory.path(), "hash of the case");
/// let mut works = [1.0, 2.0];
/// store.save(100, 0.1, &mut |visit| visit("works", Column::record(&mut works)))?;
/// works = [0.0; 2];
/// let path = store.restore(&mut |visit| visit("works", Column::record(&mut works)))?;
/// assert!(path.is_some() && works == [1.0, 2.0]);
/// # Ok::<(), lateen::Error>(())
/// ```
#[derive(Debug)]
pub struct Checkpoints {
    directory: PathBuf,
    case: String,
    skipped: Vec<String>,
}

impl Checkpoints {
    /// Checkpoints in `directory` of the case that `case` identifies (see [`fingerprint`]).
    pub fn new(directory: impl Into<PathBuf>, case: impl Into<String>) -> Self {
        Self { directory: directory.into(), case: case.into(), skipped: vec![] }
    }

    /// Checkpoint files, newest first; none if there is no directory yet.
    fn files(&self) -> Result<Vec<PathBuf>> {
        let entries = match fs::read_dir(&self.directory) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(vec![]),
            Err(error) => return Err(Error::io(&self.directory, error)),
        };
        let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        files.retain(|path| path.extension().is_some_and(|extension| extension == EXTENSION));
        files.sort_unstable_by(|a, b| b.cmp(a));
        Ok(files)
    }

    /// Puts a damaged file out of the way, so that it doesn't count as a generation.
    fn skip(&mut self, path: &Path, damage: &str) {
        self.skipped.push(format!("checkpoint {} is damaged ({damage}) and was not used", path.display()));
        // Best effort: should it fail, the file is recognised as damaged again.
        let _ = fs::rename(path, path.with_extension("damaged"));
    }

    fn error(path: &Path, message: String) -> Error {
        Error::Checkpoint { path: path.to_owned(), message }
    }
}

impl CheckpointStore for Checkpoints {
    fn save(&mut self, step: u64, time: f64, columns: &mut Columns<'_>) -> Result<PathBuf> {
        atomic::create_directory(&self.directory)?;
        let path = self.directory.join(format!("step-{step:012}.{EXTENSION}"));
        let origin = Origin { program: VERSION.to_owned(), case: self.case.clone(), step, time };
        atomic::write_synced(&path, |out| write::write(out, origin, columns))?;
        for old in self.files()?.into_iter().skip(GENERATIONS) {
            fs::remove_file(&old).map_err(|error| Error::io(&old, error))?;
        }
        Ok(path)
    }

    fn restore(&mut self, columns: &mut Columns<'_>) -> Result<Option<PathBuf>> {
        self.skipped.clear();
        for path in self.files()? {
            let verified = Reader::open(&path).and_then(|mut reader| {
                reader.check_origin(&self.case)?;
                reader.check_model(columns)?;
                reader.verify()?;
                Ok(reader)
            });
            match verified {
                Ok(mut reader) => {
                    reader.restore(columns).map_err(|trouble| Self::error(&path, trouble.to_string()))?;
                    return Ok(Some(path));
                }
                Err(Trouble::Damaged(damage)) => self.skip(&path, &damage),
                Err(Trouble::Io(error)) => return Err(Error::io(&path, error)),
                Err(trouble) => return Err(Self::error(&path, trouble.to_string())),
            }
        }
        match self.skipped.last() {
            None => Ok(None),
            Some(_) => {
                Err(Self::error(&self.directory, format!("{}; none is left to resume from", self.skipped.join("; "))))
            }
        }
    }

    fn skipped(&self) -> &[String] {
        &self.skipped
    }
}

/// A short text that identifies the contents of a case (64-bit FNV-1a, in hexadecimal).
pub fn fingerprint(contents: &[u8]) -> String {
    let hash = contents
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published test vectors of FNV-1a.
    #[test]
    fn fingerprints_are_fnv_1a() {
        assert_eq!(fingerprint(b""), "cbf29ce484222325");
        assert_eq!(fingerprint(b"foobar"), "85944171f73967e8");
    }
}
