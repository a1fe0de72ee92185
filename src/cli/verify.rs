//! `lateen verify`: the validation cases against their references.

use super::{Failure, located, say, show, signals, use_threads};
use lateen::catalog;
use lateen::error::{Diagnostic, Error};
use lateen::run::Folder;
use lateen::verify::{self, Expected, Level, Outcome};
use std::path::{Path, PathBuf};

/// Options of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Part of the names of built-in cases, or a case of your own with an expected.toml [default: all]
    pattern: Option<String>,
    /// Run at the resolution of the papers
    #[arg(long)]
    full: bool,
    /// Folder of the runs
    #[arg(long, value_name = "DIR", default_value = "runs/verify")]
    out: PathBuf,
    /// Number of threads [default: all cores]; results don't depend on it
    #[arg(long, value_name = "N", value_parser = super::threads)]
    threads: Option<usize>,
}

/// Numbers of comparisons.
#[derive(Default)]
struct Count {
    compared: usize,
    failed: usize,
}

/// Runs the cases and prints their tables.
pub fn verify(arguments: &Arguments) -> Result<(), Failure> {
    use_threads(arguments.threads)?;
    let level = if arguments.full { Level::Full } else { Level::Quick };
    let stop = signals::stop_flag()?;
    let (mut count, mut left_out) = (Count::default(), 0);
    let cases = chosen(arguments.pattern.as_deref())?;
    for (n, (name, folder)) in cases.iter().enumerate() {
        let expected = something_expected(folder)?;
        if expected.effort(level).skip {
            show(&format!("{name}\nleft out    takes {}; `--full` runs it\n\n", expected.measured.time))?;
            left_out += 1;
            continue;
        }
        for (run, expected) in expected.runs(name, level) {
            say(&format!("{} of {}: {run}", n + 1, cases.len()));
            let directory = arguments.out.join(&run);
            count.add(&run, folder, verify::verify(folder, &expected, level, &directory, &stop))?;
        }
    }
    if count.compared == 0 {
        return Err(nothing_compared());
    }
    let without = if left_out > 0 { format!("; {left_out} of {} cases left out", cases.len()) } else { String::new() };
    show(&format!("{} of {} comparisons hold{without}\n", count.compared - count.failed, count.compared))?;
    if count.failed > 0 { Err(Failure::Comparison) } else { Ok(()) }
}

impl Count {
    /// Prints and counts the comparisons of a run.
    fn add(&mut self, run: &str, folder: &Folder, outcomes: lateen::Result<Vec<Outcome>>) -> Result<(), Failure> {
        match outcomes {
            // A run that breaks down is a comparison that failed: the other cases still tell something.
            Err(Error::Step(error)) => {
                (self.compared, self.failed) = (self.compared + 1, self.failed + 1);
                show(&format!("{run}\nFAILED  {error}\n\n"))?;
            }
            Err(error) => return Err(located(error, folder)),
            Ok(outcomes) => {
                self.compared += outcomes.len();
                self.failed += outcomes.iter().filter(|outcome| !outcome.passed()).count();
                show(&format!("{}\n", verify::render(run, &outcomes)))?;
            }
        }
        Ok(())
    }
}

/// All cases are left out at this level.
fn nothing_compared() -> Failure {
    let finding =
        Diagnostic::error("", "nothing was compared: what was chosen takes long and runs with `--full` alone");
    Error::case(finding.help("add `--full`, or choose other cases; `lateen cases` shows what each takes")).into()
}

/// The comparisons of the case.
fn something_expected(folder: &Folder) -> Result<Expected, Failure> {
    let expected = super::expected(folder)?.unwrap_or_default();
    if !expected.compares_nothing() {
        return Ok(expected);
    }
    let message = format!("there is nothing to compare `{}` with", folder.source.name);
    let help = format!(
        "write comparisons, `[[check]]` or `[[profile]]`, into `{}` beside it; the guide lists their keys under \
         \"Comparisons of your own\", and `lateen new CASE DIR` copies those of a built-in case",
        catalog::EXPECTED_FILE
    );
    Err(Error::case(Diagnostic::error("", message).help(help)).into())
}

/// The built-in cases whose names contain the pattern, or the case that the pattern is a path of.
fn chosen(pattern: Option<&str>) -> Result<Vec<(String, Folder)>, Failure> {
    let pattern = pattern.unwrap_or_default();
    if !pattern.is_empty() && Path::new(pattern).exists() {
        let folder = Folder::open(pattern)?;
        let name = folder.read(&[]).map_err(|error| located(error, &folder))?.file.name;
        return Ok(vec![(name, folder)]);
    }
    let matching = catalog::all().into_iter().filter(|case| case.name().contains(pattern));
    let cases: Vec<_> = matching.map(|case| (case.name().to_owned(), Folder::built_in(case))).collect();
    if cases.is_empty() { Err(catalog::unknown(pattern).into()) } else { Ok(cases) }
}
