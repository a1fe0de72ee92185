//! The subcommands: each reads its options, calls the library, and prints.

pub mod new;
pub mod progress;
pub mod signals;

use lateen::Error;

/// Why a command ends with another code than 0.
pub enum Failure {
    /// An error of the library.
    Error(Error),
    /// A comparison failed (the table says which).
    Comparison,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}
