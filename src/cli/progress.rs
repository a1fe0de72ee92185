//! What a user sees while a case runs: a line that moves on a terminal, plain lines elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use lateen::error::{Error, Result};
use lateen::simulation::{Event, Observer, Progress};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// How often a plain line is printed.
const PLAIN_EVERY: Duration = Duration::from_secs(5);

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
        let style = ProgressStyle::with_template("{bar:16} {percent:>3}%  {msg}").expect("the template is valid");
        Self { bar: ProgressBar::new(1000).with_style(style), unit }
    }
}

impl Observer for Bar {
    fn progress(&mut self, progress: &Progress) -> Result<()> {
        self.bar.set_position((1000.0 * progress.fraction()) as u64);
        self.bar.set_message(describe(progress, self.unit));
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
            eprintln!("{:3.0}%  {}", 100.0 * progress.fraction(), describe(progress, self.unit));
        }
        Ok(())
    }

    fn event(&mut self, event: &Event<'_>, _progress: &Progress) -> Result<()> {
        if let Some(text) = announce(event) {
            eprintln!("{text}");
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

/// t / t_end, time left, energy drift, step, Δt, speed: what matters most first, where the line is cut.
fn describe(progress: &Progress, unit: &str) -> String {
    let clock = progress.clock;
    let mut line = format!("t {} / {}", quantity(clock.time, unit), quantity(progress.end, unit));
    if let Some(left) = progress.remaining {
        line.push_str(&format!("  {} left", duration(left)));
    }
    if let Some(part) = progress.energy_remainder {
        line.push_str(&format!("  energy {}", taken(part)));
    } else if let Some(drift) = progress.energy_drift {
        line.push_str(&format!("  energy {drift:+.1e}"));
    }
    line.push_str(&format!(
        "  step {}  dt {}  {} steps/s  {} particle-steps/s",
        clock.step,
        quantity(clock.dt, unit),
        quantity(progress.steps_per_second, ""),
        quantity(progress.particle_steps_per_second, ""),
    ));
    line
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
    fn what_errors_take_reads_well() {
        assert_eq!([taken(0.0312), taken(-0.004), taken(0.85)], ["3.1% lost", "0.40% gained", "85% lost"]);
    }

    /// Where the ledger finds what errors took as a remainder, its closure is nothing to show.
    #[test]
    fn the_line_shows_what_errors_took() {
        let shown = |energy_remainder| {
            describe(&Progress { energy_drift: Some(8.9e-17), energy_remainder, ..Progress::default() }, "s")
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
