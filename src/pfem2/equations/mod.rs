//! The equations of velocity and pressure on the mesh: stage `solve` of a step (Becker (17)–(20); theory F.6–F.10).
//!
//! ```text
//! element        the blocks and loads of one element                             Becker (17)–(20), theory F.6, F.7
//! subscale       orthogonal subscales, against which the pressure is stabilised  theory F.7.3
//! viscous        viscous forces at the nodes, for the consistent stabilisation   theory F.7.2
//! slip           pressure on slip facets                                         theory (F.32)
//! outflow        viscous and inertial terms of open facets                       theory (F.34), (F.35)
//! shear          the shear rate of an element                                    theory F.8
//! assemble       rows of the matrix, gathered from the elements around a node
//! contents       what fills each element, and the enriched pressures of cut ones theory F.6, G.8
//! beside_solids  what fills the elements that solids cut                         theory J.3, G.14
//! physics        the choices of a run, and the time of a step
//! system         the velocity–pressure system of a step: state, stages
//! linear_system  its matrix and right-hand side, and their solution              theory F.15, J.4
//! convergence    the error of a system that was not solved
//! estimates      frequencies of waves and crossing times, for the length of steps
//! ```

pub mod assemble;
mod beside_solids;
mod contents;
mod convergence;
pub mod dynamic_subscale;
pub mod element;
mod estimates;
mod linear_system;
pub mod outflow;
mod physics;
pub mod shear;
pub mod slip;
pub mod subscale;
pub mod system;
pub mod viscous;
