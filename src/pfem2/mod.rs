//! The particle finite element method, second generation (PFEM-2), for several fluids on a fixed mesh of simplices
//! (Becker, Idelsohn & Oñate 2015; theory F, G and H).
//!
//! ```text
//! particles carry        x_p, v_p, fluid
//! 1 convect              x_p ← x_p + ∫ v(x_p) dt along the frozen streamlines of the mesh      Becker (34)–(36), theory F.4
//! 2 reseed, project      v̂_i, fluid fractions, level set φ_i at the nodes                      Becker (37)–(39), theory G.2, G.11
//! 3 solve                velocity and pressure, implicitly and linearly                       Becker (17)–(20), (29)–(33), theory F.6, G.8
//! 4 correct              v_p ← v_p + Σ N_i (v_i − v̂_i)                                        Becker (40), theory F.11
//! ```

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
mod time;

pub use boundary::Boundary;
pub use report::moments::{ForcedPart, MomentPoint};
pub use report::snapshot::{INTERFACE, MESH};
pub use setup::Setup;
pub use step::Pfem2;
