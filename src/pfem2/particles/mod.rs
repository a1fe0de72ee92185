//! The particles: their columns, and the stages of a step that move, add and correct them (Becker (34)–(40);
//! theory F.3, F.4, F.11, G.11, G.12).
//!
//! ```text
//! columns      position, velocity, phase and depth of each particle, sorted by element
//! convect      motion along the streamlines of the mesh                                    Becker (34)–(36)
//! reseed       particles added where there are too few, merged where there are too many    theory G.12
//! project      averages of velocity and fluid at the nodes                                 Becker (37)–(39)
//! correct      the velocity increment of the mesh, given to the particles                  Becker (40)
//! solids       particles that solids overtake                                          theory J.5
//! ```

mod columns;
pub mod convect;
pub mod correct;
pub mod project;
pub mod reseed;
mod solids;

pub use columns::{GONE, Particles, lattice};
pub(in crate::pfem2) use columns::{interpolate, interpolate_nodal};
