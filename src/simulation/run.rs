//! The only time loop (theory H.10).
//!
//! ```text
//! while t < t_end:
//!     Δt ← the stable (or fixed) step
//!     step; show the state to the monitors that were due within it; checkpoint when the wall clock says so
//! ```
//!
//! A checkpoint holds the columns of the solver and of the loop: a resumed run takes the same steps, bit for bit.

mod checkpoint;
mod errors;
mod impulse;
mod recover;
mod state;
mod summary;

use self::impulse::Impulses;
use super::progress::Throughput;
use super::{
    CheckpointStore, Clock, Event, Monitor, Observer, Progress, RunSummary, Schedule, Snapshot, Solver, Timer,
};
use crate::error::{Diagnostic, Error, Result, StepError};
use crate::timed;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Steps of a run at least, where they aren't fixed: nothing may bound those of fluids at rest, or of membranes alone,
/// which take steps of their own.
pub const LEAST_STEPS: f64 = 500.0;

/// The end of a run, its steps, and the interval of its checkpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Time at which the run ends [s].
    pub end: f64,
    /// Fixed step [s]; `None`: the stable one.
    pub step: Option<f64>,
    /// Wall time between two checkpoints.
    pub checkpoint_every: Duration,
}

/// A solver on its way through time, with everything that watches it.
///
/// ```
/// use lateen::case::{Case, Source};
/// use lateen::output::Checkpoints;
/// use lateen::simulation::{Plan, Simulation};
/// use std::time::Duration;
///
/// let text = r#"
///     name = "a falling block"
///     dimension = 2
///     time = { end = "10 ms" }
///     grid = { cell = "0.1 m", lower = [0, 0], upper = [1, 1] }
///     mpm = { gravity = [0, "-10 m/s^2"] }
///     [[body]]
///     name = "block"
///     region = { shape = "box", lower = [0.4, 0.4], upper = [0.6, 0.6] }
///     spacing = "0.05 m"
///     material = { law = "hypoelastic", density = "1000 kg/m^3", young = "10 kPa", poisson = 0.3 }
/// "#;
/// let case = Case::read(Source::new("case.toml", "", text), &[])?;
/// let directory = tempfile::tempdir().unwrap();
/// let simulation = |end: f64| {
///     let plan = Plan { end, step: None, checkpoint_every: Duration::MAX };
///     let mut simulation = Simulation::new(case.build()?, plan);
///     simulation.keep_checkpoints(Box::new(Checkpoints::new(directory.path(), case.hash())));
///     Ok::<_, lateen::Error>(simulation)
/// };
/// // Half of the fall, and the other half from its checkpoint.
/// simulation(0.005)?.run()?;
/// let mut resumed = simulation(0.01)?;
/// assert!(resumed.resume()?);
/// assert_eq!(resumed.clock().time, 0.005);
/// resumed.run()?;
/// // The leap-frog has velocities in the middle of steps: v = −g (t − ½ Δt).
/// let (clock, snapshot) = (resumed.clock(), resumed.solver().snapshot());
/// let fallen = -10.0 * (clock.time - 0.5 * clock.dt);
/// let velocity = snapshot.points[0].fields.iter().find(|field| field.name == "velocity").unwrap();
/// assert!(velocity.values().chunks(3).all(|v| (v[1] - fallen).abs() < 1e-12));
/// # Ok::<(), lateen::Error>(())
/// ```
pub struct Simulation {
    solver: Box<dyn Solver>,
    plan: Plan,
    clock: Clock,
    stored_at_start: f64,
    energy_drift: Option<f64>,
    energy_remainder: Option<f64>,
    /// Impulses of the forces since they were last recorded.
    impulses: Impulses,
    monitors: Vec<(Schedule, Box<dyn Monitor>)>,
    observers: Vec<Box<dyn Observer>>,
    store: Option<Box<dyn CheckpointStore>>,
    /// Time that monitors and checkpoints took.
    timer: Timer,
    newest: Option<PathBuf>,
    stop: Arc<AtomicBool>,
    /// True after a step that failed: the solver stands somewhere within it.
    broken: bool,
    throughput: Throughput,
    saved: Instant,
    steps: u64,
    particle_steps: u64,
    substeps: u64,
    element_steps: u64,
}

impl Simulation {
    /// A run that starts at t = 0.
    pub fn new(solver: Box<dyn Solver>, plan: Plan) -> Self {
        let ledger = solver.snapshot().ledger;
        Self {
            stored_at_start: ledger.stored(),
            solver,
            plan,
            clock: Clock::default(),
            energy_drift: None,
            energy_remainder: None,
            impulses: Impulses::default(),
            monitors: Vec::new(),
            observers: Vec::new(),
            store: None,
            timer: Timer::default(),
            newest: None,
            stop: Arc::default(),
            broken: false,
            throughput: Throughput::new(Clock::default()),
            saved: Instant::now(),
            steps: 0,
            particle_steps: 0,
            substeps: 0,
            element_steps: 0,
        }
    }

    /// Adds a monitor, which sees the state at its intervals.
    pub fn add_monitor(&mut self, monitor: Box<dyn Monitor>) {
        self.monitors.push((Schedule::every(monitor.interval()), monitor));
    }

    /// Adds something that follows the run.
    pub fn follow(&mut self, observer: Box<dyn Observer>) {
        self.observers.push(observer);
    }

    /// Keeps checkpoints in `store`.
    pub fn keep_checkpoints(&mut self, store: Box<dyn CheckpointStore>) {
        self.store = Some(store);
    }

    /// Stops after the step in which `flag` becomes true, or soon where a state at the start is looked for.
    pub fn stop_on(&mut self, flag: Arc<AtomicBool>) {
        self.solver.stop_on(Arc::clone(&flag));
        self.stop = flag;
    }

    /// Time and steps so far.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// The solver, to look at.
    pub fn solver(&self) -> &dyn Solver {
        self.solver.as_ref()
    }

    /// Runs to the end.
    ///
    /// Monitors finish their files and a checkpoint of the last good state is written whatever happens.
    ///
    /// # Errors
    /// A step that failed, input/output errors, or [`Error::Interrupted`].
    pub fn run(&mut self) -> Result<RunSummary> {
        let outcome = self.begin().and_then(|()| self.march());
        let outcome = match outcome {
            Ok(()) => timed!(self.timer, "checkpoints", self.save()),
            Err(error @ Error::Io { .. }) => {
                // The state is good: worth a try, though the disk that failed may be the same one.
                let _ = self.save();
                Err(error)
            }
            Err(error @ Error::Step(_)) => {
                // Why the step failed is what the user needs to know, whatever comes of saving the state before it.
                let _ = self.save_last_good();
                Err(error)
            }
            failed => failed,
        };
        let finished = self.monitors.iter_mut().map(|(_, monitor)| monitor.finish()).fold(Ok(()), Result::and);
        let outcome = outcome.and(finished);
        let progress = self.progress();
        match &outcome {
            Ok(()) => self.tell(&Event::Done, &progress)?,
            Err(error) => {
                let (checkpoint, summary) = (self.newest.clone(), self.summary());
                // The run has failed already: what an observer adds to that is not the cause.
                let _ = self
                    .tell(&Event::Stopped { error, checkpoint: checkpoint.as_deref(), summary: &summary }, &progress);
            }
        }
        outcome.map(|()| self.summary())
    }

    /// Takes one step, shows it to the monitors that are due, and saves it when it is time to.
    ///
    /// # Errors
    /// A step that failed, or input/output errors.
    pub fn step(&mut self) -> Result<()> {
        self.advance()?;
        self.steps += 1;
        self.particle_steps += self.solver.particle_count() as u64;
        if self.saved.elapsed() >= self.plan.checkpoint_every {
            timed!(self.timer, "checkpoints", self.save())?;
        }
        Ok(())
    }

    /// The length of the next step [s].
    fn next_dt(&self) -> Result<f64, StepError> {
        Ok(self.clock.next_dt(self.plan.end, self.bound()?, self.solver.largest_change()))
    }

    /// One step, and what outputs show of it.
    fn advance(&mut self) -> Result<()> {
        let dt = self.next_dt()?;
        if self.clock.time + dt <= self.clock.time {
            return Err(self.collapsed(dt).into());
        }
        let step = self.clock.step + 1;
        let span = [self.clock.time, self.clock.time + dt];
        self.show_followed(span);
        self.show_start(span);
        self.broken = true;
        let substeps = self.solver.substeps(dt);
        self.solver.step(self.clock.time, dt).map_err(|error| StepError { step, ..error })?;
        self.broken = false;
        self.clock.advance(dt, self.plan.end);
        self.substeps += substeps;
        self.element_steps += substeps * self.solver.element_count() as u64;
        self.impulses.add(self.solver.as_ref(), dt);
        self.show_followed(span);
        let (notices, progress) = (self.solver.notices(), self.progress());
        notices.iter().try_for_each(|text| self.tell(&Event::Warning(text), &progress))?;
        timed!(self.timer, "outputs", self.sample(span[0]))
    }

    fn begin(&mut self) -> Result<()> {
        self.check_fixed_step()?;
        self.throughput = Throughput::new(self.clock);
        self.saved = Instant::now();
        let (from, progress) = (self.newest.clone(), self.progress());
        self.tell(&Event::Started { from: from.as_deref() }, &progress)?;
        let skipped = self.store.as_ref().map_or(Vec::new(), |store| store.skipped().to_vec());
        skipped.iter().try_for_each(|text| self.tell(&Event::Warning(text), &progress))?;
        if from.is_some() {
            return Ok(());
        }
        // A step that can't be told is told of when it is to be taken.
        if let Ok(dt) = self.next_dt() {
            self.broken = true;
            self.solver.begin(self.clock.time, dt)?;
            if self.stop.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            self.broken = false;
            self.stored_at_start = self.solver.snapshot().ledger.stored();
        }
        timed!(self.timer, "outputs", self.show(|_, time| vec![time]))?;
        timed!(self.timer, "checkpoints", self.save())
    }

    fn march(&mut self) -> Result<()> {
        while self.clock.time < self.plan.end {
            if self.stop.load(Ordering::Relaxed) {
                self.save()?;
                return Err(Error::Interrupted);
            }
            self.step()?;
            if self.throughput.tick(self.clock, self.substeps) {
                let progress = self.progress();
                self.observers.iter_mut().try_for_each(|observer| observer.progress(&progress))?;
            }
        }
        Ok(())
    }

    /// The largest step that may be taken now [s].
    fn bound(&self) -> Result<f64, StepError> {
        let stable = self.solver.stable_dt();
        match self.plan.step {
            _ if stable.is_nan() || stable <= 0.0 => Err(self.collapsed(stable)),
            Some(fixed) if fixed > stable => Err(self.unstable(fixed, stable)),
            Some(fixed) => Ok(fixed),
            None => Ok(self.solver.recommended_dt().min(self.plan.end / LEAST_STEPS)),
        }
    }

    fn check_fixed_step(&self) -> Result<()> {
        let stable = self.solver.stable_dt();
        match self.plan.step {
            Some(fixed) if fixed > stable && self.clock.step == 0 => Err(Error::case(
                Diagnostic::error("time.step", format!("{fixed:.4e} s is above the stable step, {stable:.4e} s"))
                    .help("write a smaller step, or leave it out: the program then takes the stable one"),
            )),
            _ => Ok(()),
        }
    }

    /// Shows the state to every monitor that was due in the step that began at `from` [s]: at its times, and at the
    /// end.
    fn sample(&mut self, from: f64) -> Result<()> {
        let end = self.plan.end;
        self.show(|schedule, time| {
            let mut due = schedule.due(from, time);
            if time >= end && !due.last().is_some_and(|&last| schedule.is_same(last, time)) {
                due.push(time);
            }
            due
        })
    }

    /// Shows the state at the start of a step to the monitors that have values within it.
    fn show_start(&mut self, [from, to]: [f64; 2]) {
        let wants = |(schedule, monitor): &(Schedule, Box<dyn Monitor>)| {
            monitor.interpolates() && schedule.is_due_between(from, to)
        };
        if !self.monitors.iter().any(wants) {
            return;
        }
        let snapshot = snapshot(self.solver.as_ref(), self.clock);
        self.monitors
            .iter_mut()
            .filter(|monitor| wants(monitor))
            .for_each(|(_, monitor)| monitor.begin_step(&snapshot));
    }

    /// Shows the state at an end of a step to the monitors that follow it.
    fn show_followed(&mut self, [from, to]: [f64; 2]) {
        if !self.monitors.iter().any(|(_, monitor)| monitor.follows(from, to)) {
            return;
        }
        let snapshot = snapshot(self.solver.as_ref(), self.clock);
        let following = self.monitors.iter_mut().filter(|(_, monitor)| monitor.follows(from, to));
        following.for_each(|(_, monitor)| monitor.follow(&snapshot));
    }

    /// Shows the state to the monitors that are due, from their schedules and the time [s], at the times [s] that `due`
    /// gives.
    fn show(&mut self, due: impl Fn(&Schedule, f64) -> Vec<f64>) -> Result<()> {
        let time = self.clock.time;
        let due: Vec<Vec<f64>> = self.monitors.iter().map(|(schedule, _)| due(schedule, time)).collect();
        if due.iter().all(Vec::is_empty) {
            return Ok(());
        }
        let mut snapshot = snapshot(self.solver.as_ref(), self.clock);
        for ((schedule, monitor), due) in self.monitors.iter_mut().zip(&due) {
            let first = if monitor.interpolates() { 0 } else { due.len().saturating_sub(1) };
            for &due in &due[first..] {
                let rest = if schedule.is_same(due, time) { 0.0 } else { time - due };
                if monitor.records_forces() {
                    self.impulses.average(rest, [&mut snapshot.forces, &mut snapshot.moments]);
                }
                monitor.sample(&snapshot, due)?;
                if monitor.records_forces() {
                    self.impulses.begin_anew(rest);
                }
            }
        }
        let (ledger, start) = (&snapshot.ledger, self.stored_at_start);
        let scale = ledger.scale(start);
        self.energy_remainder = ledger.remainder(start);
        // A closure that is zero by definition says nothing about errors.
        self.energy_drift = (scale > 0.0 && self.energy_remainder.is_none()).then(|| ledger.closure(start) / scale);
        drop(snapshot);
        let progress = self.progress();
        self.tell(&Event::Sampled, &progress)
    }

    fn tell(&mut self, event: &Event<'_>, progress: &Progress) -> Result<()> {
        self.observers.iter_mut().try_for_each(|observer| observer.event(event, progress))
    }

    fn progress(&self) -> Progress {
        let counts = [self.solver.particle_count(), self.solver.element_count()];
        Progress {
            energy_drift: self.energy_drift,
            energy_remainder: self.energy_remainder,
            ..self.throughput.progress(self.clock, self.plan.end, counts)
        }
    }
}

/// The state at a time.
fn snapshot(solver: &dyn Solver, clock: Clock) -> Snapshot<'_> {
    Snapshot { time: clock.time, step: clock.step, dt: clock.dt, ..solver.snapshot() }
}
