//! Signals of a case, tried out at places and times of the run before it starts.

use super::Assembly;
use crate::case::SignalSpec;
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::simulation::Watched;

/// Where and when a signal is tried out.
pub(super) struct Samples {
    places: Vec<[f64; 3]>,
    times: Vec<f64>,
    /// The signal is the state at the start, and may not vary in time.
    start: bool,
}

/// Most places that a signal is tried at; more are thinned out.
const MOST: usize = 512;

/// Most places that a signal is tried at before every step.
const WATCHED: usize = 8;

impl Samples {
    /// At all of `places` at the start.
    pub(super) fn start<const D: usize>(places: &[Vector<D>]) -> Self {
        Self { places: places.iter().map(|x| x.to3()).collect(), times: vec![0.0], start: true }
    }

    /// At some of `places` from 0 to `end`.
    pub(super) fn over<const D: usize>(places: &[Vector<D>], end: f64) -> Self {
        let stride = places.len().div_ceil(MOST).max(1);
        let mut places: Vec<_> = places.iter().step_by(stride).map(|x| x.to3()).collect();
        if places.is_empty() {
            places.push([0.0; 3]);
        }
        Self { places, times: times(end), start: false }
    }

    /// At `places` from 0 to `end`.
    pub(super) fn at(places: &[[f64; 3]], end: f64) -> Self {
        Self { places: places.to_vec(), times: times(end), start: false }
    }

    /// A few of the places.
    fn some(&self) -> Vec<[f64; 3]> {
        let stride = self.places.len().div_ceil(WATCHED).max(1);
        self.places.iter().step_by(stride).copied().collect()
    }

    /// The first place and time where `signal` is not finite.
    fn undefined(&self, signal: &Signal) -> Option<([f64; 3], f64)> {
        let pairs = self.times.iter().flat_map(|&t| self.places.iter().map(move |&x| (x, t)));
        pairs.into_iter().find(|&(x, t)| !signal.value(x, t).is_finite())
    }
}

fn times(end: f64) -> Vec<f64> {
    (0..=16).map(|i| end * f64::from(i) / 16.0).collect()
}

impl Assembly<'_> {
    /// Builds a signal and tries it out; what is wrong is noted at `key` and gives zero.
    pub(super) fn signal(&mut self, key: &str, spec: &SignalSpec, samples: &Samples) -> Signal {
        let signal = match spec.build(&self.case.source.base) {
            Ok(signal) => signal,
            Err(message) => {
                self.findings.push(Diagnostic::error(key, message));
                return Signal::ZERO;
            }
        };
        if samples.start && !signal.is_steady() {
            let message = "this is the state at the start, and must not depend on the time";
            self.findings.push(Diagnostic::error(key, message).help("take `t` out, or write its value at the start"));
            return Signal::ZERO;
        }
        if let Some(([x, y, z], t)) = samples.undefined(&signal) {
            let value = signal.value([x, y, z], t);
            let message = format!("the formula gives {value} at x = {x}, y = {y}, z = {z}, t = {t}");
            let help = "it divides by zero or leaves the domain of a function there";
            self.findings.push(Diagnostic::error(key, message).help(help));
            return Signal::ZERO;
        }
        if !signal.is_steady() {
            self.watched.push(Watched { key: key.to_owned(), signal: signal.clone(), places: samples.some() });
        }
        signal
    }

    /// Builds one signal per entry.
    pub(super) fn signals<const N: usize>(
        &mut self,
        key: &str,
        specs: &[SignalSpec; N],
        samples: &Samples,
    ) -> [Signal; N] {
        std::array::from_fn(|i| self.signal(&format!("{key}[{i}]"), &specs[i], samples))
    }
}
