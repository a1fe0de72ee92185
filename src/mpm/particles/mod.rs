//! The particles: material points in columns (`body`), the bodies of each velocity field (`bodies`), how particles
//! move, and checks of their state (`health`).
//!
//! ```text
//! v_p ← (1 − β)(v_p + Δt Σ N_Ip a_I) + β Σ N_Ip v_I⁺,  x_p ← x_p + Δt Σ N_Ip v_I⁺      `motion`   Lian (65, 19)
//! ```

mod bodies;
mod body;
pub(in crate::mpm) mod health;
mod summary;

pub use bodies::Bodies;
pub use body::{Body, Part, Particles, Work};
pub(crate) use summary::Reduce;
pub(in crate::mpm) use summary::Summary;
