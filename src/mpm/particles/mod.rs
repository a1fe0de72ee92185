//! The particles: material points in columns, how they move, and what keeps them in order over many steps.
//!
//! ```text
//! v_p ← (1 − β)(v_p + Δt Σ N_Ip a_I) + β Σ N_Ip v_I⁺,  x_p ← x_p + Δt Σ N_Ip v_I⁺      `motion`    Lian (65, 19)
//! f_p = t A,  or −P a along the normal of the deformed surface                        `traction`  theory A.14
//! x_p ← x_p − α h² ‖ε̇_p‖ Δt ∇c(x_p)                                                   `shifting`  theory A.11
//! V_p ← V_p (p_p / Σ N_Ip p_I)^β                                                      `volumes`   theory A.12
//! ```
//!
//! `body` holds the columns. A fluid on both sides of closed membranes is divided at set-up (`regions`), and `sides`
//! warns of bodies that membranes cut.

mod body;
pub(in crate::mpm) mod motion;
pub(in crate::mpm) mod regions;
pub(in crate::mpm) mod shifting;
pub(in crate::mpm) mod sides;
pub mod traction;
pub(in crate::mpm) mod volumes;

pub(super) use body::in_field;
pub use body::{Body, Part, Particles, Work};
