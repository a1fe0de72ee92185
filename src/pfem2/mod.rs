//! The particle finite element method, second generation (PFEM-2), for several fluids, and elastic and rigid solids in
//! them, on a fixed mesh of simplices (Becker, Idelsohn & Oñate 2015; theory F, G and H; solids J and K).
//!
//! Particles carry x_p, v_p and their phase; of solids on particles σ'_p, p_p and a_p, too. The stages of a step, in
//! their order, are in `Pfem2::advance` (`step.rs`).
//!
//! | room | what it holds |
//! |---|---|
//! | `particles` | particles in columns, streamlines, reseeding, projection to the nodes, correction |
//! | `interface` | phases, level set, shares of fluids, volumes that are kept, cut elements |
//! | `equations` | elements, stabilisation, the system of velocity and pressure and its solution |
//! | `boundary` | conditions on the boundary of the mesh |
//! | `solid` | solids on meshes of their own: state, cut mesh, coupling with the fluid, contact |
//! | `particle_solids` | solids on particles, as the paper has them |
//! | `time` | history of nodal values, start, length of steps |
//! | `report` | energy balance, forces, snapshots, checkpoints, notices |

pub mod boundary;
pub mod equations;
pub mod interface;
pub mod particle_solids;
pub mod particles;
mod report;
pub mod setup;
pub mod solid;
mod step;
#[cfg(test)]
mod tests;
mod theta_step;
mod time;

pub use boundary::Boundary;
pub use report::moments::{ForcedPart, MomentPoint};
pub use report::snapshot::{INTERFACE, MESH};
pub use setup::{Setup, is_gas};
pub use step::Pfem2;
pub use theta_step::{Scheme, ThetaStep};
