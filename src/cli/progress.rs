//! Progress of a run: one line that is rewritten on a terminal, plain lines elsewhere.

use super::say;
use indicatif::{ProgressBar, ProgressStyle};
use lateen::error::{Error, Result};
use lateen::simulation::{Event, Observer, Progress};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Interval of plain lines.
const PLAIN_EVERY: Duration = Duration::from_secs(5);

/// Columns of a terminal that nobody has widened.
const COLUMNS: usize = 80;

/// Columns of the bar on a terminal, with the percentage that is done.
const BAR: usize = 17;

/// Columns of the percentage that is done on a plain line.
const PERCENTAGE: usize = 6;

/// The progress display that fits where the output goes.
pub fn display(unit: &'static str) -> Box<dyn Observer> {
    if std::io::stderr().is_terminal() { Box::new(Bar::new(unit)) } else { Box::new(Lines::new(unit)) }
}

/// One line that is drawn anew, with events above it.
struct Bar {
    bar: ProgressBar,
    unit: &'static str,
}

impl Bar {
    fn new(unit: &'static str) -> Self {
        let style = ProgressStyle::with_template("{bar:10} {percent:>3}%  {wide_msg}").expect("the template is valid");
        Self { bar: ProgressBar::new(1000).with_style(style), unit }
    }
}

impl Observer for Bar {
    fn progress(&mut self, progress: &Progress) -> Result<()> {
        self.bar.set_position((1000.0 * progress.fraction()) as u64);
        self.bar.set_message(describe(progress, self.unit, COLUMNS - BAR));
        Ok(())
    }

    fn event(&mut self, event: &Event<'_>, progress: &Progress) -> Result<()> {
        if let Some(text) = announce(event) {
            self.bar.println(text);
        }
        match event {
            Event::Done | Event::Stopped { .. } => self.bar.finish_and_clear(),
            _ => self.progress(progress)?,
        }
        Ok(())
    }
}

/// A plain line every few seconds.
struct Lines {
    unit: &'static str,
    printed: Instant,
}

impl Lines {
    fn new(unit: &'static str) -> Self {
        Self { unit, printed: Instant::now() }
    }
}

impl Observer for Lines {
    fn progress(&mut self, progress: &Progress) -> Result<()> {
        if self.printed.elapsed() >= PLAIN_EVERY {
            self.printed = Instant::now();
            let line = describe(progress, self.unit, COLUMNS - PERCENTAGE);
            say(&format!("{:3.0}%  {line}", 100.0 * progress.fraction()));
        }
        Ok(())
    }

    fn event(&mut self, event: &Event<'_>, _progress: &Progress) -> Result<()> {
        if let Some(text) = announce(event) {
            say(&text);
        }
        Ok(())
    }
}

/// The line of an event; `None` where the progress line says enough.
fn announce(event: &Event<'_>) -> Option<String> {
    match event {
        Event::Started { from: Some(path) } => Some(format!("resumed from {}", path.display())),
        Event::Warning(text) => Some(format!("warning: {text}")),
        Event::Checkpoint(path) => Some(format!("checkpoint {}", path.display())),
        Event::Stopped { error: Error::Interrupted, .. } => Some("interrupted: finished the step".to_owned()),
        _ => None,
    }
}

/// t / t_end, time left, energy drift, step, Δt, speed, that of membranes: what matters most first, and as much of it
/// as `room` columns hold.
fn describe(progress: &Progress, unit: &str, room: usize) -> String {
    let clock = progress.clock;
    let time = format!("{} / {}", quantity(clock.time, unit), quantity(progress.end, unit));
    let drift = || progress.energy_drift.map(|drift| format!("energy {drift:+.1e}"));
    let energy = progress.energy_remainder.map(|part| format!("energy {}", taken(part))).or_else(drift);
    let membranes = progress.substeps_per_second > 0.0;
    let parts = [
        progress.remaining.map(|left| format!("{} left", duration(left))),
        energy,
        Some(format!("step {}", clock.step)),
        Some(format!("dt {}", quantity(clock.dt, unit))),
        Some(format!("{} steps/s", quantity(progress.steps_per_second, ""))),
        membranes.then(|| format!("{} sub-steps/s", quantity(progress.substeps_per_second, ""))),
    ];
    let fitting = parts.into_iter().flatten().try_fold(time, |line, part| {
        let longer = format!("{line}  {part}");
        if longer.chars().count() <= room { Ok(longer) } else { Err(line) }
    });
    fitting.unwrap_or_else(|line| line)
}

/// `3.1% lost`, `0.4% gained`: what errors have done to the energy.
pub fn taken(part: f64) -> String {
    let what = if part < 0.0 { "gained" } else { "lost" };
    let percent = 100.0 * part.abs();
    let digits = if percent >= 9.95 { 0 } else { 1 + usize::from(percent < 0.995) };
    format!("{percent:.digits$}% {what}")
}

/// Three digits with a prefix of the unit: `0.000123 s` reads `123 µs`.
pub fn quantity(value: f64, unit: &str) -> String {
    const PREFIXES: [(f64, &str); 8] =
        [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p")];
    let fits = |&&(size, _): &&(f64, &str)| value.abs() >= 0.9995 * size;
    let gap = if unit.is_empty() { "" } else { " " };
    match PREFIXES.iter().find(fits) {
        Some((size, prefix)) if !unit.is_empty() || *size >= 1.0 => {
            let scaled = value / size;
            let digits = if scaled.abs() >= 99.95 { 0 } else { 1 + usize::from(scaled.abs() < 9.995) };
            let space = if unit.is_empty() && !prefix.is_empty() { " " } else { gap };
            format!("{scaled:.digits$}{space}{prefix}{unit}")
        }
        _ => format!("{value:.3}{gap}{unit}"),
    }
}

/// `1:05` or `2:03:04`.
pub fn duration(time: Duration) -> String {
    let seconds = time.as_secs();
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lateen::simulation::Clock;

    #[test]
    fn quantities_read_well() {
        assert_eq!(quantity(1.23456e-4, "s"), "123 µs");
        assert_eq!(quantity(1.2e-3, "s"), "1.20 ms");
        assert_eq!(quantity(9.9996e-4, "s"), "1.00 ms");
        assert_eq!(quantity(15.34e6, ""), "15.3 M");
        assert_eq!(quantity(345.4, ""), "345");
        assert_eq!(quantity(0.0, "s"), "0.000 s");
        assert_eq!(quantity(0.02, ""), "0.020");
    }

    #[test]
    fn the_line_keeps_to_its_columns_and_drops_what_matters_least() {
        let clock = Clock { time: 0.1234, step: 123_456_789, dt: 1.23e-7 };
        let hours = Some(Duration::from_secs(100 * 3600));
        let progress =
            Progress { clock, end: 0.678, remaining: hours, energy_drift: Some(-1.2e-13), ..Progress::default() };
        for room in [COLUMNS - BAR, COLUMNS - PERCENTAGE] {
            let line = describe(&progress, "s", room);
            assert!(line.starts_with("123 ms / 678 ms  100:00:00 left  energy -1.2e-13"), "{line}");
            assert!(line.chars().count() <= room && !line.contains("steps/s"), "{line}");
        }
        let start = Progress { end: 0.678, ..Progress::default() };
        let line = describe(&start, "s", COLUMNS - PERCENTAGE);
        assert!(line.ends_with("step 0  dt 0.000 s  0.000 steps/s"), "{line}");
        let sheet = Progress { end: 0.678, substeps_per_second: 2345.6, ..Progress::default() };
        let line = describe(&sheet, "s", COLUMNS - PERCENTAGE);
        assert!(line.ends_with("0.000 steps/s  2.35 k sub-steps/s"), "{line}");
    }

    #[test]
    fn the_part_lost_to_errors_reads_well() {
        assert_eq!([taken(0.0312), taken(-0.004), taken(0.85)], ["3.1% lost", "0.40% gained", "85% lost"]);
    }

    /// A ledger that finds the errors as its remainder closes by definition: its closure is not shown.
    #[test]
    fn the_line_shows_what_errors_took() {
        let shown = |energy_remainder| {
            describe(&Progress { energy_drift: Some(8.9e-17), energy_remainder, ..Progress::default() }, "s", COLUMNS)
        };
        assert!(shown(Some(0.11)).contains("energy 11% lost") && !shown(Some(0.11)).contains("e-17"));
        assert!(shown(None).contains("energy +8.9e-17"));
    }

    #[test]
    fn durations_read_well() {
        assert_eq!(duration(Duration::from_secs(65)), "1:05");
        assert_eq!(duration(Duration::from_secs(7384)), "2:03:04");
    }
}
