//! The fluid at solids: equations of cut elements, and the linear system of fluid and solids (theory J.3, J.4).
//!
//! | | |
//! |---|---|
//! | `fluid_part`, `element`, `enriched` | the fluid part of a cut element, rows and columns of its unknowns, and what its enriched pressures add |
//! | `assemble` | the equations of a cut element, from these |
//! | `viscous` | viscous forces in a cut element, for the stabilisation |
//! | `trace` | what flows through the surface of elastic solids between cut points |
//! | `walls` | the reaction of walls at which that surface ends |
//! | `openings` | the tractions of openings at which it ends |
//! | `pressure_stiffness` | how the force of the fluid's pressure changes as that surface moves |
//! | `immersed` | all cut elements, with the equations of the solids |
//! | `border`, `near_nodes`, `node_coupling` | the unknowns of the solids in the linear system, and in its preconditioner |
//! | `dilatation` | the gas that gives way to solids in a closed box |
//! | `compliance` | how the nodes of solids yield to the pressure of the fluid, for its preconditioner |

mod assemble;
pub mod border;
mod compliance;
pub mod dilatation;
pub mod element;
mod enriched;
pub mod fluid_part;
pub mod immersed;
mod near_nodes;
mod node_coupling;
mod one_sided;
mod openings;
pub(in crate::pfem2) mod pressure_stiffness;
pub(in crate::pfem2) mod trace;
pub mod viscous;
pub mod walls;
