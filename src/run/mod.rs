//! From a case to a directory of results, for the command line, `verify` and other front ends.

mod directory;
mod folder;
mod leavings;
mod monitors;
mod resume;
mod status;

pub use directory::{Existing, Occupied, RunDirectory};
pub use folder::Folder;
pub use status::{RunLog, StatusFile};

use crate::case::{Case, Units};
use crate::error::Result;
use crate::output::atomic;
use crate::output::plot::{ReferenceCurve, plot_run};
use crate::output::{Checkpoints, UnitLabels};
use crate::parallel;
use crate::simulation::{Observer, Plan, RunSummary, Simulation, Solver};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Wall time between checkpoints, where the case doesn't say [s].
const CHECKPOINT_EVERY: f64 = 60.0;

/// Options of a run.
#[derive(Default)]
pub struct Options {
    /// Treatment of a directory that is not empty.
    pub existing: Existing,
    /// Stops after the step in which it becomes true.
    pub stop: Arc<AtomicBool>,
    /// Observers of the run, besides `status.json` and `run.log`.
    pub observers: Vec<Box<dyn Observer>>,
    /// Published curves to draw in the plots.
    pub references: Vec<ReferenceCurve>,
    /// Choices that were made for the user, in sentences: comments of `resolved.toml`.
    pub notes: Vec<String>,
}

/// Runs a case with the solver that it asks for into a directory.
///
/// # Errors
/// Case errors (probes and pictures of missing parts), input/output errors, a step that failed, or an
/// interruption; the results until then are on disk.
pub fn run(case: &Case, solver: Box<dyn Solver>, directory: &RunDirectory, options: Options) -> Result<RunSummary> {
    let mut simulation = Simulation::new(solver, plan(case));
    monitors::add_monitors(&mut simulation, case, directory)?;
    let _occupied = directory.prepare(options.existing)?;
    simulation.stop_on(options.stop);
    simulation.keep_checkpoints(Box::new(Checkpoints::new(directory.checkpoints(), case.hash())));
    simulation.follow(Box::new(StatusFile::new(directory.status())));
    simulation.follow(Box::new(RunLog::append(directory.log())?));
    options.observers.into_iter().for_each(|observer| simulation.follow(observer));

    let resumed = options.existing == Existing::Resume && directory.has_checkpoint() && {
        resume::check_histories(case, directory, &simulation.solver().snapshot())?;
        simulation.resume().map_err(|error| resume::explained(error, case, directory))?
    };
    if !resumed || !directory.case().is_file() {
        write_text(&directory.case(), &case.source.text)?;
    }
    write_text(&directory.resolved(), &resolved(case, &options.notes))?;
    let outcome = simulation.run();
    // A run that failed is worth looking at, too: its plots end where it did.
    let plotted = plot_run(&directory.history(), &directory.plots(), &options.references);
    outcome.and_then(|summary| plotted.map(|()| summary))
}

/// Unit labels of the columns of a case.
pub fn unit_labels(case: &Case) -> UnitLabels {
    match case.file.units {
        Units::SI => UnitLabels::Shown,
        Units::None => UnitLabels::Hidden,
    }
}

fn plan(case: &Case) -> Plan {
    let seconds = case.file.output.checkpoint.unwrap_or(CHECKPOINT_EVERY);
    let checkpoint_every = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    Plan { end: case.file.time.end, step: case.file.time.step, checkpoint_every }
}

/// The case with every default, and what ran it.
fn resolved(case: &Case, notes: &[String]) -> String {
    let (version, threads) = (env!("CARGO_PKG_VERSION"), parallel::threads());
    let notes: String = notes.iter().map(|note| format!("# {note}\n")).collect();
    let head = format!("# {}, as run by lateen {version} on {threads} threads\n{notes}", case.source.name);
    format!("{head}\n{}", case.resolved_toml())
}

fn write_text(path: &Path, text: &str) -> Result<()> {
    atomic::write(path, |out| out.write_all(text.as_bytes()))
}
