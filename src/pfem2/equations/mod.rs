//! The equations of velocity and pressure on the mesh: stage `solve` of a step (Becker (17)–(20); theory F.6–F.10).
//!
//! ```text
//! subscale       orthogonal subscales, against which the pressure is stabilised  theory F.7.3
//! viscous        viscous forces at the nodes, for the consistent stabilisation   theory F.7.2
//! slip           pressure on slip facets                                         theory (F.32)
//! outflow        viscous and inertial terms of open facets                       theory (F.34), (F.35)
//! mesh_data      sizes of elements, and their facets on the boundary
//! assemble       rows of the matrix, gathered from the elements around a node
//! contents       what fills each element in a step; cut elements                 theory F.6, G.8
//! prescribed     unknowns that the boundary and solids prescribe
//! physics        the fluids and the choices of a run
//! linear_system  matrix and right-hand side of a step, and their solution        theory F.15, J.4
//! system         the velocity–pressure system of a step: state, stages
//! fill           its stage that fills the elements, and enriches cut ones        theory F.6, G.8
//! beside_solids  the same for elements that solids cut                           theory J.3, G.14
//! stabilise      its stages for subscales                                        theory F.7
//! convergence    the error of a system that was not solved
//! estimates      frequencies of waves and crossing times, for the length of steps
//! ```

pub mod assemble;
mod beside_solids;
pub mod contents;
mod convergence;
pub mod dynamic_subscale;
mod estimates;
mod fill;
mod linear_system;
pub mod mesh_data;
pub mod outflow;
mod physics;
pub mod prescribed;
pub mod slip;
mod stabilise;
pub mod subscale;
pub mod system;
pub mod viscous;
