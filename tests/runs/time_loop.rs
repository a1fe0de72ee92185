//! The time loop with a solver that is simple enough to check by hand: an oscillator whose stable step varies.

use lateen::error::{Error, Place, Result, StepError};
use lateen::simulation::{
    BalanceTerm, CheckpointStore, Column, Columns, Ledger, Monitor, Plan, Simulation, Snapshot, Solver, TermKind,
};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A mass on a spring (m = k = 1), stepped by the symplectic Euler rule.
struct Oscillator {
    /// Position and velocity.
    state: Vec<f64>,
    /// The force of the last step.
    force: f64,
    fails_at: f64,
    interrupts: Option<(f64, Arc<AtomicBool>)>,
}

impl Oscillator {
    fn new() -> Self {
        Self { state: vec![1.0, 0.0], force: 0.0, fails_at: f64::INFINITY, interrupts: None }
    }
}

impl Solver for Oscillator {
    fn stable_dt(&self) -> f64 {
        0.013 + 0.01 * self.state[0] * self.state[0]
    }

    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        if t + dt > self.fails_at {
            self.state.fill(f64::NAN);
            return Err(StepError {
                what: "the spring broke".into(),
                time: t,
                step: 0,
                place: Place::Everywhere,
                quantity: "length",
                value: 1.0,
                advice: "pull less".into(),
            });
        }
        if let Some((time, flag)) = &self.interrupts {
            flag.store(t + dt >= *time, Ordering::Relaxed);
        }
        self.force = -self.state[0];
        self.state[1] += dt * self.force;
        self.state[0] += dt * self.state[1];
        Ok(())
    }

    fn snapshot(&self) -> Snapshot<'_> {
        let energy = 0.5 * (self.state[0].powi(2) + self.state[1].powi(2));
        let stored = BalanceTerm { name: "energy".into(), unit: "J", kind: TermKind::Stored, value: energy };
        Snapshot {
            dimension: 2,
            ledger: Ledger { terms: vec![stored], ..Ledger::default() },
            forces: vec![("spring".into(), [self.force, 0.0, 0.0])],
            ..Snapshot::default()
        }
    }

    fn forces(&self, visit: &mut dyn FnMut([f64; 3])) {
        visit([self.force, 0.0, 0.0]);
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit("state", Column::new(&mut self.state));
    }

    fn particle_count(&self) -> usize {
        1
    }
}

type Rows = Rc<RefCell<Vec<(f64, f64)>>>;

/// Keeps time and force of every sample.
struct Recorder {
    interval: f64,
    rows: Rows,
    full_after: usize,
}

impl Monitor for Recorder {
    fn interval(&self) -> f64 {
        self.interval
    }

    fn interpolates(&self) -> bool {
        true
    }

    fn sample(&mut self, snapshot: &Snapshot<'_>, due: f64) -> Result<()> {
        if self.rows.borrow().len() >= self.full_after {
            return Err(Error::io("history.csv", std::io::ErrorKind::StorageFull.into()));
        }
        self.rows.borrow_mut().push((due, snapshot.forces[0].1[0]));
        Ok(())
    }

    fn records_forces(&self) -> bool {
        true
    }

    fn resume(&mut self, time: f64) -> Result<()> {
        self.rows.borrow_mut().retain(|row| row.0 <= time);
        Ok(())
    }
}

type Saved = Rc<RefCell<BTreeMap<String, Vec<u8>>>>;

/// Keeps one checkpoint in memory.
struct Memory(Saved);

impl CheckpointStore for Memory {
    fn save(&mut self, _step: u64, _time: f64, columns: &mut Columns<'_>) -> Result<PathBuf> {
        self.0.borrow_mut().clear();
        columns(&mut |name, column| {
            let old = self.0.borrow_mut().insert(name.to_owned(), column.data.bytes().to_vec());
            assert!(old.is_none(), "two columns are named `{name}`");
        });
        Ok("memory".into())
    }

    fn restore(&mut self, columns: &mut Columns<'_>) -> Result<Option<PathBuf>> {
        if self.0.borrow().is_empty() {
            return Ok(None);
        }
        columns(&mut |name, column| assert!(column.data.replace(&self.0.borrow()[name])));
        Ok(Some("memory".into()))
    }
}

const PLAN: Plan = Plan { end: 2.0, step: None, checkpoint_every: Duration::MAX };

fn simulation(solver: Oscillator, plan: Plan, rows: &Rows, saved: &Saved) -> Simulation {
    let mut simulation = Simulation::new(Box::new(solver), plan);
    simulation.add_monitor(Box::new(Recorder { interval: 0.1, rows: rows.clone(), full_after: usize::MAX }));
    simulation.keep_checkpoints(Box::new(Memory(saved.clone())));
    simulation
}

#[test]
fn monitors_are_called_at_the_start_at_multiples_of_their_interval_and_at_the_end() {
    let rows = Rows::default();
    let plan = Plan { end: 1.05, ..PLAN };
    simulation(Oscillator::new(), plan, &rows, &Saved::default()).run().unwrap();
    let times: Vec<f64> = rows.borrow().iter().map(|row| row.0).collect();
    let expected: Vec<f64> = (0..=10).map(|n| f64::from(n) * 0.1).chain([1.05]).collect();
    assert_eq!(times, expected);
}

/// Rows every 0.1 s, twenty of them in a step, or none at all: the state at the end has the same bits.
#[test]
fn outputs_change_no_step() {
    let ends = [0.1, 0.001, 0.37, f64::INFINITY].map(|interval| {
        let (rows, saved) = (Rows::default(), Saved::default());
        let mut run = Simulation::new(Box::new(Oscillator::new()), PLAN);
        run.add_monitor(Box::new(Recorder { interval, rows: rows.clone(), full_after: usize::MAX }));
        run.keep_checkpoints(Box::new(Memory(saved.clone())));
        run.run().unwrap();
        let expected = if interval.is_finite() { (2.0 / interval + 1e-9) as usize + 1 } else { 2 };
        assert!(rows.borrow().len().abs_diff(expected) <= 1, "{} rows of {expected}", rows.borrow().len());
        let state = saved.borrow()["state"].clone();
        (state, saved.borrow()["loop/step"].clone())
    });
    assert!(ends.iter().all(|end| *end == ends[0]));
}

/// The exact solution is cos t. By Newton's second law rows times intervals are changes of the velocity, to rounding.
#[test]
fn forces_are_means_over_the_time_since_the_row_before() {
    let (rows, saved) = (Rows::default(), Saved::default());
    simulation(Oscillator::new(), Plan { end: 1.05, ..PLAN }, &rows, &saved).run().unwrap();
    let rows = rows.borrow();
    for pair in rows.windows(2) {
        let ((t0, _), (t, force)) = (pair[0], pair[1]);
        let exact = (t0.sin() - t.sin()) / (t - t0);
        assert!((force - exact).abs() < 0.01, "{force} from {t0} to {t}, exact {exact}");
    }
    let impulse: f64 = rows.windows(2).map(|pair| pair[1].1 * (pair[1].0 - pair[0].0)).sum();
    let velocity = f64::from_le_bytes(saved.borrow()["state"][8..16].try_into().unwrap());
    assert!((impulse - velocity).abs() < 1e-15, "impulse {impulse}, velocity {velocity}");
}

#[test]
fn an_interrupted_and_resumed_run_is_bit_identical() {
    let (whole, parts, saved) = (Rows::default(), Rows::default(), Saved::default());
    let summary = simulation(Oscillator::new(), PLAN, &whole, &Saved::default()).run().unwrap();

    for stop_at in [0.05, 0.7, 1.333] {
        let flag = Arc::new(AtomicBool::new(false));
        let solver = Oscillator { interrupts: Some((stop_at, flag.clone())), ..Oscillator::new() };
        let mut run = simulation(solver, PLAN, &parts, &saved);
        run.stop_on(flag);
        run.resume().unwrap();
        assert!(matches!(run.run(), Err(Error::Interrupted)));
        assert!(run.clock().time >= stop_at && run.clock().time < stop_at + 0.03);
        // Rows that a killed run wrote after its checkpoint are dropped on resume.
        parts.borrow_mut().push((stop_at + 0.05, 99.0));
    }
    let mut last = simulation(Oscillator::new(), PLAN, &parts, &saved);
    assert!(last.resume().unwrap());
    let resumed = last.run().unwrap();
    assert_eq!(resumed.clock, summary.clock);
    assert_eq!(resumed.closure.to_bits(), summary.closure.to_bits());
    assert_eq!(*parts.borrow(), *whole.borrow());
}

#[test]
fn a_failed_step_has_its_number_and_leaves_the_last_checkpoint() {
    let (rows, saved) = (Rows::default(), Saved::default());
    let solver = Oscillator { fails_at: 0.5, ..Oscillator::new() };
    let plan = Plan { checkpoint_every: Duration::ZERO, ..PLAN };
    let mut run = simulation(solver, plan, &rows, &saved);
    let Err(Error::Step(error)) = run.run() else { panic!("the step must fail") };
    assert_eq!(error.step, run.clock().step + 1);
    assert!(error.time > 0.47 && error.time <= 0.5, "the start of the step that ends after 0.5: {}", error.time);
    let last: Vec<u8> = run.clock().step.to_le_bytes().into();
    assert_eq!(saved.borrow()["loop/step"], last, "the step before the failure is the newest checkpoint");
}

/// The oscillator falls between two outputs, long after its last checkpoint.
#[test]
fn a_failed_run_returns_to_the_state_before_the_failed_step() {
    let (every, once) = (Saved::default(), Saved::default());
    let (rows, fails_at) = (Rows::default(), 0.573);
    let each_step = Plan { checkpoint_every: Duration::ZERO, ..PLAN };
    simulation(Oscillator { fails_at, ..Oscillator::new() }, each_step, &Rows::default(), &every).run().unwrap_err();

    let mut run = simulation(Oscillator { fails_at, ..Oscillator::new() }, PLAN, &rows, &once);
    assert!(matches!(run.run(), Err(Error::Step(_))));
    assert_eq!(*once.borrow(), *every.borrow(), "the same bits as if every step had been saved");
    let last = rows.borrow().last().copied().unwrap();
    assert_eq!(last.0, run.clock().time, "the last good state is shown");
    assert!(last.0 > 0.5 && last.0 <= fails_at);
}

#[test]
fn a_full_disk_stops_the_run_with_an_input_output_error() {
    let saved = Saved::default();
    let mut run = Simulation::new(Box::new(Oscillator::new()), PLAN);
    run.add_monitor(Box::new(Recorder { interval: 0.1, rows: Rows::default(), full_after: 5 }));
    run.keep_checkpoints(Box::new(Memory(saved.clone())));
    let error = run.run().unwrap_err();
    assert_eq!(error.exit_code(), 4);
    assert!(!saved.borrow().is_empty(), "the state was good and is kept");
}

#[test]
fn a_fixed_step_above_the_stable_one_is_a_case_error() {
    let plan = Plan { step: Some(0.5), ..PLAN };
    let error = simulation(Oscillator::new(), plan, &Rows::default(), &Saved::default()).run().unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("time.step"), "{error}");
}

#[test]
fn a_fixed_step_that_becomes_unstable_stops_the_run() {
    let plan = Plan { step: Some(0.02), ..PLAN };
    let error = simulation(Oscillator::new(), plan, &Rows::default(), &Saved::default()).run().unwrap_err();
    assert_eq!(error.exit_code(), 3);
    assert!(error.to_string().contains("lower `time.step`"), "{error}");
}

#[test]
fn a_fixed_step_that_divides_the_end_is_taken_as_it_is() {
    let plan = Plan { end: 1.0, step: Some(0.01), ..PLAN };
    let summary = simulation(Oscillator::new(), plan, &Rows::default(), &Saved::default()).run().unwrap();
    assert_eq!((summary.steps, summary.particle_steps), (100, 100));
}

#[test]
fn a_step_saves_a_checkpoint_only_after_the_interval_of_the_wall_clock() {
    for (checkpoint_every, is_saved) in [(Duration::ZERO, true), (Duration::MAX, false)] {
        let saved = Saved::default();
        let mut run = simulation(Oscillator::new(), Plan { checkpoint_every, ..PLAN }, &Rows::default(), &saved);
        run.step().unwrap();
        assert_eq!(!saved.borrow().is_empty(), is_saved, "{checkpoint_every:?}");
    }
}
