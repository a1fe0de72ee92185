//! After a step that failed: the last good state.
//!
//! A failed step leaves the solver somewhere within the step, and a copy of the state before every step would cost
//! more than the step. But a step is a function of the state alone, so the steps since the newest checkpoint,
//! taken once more, give the same bits: the loop goes back to it, repeats them up to the one that failed, saves,
//! shows the state to every monitor, and saves what that leaves behind.

use super::Simulation;
use crate::error::Result;
use crate::simulation::Event;
use std::sync::atomic::Ordering;

impl Simulation {
    /// Saves the state before the step that failed, and shows it to all monitors.
    ///
    /// # Errors
    /// Input/output errors, or a repeated step that failed; an older checkpoint is the newest then.
    pub(super) fn save_last_good(&mut self) -> Result<()> {
        let goal = self.clock.step;
        if self.broken && !self.go_back_to(goal)? {
            return Ok(());
        }
        self.broken = false;
        self.save()?;
        self.show(|schedule, time| if schedule.is_due(time) { vec![] } else { vec![time] })?;
        // Recorded impulses begin anew.
        self.save()
    }

    /// Restores the newest checkpoint and repeats the steps from there; `false` where there is no checkpoint, or
    /// the user has had enough.
    fn go_back_to(&mut self, goal: u64) -> Result<bool> {
        let Some(from) = self.restore()? else { return Ok(false) };
        let text = format!("repeating {} steps to save the state before the one that failed", goal - self.clock.step);
        let progress = self.progress();
        self.tell(&Event::Warning(&text), &progress)?;
        self.newest = Some(from);
        while self.clock.step < goal {
            if self.stop.load(Ordering::Relaxed) {
                return Ok(false);
            }
            self.advance()?;
        }
        Ok(true)
    }
}
