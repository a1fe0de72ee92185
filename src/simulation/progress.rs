//! Progress of a run: time reached, speed, its summary at the end, and the observers of its events.

use super::Clock;
use crate::error::{Error, Result};
use std::path::Path;
use std::time::{Duration, Instant};

/// Progress of a run: time reached and speed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Progress {
    /// Time, steps and the last step.
    pub clock: Clock,
    /// Time at which the run ends [s].
    pub end: f64,
    /// Wall time since this process started or resumed the run.
    pub elapsed: Duration,
    /// Steps per second of wall time, lately.
    pub steps_per_second: f64,
    /// Particles moved per second of wall time, lately.
    pub particle_steps_per_second: f64,
    /// Sub-steps of the membranes per second of wall time, lately; 0 without any.
    pub substeps_per_second: f64,
    /// Elements of membranes advanced by a sub-step, per second of wall time, lately.
    pub element_steps_per_second: f64,
    /// Energy that the ledger can't explain, relative to the largest of its terms.
    pub energy_drift: Option<f64>,
    /// Energy that errors have taken, or given if it is below zero, relative to the largest other term, where the
    /// ledger finds it as the remainder of all others.
    pub energy_remainder: Option<f64>,
    /// Estimated wall time to the end.
    pub remaining: Option<Duration>,
}

impl Progress {
    /// The fraction of the run that is done, 0 to 1.
    pub fn fraction(&self) -> f64 {
        if self.end > 0.0 { (self.clock.time / self.end).clamp(0.0, 1.0) } else { 1.0 }
    }
}

/// Summary of a run that has ended.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RunSummary {
    /// Time and steps at the end.
    pub clock: Clock,
    /// Wall time of this process.
    pub elapsed: Duration,
    /// Steps of this process.
    pub steps: u64,
    /// Particles moved, summed over the steps of this process.
    pub particle_steps: u64,
    /// Sub-steps of the membranes in the steps of this process; 0 without any.
    pub substeps: u64,
    /// Elements of membranes advanced, summed over these sub-steps.
    pub element_steps: u64,
    /// Seconds per stage: those of the solver, outputs and checkpoints.
    pub stages: Vec<(&'static str, f64)>,
    /// Energy that the ledger can't explain [J].
    pub closure: f64,
    /// The largest term of the ledger [J], to measure the closure by.
    pub energy_scale: f64,
    /// The part of it that errors have taken, where the ledger finds it as the remainder of all other terms.
    pub energy_remainder: Option<f64>,
}

/// Something that happened in a run.
#[derive(Debug)]
pub enum Event<'a> {
    /// The run starts; or goes on from a checkpoint.
    Started {
        /// The checkpoint, when resumed.
        from: Option<&'a Path>,
    },
    /// Something that the user should know.
    Warning(&'a str),
    /// Outputs saw the state.
    Sampled,
    /// A checkpoint was written.
    Checkpoint(&'a Path),
    /// The run reached its end.
    Done,
    /// The run stopped before its end.
    Stopped {
        /// Why.
        error: &'a Error,
        /// The newest checkpoint that a resumed run goes on from.
        checkpoint: Option<&'a Path>,
        /// Time reached, and wall time per stage.
        summary: &'a RunSummary,
    },
}

/// Something that follows a run: a progress line, a status file, a log.
pub trait Observer {
    /// The run has moved on; called a few times per second.
    ///
    /// # Errors
    /// Input/output errors; they stop the run.
    fn progress(&mut self, progress: &Progress) -> Result<()> {
        let _ = progress;
        Ok(())
    }

    /// Something happened.
    ///
    /// # Errors
    /// Input/output errors; they stop the run.
    fn event(&mut self, event: &Event<'_>, progress: &Progress) -> Result<()>;
}

/// Wall time between two looks at the speed.
const WINDOW: Duration = Duration::from_millis(400);

/// Measures the speed of a run over a sliding window.
#[derive(Debug)]
pub(super) struct Throughput {
    start: Instant,
    mark: Instant,
    mark_clock: Clock,
    mark_substeps: u64,
    steps_per_second: f64,
    substeps_per_second: f64,
    time_per_second: f64,
}

impl Throughput {
    /// Starts the watch at `clock`.
    pub fn new(clock: Clock) -> Self {
        let now = Instant::now();
        Self {
            start: now,
            mark: now,
            mark_clock: clock,
            mark_substeps: 0,
            steps_per_second: 0.0,
            substeps_per_second: 0.0,
            time_per_second: 0.0,
        }
    }

    /// Wall time since the start.
    pub fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Looks at the speed if a window has passed; true then. `substeps`: those of the membranes so far.
    pub fn tick(&mut self, clock: Clock, substeps: u64) -> bool {
        let window = self.mark.elapsed();
        if window < WINDOW {
            return false;
        }
        self.look(clock, substeps, window.as_secs_f64());
        self.mark = Instant::now();
        (self.mark_clock, self.mark_substeps) = (clock, substeps);
        true
    }

    fn look(&mut self, clock: Clock, substeps: u64, seconds: f64) {
        let latest = |old: f64, new: f64| if old == 0.0 { new } else { 0.6 * old + 0.4 * new };
        let steps = (clock.step - self.mark_clock.step) as f64;
        self.steps_per_second = latest(self.steps_per_second, steps / seconds);
        let substeps = (substeps - self.mark_substeps) as f64;
        self.substeps_per_second = latest(self.substeps_per_second, substeps / seconds);
        self.time_per_second = latest(self.time_per_second, (clock.time - self.mark_clock.time) / seconds);
    }

    /// The progress at `clock` of a run that ends at `end` [s], moves `particles` per step and elements of membranes
    /// per sub-step.
    pub fn progress(&self, clock: Clock, end: f64, [particles, elements]: [usize; 2]) -> Progress {
        let seconds_left = (end - clock.time) / self.time_per_second;
        Progress {
            clock,
            end,
            elapsed: self.elapsed(),
            steps_per_second: self.steps_per_second,
            particle_steps_per_second: self.steps_per_second * particles as f64,
            substeps_per_second: self.substeps_per_second,
            element_steps_per_second: self.substeps_per_second * elements as f64,
            remaining: Duration::try_from_secs_f64(seconds_left).ok(),
            ..Progress::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_and_time_left_follow_the_last_window() {
        let mut throughput = Throughput::new(Clock::default());
        let clock = Clock { time: 0.5, step: 50, dt: 0.01 };
        throughput.look(clock, 20_000, 2.0);
        let progress = throughput.progress(clock, 2.0, [1000, 30]);
        assert_eq!([progress.steps_per_second, progress.substeps_per_second], [25.0, 10_000.0]);
        assert_eq!([progress.particle_steps_per_second, progress.element_steps_per_second], [25_000.0, 300_000.0]);
        assert_eq!(progress.remaining, Some(Duration::from_secs(6)));
        assert_eq!(progress.fraction(), 0.25);
    }

    #[test]
    fn nothing_is_known_before_the_first_step() {
        let progress = Throughput::new(Clock::default()).progress(Clock::default(), 1.0, [10, 0]);
        assert_eq!(progress.remaining, None);
        assert_eq!(progress.fraction(), 0.0);
    }
}
