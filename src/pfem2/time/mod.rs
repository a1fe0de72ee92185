//! The length of steps (theory H.1 to H.8).
//!
//! ```text
//! vibration      vibrations of solids, weak ones of which shorten no step                   theory H.5
//! step_control   automatic steps from estimated errors                                      theory H.1–H.5
//! step_bounds    bounds of the step by waves and by the flow                                theory H.6–H.8
//! ```

pub(super) mod step_bounds;
pub(super) mod step_control;
pub(super) mod vibration;
