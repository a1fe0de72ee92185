//! Runs as a whole: steps and outputs in time, runs that are resumed, and verification.

mod resume;
mod time_loop;
mod verify;
