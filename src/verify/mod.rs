//! Runs validation cases and compares what they compute with published, analytic or independent values.
//!
//! What a case is compared with stands beside it in `expected.toml` ([`expected`]); measures on histories
//! are in [`series`] and [`measure`].

pub mod expected;
pub mod measure;
pub mod series;

pub use expected::Expected;
pub use measure::Outcome;
pub use series::{Series, Table};
