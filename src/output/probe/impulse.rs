//! Impulses: a value integrated over time within a window, J = ∫ f dt, by the trapezoidal rule over every step.
//!
//! A peak that lasts a step or two has the height that the step gives it; its impulse doesn't depend on that.

use crate::simulation::{Column, OF_OUTPUT};

/// The integral of a probe's values.
#[derive(Debug, Clone)]
pub(super) struct ProbeIntegral {
    /// Beginning and end [s].
    window: [f64; 2],
    /// Name of its column.
    column: String,
    /// The time of the last values [s], the values, their integrals: a column of a checkpoint; empty before the first.
    state: Vec<f64>,
}

impl ProbeIntegral {
    /// The impulse of the probe `name` over a window [s].
    pub fn new(name: &str, window: [f64; 2]) -> Self {
        Self { window, column: format!("{OF_OUTPUT}probe/{name}"), state: Vec::new() }
    }

    /// True if a step from `from` to `to` [s] counts.
    pub fn holds(&self, from: f64, to: f64) -> bool {
        to > self.window[0] && from < self.window[1]
    }

    /// Takes the values at a time [s], which is that before, or later.
    pub fn add(&mut self, time: f64, values: &[f64]) {
        let n = values.len();
        if self.state.len() != 1 + 2 * n {
            // The integral before the first values is unknown if the window had begun.
            let start = if time > self.window[0] { f64::NAN } else { 0.0 };
            self.state = [&[time], values, &vec![start; n]].concat();
            return;
        }
        let [from, to] = [self.state[0], time];
        let [a, b] = [from.max(self.window[0]), to.min(self.window[1])];
        for (k, &end) in values.iter().enumerate() {
            let start = self.state[1 + k];
            let at = |t: f64| start + (end - start) * (t - from) / (to - from);
            if b > a {
                self.state[1 + n + k] += 0.5 * (at(a) + at(b)) * (b - a);
            }
            self.state[1 + k] = end;
        }
        self.state[0] = time;
    }

    /// The integrals so far of `n` values at a time [s].
    pub fn values(&self, time: f64, n: usize) -> Vec<f64> {
        match self.state.get(1 + n..1 + 2 * n) {
            Some(integrals) => integrals.to_vec(),
            None if time > self.window[0] => vec![f64::NAN; n],
            None => vec![0.0; n],
        }
    }

    /// Shows the state to a checkpoint.
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit(&self.column, Column::growing(&mut self.state));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = 2 t over 0.5..2.5, whatever the steps: 6.
    #[test]
    fn a_window_cuts_steps() {
        for steps in [1, 3, 4, 7] {
            let mut impulse = ProbeIntegral::new("p", [0.5, 2.5]);
            for k in 0..=steps {
                let t = 3.0 * f64::from(k) / f64::from(steps);
                impulse.add(t, &[2.0 * t, 1.0]);
            }
            let [ramp, one] = impulse.values(3.0, 2)[..] else { panic!() };
            assert!((ramp - 6.0).abs() < 1e-14 && (one - 2.0).abs() < 1e-14, "{steps}: {ramp} {one}");
        }
    }

    #[test]
    fn an_impulse_that_was_not_seen_has_no_value() {
        let mut impulse = ProbeIntegral::new("p", [0.5, 2.5]);
        assert_eq!(impulse.values(0.0, 1), [0.0]);
        assert!(impulse.values(1.0, 1)[0].is_nan());
        impulse.add(1.0, &[1.0]);
        impulse.add(2.0, &[1.0]);
        assert!(impulse.values(2.0, 1)[0].is_nan());
        assert!(impulse.holds(0.0, 0.6) && impulse.holds(2.4, 3.0));
        assert!(!impulse.holds(0.0, 0.5) && !impulse.holds(2.5, 3.0));
    }
}
