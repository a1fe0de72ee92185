//! The particles: their columns, and the stages of a step that move, add and correct them (Becker (34)–(40);
//! theory F.3, F.4, F.11, G.11, G.12).
//!
//! ```text
//! columns      position, velocity, phase and depth of each particle, sorted by element
//! tracking     the particles of a run with their rules and events
//! transport    the convective part of a step: motion, reseeding, and nodal values that go along
//! convect      motion along the streamlines of the mesh                                    Becker (34)–(36)
//! reseed       particles added where there are too few, merged where there are too many    theory G.12
//! project      averages of velocity and fluid at the nodes                                 Becker (37)–(39)
//! correct      the velocity increment of the mesh, given to the particles                  Becker (40)
//! solids       particles that solids overtake                                          theory J.5
//! unresolved   bound of the velocity of particles relative to the mesh                     theory (F.37)
//! stray        particles of one fluid deep inside the other                                theory G.5
//! ```

mod columns;
pub mod convect;
pub mod correct;
pub mod project;
pub mod reseed;
mod solids;
mod stray;
pub(super) mod tracking;
mod transport;
mod unresolved;

pub use columns::{GONE, Particles, lattice};
pub(in crate::pfem2) use columns::{interpolate, interpolate_nodal};
pub use tracking::Unresolved;
pub(super) use transport::FrozenFlow;
