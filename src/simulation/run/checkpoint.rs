//! Checkpoints of a run: saved and gone on from.

use super::Simulation;
use super::state::LoopState;
use crate::error::{Error, Result};
use crate::simulation::{Clock, Column, Event, MOST_COUNTED};
use std::path::PathBuf;
use std::time::Instant;

impl Simulation {
    /// Goes on from the newest good checkpoint; `false` if there is none to go on from.
    ///
    /// # Errors
    /// Checkpoints that can't be used; input/output errors.
    pub fn resume(&mut self) -> Result<bool> {
        let Some(path) = self.restore()? else { return Ok(false) };
        self.newest = Some(path);
        for (_, monitor) in &mut self.monitors {
            monitor.resume(self.clock.time)?;
        }
        Ok(true)
    }

    /// The state of the newest good checkpoint; returns which, or `None` if there is none.
    pub(super) fn restore(&mut self) -> Result<Option<PathBuf>> {
        let Self { solver, clock, stored_at_start, impulses, monitors, .. } = self;
        let Some(store) = &mut self.store else { return Ok(None) };
        let restored = store.restore(&mut |visit| {
            LoopState { clock, stored_at_start, impulses }.columns(solver.as_mut(), visit);
            monitors.iter_mut().for_each(|(_, monitor)| monitor.columns(visit));
        })?;
        if let Some(path) = &restored {
            if let Some(misfit) = self.misfit() {
                let message = format!("holds no state of this case: {misfit}; take it away to go on from an older one");
                return Err(Error::Checkpoint { path: path.clone(), message });
            }
            self.solver.restored();
        }
        Ok(restored)
    }

    /// An inconsistency of a state that was read, as a sentence.
    fn misfit(&self) -> Option<String> {
        let Clock { time, dt, step } = self.clock;
        if step > MOST_COUNTED {
            return Some(format!("it says that {step} steps were taken"));
        }
        let possible = |seconds: f64| seconds.is_finite() && seconds >= 0.0;
        if !(possible(time) && possible(dt)) {
            return Some(format!("its time is {time} s, its step {dt} s"));
        }
        self.solver.misfit()
    }

    /// Saves the state as the newest checkpoint.
    ///
    /// # Errors
    /// Input/output errors.
    pub(super) fn save(&mut self) -> Result<()> {
        let Clock { step, time, .. } = self.clock;
        let Self { solver, clock, stored_at_start, impulses, monitors, .. } = self;
        let Some(store) = &mut self.store else { return Ok(()) };
        let visitor = &mut |visit: &mut dyn FnMut(&str, Column<'_>)| {
            LoopState { clock, stored_at_start, impulses }.columns(solver.as_mut(), visit);
            monitors.iter_mut().for_each(|(_, monitor)| monitor.columns(visit));
        };
        let path = store.save(step, time, visitor)?;
        self.saved = Instant::now();
        self.newest = Some(path.clone());
        let progress = self.progress();
        self.tell(&Event::Checkpoint(&path), &progress)
    }
}
