//! The sums of every step as visits that a schedule lists, and the executors that compute them.
//!
//! `visit` is the language of the schedule, `visitor` runs it on a body, with `operations` on its particles. Two
//! executors compute the sums: `plain` as plain loops, the specification; `tiles`, which runs use, fast (`transfer`).

mod operations;
mod plain;
#[cfg(test)]
mod tests;
mod tiles;
mod visit;
mod visitor;

pub(in crate::mpm) use operations::{OperationParameters, Operations};
pub(in crate::mpm) use plain::Plain;
pub(in crate::mpm) use tiles::Tiles;
pub(in crate::mpm) use visit::{MoveBy, Onto, Operation, Read, Visit};
pub(in crate::mpm) use visitor::{Executor, Gathering, Nodal, Scattering, Targets, Visitor};
