//! The ends of steps, and the times at which outputs are due.
//!
//! Time is the sum of the steps, but it never drifts from the output times: those are integer multiples
//! n·Δt_out, and equal steps land on them exactly. Everything here is a function of the
//! current time and the last step, so a resumed run takes the steps that the uninterrupted one would have taken.
//!
//! Output times of several schedules may lie so close to each other that a tiny step has to follow a long one. Where a
//! solver can't take that, steps shrink towards such times and grow after them: with a ratio ρ, a gap a behind the target and
//! the time r left to it, Δt ≤ ρ Δt_before and Δt ≤ (1 − 1/ρ) r + a, the first of the steps Δt, Δt/ρ, … that still end with ρ a.

/// Times closer than this fraction of an interval are the same time.
const SAME_TIME: f64 = 1e-9;

/// An output that is due this fraction of its interval before the end is the one at the end: `end = "1 s"` with an interval of
/// "0.033333 s" shall not end with a step of ten microseconds, whose pressures would be what the step before left, over its length.
const NEAR_THE_END: f64 = 1e-3;

/// Simulated time, counted in steps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
///
/// ```
/// use lateen::simulation::Clock;
///
/// let mut clock = Clock::default();
/// let target = 1.0;
/// while clock.time < target {
///     clock.advance(clock.next_dt(target, 0.3), target);
/// }
/// assert_eq!((clock.step, clock.dt, clock.time), (4, 0.25, 1.0), "equal steps that land on the target");
/// ```
pub struct Clock {
    /// Time [s].
    pub time: f64,
    /// Steps taken.
    pub step: u64,
    /// The step that led here [s].
    pub dt: f64,
}

impl Clock {
    /// The longest step [s] where none is above `bound` or more than `ratio` times longer or shorter than the one before, on
    /// the way to `target`, behind which comes another one after a time `gap` [s].
    pub fn paced(&self, bound: f64, ratio: f64, target: f64, gap: f64) -> f64 {
        if ratio.is_infinite() {
            return bound;
        }
        let slower = (1.0 - ratio.recip()) * (target - self.time) + gap.min(bound);
        let faster = if self.dt > 0.0 { ratio * self.dt } else { f64::INFINITY };
        bound.min(slower).min(faster)
    }

    /// The next step [s]: at most `bound`, one of equal steps that land on `target`.
    ///
    /// Equal, because a step cut short at every output shakes the explicit membranes once per output interval: the
    /// leap-frog with Δt near its bound then has bands of resonance in which a sheet gains energy without end.
    pub fn next_dt(&self, target: f64, bound: f64) -> f64 {
        let remaining = target - self.time;
        let steps = (remaining / bound * (1.0 - SAME_TIME)).ceil();
        if steps > 1.0 { remaining / steps } else { remaining }
    }

    /// Counts a step of `dt` [s]; a step that reaches `target` ends exactly there.
    pub fn advance(&mut self, dt: f64, target: f64) {
        self.time = if dt == target - self.time { target } else { self.time + dt };
        self.step += 1;
        self.dt = dt;
    }
}

/// The next time that a step has to land on after `time` [s]: the first that a schedule is due at, or `end`.
pub(super) fn next_target(time: f64, end: f64, schedules: impl Iterator<Item = Schedule>) -> f64 {
    schedules.filter_map(|schedule| schedule.before(time, end)).fold(end, f64::min)
}

/// Something that is due at every integer multiple of an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    interval: f64,
}

impl Schedule {
    /// Due every `interval` [s] from 0; never, where the interval is not a positive number.
    pub fn every(interval: f64) -> Self {
        Self { interval: if interval > 0.0 { interval } else { f64::INFINITY } }
    }

    /// The first due time after `time` [s]; infinity if there is none.
    pub fn next(&self, time: f64) -> f64 {
        if self.interval.is_finite() {
            ((time / self.interval + SAME_TIME).floor() + 1.0) * self.interval
        } else {
            f64::INFINITY
        }
    }

    /// The first due time after `time` [s] that is well before `end` [s].
    fn before(&self, time: f64, end: f64) -> Option<f64> {
        let next = self.next(time);
        (end - next > NEAR_THE_END * self.interval.min(end)).then_some(next)
    }

    /// True if `time` [s] is a multiple of the interval.
    pub fn is_due(&self, time: f64) -> bool {
        let count = time / self.interval;
        self.interval.is_finite() && (count - count.round()).abs() <= SAME_TIME
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs to `end` with a constant bound, and returns every time that a schedule was due at.
    fn due_times(interval: f64, bound: f64, end: f64) -> Vec<f64> {
        let (schedule, mut clock, mut due) = (Schedule::every(interval), Clock::default(), vec![]);
        while clock.time < end {
            let target = schedule.next(clock.time).min(end);
            clock.advance(clock.next_dt(target, bound), target);
            assert!(clock.dt > 0.49 * bound.min(interval), "sliver of {} s at {}", clock.dt, clock.time);
            if schedule.is_due(clock.time) {
                due.push(clock.time);
            }
        }
        due
    }

    #[test]
    fn output_times_are_integer_multiples_without_drift() {
        let due = due_times(0.1, 0.037, 1000.0);
        assert_eq!(due.len(), 10_000);
        assert!(due.iter().enumerate().all(|(n, &t)| t == (n + 1) as f64 * 0.1));
    }

    #[test]
    fn the_steps_to_an_output_are_equal() {
        let clock = Clock { time: 1.0, ..Clock::default() };
        assert_eq!(clock.next_dt(2.0, 0.9), 0.5);
        assert_eq!(clock.next_dt(2.0, 1.0), 1.0);
        assert_eq!(clock.next_dt(2.0, 0.4), 1.0 / 3.0);
        assert_eq!(clock.next_dt(2.0, f64::INFINITY), 1.0);
    }

    #[test]
    fn outputs_never_drive_an_oscillator() {
        // Leap-frog of ẍ = −x with Δt at most 1.6 of the 2 that are stable: the amplitude is at most
        // 1/√(1 − ¼ Δt²) = 5/3 of the energy's, whatever the outputs.
        for interval in (0..200).map(|k| 10.0 + 0.1 * f64::from(k)) {
            let (schedule, mut clock, mut x, mut v) = (Schedule::every(interval), Clock::default(), 1.0_f64, 0.0);
            for _ in 0..3000 {
                let target = schedule.next(clock.time);
                clock.advance(clock.next_dt(target, 1.6), target);
                v -= x * clock.dt;
                x += v * clock.dt;
                assert!(x.abs() < 3.0, "|x| = {} with outputs every {interval}", x.abs());
            }
        }
    }

    #[test]
    fn intervals_that_differ_by_rounding_share_one_step() {
        let (fine, coarse) = (Schedule::every(0.002e-3), Schedule::every(0.02e-3));
        let mut clock = Clock::default();
        for _ in 0..10_000 {
            let target = fine.next(clock.time).min(coarse.next(clock.time));
            clock.advance(clock.next_dt(target, 1.0), target);
            assert!(clock.dt > 0.0019e-3);
        }
        assert!(coarse.is_due(clock.time) && fine.is_due(clock.time));
        assert!((clock.time - 0.02).abs() < 1e-15);
    }

    #[test]
    fn an_end_that_is_a_multiple_but_for_rounding_is_reached_in_one_step() {
        let schedule = Schedule::every(0.002e-3);
        let (end, mut clock) = (0.2e-3, Clock::default());
        assert_ne!(100.0 * 0.002e-3, end, "the case that this test is about");
        while clock.time < end {
            let target = next_target(clock.time, end, [schedule].into_iter());
            clock.advance(clock.next_dt(target, 1.0), target);
        }
        assert_eq!((clock.time, clock.step), (end, 100));
        assert!(schedule.is_due(end));
    }

    #[test]
    fn an_output_just_before_the_end_is_the_one_at_the_end() {
        let schedules = [Schedule::every(0.033_333), Schedule::every(0.25)];
        let (mut clock, mut shortest) = (Clock::default(), f64::INFINITY);
        while clock.time < 1.0 {
            let target = next_target(clock.time, 1.0, schedules.into_iter());
            clock.advance(clock.next_dt(target, 0.1), target);
            shortest = shortest.min(clock.dt);
        }
        // 30 × 0.033333 = 0.99999 is left out; 0.25 and 0.233331, 0.5 and 0.499995, 0.75 and 0.733326 are not.
        assert_eq!((clock.time, clock.step), (1.0, 33));
        assert!((shortest - 5e-6).abs() < 1e-12, "{shortest}");
    }

    /// Intervals of 1 and 1.0017: the shortest gap is 0.0017, steps are at most 0.3.
    #[test]
    fn steps_shrink_and_grow_gradually_where_outputs_nearly_meet() {
        let (ratio, schedules) = (1.5, [Schedule::every(1.0), Schedule::every(1.0017)]);
        let (mut clock, mut shortest, mut before) = (Clock::default(), f64::INFINITY, 0.0);
        while clock.time < 20.0 {
            let target = next_target(clock.time, 20.0, schedules.into_iter());
            let gap = next_target(target, 21.0, schedules.into_iter()) - target;
            let bound = clock.paced(0.3, ratio, target, gap);
            clock.advance(clock.next_dt(target, bound), target);
            let change = clock.dt / before;
            // Equal steps to a target may take up to half of the bound.
            assert!(before == 0.0 || (0.5 / ratio..=1.0001 * ratio).contains(&change), "{change} at {}", clock.time);
            (before, shortest) = (clock.dt, f64::min(shortest, clock.dt));
        }
        assert!((shortest / 0.0017 - 1.0).abs() < 1e-9 && clock.step < 1500, "{shortest} {}", clock.step);
    }

    #[test]
    fn no_interval_is_never_due() {
        let never = Schedule::every(0.0);
        assert_eq!(never.next(3.0), f64::INFINITY);
        assert!(!never.is_due(0.0));
    }
}
