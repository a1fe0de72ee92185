//! Steps in time: the first one, and how long they may be (theory F.2, H).
//!
//! ```text
//! startup        values that the first step of second order takes from the step before it   theory H.9
//! step_bounds    bounds of the step by waves and by the flow                                theory H.6–H.8
//! step_control   automatic steps from estimated errors                                      theory H.1–H.5
//! ```

mod startup;
mod step_bounds;
pub(super) mod step_control;
