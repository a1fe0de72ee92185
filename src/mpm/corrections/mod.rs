//! Corrections of what the scheme of particles gets wrong over many steps, outside of its equations.
//!
//! ```text
//! x_p ← x_p − α h² ‖ε̇_p‖ Δt ∇c(x_p)         `shifting`   theory A.11
//! V_p ← V_p (p_p / Σ N_Ip p_I)^β            `volumes`    theory A.12
//! ```
//!
//! Both are booked in the ledger, and keep no state.

pub(in crate::mpm) mod shifting;
pub(in crate::mpm) mod volumes;
