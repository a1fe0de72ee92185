//! The particle finite element method, second generation (PFEM-2), for several fluids, and elastic and rigid solids in
//! them, on a fixed mesh of simplices (Becker, Idelsohn & Oñate 2015; theory F.1, G.1, H.1; solids: J.1, K.1).
//!
//! Particles carry x_p, v_p and their phase; of solids on particles σ'_p, p_p and a_p, too. The stages of a step, in
//! their order, are in `Pfem2::advance` (`step/mod.rs`).
//!
//! | room | what it holds |
//! |---|---|
//! | `theta_step`, `history`, `moments` | the time of a step, the velocities and accelerations of those before, forces and moments over a step |
//! | `fluid`, `boundary` | a fluid as a run starts with it, conditions on the boundary of the mesh |
//! | `element` | the equations of one element |
//! | `cut_element` | elements that an interface cuts: their sides, the enriched pressure, surface tension |
//! | `solid` | solids on meshes of their own: state, cut mesh, coupling with the fluid, contact |
//! | `phases` | the phases, and which of them fill nodes and elements |
//! | `particles` | particles in columns, streamlines, reseeding, projection to the nodes, correction |
//! | `interface` | level set, weights of fractions, what flows in, interfaces as surfaces |
//! | `particle_solids` | solids on particles, as the paper has them |
//! | `equations` | the system of velocity and pressure, stabilisation, and its solution |
//! | `checks` | notices, errors that stop a run |
//! | `tracking` | interfaces, particles and solids of a run, with the stages that change each |
//! | `balance` | energy balance, forces on the boundary |
//! | `time` | length of steps |
//! | `setup` | what a run starts from |
//! | `step` | the step and its stages, the first step, a start in equilibrium |
//! | `report` | the method as the time loop, outputs and checkpoints see it |
//!
//! A room imports those above it in this table, and no other.

mod balance;
pub mod boundary;
mod checks;
pub mod cut_element;
pub mod element;
pub mod equations;
pub mod fluid;
mod history;
pub mod interface;
mod moments;
pub mod particle_solids;
pub mod particles;
pub mod phases;
mod report;
pub mod setup;
pub mod solid;
mod step;
#[cfg(test)]
mod tests;
mod theta_step;
mod time;
pub mod tracking;

pub use boundary::Boundary;
pub use fluid::is_gas;
pub use moments::{ForcedPart, MomentPoint};
pub use report::snapshot::{INTERFACE, MESH};
pub use setup::Setup;
pub use step::Pfem2;
pub use theta_step::{Scheme, ThetaStep};
