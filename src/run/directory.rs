//! The directory of a run: its paths, and the rules for overwriting.
//!
//! Files are deleted or overwritten only if the user says so, and only files that a run left (`leavings.rs`). While a
//! run writes, it holds a lock on `run.lock`, which the operating system takes back however the run ends.

use super::leavings;
use crate::error::{Error, Result};
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// First line of every log.
pub(super) const SIGNATURE: &str = concat!("lateen ", env!("CARGO_PKG_VERSION"));

/// Treatment of a directory that is not empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Existing {
    /// Refuse it.
    #[default]
    Refuse,
    /// Remove the files that a run left there, and nothing else; refuse a directory that no run made.
    Replace,
    /// Go on from its newest checkpoint; begin anew where a run was killed before its first.
    Resume,
}

/// The directory of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunDirectory {
    root: PathBuf,
}

/// A directory that a run writes into: no other run may, as long as this lives.
#[derive(Debug)]
#[must_use = "the directory is free again when this is dropped"]
pub struct Occupied {
    lock: File,
    path: PathBuf,
}

impl Drop for Occupied {
    fn drop(&mut self) {
        // A file that can't be taken away does no harm: the lock is what counts.
        let _ = self.lock.unlock();
        let _ = fs::remove_file(&self.path);
    }
}

impl RunDirectory {
    /// The directory at `root`, as it is.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// Makes the directory ready for a run, and keeps other runs out.
    ///
    /// # Errors
    /// A directory that is not empty, can't be written to, has nothing to resume, or that another run writes into.
    pub fn prepare(&self, existing: Existing) -> Result<Occupied> {
        let entries = self.entries()?;
        let ours = leavings::is_from_a_run(&self.status(), &self.resolved(), &self.log());
        if existing != Existing::Refuse && ours && self.lock_file().is_file() {
            drop(self.occupy()?);
        }
        let from_a_run = self.has_checkpoint() || (ours && self.status().is_file()) || self.is_begun(&entries);
        match existing {
            Existing::Refuse if !entries.is_empty() => Err(self.refuse(
                io::ErrorKind::DirectoryNotEmpty,
                "the directory is not empty; --resume goes on with the run in it, --force replaces it, --out names another",
            )),
            Existing::Replace if !entries.is_empty() && !ours => Err(self.refuse(
                io::ErrorKind::DirectoryNotEmpty,
                "no run of lateen made this directory, and --force replaces no other; name another directory with --out, or \
                 empty this one yourself",
            )),
            Existing::Resume if !from_a_run => Err(self.refuse(
                io::ErrorKind::NotFound,
                "there is no checkpoint to resume from; leave out --resume (and add --force if a run is there)",
            )),
            Existing::Resume if !self.has_checkpoint() && self.had_checkpoint() => Err(self.refuse(
                io::ErrorKind::NotFound,
                "the checkpoints of this run are gone, so that it can't go on; --force begins anew and replaces what is here",
            )),
            // A run that was killed before its first checkpoint has nothing to lose.
            Existing::Resume if !self.has_checkpoint() => self.clear().and_then(|()| self.create()),
            Existing::Replace => self.clear().and_then(|()| self.create()),
            _ => self.create(),
        }?;
        self.occupy()
    }

    /// Takes the lock.
    fn occupy(&self) -> Result<Occupied> {
        let path = self.lock_file();
        let file = fs::OpenOptions::new().create(true).append(true).open(&path);
        let lock = file.map_err(|error| self.not_writable(&error))?;
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => Err(self.refuse(
                io::ErrorKind::ResourceBusy,
                "another run is writing here; wait for its end, or name another directory with --out",
            )),
            // Some file systems know no locks: that is no reason to refuse a run.
            _ => Ok(Occupied { lock, path }),
        }
    }

    pub(super) fn lock_file(&self) -> PathBuf {
        self.root.join(leavings::LOCK)
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

    /// Lines of the log.
    pub fn log(&self) -> PathBuf {
        self.root.join("run.log")
    }

    /// Path of the progress file.
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

    /// True if a checkpoint was written whole, though it may have been damaged since.
    pub(super) fn has_checkpoint(&self) -> bool {
        let files = fs::read_dir(self.checkpoints()).into_iter().flatten().flatten();
        files.map(|entry| entry.path()).any(|path| path.extension().is_some_and(|ending| ending == "checkpoint"))
    }

    /// True if a run was killed while it prepared the directory: its log is there, and nothing that no run leaves.
    fn is_begun(&self, entries: &[PathBuf]) -> bool {
        let own = |path: &PathBuf| path.file_name().is_some_and(leavings::is_one);
        self.log().is_file() && entries.iter().all(own)
    }

    /// True if the run here says that it wrote one.
    fn had_checkpoint(&self) -> bool {
        let status =
            fs::read(self.status()).ok().and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
        status.is_some_and(|status| status["checkpoint"].is_string())
    }

    fn entries(&self) -> Result<Vec<PathBuf>> {
        match fs::read_dir(&self.root) {
            Ok(entries) => Ok(entries.flatten().map(|entry| entry.path()).collect()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
            Err(error) => Err(self.not_writable(&error)),
        }
    }

    /// Removes the files that a run left.
    fn clear(&self) -> Result<()> {
        leavings::remove(&self.root, &self.resolved())
    }

    /// Creates it and tries to write in it, so that an error comes before hours of work, not after. What is written
    /// says whose the directory is.
    fn create(&self) -> Result<()> {
        let sign = || {
            fs::create_dir_all(&self.root)?;
            let mut log = fs::OpenOptions::new().create(true).append(true).open(self.log())?;
            if log.metadata()?.len() == 0 { writeln!(log, "{SIGNATURE}") } else { Ok(()) }
        };
        sign().map_err(|error| self.not_writable(&error))
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
        drop(RunDirectory::new(&root).prepare(Existing::Refuse).unwrap());
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
        drop(run.prepare(Existing::Refuse).unwrap());
        fs::create_dir(run.history()).unwrap();
        fs::write(run.history().join("balance.csv"), "time\n").unwrap();
        fs::write(home.path().join("notes.txt"), "mine").unwrap();
        drop(run.prepare(Existing::Replace).unwrap());
        assert!(!run.history().exists());
        assert_eq!(fs::read_to_string(home.path().join("notes.txt")).unwrap(), "mine");
    }

    #[test]
    fn files_of_the_user_stay_among_those_of_a_run() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::new(home.path());
        drop(run.prepare(Existing::Refuse).unwrap());
        fs::write(run.resolved(), "name = 'mine'\n[[probe]]\nname = 'top of it'\n[[body]]\nname = 'block'\n").unwrap();
        let written = [
            "history/top-of-it.csv",
            "history/wall-left.csv.partial",
            "plots/top-of-it-uz.png",
            "fields/block.pvd",
            "fields/block/000012.vtp",
            "checkpoint/step-000000000012.checkpoint",
            "status.json",
        ];
        let mine = [
            "history/topography.csv",
            "history/wall-left.ods",
            "plots/mine.png",
            "fields/block/camera.vtu",
            "fields/block.pvsm",
            "reference/measured.csv",
            "expected.toml",
        ];
        for file in written.iter().chain(&mine) {
            let path = home.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        drop(run.prepare(Existing::Replace).unwrap());
        assert_eq!(written.map(|file| home.path().join(file).exists()), [false; 7], "{written:?}");
        assert_eq!(mine.map(|file| home.path().join(file).exists()), [true; 7], "{mine:?}");
        assert!(!run.checkpoints().exists(), "nothing is left in it");
    }

    #[test]
    fn a_directory_that_no_run_made_is_never_replaced() {
        for (file, text) in
            [("case.toml", "name = 'mine'"), ("status.json", "{\"state\": 1}"), ("run.log", "12:00 ran\n")]
        {
            let home = tempfile::tempdir().unwrap();
            let files = [file, "run.lock", "history/balance.csv", "reference/balance.csv"];
            fs::create_dir(home.path().join("history")).unwrap();
            fs::create_dir(home.path().join("reference")).unwrap();
            files.iter().for_each(|file| fs::write(home.path().join(file), text).unwrap());
            for existing in [Existing::Replace, Existing::Resume] {
                let error = RunDirectory::new(home.path()).prepare(existing).unwrap_err();
                assert_eq!(error.exit_code(), 4);
                if existing == Existing::Replace {
                    assert!(error.to_string().contains("no run of lateen made this directory"), "{error}");
                }
                for file in files {
                    assert_eq!(fs::read_to_string(home.path().join(file)).unwrap(), text, "{file}");
                }
            }
        }
        let empty = tempfile::tempdir().unwrap();
        drop(RunDirectory::new(empty.path()).prepare(Existing::Replace).unwrap());
    }

    #[test]
    #[cfg(unix)]
    fn links_are_not_followed() {
        let (home, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let run = RunDirectory::new(home.path());
        drop(run.prepare(Existing::Refuse).unwrap());
        fs::write(elsewhere.path().join("balance.csv"), "time\n").unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), run.history()).unwrap();
        let error = run.prepare(Existing::Replace).unwrap_err();
        assert!(error.to_string().contains("this is a link"), "{error}");
        assert!(elsewhere.path().join("balance.csv").exists() && run.history().is_symlink());
    }

    #[test]
    fn a_second_run_is_kept_out_until_the_first_is_done() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::new(home.path());
        let first = run.prepare(Existing::Refuse).unwrap();
        fs::create_dir(run.checkpoints()).unwrap();
        fs::write(run.checkpoints().join("step-0.checkpoint"), "").unwrap();
        for existing in [Existing::Replace, Existing::Resume] {
            let error = run.prepare(existing).unwrap_err();
            assert!(error.to_string().contains("another run is writing here"), "{error}");
            assert!(run.log().is_file() && run.checkpoints().is_dir());
        }
        drop(first);
        drop(run.prepare(Existing::Resume).unwrap());
        drop(run.prepare(Existing::Replace).unwrap());
        assert!(!home.path().join(leavings::LOCK).exists());
    }

    #[test]
    fn nothing_to_resume_is_an_error() {
        let home = tempfile::tempdir().unwrap();
        let error = RunDirectory::new(home.path().join("none")).prepare(Existing::Resume).unwrap_err();
        assert!(error.to_string().contains("no checkpoint"), "{error}");
    }

    #[test]
    fn a_run_that_was_killed_before_its_first_checkpoint_begins_anew() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::new(home.path());
        drop(run.prepare(Existing::Refuse).unwrap());
        fs::write(run.status(), "{}").unwrap();
        fs::create_dir(run.fields()).unwrap();
        drop(run.prepare(Existing::Resume).unwrap());
        assert!(!run.fields().exists() && !run.status().exists(), "what was begun is gone");
    }

    #[test]
    fn a_run_that_was_killed_while_it_began_begins_anew() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::new(home.path());
        drop(run.prepare(Existing::Refuse).unwrap());
        fs::write(run.case(), "").unwrap();
        drop(run.prepare(Existing::Resume).unwrap());
        assert!(!run.case().exists() && run.log().is_file());
        fs::write(home.path().join("notes.txt"), "mine").unwrap();
        assert!(run.prepare(Existing::Resume).is_err() && home.path().join("notes.txt").is_file());
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
