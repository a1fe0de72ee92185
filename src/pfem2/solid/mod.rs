//! Elastic and rigid solids in the system of velocity and pressure, on Lagrangian meshes of their own (theory
//! J.1 to J.4).
//!
//! ```text
//! Δ = θ Δt,   û = uⁿ + Δt (β₁ vⁿ + β₂ vⁿ⁻¹),   v̂ = vⁿ + Δt (β₁ aⁿ + β₂ aⁿ⁻¹),   u* = uⁿ + Δt v*
//! [M/Δ + Δ K(u*)] v = f + M v̂/Δ − F(u*) − K (û − u*) + forces of the fluid
//! uⁿ⁺¹ = û + Δ vⁿ⁺¹,   aⁿ⁺¹ = (vⁿ⁺¹ − v̂)/Δ
//! ```
//!
//! The fluid ends at the surface of the solid: elements of the fixed mesh that it cuts are decomposed, and their cut
//! points move with the solid.
//!
//! | room | what it holds |
//! |---|---|
//! | `mesh` | meshes of solids, their Gauss points, and mass points for closed surfaces |
//! | `structure` | state, prediction, forces and equations of the solids, with supports, loads, bonds and outputs |
//! | `equations` | the linear equations of a step, in the velocities of all nodes and in the independent ones |
//! | `rigid` | rigid solids: rotation, momentum, and the velocities that supports leave them |
//! | `surface` | the surface of the solids in space: nearest places, normals, edges |
//! | `cut` | the mesh of the fluid, cut at that surface |
//! | `coupling` | the equations of the fluid in cut elements, and the linear system of fluid and solids |
//! | `contact` | contact with walls, among solids, and of a solid with itself |
//!
//! `setup` has a solid as a run starts with it, `holding` the forces that hold solids, `step_results` what a step leaves,
//! `energy` the energy of solids in the balance of a run. The solids of a run from step to step are in `tracking` of
//! `pfem2`, which knows all rooms.

pub mod contact;
pub mod coupling;
pub mod cut;
pub(in crate::pfem2) mod energy;
pub mod equations;
pub(in crate::pfem2) mod holding;
pub mod mesh;
pub mod rigid;
pub mod setup;
pub(in crate::pfem2) mod step_results;
pub mod structure;
pub mod surface;

pub use structure::support;
