//! The particle finite element method, second generation (PFEM-2), for several fluids, and elastic and rigid solids in
//! them, on a fixed mesh of simplices (Becker, Idelsohn & Oñate 2015; theory F, G and H; solids J and K).
//!
//! ```text
//! particles carry   x_p, v_p, phase; of solids on particles σ'_p, p_p, a_p
//! 1 predict         u* of solids on meshes, at whose surface the fixed mesh is cut   theory J.1, J.2
//!                   σ'_p ← Q σ'_p Qᵀ of solids on particles                         Becker (16), theory (K.3)
//! 2 convect         x_p ← x_p + ∫ v(x_p) dt along the frozen streamlines of the mesh   Becker (34)–(36), theory F.4
//! 3 reseed, project   v̂_i, fluid fractions, level set φ_i at the nodes              Becker (37)–(39), theory G.2, G.11
//! 4 solve           velocity and pressure, implicitly and linearly,                 Becker (17)–(20), theory F.6
//!                   with cut elements and with the solids                           Becker (29)–(33), theory G.8, J.4
//! 5 update          u, v, a of solids on meshes                                     theory J.1
//!                   σ'_p, p_p, a_p of solids on particles                           Becker (15), theory (K.2), (K.6)
//! 6 correct         v_p ← v_p + Σ N_i (v_i − v̂_i)                                   Becker (40), theory F.11
//! ```
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
pub use setup::Setup;
pub use step::Pfem2;
pub use theta_step::{Scheme, ThetaStep};
