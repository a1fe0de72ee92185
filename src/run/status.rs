//! Files that follow a run: `status.json` (how far it is now) and `run.log` (what happened).

use crate::error::{Error, Result};
use crate::output::atomic;
use crate::simulation::{Event, Observer, Progress};
use serde_json::{Value, json};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Keeps `status.json`: the contents of the progress line, for other programs.
#[derive(Debug)]
pub struct StatusFile {
    path: PathBuf,
    every: Duration,
    written: Option<Instant>,
    checkpoint: Option<PathBuf>,
}

impl StatusFile {
    /// A status file at `path`, written about once per second.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), every: Duration::from_secs(1), written: None, checkpoint: None }
    }

    fn write(&mut self, state: &str, progress: &Progress, error: Option<&Error>) -> Result<()> {
        self.written = Some(Instant::now());
        let status = status(state, progress, error, self.checkpoint.as_deref());
        atomic::write(&self.path, |out| writeln!(out, "{status:#}"))
    }
}

impl Observer for StatusFile {
    fn progress(&mut self, progress: &Progress) -> Result<()> {
        if self.written.is_some_and(|written| written.elapsed() < self.every) {
            return Ok(());
        }
        self.write("running", progress, None)
    }

    fn event(&mut self, event: &Event<'_>, progress: &Progress) -> Result<()> {
        match event {
            Event::Sampled | Event::Warning(_) => Ok(()),
            Event::Started { from } => {
                self.checkpoint = from.map(Path::to_owned);
                self.write("running", progress, None)
            }
            Event::Checkpoint(path) => {
                self.checkpoint = Some((*path).to_owned());
                self.write("running", progress, None)
            }
            Event::Done => self.write("done", progress, None),
            Event::Stopped { error, .. } => {
                let state = if matches!(error, Error::Interrupted) { "interrupted" } else { "failed" };
                self.write(state, progress, Some(error))
            }
        }
    }
}

/// The contents of `status.json`. Times are in seconds.
fn status(state: &str, progress: &Progress, error: Option<&Error>, checkpoint: Option<&Path>) -> Value {
    json!({
        "state": state,
        "time": progress.clock.time,
        "end": progress.end,
        "step": progress.clock.step,
        "dt": progress.clock.dt,
        "elapsed_seconds": progress.elapsed.as_secs_f64(),
        "remaining_seconds": progress.remaining.map(|left| left.as_secs_f64()),
        "steps_per_second": progress.steps_per_second,
        "particle_steps_per_second": progress.particle_steps_per_second,
        "substeps_per_second": progress.substeps_per_second,
        "element_steps_per_second": progress.element_steps_per_second,
        "energy_drift": progress.energy_drift,
        "energy_lost_to_errors": progress.energy_remainder,
        "checkpoint": checkpoint.map(|path| path.display().to_string()),
        "error": error.map(ToString::to_string),
        "exit_code": error.map_or(0, Error::exit_code),
        "version": env!("CARGO_PKG_VERSION"),
        "process": std::process::id(),
    })
}

/// Keeps `run.log`: one line per event, with the wall time since the start.
#[derive(Debug)]
pub struct RunLog {
    path: PathBuf,
    file: File,
}

impl RunLog {
    /// Opens the log at `path` and adds to it.
    ///
    /// # Errors
    /// Input/output errors.
    pub fn append(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        let file = OpenOptions::new().create(true).append(true).open(&path).map_err(|e| Error::io(&path, e))?;
        Ok(Self { path, file })
    }

    /// Adds a line (or several).
    ///
    /// # Errors
    /// Input/output errors.
    pub fn line(&mut self, text: &str) -> Result<()> {
        writeln!(self.file, "{text}").map_err(|error| Error::io(&self.path, error))
    }
}

impl Observer for RunLog {
    fn event(&mut self, event: &Event<'_>, progress: &Progress) -> Result<()> {
        let what = match event {
            Event::Started { from: None } => "started".to_owned(),
            Event::Started { from: Some(path) } => format!("resumed from {}", path.display()),
            Event::Warning(text) => format!("warning: {text}"),
            Event::Sampled => return Ok(()),
            Event::Checkpoint(path) => format!("checkpoint {}", path.display()),
            Event::Done => "done".to_owned(),
            Event::Stopped { error, .. } => format!("stopped: {error}"),
        };
        let (clock, seconds) = (progress.clock, progress.elapsed.as_secs_f64());
        self.line(&format!("{seconds:10.2} s  step {:<9} t = {:.6e}  {what}", clock.step, clock.time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{Clock, RunSummary};
    use std::fs;

    fn progress() -> Progress {
        Progress { clock: Clock { time: 0.25, step: 7, dt: 0.05 }, end: 1.0, ..Progress::default() }
    }

    #[test]
    fn status_says_how_far_the_run_is_and_why_it_stopped() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("status.json");
        let mut file = StatusFile::new(&path);
        let read = || -> Value { serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap() };

        file.event(&Event::Checkpoint(Path::new("checkpoint/7")), &progress()).unwrap();
        assert_eq!((read()["state"].as_str(), read()["time"].as_f64()), (Some("running"), Some(0.25)));

        let (error, summary) = (&Error::Interrupted, &RunSummary::default());
        file.event(&Event::Stopped { error, checkpoint: None, summary }, &progress()).unwrap();
        assert_eq!((read()["state"].as_str(), read()["exit_code"].as_u64()), (Some("interrupted"), Some(130)));
        assert_eq!(read()["checkpoint"], "checkpoint/7");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1, "the temporary file is gone");
    }
}
