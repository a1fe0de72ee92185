//! The state as outputs, checkpoints and the time loop see it.
//!
//! ```text
//! snapshot    the state as outputs see it
//! filled      fluids as volumes, for outputs                              theory G.7
//! vorticity   the curl of the velocity, for outputs
//! checkpoint  the columns of a checkpoint
//! solver      the method as a solver that the time loop steps
//! ```

pub(super) mod checkpoint;
pub(super) mod filled;
pub(super) mod snapshot;
mod solver;
mod vorticity;
