//! `lateen run`: a case from its file to its results.

use super::progress::{self, duration, quantity, taken};
use super::{Failure, located, signals};
use lateen::case::Units;
use lateen::error::Error;
use lateen::run::{self, Existing, Folder, Options, RunDirectory};
use lateen::simulation::Summary;
use lateen::verify;
use std::io::IsTerminal;
use std::path::PathBuf;

/// What the user asked for.
#[derive(clap::Args)]
pub struct Arguments {
    /// A case file, or the name of a built-in case
    case: String,
    /// Where the results go [default: runs/<name of the case>]
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
    /// Replace what a run left in DIR
    #[arg(long)]
    force: bool,
}

/// Runs a case.
pub fn run(arguments: Arguments) -> Result<(), Failure> {
    super::use_threads(arguments.threads)?;
    let folder = Folder::open(&arguments.case)?;
    let case = folder.read(&arguments.set).map_err(|error| located(error, &folder))?;
    let model = case.model().map_err(|error| located(error, &folder))?;
    eprint!("{}", folder.source.render(&model.warnings, std::io::stderr().is_terminal()));
    model.summary.notes.iter().for_each(|note| eprintln!("{note}"));
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
        observers: vec![progress::display(unit)],
        references: verify::drawn(&folder, &expected)?,
        notes: model.summary.notes.clone(),
    };
    eprintln!("{}: {} particles, into {}", case.file.name, model.summary.particles(), directory.root().display());
    match run::run(&case, model.solver, &directory, options) {
        Ok(summary) => {
            print_summary(&summary, &directory, unit);
            Ok(())
        }
        Err(error) => {
            advise(&error, &directory, &arguments.case, &arguments.set);
            Err(located(error, &folder))
        }
    }
}

/// What to do after a run that stopped before its end.
fn advise(error: &Error, directory: &RunDirectory, case: &str, set: &[(String, String)]) {
    let root = directory.root().display();
    let set: String = set.iter().map(|(key, value)| format!(" --set '{key}={value}'")).collect();
    let resume = format!("lateen run {case}{set} --out {root} --resume");
    match error {
        Error::Interrupted => eprintln!("go on with: {resume}"),
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::StorageFull => {
            eprintln!("make room on the disk, then go on with: {resume}");
        }
        Error::Step(_) if directory.checkpoints().is_dir() => {
            eprintln!("the last good state is saved in {root}/checkpoint and shown by the last fields and pictures");
        }
        _ => {}
    }
}

/// Where the time went, how fast it was, how well energy is accounted for, what is on disk.
fn print_summary(summary: &Summary, directory: &RunDirectory, unit: &str) {
    let seconds = summary.elapsed.as_secs_f64();
    let particle_rate = quantity(summary.particle_steps as f64 / seconds, "");
    println!(
        "done: t = {} in {} steps, {}; {particle_rate} particle-steps/s",
        quantity(summary.clock.time, unit),
        summary.clock.step,
        duration(summary.elapsed),
    );
    let mut stages = summary.stages.clone();
    let inside: f64 = stages.iter().map(|stage| stage.1).sum();
    stages.push(("outputs and the rest", (seconds - inside).max(0.0)));
    for (stage, spent) in stages {
        println!("  {:5.1}%  {spent:8.2} s  {stage}", 100.0 * spent / seconds);
    }
    if let Some(part) = summary.energy_remainder {
        println!(
            "energy: {} to errors, of the largest other term (`numerical dissipation` in history/balance.csv)",
            taken(part)
        );
    } else if summary.energy_scale > 0.0 {
        let relative = summary.closure / summary.energy_scale;
        println!("energy: all but {relative:.1e} of the largest term is accounted for");
    }
    let (files, bytes) = directory.contents();
    println!("{}: {files} files, {} bytes", directory.root().display(), quantity(bytes as f64, ""));
}
