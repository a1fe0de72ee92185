//! Periodic references, moved in time to the phase of a run.
//!
//! Phases of an oscillation that sets in by itself are arbitrary. A reference that rises through its middle at t_r is
//! shown later by t − t_r, with the last time t at which the run rises through the middle of its last oscillation.

/// Reference of the phase: a signal of the run, and when the same signal of the reference rises.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseReference {
    /// The history of the signal: name of its file without extension.
    pub history: String,
    /// The column, without unit.
    pub column: String,
    /// The signal of the reference: points (t, y) of one period or more, in units of the history.
    pub signal: Vec<[f64; 2]>,
}

impl PhaseReference {
    /// Time by which the reference is moved for `run` to be in phase with it at its end [s]; `None` if either doesn't
    /// rise through its middle.
    pub fn shift(&self, run: &[[f64; 2]]) -> Option<f64> {
        let length = self.signal.last()?[0] - self.signal.first()?[0];
        let end = run.last()?[0];
        let last: Vec<[f64; 2]> = run.iter().filter(|point| point[0] >= end - length).copied().collect();
        Some(last_rise(&last)? - last_rise(&self.signal)?)
    }
}

/// The last time at which points (t, y) rise through the middle of their extremes.
fn last_rise(points: &[[f64; 2]]) -> Option<f64> {
    let extremes =
        points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| [low.min(p[1]), high.max(p[1])]);
    let middle = 0.5 * (extremes[0] + extremes[1]);
    let rise = points.windows(2).rfind(|pair| pair[0][1] < middle && pair[1][1] >= middle)?;
    let [[t0, y0], [t1, y1]] = [rise[0], rise[1]];
    Some(t0 + (middle - y0) / (y1 - y0) * (t1 - t0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::plot::CurveShape;
    use std::f64::consts::TAU;

    /// 1 + a sin(2π(t − t₀)/0.2) every 2 ms.
    fn swing(count: u32, start: f64, amplitude: f64) -> Vec<[f64; 2]> {
        let at = |n: u32| {
            let t = f64::from(n) * 2e-3;
            [t, 1.0 + amplitude * (TAU * (t - start) / 0.2).sin()]
        };
        (0..count).map(at).collect()
    }

    /// A run that has risen last at 1.83 s, beside a reference that rises at 0.05 and 0.25 s; that the run has swung
    /// farther before doesn't matter.
    #[test]
    fn a_reference_is_moved_by_the_difference_of_phases() {
        let phase = PhaseReference { history: "tip".into(), column: "y".into(), signal: swing(150, 0.05, 1.0) };
        let mut run = swing(1000, 0.03, 1.1);
        run[100][1] = 40.0;
        let shift = phase.shift(&run).unwrap();
        assert!((shift - (1.83 - 0.25)).abs() < 1e-4, "{shift}");
        let moved = CurveShape::Points(phase.signal.clone()).later(shift);
        assert_eq!(moved.begin(), Some(shift));
    }

    #[test]
    fn a_steady_signal_has_no_phase() {
        let phase = PhaseReference { history: "tip".into(), column: "y".into(), signal: swing(150, 0.05, 1.0) };
        assert_eq!(phase.shift(&[[0.0, 1.0], [1.0, 1.0]]), None);
        assert_eq!(phase.shift(&[]), None);
    }
}
