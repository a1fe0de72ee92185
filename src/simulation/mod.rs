//! The driver: it knows *when*; a [`Solver`] knows *how*.
//!
//! This module doesn't depend on particles or elements: a solver steps, shows a [`Snapshot`] to the
//! [`Monitor`]s, and lends its [`Column`]s to the checkpoint.

mod checkpoint;
mod clock;
mod column;
mod guard;
mod ledger;
mod progress;
mod run;
mod said_once;
mod snapshot;
mod timer;

pub use checkpoint::{CheckpointStore, Columns};
pub use clock::{Clock, Schedule};
pub use column::{Column, ColumnData, Number, OF_OUTPUT, Record, Size};
pub use guard::{DrivingFormula, Guarded};
pub use ledger::{BalanceTerm, CompensatedSum, Ledger, LedgerSums, TermId, TermKind};
pub use progress::{Event, Observer, Progress, RunSummary};
pub use run::{LEAST_STEPS, Plan, Simulation};
pub use said_once::SaidOnce;
pub use snapshot::{Elements, Field, FieldValues, Filled, PointSet, SIDES_OF_HEXAHEDRON, Snapshot, SurfaceSet};
pub use timer::Timer;

use crate::error::{Result, StepError};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Bound of counts of steps, particles or events: a state beyond it was not left by a run.
pub const MOST_COUNTED: u64 = 1 << 53;

/// One of the two methods, ready to step. The only abstraction over both.
///
/// A mass on a spring, by the symplectic Euler method:
///
/// ```
/// use lateen::error::StepError;
/// use lateen::simulation::{Column, Plan, Simulation, Snapshot, Solver};
/// use std::time::Duration;
///
/// /// x¨ = −ω² x.
/// struct Spring { omega: f64, x: f64, v: f64 }
///
/// impl Solver for Spring {
///     fn stable_dt(&self) -> f64 {
///         0.001 / self.omega
///     }
///     fn step(&mut self, _t: f64, dt: f64) -> Result<(), StepError> {
///         self.v -= self.omega.powi(2) * self.x * dt;
///         self.x += self.v * dt;
///         Ok(())
///     }
///     fn snapshot(&self) -> Snapshot<'_> {
///         Snapshot { amounts: vec![("x".into(), "m", self.x)], ..Snapshot::default() }
///     }
///     fn forces(&self, _visit: &mut dyn FnMut([f64; 3])) {}
///     fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
///         visit("position", Column::scalar(&mut self.x));
///         visit("velocity", Column::scalar(&mut self.v));
///     }
///     fn particle_count(&self) -> usize {
///         1
///     }
/// }
///
/// // Half a period.
/// let plan = Plan { end: std::f64::consts::PI / 2.0, step: None, checkpoint_every: Duration::MAX };
/// let mut simulation = Simulation::new(Box::new(Spring { omega: 2.0, x: 1.0, v: 0.0 }), plan);
/// simulation.run()?;
/// assert!((simulation.solver().snapshot().amounts[0].2 - -1.0).abs() < 1e-5);
/// # Ok::<(), lateen::Error>(())
/// ```
pub trait Solver: Send {
    /// The largest stable step now [s]; infinity when there is no bound.
    fn stable_dt(&self) -> f64;

    /// The step to take where none is fixed [s]: at most the stable one.
    fn recommended_dt(&self) -> f64 {
        self.stable_dt()
    }

    /// The shortest and the longest step that a run up to the time `end` [s] may be expected to take where none is
    /// fixed [s]; `None` where that can't be foreseen.
    fn foreseen_dt(&self, end: f64) -> Option<[f64; 2]> {
        let _ = end;
        Some([self.recommended_dt(); 2])
    }

    /// Largest ratio between a step and the one before, in both directions; at least 1.
    fn largest_change(&self) -> f64 {
        f64::INFINITY
    }

    /// Computes what the constructor of the initial state could not, before the state is shown; `dt` is the step that
    /// follows [s].
    ///
    /// # Errors
    /// There is no such state.
    fn begin(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        let _ = (t, dt);
        Ok(())
    }

    /// Gives the flag that asks a run to stop: once it is true, [`Solver::begin`] returns soon, with a state that
    /// nobody will use.
    fn stop_on(&mut self, flag: Arc<AtomicBool>) {
        let _ = flag;
    }

    /// Advances from `t` to `t + dt` [s].
    ///
    /// # Errors
    /// A [`StepError`] with the place and advice when the state is no longer physical.
    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError>;

    /// The state as outputs see it; time, step and dt are filled in by the time loop.
    fn snapshot(&self) -> Snapshot<'_>;

    /// Shows the forces of the last step [N], its means, in the order of [`Snapshot::forces`], and then the moments [N
    /// m] in that of [`Snapshot::moments`].
    fn forces(&self, visit: &mut dyn FnMut([f64; 3]));

    /// Every array that a checkpoint stores and restores, each with a unique name.
    ///
    /// After a restore (the visitor has replaced the contents) [`Solver::restored`] is called.
    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>));

    /// An inconsistency between columns that were just restored, as a sentence: such a state can't be stepped.
    fn misfit(&self) -> Option<String> {
        None
    }

    /// Rebuilds the data derived from the columns after a restore.
    fn restored(&mut self) {}

    /// Notices for the user about the steps since the last call, in sentences; each is given once in a run, also if it
    /// is resumed.
    fn notices(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Seconds spent per stage since the start, in the order of the step: `(stage, seconds)`.
    fn stage_times(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// Number of particles that a step moves (for rates in progress lines).
    fn particle_count(&self) -> usize;

    /// Elements of all membranes.
    fn element_count(&self) -> usize {
        0
    }

    /// Sub-steps that the membranes take in the next step, of `dt` [s]; 0 without any.
    fn substeps(&self, dt: f64) -> u64 {
        let _ = dt;
        0
    }
}

/// Something that watches a run: a field writer, a probe, a history.
pub trait Monitor {
    /// Times at which this monitor is due: every `interval` seconds from 0, and the end. Steps don't depend on them.
    /// Not a positive number: only the start and the end.
    fn interval(&self) -> f64;

    /// Sees the state at time `snapshot.time`, the end of a step within which it is due, at the time `due` [s].
    ///
    /// # Errors
    /// Input/output errors.
    fn sample(&mut self, snapshot: &Snapshot<'_>, due: f64) -> Result<()>;

    /// True if it has values at every time that it is due at, also between the ends of steps; of several such times in
    /// a step the others see the last.
    fn interpolates(&self) -> bool {
        false
    }

    /// Sees the state at the start of a step, between whose ends it is due; only where it interpolates.
    fn begin_step(&mut self, _snapshot: &Snapshot<'_>) {}

    /// True if it records forces: the means up to the time that it is due at begin anew each time.
    fn records_forces(&self) -> bool {
        false
    }

    /// True if it wants to see the states at both ends of a step from `from` to `to` [s].
    fn follows(&self, _from: f64, _to: f64) -> bool {
        false
    }

    /// Sees the state at an end of a step that it follows; one state may be shown twice.
    fn follow(&mut self, _snapshot: &Snapshot<'_>) {}

    /// Arrays that a checkpoint keeps, with names that begin with [`OF_OUTPUT`].
    fn columns(&mut self, _visit: &mut dyn FnMut(&str, Column<'_>)) {}

    /// The run is over (also after an error): flush files, write plots.
    ///
    /// # Errors
    /// Input/output errors.
    fn finish(&mut self) -> Result<()> {
        Ok(())
    }

    /// Prepares for a resumed run that goes on from `time`: drop all that was written after it.
    ///
    /// # Errors
    /// Input/output errors.
    fn resume(&mut self, time: f64) -> Result<()>;
}
