//! Steps in time: the first one, and how long they may be (theory F.2, H).
//!
//! ```text
//! history        velocities and accelerations of the steps before                            theory F.2, F.5
//! equilibrium    a start with solids at rest under their loads                              theory J.14
//! startup        values that the first step of second order takes from the step before it   theory H.9
//! step_bounds    bounds of the step by waves and by the flow                                theory H.6–H.8
//! step_control   automatic steps from estimated errors                                      theory H.1–H.5
//! ```

pub(super) mod equilibrium;
pub(super) mod history;
pub(super) mod startup;
pub(super) mod step_bounds;
pub(super) mod step_control;
