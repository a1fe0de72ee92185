//! Signals: the first of those that end a run asks it to stop after its step, the second stops at once; a file that
//! grows beyond what is allowed is an error of its writer.

use lateen::error::{Error, Result};
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGQUIT, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Exit code of an interrupted run.
const INTERRUPTED: i32 = 130;

/// A flag that becomes true at the first signal; the second ends the program with code 130.
///
/// # Errors
/// When the operating system refuses.
pub fn stop_flag() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in ending() {
        // In this order: the signal that sets the flag doesn't see it set.
        flag::register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&stop))
            .and_then(|_| flag::register(signal, Arc::clone(&stop)))
            .map_err(refused)?;
    }
    // A signal that is handled doesn't end the program: the write that is too long fails with an error.
    #[cfg(unix)]
    flag::register(SIGXFSZ, Arc::default()).map_err(refused)?;
    Ok(stop)
}

fn refused(error: io::Error) -> Error {
    Error::io("signals", error)
}

/// The signals that end a run.
fn ending() -> Vec<i32> {
    let mut signals = vec![SIGINT, SIGTERM];
    #[cfg(unix)]
    signals.push(SIGQUIT);
    #[cfg(unix)]
    if hangup_counts() {
        signals.push(SIGHUP);
    }
    signals
}

/// False where whoever started the program has told it to outlive its terminal, as `nohup` does, or where the system
/// doesn't say (it does on Linux): bit n - 1 of `SigIgn` is set where signal n is ignored.
#[cfg(unix)]
fn hangup_counts() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (SIGHUP - 1) & 1 == 0)
}
