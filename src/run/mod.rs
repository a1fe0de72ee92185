//! From a case to a directory full of results: what the command line, `verify` and other front ends share.

mod directory;

pub use directory::{Existing, RunDirectory};
