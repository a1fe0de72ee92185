//! The ends of steps, and the times at which outputs are due (theory A.15, H.10).
//!
//! Steps follow from the solver and the end of the run alone: outputs don't change them, so that no key of an output
//! changes a result. What is due between two ends of steps is shown at the second, and histories have the values on the
//! straight line between both in their rows. Everything here is a function of the current time and the last step, so a
//! resumed run takes the steps that the uninterrupted one would have taken.
//!
//! Only the last steps are cut, to reach the end: equal ones, so many that none is shorter than the solver can take
//! after the one before. With a ratio ρ between two steps these are ρ/(ρ − 1), and two at least.

/// Times closer than this fraction of an interval are the same time.
const SAME_TIME: f64 = 1e-9;

/// The least number of equal steps at the end.
const LAST: f64 = 2.0;

/// Simulated time, counted in steps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
///
/// ```
/// use lateen::simulation::Clock;
///
/// let mut clock = Clock::default();
/// let mut steps = vec![];
/// while clock.time < 1.0 {
///     clock.advance(clock.next_dt(1.0, 0.3, f64::INFINITY), 1.0);
///     steps.push(clock.dt);
/// }
/// assert_eq!((steps[0], clock.step, clock.time), (0.3, 4, 1.0), "what is left, 0.4, is taken in two equal steps");
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
    /// The next step [s] on the way to `end` [s]: `bound`, or less after a step that was shorter by more than `ratio`,
    /// or one of the last equal ones.
    pub fn next_dt(&self, end: f64, bound: f64, ratio: f64) -> f64 {
        let bound = if self.dt > 0.0 { bound.min(ratio * self.dt) } else { bound };
        let remaining = end - self.time;
        let steps = (remaining / bound * (1.0 - SAME_TIME)).ceil();
        let last = (1.0 - ratio.recip()).recip().max(LAST);
        if remaining / bound > last || (remaining - steps * bound).abs() <= SAME_TIME * bound {
            return bound;
        }
        if steps > 1.0 { remaining / steps } else { remaining }
    }

    /// Counts a step of `dt` [s]; one that reaches `end` ends exactly there. Steps of one length from 0 on end at
    /// multiples of it, without the rounding of a sum: a run that goes on beyond its end takes the steps of a longer
    /// one.
    pub fn advance(&mut self, dt: f64, end: f64) {
        let sum = self.time + dt;
        let multiple = (sum / dt).round() * dt;
        let is = |time: f64| (time - sum).abs() <= SAME_TIME * dt;
        self.time = if is(end) {
            end
        } else if is(multiple) {
            multiple
        } else {
            sum
        };
        self.step += 1;
        self.dt = dt;
    }
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

    /// The due times of a step from `from` to `to` [s], without those at its start. A time is the same as another that
    /// is nearer than a billionth of the interval.
    pub fn due(&self, from: f64, to: f64) -> Vec<f64> {
        let count = |time: f64| (time / self.interval + SAME_TIME).floor();
        if self.interval.is_infinite() {
            return Vec::new();
        }
        // Sums of steps may miss a time by rounding.
        let time = |n: f64| n * self.interval;
        let (first, last) = (count(from) + 1.0, count(to));
        (0..).map(|k| first + f64::from(k)).take_while(|&n| n <= last).map(time).collect()
    }

    /// True if something is due within a step from `from` to `to` [s], between both ends.
    pub fn is_due_between(&self, from: f64, to: f64) -> bool {
        self.due(from, to).first().is_some_and(|&first| !self.is_same(first, to))
    }

    /// True if two times [s] are the same, but for rounding.
    pub fn is_same(&self, a: f64, b: f64) -> bool {
        (a - b).abs() <= SAME_TIME * self.interval
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

    /// The lengths of the steps to `end` under a constant bound.
    fn steps(end: f64, bound: f64, ratio: f64, first: f64) -> Vec<f64> {
        let (mut clock, mut steps) = (Clock::default(), vec![]);
        clock.advance(first, end);
        while clock.time < end {
            clock.advance(clock.next_dt(end, bound, ratio), end);
            steps.push(clock.dt);
        }
        assert_eq!(clock.time, end);
        steps
    }

    #[test]
    fn due_times_are_integer_multiples_without_drift() {
        let (schedule, mut clock, mut due) = (Schedule::every(0.1), Clock::default(), vec![]);
        while clock.time < 1000.0 {
            let from = clock.time;
            clock.advance(clock.next_dt(1000.0, 0.037, f64::INFINITY), 1000.0);
            due.extend(schedule.due(from, clock.time));
        }
        assert_eq!(due.len(), 10_000);
        assert!(due.iter().enumerate().all(|(n, &t)| t == (n + 1) as f64 * 0.1));
    }

    /// A step may hold several due times, or none; one at its start belongs to the step before, one at its end to this,
    /// also where a sum of steps misses it by rounding.
    #[test]
    fn a_step_has_the_due_times_up_to_its_end() {
        let schedule = Schedule::every(0.25);
        assert_eq!(schedule.due(0.25, 0.8), [0.5, 0.75]);
        assert!(schedule.due(0.3, 0.45).is_empty());
        assert_eq!(schedule.due(0.25 - 1e-16, 0.5 - 1e-16), [0.5]);
        assert!(schedule.is_due_between(0.3, 0.8) && schedule.is_due_between(0.3, 0.5 + 1e-6));
        assert!(!schedule.is_due_between(0.25, 0.5 - 1e-16) && !schedule.is_due_between(0.3, 0.4));
    }

    #[test]
    fn steps_are_their_bound_but_for_the_last_ones() {
        let all = steps(2.0, 0.3, f64::INFINITY, 0.2);
        assert_eq!(all[..4], [0.3; 4]);
        assert!(all.len() == 6 && all[4..].iter().all(|dt| (dt - 0.3).abs() < 1e-14), "{all:?}");
        let all = steps(2.0, 0.3, f64::INFINITY, 0.3);
        assert!(all.len() == 6 && all[4..].iter().all(|dt| (dt - 0.25).abs() < 1e-14), "{all:?}");
    }

    /// With a ratio of 1.2 between steps six at the end are equal, so that the first of them isn't too short.
    #[test]
    fn steps_grow_and_end_gradually() {
        let ratio = 1.2;
        for end in (0..50).map(|k| 20.0 + 0.02 * f64::from(k)) {
            let all = steps(end, 0.3, ratio, 0.01);
            let mut before = 0.01;
            for dt in all {
                assert!((1.0 / ratio..=1.000_001 * ratio).contains(&(dt / before)), "{dt} after {before}");
                before = dt;
            }
        }
    }

    #[test]
    fn an_end_that_is_a_multiple_but_for_rounding_needs_no_step_more() {
        let end = 0.2e-3;
        assert_ne!(100.0 * 0.002e-3, end, "the case that this test is about");
        assert_eq!(steps(end, 0.002e-3, f64::INFINITY, 0.002e-3).len(), 99);
        assert_eq!(steps(end, f64::INFINITY, f64::INFINITY, 0.1e-3).len(), 1);
    }

    /// 0.02 is no sum of powers of two: ten times the sum of it is 0.19999999999999998.
    #[test]
    fn steps_of_one_length_have_no_rounding() {
        let run = |end: f64| {
            let mut clock = Clock::default();
            let mut all = vec![];
            while clock.time < end {
                clock.advance(clock.next_dt(end, 0.02, 2.0), end);
                all.push((clock.dt, clock.time));
            }
            all
        };
        let (short, long) = (run(0.2), run(0.4));
        assert_eq!((short.len(), short[9]), (10, (0.02, 0.2)));
        assert_eq!(short, long[..10]);
        assert_eq!(long[19], (0.02, 0.4));
    }

    #[test]
    fn no_interval_is_never_due() {
        let never = Schedule::every(0.0);
        assert!(never.due(0.0, 1e300).is_empty());
        assert!(!never.is_due(0.0) && !never.is_due_between(0.0, 1.0));
    }
}
