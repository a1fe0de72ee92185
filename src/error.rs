//! Errors: cause, place, and advice.
//!
//! Three kinds, never mixed:
//! * **case errors** ([`Diagnostic`]s): the input is wrong; all are collected, each with its place in the file;
//! * **step errors** ([`StepError`]): the run went wrong; they carry time, place, value and advice;
//! * **input/output errors** ([`Error::Io`], [`Error::Checkpoint`]).
//!
//! Anything else is a bug and panics.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A result of this library.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that a run can fail with.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The case is wrong: every finding, in the order of the file.
    #[error("{}", CaseReport(.0))]
    Case(Vec<Diagnostic>),
    /// The run went wrong numerically.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A file or directory could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A checkpoint that can't be used: torn, corrupted, of another case or version.
    #[error("checkpoint {}: {message}", path.display())]
    Checkpoint {
        /// The checkpoint.
        path: PathBuf,
        /// The problem, and advice.
        message: String,
    },
    /// The run was interrupted by the user; a checkpoint was written.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// An input/output error at `path`.
    pub fn io(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { path: path.as_ref().to_owned(), source }
    }

    /// A single case error.
    pub fn case(diagnostic: Diagnostic) -> Self {
        Self::Case(vec![diagnostic])
    }

    /// The exit code of the command: 2 case, 3 numerical, 4 input/output, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Case(_) => 2,
            Self::Step(_) => 3,
            Self::Io { .. } | Self::Checkpoint { .. } => 4,
            Self::Interrupted => 130,
        }
    }
}

struct CaseReport<'a>(&'a [Diagnostic]);

impl fmt::Display for CaseReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (shown, more) = first(self.0);
        for (i, diagnostic) in shown.into_iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{diagnostic}")?;
        }
        more.map_or(Ok(()), |more| write!(f, "\n{more}"))
    }
}

/// Findings that are shown at most.
const SHOWN: usize = 20;

/// The findings to show, in their order, errors before warnings where there are too many; and how many more there are.
pub fn first(findings: &[Diagnostic]) -> (Vec<&Diagnostic>, Option<String>) {
    let of = |severity: Severity| findings.iter().filter(move |finding| finding.severity == severity);
    if findings.len() <= SHOWN {
        return (findings.iter().collect(), None);
    }
    let shown: Vec<_> = of(Severity::Error).chain(of(Severity::Warning)).take(SHOWN).collect();
    let count = |severity| of(severity).count() - shown.iter().filter(|finding| finding.severity == severity).count();
    let more = match (count(Severity::Error), count(Severity::Warning)) {
        (0, warnings) => format!("… and {warnings} more warnings"),
        (errors, 0) => format!("… and {errors} more errors"),
        (errors, warnings) => format!("… and {errors} more errors, {warnings} warnings"),
    };
    (shown, Some(more))
}

/// Text on its lines, with everything that a terminal would obey, or that turns the direction of writing, escaped.
pub fn escaped(text: &str) -> String {
    let obeyed = |c: &char| {
        *c != '\n'
            && (c.is_control()
                || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'))
    };
    text.chars().map(|c| if obeyed(&c) { c.escape_unicode().to_string() } else { c.to_string() }).collect()
}

/// One finding about the case: the problem, its key, and advice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// The key's path, for example `body[0].material.density`; empty for the whole file.
    pub key: String,
    /// Bytes of the case file to underline, where known.
    pub span: Option<Range<usize>>,
    /// The problem.
    pub message: String,
    /// Advice.
    pub help: Option<String>,
    /// Warnings don't stop a run.
    pub severity: Severity,
}

/// Severity of a [`Diagnostic`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// The case can't be run.
    Error,
    /// The case can be run, but the user should know.
    Warning,
}

impl Diagnostic {
    /// An error at `key` (a path such as `body[0].spacing`).
    pub fn error(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), span: None, message: message.into(), help: None, severity: Severity::Error }
    }

    /// A warning at `key`.
    pub fn warning(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(key, message) }
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds the bytes of the file to underline.
    #[must_use]
    pub fn at(mut self, span: Range<usize>) -> Self {
        self.span = Some(span);
        self
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(f, "{kind}: ")?;
        if !self.key.is_empty() {
            write!(f, "`{}`: ", escaped(&self.key))?;
        }
        f.write_str(&escaped(&self.message))?;
        if let Some(help) = &self.help {
            write!(f, "\n  help: {}", escaped(help))?;
        }
        Ok(())
    }
}

/// A run that went wrong: what, where, when, and what to try.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what} at t = {time:.6e} (step {step}), {place}: {quantity} = {value:.6e}\n  help: {advice}")]
pub struct StepError {
    /// The event, for example "a particle's volume became negative".
    pub what: String,
    /// Time at the start of the failing step [s].
    pub time: f64,
    /// Number of the failing step (filled by the time loop).
    pub step: u64,
    /// Its place.
    pub place: Place,
    /// Name of the offending quantity.
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// Advice.
    pub advice: String,
}

impl StepError {
    /// An error at a place, with the value of a quantity that shows it, and what to try. Time and step are zero: the
    /// step and the time loop fill them in.
    ///
    /// ```
    /// use lateen::error::{Place, StepError};
    ///
    /// let advice = "lower `mpm.safety`";
    /// let error = StepError::new(Place::Everywhere, "the energy is not a number", "energy", f64::NAN, advice);
    /// assert!(error.to_string().contains("everywhere: energy = NaN"));
    /// ```
    pub fn new(
        place: Place,
        what: impl Into<String>,
        quantity: &'static str,
        value: f64,
        advice: impl Into<String>,
    ) -> Self {
        Self { what: what.into(), time: 0.0, step: 0, place, quantity, value, advice: advice.into() }
    }
}

/// A place in the model. Positions are in metres, padded with zeros in 2D.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// A material point.
    Particle {
        /// Name of its body.
        body: String,
        /// Its identity (stable through sorting).
        id: u32,
        /// Position [m].
        position: [f64; 3],
    },
    /// A membrane element or mesh element.
    Element {
        /// Name of the membrane or mesh.
        body: String,
        /// Its index.
        index: usize,
        /// Its centre [m].
        position: [f64; 3],
    },
    /// A node of a membrane or grid.
    Node {
        /// Name of the membrane, mesh or field.
        body: String,
        /// Its index.
        index: usize,
        /// Position [m].
        position: [f64; 3],
    },
    /// A place that is no part of the model.
    Point {
        /// Position [m].
        position: [f64; 3],
    },
    /// The model as a whole.
    Everywhere,
}

impl Place {
    /// Position [m]; `None` for the model as a whole.
    pub fn position(&self) -> Option<[f64; 3]> {
        match self {
            Self::Particle { position, .. }
            | Self::Element { position, .. }
            | Self::Node { position, .. }
            | Self::Point { position } => Some(*position),
            Self::Everywhere => None,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kind, body, index, [x, y, z]) = match self {
            Self::Particle { body, id, position } => ("particle", body, *id as usize, position),
            Self::Element { body, index, position } => ("element", body, *index, position),
            Self::Node { body, index, position } => ("node", body, *index, position),
            Self::Point { position: [x, y, z] } => return write!(f, "at ({x:.6e}, {y:.6e}, {z:.6e})"),
            Self::Everywhere => return f.write_str("everywhere"),
        };
        write!(f, "{kind} {index} of `{body}` at ({x:.6e}, {y:.6e}, {z:.6e})")
    }
}
