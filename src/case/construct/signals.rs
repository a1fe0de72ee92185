//! Signals of a case, tried out at places and times of the run before it starts.

use super::Construction;
use crate::case::SignalSpec;
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::simulation::DrivingFormula;

/// Places and times at which a signal is evaluated as a test.
pub(super) struct TrialPoints {
    places: Vec<[f64; 3]>,
    times: Vec<f64>,
    /// The signal is the state at the start, and may not vary in time.
    start: bool,
    /// The signal acts on a part of the boundary, and need not have a value elsewhere.
    on_boundary: bool,
}

/// Most places that a signal is tried at which depends on the time; more are thinned out.
const MOST_PLACES: usize = 512;

/// Most places that a signal is tried at before every step.
const TRIED_EACH_STEP: usize = 8;

/// A value so many times those on both sides of it is that of a pole, finite by rounding only.
const SPIKE: f64 = 1e5;

/// Distance of trial points to both sides, relative to the size of the region that the signal acts on.
const BESIDE: f64 = 1e-6;

impl TrialPoints {
    /// At all of `places` at the start.
    pub(super) fn start<const D: usize>(places: &[Vector<D>]) -> Self {
        Self { places: places.iter().map(|x| x.to3()).collect(), times: vec![0.0], start: true, on_boundary: false }
    }

    /// At `places` from 0 to `end`; at some of them if the signal depends on the time.
    pub(super) fn over<const D: usize>(places: &[Vector<D>], end: f64) -> Self {
        let mut places: Vec<_> = places.iter().map(|x| x.to3()).collect();
        if places.is_empty() {
            places.push([0.0; 3]);
        }
        Self { places, times: times(end), start: false, on_boundary: false }
    }

    /// At `places` from 0 to `end`.
    pub(super) fn at(places: &[[f64; 3]], end: f64) -> Self {
        Self { places: places.to_vec(), times: times(end), start: false, on_boundary: false }
    }

    /// At the `places` of a part of the boundary from 0 to `end`.
    pub(super) fn on_boundary<const D: usize>(places: impl Iterator<Item = Vector<D>>, end: f64) -> Self {
        Self { places: places.map(|x| x.to3()).collect(), times: times(end), start: false, on_boundary: true }
    }

    /// A few of the places, `most` at most.
    fn some(&self, most: usize) -> impl Iterator<Item = [f64; 3]> + Clone {
        let stride = self.places.len().div_ceil(most).max(1);
        self.places.iter().step_by(stride).copied()
    }

    /// True if `signal` is positive somewhere, some time.
    pub(super) fn has_positive(&self, signal: &Signal) -> bool {
        self.times.iter().any(|&t| self.some(MOST_PLACES).any(|x| signal.value(x, t) > 0.0))
    }

    /// The first place and time where `signal` is not finite, or where a pole is.
    fn undefined(&self, signal: &Signal) -> Option<([f64; 3], f64)> {
        if self.places.is_empty() {
            return None;
        }
        let (times, most) = match signal.is_steady() {
            true => (&self.times[..1], self.places.len()),
            false => (&self.times[..], MOST_PLACES),
        };
        let pairs = || times.iter().flat_map(|&t| self.some(most).map(move |x| (x, t)));
        let infinite = pairs().find(|&(x, t)| !signal.value(x, t).is_finite());
        if infinite.is_some() || signal.is_uniform() {
            return infinite;
        }
        let size = |&(x, t): &([f64; 3], f64)| signal.value(x, t).abs();
        pairs().max_by(|a, b| size(a).total_cmp(&size(b))).filter(|&(x, t)| self.is_pole(signal, x, t))
    }

    /// True if the value at `x` stands out from those beside it along an axis.
    fn is_pole(&self, signal: &Signal, x: [f64; 3], t: f64) -> bool {
        let most = |a: usize| self.places.iter().map(|y| (y[a] - x[a]).abs()).fold(0.0, f64::max);
        let beside = BESIDE * (0..3).map(most).fold(0.0, f64::max);
        let value = |axis: usize, step: f64| {
            let mut y = x;
            y[axis] += step;
            signal.value(y, t).abs()
        };
        let spike = |axis: usize| {
            let largest = value(axis, beside).max(value(axis, -beside));
            largest > 0.0 && value(axis, 0.0) > SPIKE * largest
        };
        beside > 0.0 && (0..3).any(spike)
    }
}

fn times(end: f64) -> Vec<f64> {
    (0..=16).map(|i| end * f64::from(i) / 16.0).collect()
}

impl Construction<'_> {
    /// Builds a signal and evaluates it at the trial points; an error becomes a finding at `key`, and the signal zero.
    pub(super) fn signal(&mut self, key: &str, spec: &SignalSpec, samples: &TrialPoints) -> Signal {
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
            let message = format!("the formula gives {value:e} at x = {x}, y = {y}, z = {z}, t = {t}");
            let help = "it divides by zero or leaves the domain of a function there";
            self.findings.push(Diagnostic::error(key, message).help(help));
            return Signal::ZERO;
        }
        if !(samples.start || signal.is_steady() && signal.is_uniform()) {
            let places = if signal.is_steady() { Vec::new() } else { samples.some(TRIED_EACH_STEP).collect() };
            let (signal, on_boundary) = (signal.clone(), samples.on_boundary);
            self.formulas.push(DrivingFormula { key: key.to_owned(), signal, places, on_boundary });
        }
        signal
    }

    /// Builds one signal per entry.
    pub(super) fn signals<const N: usize>(
        &mut self,
        key: &str,
        specs: &[SignalSpec; N],
        samples: &TrialPoints,
    ) -> [Signal; N] {
        std::array::from_fn(|i| self.signal(&format!("{key}[{i}]"), &specs[i], samples))
    }
}
