//! Elastic and rigid solids in the system of velocity and pressure, on Lagrangian meshes of their own (theory J).
//!
//! ```text
//! Δ = θ Δt,   û = uⁿ + Δt (β₁ vⁿ + β₂ vⁿ⁻¹),   v̂ = vⁿ + Δt (β₁ aⁿ + β₂ aⁿ⁻¹),   u* = uⁿ + Δt v*
//! [M/Δ + Δ K(u*)] v = f + M v̂/Δ − F(u*) − K (û − u*) + forces of the fluid
//! uⁿ⁺¹ = û + Δ vⁿ⁺¹,   aⁿ⁺¹ = (vⁿ⁺¹ − v̂)/Δ
//! ```
//!
//! The fluid ends at the surface of the solid: elements of the fixed mesh that it cuts are decomposed, and their cut points
//! move with the solid.

pub mod bodies;
pub mod border;
mod constrained;
pub mod contact;
mod contact_step;
pub mod coupling;
pub mod cut;
mod dilatation;
pub mod element;
mod enclosed;
mod enriched;
pub mod equations;
pub mod equilibrium;
pub mod fluid_part;
pub mod gauss;
pub mod immersed;
mod impulses;
pub mod independent;
mod linearisation;
pub mod mesh;
pub mod modes;
mod near;
mod node_coupling;
pub mod outline;
pub mod pressure;
pub mod rigid;
pub mod setup;
pub mod springs;
mod state;
pub mod stress;
pub mod structure;
mod sums;
pub mod support;
pub mod surface;
pub mod ties;
mod touching;
mod trace;
pub(in crate::pfem2) mod tracking;
mod unilateral;
pub mod walls;
mod wetted;
