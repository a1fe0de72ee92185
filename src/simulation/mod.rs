//! The driver: it knows *when*; a [`Solver`] knows *how*.
//!
//! Nothing here knows about particles or elements: a solver steps, shows a [`Snapshot`] to the
//! [`Monitor`]s, and lends its [`Column`]s to the checkpoint.

mod checkpoint;
mod clock;
mod column;
mod guard;
mod progress;
mod run;
mod snapshot;
mod timer;

pub use checkpoint::{CheckpointStore, Columns};
pub use clock::{Clock, Schedule};
pub use column::{Column, ColumnData};
pub use guard::{Guarded, Watched};
pub use progress::{Event, Observer, Progress};
pub use run::{Plan, Simulation, Summary};
pub use snapshot::{
    BalanceTerm, Elements, Field, FieldValues, Filled, Ledger, PointSet, Snapshot, SurfaceSet, TermKind,
};
pub use timer::Timer;

use crate::error::{Result, StepError};

/// One of the two methods, ready to step. The only abstraction over both.
pub trait Solver: Send {
    /// The largest stable step now [s]; infinity when there is no bound.
    fn stable_dt(&self) -> f64;

    /// The step to take where none is fixed [s]: at most the stable one.
    fn recommended_dt(&self) -> f64 {
        self.stable_dt()
    }

    /// How many times longer or shorter than the one before a step may be; at least 1.
    fn largest_change(&self) -> f64 {
        f64::INFINITY
    }

    /// Advances from `t` to `t + dt` [s].
    ///
    /// # Errors
    /// A [`StepError`] with the place and advice when the state is no longer physical.
    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError>;

    /// What outputs may see; time, step and dt are filled in by the time loop.
    fn snapshot(&self) -> Snapshot<'_>;

    /// Shows the forces of the last step [N], its means, in the order of [`Snapshot::forces`].
    fn forces(&self, visit: &mut dyn FnMut([f64; 3]));

    /// Every array that a checkpoint stores and restores, each with a unique name.
    ///
    /// After a restore (the visitor has replaced the contents) [`Solver::restored`] is called.
    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>));

    /// Rebuilds what is derived from the columns after a restore.
    fn restored(&mut self) {}

    /// What the user should know about the steps since the last call, in sentences; each is said once.
    fn notices(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Seconds spent per stage since the start, in the order of the step: `(stage, seconds)`.
    fn stage_times(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// How many particles a step moves (for rates in progress lines).
    fn particle_count(&self) -> usize;
}

/// Something that watches a run: a field writer, a probe, a history.
pub trait Monitor {
    /// Times at which this monitor wants to see the state: every `interval` seconds from 0, and the end.
    /// Not a positive number: only the start and the end.
    fn interval(&self) -> f64;

    /// Sees the state at time `snapshot.time`.
    ///
    /// # Errors
    /// Input/output errors.
    fn sample(&mut self, snapshot: &Snapshot<'_>) -> Result<()>;

    /// True if it records forces: the means that it is shown begin anew each time.
    fn records_forces(&self) -> bool {
        false
    }

    /// The run is over (also after an error): flush files, write plots.
    ///
    /// # Errors
    /// Input/output errors.
    fn finish(&mut self) -> Result<()> {
        Ok(())
    }

    /// Prepares for a resumed run that goes on from `time`: drop what was written after it.
    ///
    /// # Errors
    /// Input/output errors.
    fn resume(&mut self, time: f64) -> Result<()>;
}
