//! Ctrl-C and SIGTERM: the first asks the run to stop after its step, the second stops at once.

use lateen::error::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
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
    for signal in [SIGINT, SIGTERM] {
        // In this order: the signal that sets the flag doesn't see it set.
        flag::register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&stop))
            .and_then(|_| flag::register(signal, Arc::clone(&stop)))
            .map_err(|error| Error::io("signals", error))?;
    }
    Ok(stop)
}
