//! The state of a run as others see it: ledger, checkpoints, snapshots, and what must hold after each step.
//!
//! ```text
//! Δ(K + U) = Σ gains − Σ losses + closure        `energy`     theory A.17
//! Δt ≤ safety · min_p h / (c_p + |v_p|)          `stability`  Lian (21), theory A.15
//! ```
//!
//! `columns` lists what a checkpoint keeps, `snapshot` what outputs show. `health` stops a run that has gone wrong;
//! `notices` and `proximity` say what a user should hear of while it goes on.

pub(in crate::mpm) mod columns;
pub(in crate::mpm) mod energy;
pub(in crate::mpm) mod health;
pub(in crate::mpm) mod notices;
pub mod proximity;
pub(in crate::mpm) mod snapshot;
pub(in crate::mpm) mod stability;
