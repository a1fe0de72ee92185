//! The state of a run: its ledger, the stable step, and what must hold after each step.
//!
//! ```text
//! Δ(K + U) = Σ gains − Σ losses + closure        `energy`     theory A.17
//! Δt ≤ safety · min_p h / (c_p + |v_p|)          `stability`  Lian (21), theory A.15
//! ```
//!
//! `health` stops a run that has gone wrong; `notices` says what a user should hear of while it goes on.

pub(in crate::mpm) mod energy;
pub(in crate::mpm) mod health;
pub(in crate::mpm) mod notices;
pub(in crate::mpm) mod stability;
