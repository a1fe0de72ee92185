//! Wall time per stage of a step.

use std::time::Duration;

/// Wall time per stage, in the order in which the stages first ran.
#[derive(Debug, Clone, Default)]
pub struct Timer {
    stages: Vec<(&'static str, Duration)>,
}

impl Timer {
    /// Adds time to a stage.
    pub fn add(&mut self, stage: &'static str, elapsed: Duration) {
        match self.stages.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, total)) => *total += elapsed,
            None => self.stages.push((stage, elapsed)),
        }
    }

    /// Seconds per stage.
    pub fn seconds(&self) -> Vec<(&'static str, f64)> {
        self.stages.iter().map(|(stage, total)| (*stage, total.as_secs_f64())).collect()
    }
}

/// Adds the wall time of an expression to a stage of a [`Timer`](crate::simulation::Timer):
/// `timed!(self.timer, "p2g", p2g(body, kernel, field))`. A macro, so that it borrows nothing while
/// the expression runs.
#[macro_export]
macro_rules! timed {
    ($timer:expr, $stage:literal, $work:expr) => {{
        let start = std::time::Instant::now();
        let result = $work;
        $timer.add($stage, start.elapsed());
        result
    }};
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_keep_their_order_and_add_up() {
        let mut timer = Timer::default();
        timer.add("p2g", Duration::from_millis(250));
        timer.add("g2p", Duration::from_millis(500));
        timer.add("p2g", Duration::from_millis(250));
        assert_eq!(timer.seconds(), [("p2g", 0.5), ("g2p", 0.5)]);
    }

    #[test]
    fn timing_returns_what_the_work_returns() {
        let mut timer = Timer::default();
        assert_eq!(timed!(timer, "sum", 1 + 2), 3);
        assert_eq!(timer.seconds().len(), 1);
    }
}
