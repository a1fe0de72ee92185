//! Contact of solids with walls, with each other, and with themselves (theory J.8, J.9, J.11).
//!
//! | | |
//! |---|---|
//! | `places` | places of the nodes in a step, and the areas of those on a surface |
//! | `walls`, `between_solids` | where a solid meets a wall, another solid, or itself |
//! | `force` | the force of one contact |
//! | `unilateral` | which contacts push, found from solutions of the step |
//! | `impulses` | which contacts of rigid solids push with the forces of the last step, and their friction |
//! | `arrivals` | impacts that the next step begins, and the step that resolves them |
//! | `step` | the contacts of a step in its equations; impacts that it doesn't resolve |

mod arrivals;
pub mod between_solids;
pub mod force;
mod impulses;
mod places;
pub(in crate::pfem2) mod step;
#[cfg(test)]
mod thin_strip_tests;
mod unilateral;
pub mod walls;
