//! `lateen run`: a case from its file to its results.

use super::progress::{self, duration, quantity, taken};
use super::{Failure, located, quoted, say, show, signals};
use lateen::case::Units;
use lateen::error::Error;
use lateen::run::{self, Existing, Folder, Options, RunDirectory};
use lateen::simulation::{Event, Observer, Progress, RunSummary};
use lateen::verify;
use std::io::ErrorKind;
use std::path::PathBuf;

/// Options of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// A case file, or the name of a built-in case
    case: String,
    /// Folder of the results [default: runs/<name of the case>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Override a key of the case, for example --set grid.cell="2 mm"
    #[arg(long, value_name = "KEY=VALUE", value_parser = super::key_value)]
    set: Vec<(String, String)>,
    /// Number of threads [default: all cores]; results don't depend on it
    #[arg(long, value_name = "N", value_parser = super::threads)]
    threads: Option<usize>,
    /// Go on from the newest good checkpoint in DIR, bit for bit
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Replace what a run of lateen left in DIR, and nothing else
    #[arg(long)]
    force: bool,
}

/// Runs a case.
pub fn run(arguments: Arguments) -> Result<(), Failure> {
    super::use_threads(arguments.threads)?;
    let folder = Folder::open(&arguments.case)?;
    let case = folder.read(&arguments.set).map_err(|error| located(error, &folder))?;
    let model = case.model().map_err(|error| located(error, &folder))?;
    super::show_findings(&folder.source, &model.warnings);
    model.summary.notes.iter().for_each(|note| say(note));
    let expected = super::expected(&folder)?.unwrap_or_default();
    let directory = RunDirectory::new(arguments.out.unwrap_or_else(|| PathBuf::from("runs").join(&case.file.name)));
    let unit = if case.file.units == Units::SI { "s" } else { "" };
    let options = Options {
        existing: match (arguments.resume, arguments.force) {
            (true, _) => Existing::Resume,
            (_, true) => Existing::Replace,
            _ => Existing::Refuse,
        },
        stop: signals::stop_flag()?,
        observers: vec![progress::display(unit), Box::new(Stop { unit })],
        references: verify::drawn(&folder, &expected)?,
        notes: model.summary.notes.clone(),
    };
    let (particles, elements) = (model.summary.particles(), model.summary.elements());
    let elements = if elements > 0 { format!(", {elements} elements of membranes") } else { String::new() };
    say(&format!("{}: {particles} particles{elements}, into {}", case.file.name, directory.root().display()));
    match run::run(&case, model.solver, &directory, options) {
        Ok(summary) => print_summary(&summary, &directory, unit),
        Err(error) => {
            advise(&error, &directory, &arguments.case, &arguments.set);
            Err(located(error, &folder))
        }
    }
}

/// Advice after a run that stopped before its end.
fn advise(error: &Error, directory: &RunDirectory, case: &str, set: &[(String, String)]) {
    let root = directory.root().display().to_string();
    let set: String = set.iter().map(|(key, value)| format!(" --set {}", quoted(&format!("{key}={value}")))).collect();
    let resume = format!("lateen run {}{set} --out {} --resume", quoted(case), quoted(&root));
    match error {
        Error::Interrupted => say(&format!("go on with: {resume}")),
        Error::Io { source, .. } if source.kind() == ErrorKind::StorageFull => {
            say(&format!("make room on the disk, then go on with: {resume}"));
        }
        Error::Io { source, .. } if source.kind() == ErrorKind::FileTooLarge => {
            say(&format!("files may not grow so large here: raise the limit (`ulimit -f`), then go on with: {resume}"));
        }
        Error::Step(_) if directory.checkpoints().is_dir() => {
            say(&format!(
                "the last good state is saved in {root}/checkpoint and shown by the last fields and pictures"
            ));
        }
        _ => {}
    }
}

/// Says how far a run came that stopped before its end, and where its time went.
struct Stop {
    unit: &'static str,
}

impl Observer for Stop {
    fn event(&mut self, event: &Event<'_>, _progress: &Progress) -> lateen::Result<()> {
        if let Event::Stopped { summary, .. } = event {
            // The run has an error already, which is the one to report.
            let _ = show(&times("stopped", summary, self.unit));
        }
        Ok(())
    }
}

/// Times per stage, speed, closure of the energy ledger, files on disk.
fn print_summary(summary: &RunSummary, directory: &RunDirectory, unit: &str) -> Result<(), Failure> {
    let mut text = times("done", summary, unit);
    if let Some(part) = summary.energy_remainder {
        text += &format!(
            "energy: {} to errors, of the largest other term (`numerical dissipation` in history/balance.csv)\n",
            taken(part)
        );
    } else if summary.energy_scale > 0.0 {
        let relative = summary.closure / summary.energy_scale;
        text += &format!("energy: all but {relative:.1e} of the largest term is accounted for\n");
    }
    let (files, bytes) = directory.contents();
    text += &format!("{}: {files} files, {} bytes\n", directory.root().display(), quantity(bytes as f64, ""));
    show(&text)
}

/// Time reached, speed, and wall time per stage.
fn times(state: &str, summary: &RunSummary, unit: &str) -> String {
    let seconds = summary.elapsed.as_secs_f64().max(f64::MIN_POSITIVE);
    let mut text = format!(
        "{state}: t = {} in {} steps, {}; {} particle-steps/s",
        quantity(summary.clock.time, unit),
        summary.clock.step,
        duration(summary.elapsed),
        quantity(summary.particle_steps as f64 / seconds, ""),
    );
    if summary.substeps > 0 {
        let speed = quantity(summary.element_steps as f64 / seconds, "");
        text += &format!(", {speed} element-steps/s ({} sub-steps of membranes)", summary.substeps);
    }
    text.push('\n');
    let inside: f64 = summary.stages.iter().map(|stage| stage.1).sum();
    let outside = ("the rest", (seconds - inside).max(0.0));
    for (stage, spent) in summary.stages.iter().chain([&outside]) {
        text += &format!("  {:5.1}%  {spent:8.2} s  {stage}\n", 100.0 * spent / seconds);
    }
    text
}
