//! The subcommands: each reads its options, calls the library, and prints.

pub mod check;
pub mod new;
pub mod progress;
pub mod run;
pub mod signals;
pub mod verify;

use lateen::case::Source;
use lateen::catalog::EXPECTED_FILE;
use lateen::error::{Diagnostic, Error};
use lateen::parallel;
use lateen::run::Folder;
use lateen::verify::Expected;
use std::io::{IsTerminal, Write};

/// Why a command ends with another code than 0.
pub enum Failure {
    /// An error of the library.
    Error(Error),
    /// A wrong case, with the text that the findings are about.
    Case(Source, Vec<Diagnostic>),
    /// A comparison failed (the table says which).
    Comparison,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

impl Failure {
    /// Prints it and returns the exit code.
    pub fn report(&self) -> u8 {
        match self {
            Self::Comparison => 1,
            Self::Error(error) => {
                // The text of a case error is complete, and an interruption is no error.
                let label = if matches!(error, Error::Case(_) | Error::Interrupted) { "" } else { "error: " };
                say(&format!("{label}{error}"));
                error.exit_code()
            }
            Self::Case(source, findings) => {
                show_findings(source, findings);
                2
            }
        }
    }
}

/// An error, with the text of the case if it is about that.
pub fn located(error: Error, folder: &Folder) -> Failure {
    match error {
        Error::Case(findings) => Failure::Case(folder.source.clone(), findings),
        error => Failure::Error(error),
    }
}

/// The comparisons of a case, if it has any; findings are shown with their places in the file.
pub fn expected(folder: &Folder) -> Result<Option<Expected>, Failure> {
    lateen::verify::expected(folder).map_err(|error| match (error, folder.beside(EXPECTED_FILE)) {
        (Error::Case(findings), Ok(Some(source))) => Failure::Case(source, findings),
        (error, _) => Failure::Error(error),
    })
}

/// Reads `KEY=VALUE`.
pub fn key_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or_else(|| format!("`{text}` is not KEY=VALUE"))?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// More threads than any machine has cores cost memory and nothing else.
const MOST_THREADS: usize = 1024;

/// Reads the number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..=MOST_THREADS) => Ok(count),
        _ => Err(format!("a number from 1 to {MOST_THREADS} is expected; leave it out to use all cores")),
    }
}

/// Computes with this many threads, all cores where not said.
pub fn use_threads(count: Option<usize>) -> Result<(), Failure> {
    parallel::use_threads(count).map_err(|error| Error::io("threads", error).into())
}

/// Prints a line to the standard error. Nobody may read it, the disk behind it may be full, the terminal gone: a
/// message that can't be shown must not stop the command.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Shows findings with the text that they are about, as [`say`] does.
pub fn show_findings(source: &Source, findings: &[Diagnostic]) {
    let mut errors = std::io::stderr();
    let page = source.render(findings, errors.is_terminal());
    let _ = errors.write_all(page.as_bytes());
}

/// A path, name or value as a shell takes it for one word.
pub fn quoted(word: &str) -> String {
    shlex::try_quote(word).map_or_else(|_| word.to_owned(), |quoted| quoted.into_owned())
}

/// Prints to the standard output. Its reader may stop early, as `head` does: that is no failure.
pub fn show(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output", error).into()),
        _ => Ok(()),
    }
}
