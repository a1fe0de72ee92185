//! The directory of a run: what lies where, and who may overwrite it.
//!
//! ```text
//! case.toml  resolved.toml  run.log  status.json
//! history/  fields/  checkpoint/  plots/  pictures/
//! ```
//!
//! Nothing is deleted or overwritten unless the user says so, and never anything but what a run leaves.

use crate::error::{Error, Result};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Everything that a run leaves.
const LEFT_BEHIND: &[&str] = &[
    "case.toml",
    "resolved.toml",
    "run.log",
    "status.json",
    "history",
    "fields",
    "checkpoint",
    "plots",
    "pictures",
    "reference",
];

/// What to do with a directory that is not empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Existing {
    /// Refuse it.
    #[default]
    Refuse,
    /// Remove what a run left there (and nothing else).
    Replace,
    /// Go on from its newest checkpoint.
    Resume,
}

/// The directory of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunDirectory {
    root: PathBuf,
}

impl RunDirectory {
    /// The directory at `root`, as it is.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// Makes the directory ready for a run.
    ///
    /// # Errors
    /// A directory that is not empty, can't be written to, or has nothing to resume.
    pub fn prepare(&self, existing: Existing) -> Result<()> {
        let entries = self.entries()?;
        match existing {
            Existing::Refuse if !entries.is_empty() => Err(self.refuse(
                io::ErrorKind::DirectoryNotEmpty,
                "the directory is not empty; --resume goes on with the run in it, --force replaces it, --out names another",
            )),
            Existing::Resume if !self.checkpoints().is_dir() => Err(self.refuse(
                io::ErrorKind::NotFound,
                "there is no checkpoint to resume from; leave out --resume (and add --force if a run is there)",
            )),
            Existing::Replace => self.clear().and_then(|()| self.create()),
            _ => self.create(),
        }
    }

    /// The directory itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The case as it was given.
    pub fn case(&self) -> PathBuf {
        self.root.join("case.toml")
    }

    /// The case with every default, and what ran it.
    pub fn resolved(&self) -> PathBuf {
        self.root.join("resolved.toml")
    }

    /// What happened.
    pub fn log(&self) -> PathBuf {
        self.root.join("run.log")
    }

    /// How far the run is.
    pub fn status(&self) -> PathBuf {
        self.root.join("status.json")
    }

    /// Tables over time.
    pub fn history(&self) -> PathBuf {
        self.root.join("history")
    }

    /// Fields for ParaView.
    pub fn fields(&self) -> PathBuf {
        self.root.join("fields")
    }

    /// Checkpoints.
    pub fn checkpoints(&self) -> PathBuf {
        self.root.join("checkpoint")
    }

    /// Plots of the histories.
    pub fn plots(&self) -> PathBuf {
        self.root.join("plots")
    }

    /// Rendered pictures.
    pub fn pictures(&self) -> PathBuf {
        self.root.join("pictures")
    }

    /// The number of files in it and their size [bytes].
    pub fn contents(&self) -> (usize, u64) {
        fn count(directory: &Path) -> (usize, u64) {
            let entries = fs::read_dir(directory).into_iter().flatten().flatten();
            let sizes = entries.map(|entry| match entry.metadata() {
                Ok(data) if data.is_dir() => count(&entry.path()),
                Ok(data) => (1, data.len()),
                Err(_) => (0, 0),
            });
            sizes.fold((0, 0), |sum, next| (sum.0 + next.0, sum.1 + next.1))
        }
        count(&self.root)
    }

    fn entries(&self) -> Result<Vec<PathBuf>> {
        match fs::read_dir(&self.root) {
            Ok(entries) => Ok(entries.flatten().map(|entry| entry.path()).collect()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
            Err(error) => Err(self.not_writable(&error)),
        }
    }

    fn clear(&self) -> Result<()> {
        for name in LEFT_BEHIND {
            let path = self.root.join(name);
            let removed = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            match removed {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(Error::io(path, error)),
                _ => {}
            }
        }
        Ok(())
    }

    /// Creates it and tries to write in it, so that an error comes before hours of work, not after.
    fn create(&self) -> Result<()> {
        let attempt = fs::create_dir_all(&self.root)
            .and_then(|()| fs::OpenOptions::new().create(true).append(true).open(self.log()).map(drop));
        attempt.map_err(|error| self.not_writable(&error))
    }

    fn not_writable(&self, error: &io::Error) -> Error {
        self.refuse(error.kind(), &format!("can't write here ({error}); --out names another directory"))
    }

    fn refuse(&self, kind: io::ErrorKind, message: &str) -> Error {
        Error::io(&self.root, io::Error::new(kind, message))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_that_is_not_empty_is_refused_with_a_way_out() {
        let home = tempfile::tempdir().unwrap();
        let root = home.path().join("a/b");
        RunDirectory::new(&root).prepare(Existing::Refuse).unwrap();
        let error = RunDirectory::new(&root).prepare(Existing::Refuse).unwrap_err();
        assert_eq!(error.exit_code(), 4);
        for way in ["--resume", "--force", "--out"] {
            assert!(error.to_string().contains(way), "{error}");
        }
    }

    #[test]
    fn replacing_removes_what_a_run_left_and_nothing_else() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::new(home.path());
        run.prepare(Existing::Refuse).unwrap();
        fs::create_dir(run.history()).unwrap();
        fs::write(run.history().join("balance.csv"), "time\n").unwrap();
        fs::write(home.path().join("notes.txt"), "mine").unwrap();
        run.prepare(Existing::Replace).unwrap();
        assert!(!run.history().exists());
        assert_eq!(fs::read_to_string(home.path().join("notes.txt")).unwrap(), "mine");
    }

    #[test]
    fn nothing_to_resume_is_an_error() {
        let home = tempfile::tempdir().unwrap();
        let error = RunDirectory::new(home.path().join("none")).prepare(Existing::Resume).unwrap_err();
        assert!(error.to_string().contains("no checkpoint"), "{error}");
    }

    #[test]
    fn a_place_that_can_not_be_written_to_is_an_error_with_a_way_out() {
        let home = tempfile::tempdir().unwrap();
        let file = home.path().join("file");
        fs::write(&file, "").unwrap();
        let error = RunDirectory::new(file.join("run")).prepare(Existing::Refuse).unwrap_err();
        assert_eq!(error.exit_code(), 4);
        assert!(error.to_string().contains("can't write here"), "{error}");
    }
}
