//! Checks of a run: what the user is told, and what stops it.
//!
//! ```text
//! health      errors that stop a run
//! notices     notices of a run
//! ```

pub(super) mod health;
pub(super) mod notices;
