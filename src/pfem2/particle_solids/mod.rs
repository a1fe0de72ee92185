//! Solids on particles, as the paper has them (Becker, Idelsohn & Oñate 2015; theory K.1 to K.6): particles carry
//! deviator and pressure of a rate law, and the velocity and pressure of the fixed mesh are those of fluid and solid in
//! one system.
//!
//! ```text
//! 1 turn     σ'_p ← Q σ'_p Qᵀ with the spin of vⁿ                          Becker (16), theory (K.3)
//! 2 gather   p̂_i, â_i at the nodes, means of σ'_p in the elements          theory (K.4), (K.5)
//! 3 solve    (2M/Δt + Δt K) v − Dᵀp = M (2v̂/Δt + â) + F − ∫Bᵀσ̂',           Becker (22)–(27), theory (K.8)
//!            D v + M_p (p − p̂)/κΔt = 0
//!            in cut elements M/Δt, and a pressure on each side             Becker (29)–(33), theory (K.11)
//! 4 update   σ'_p ← σ'_p + 2μΔt d',  p_p ← p_p + Σ N_i (p_i − p̂_i),        Becker (15), (40), theory (K.2)
//!            a_p = δv_p/Δt
//! ```
//!
//! `solid` has what is better: solids on meshes of their own (theory J.1). This is the preset of the paper, to compare
//! with.
//!
//! ```text
//! setup        a solid as a run starts with it
//! columns      what its particles carry
//! strain_rate  the rate of strain of an element
//! averages     sums over the particles of an element, and averages at the nodes
//! element      the equations of an element that holds solid
//! solids       all of them in the system: equations, recovery, forces
//! sums         how the sums and averages are taken
//! stress       the rate law on the particles
//! ```
//!
//! The stages of a step are in `tracking/particle_solids.rs`.

pub mod averages;
pub mod columns;
pub mod element;
pub mod setup;
pub mod solids;
pub mod strain_rate;
pub mod stress;
pub mod sums;
