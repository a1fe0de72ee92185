//! The background grid: velocity fields on a uniform lattice, shape functions, and what happens at its ends.
//!
//! ```text
//! N_I(x) = Π_a N(x_a/h − I_a)                                       shape functions (`kernel`, theory A.2)
//! u_{−k} = u_k mirrored,  or  (1 + k θ) u_0 − k θ u_1               ghosts beyond walls (`ghost`, theory A.3)
//! m_I ≤ m_cut:  f_J ← f_J + f_I m_J / Σ_K m_K,  f_I ← 0            nodes of small mass (`small_mass`, theory A.4)
//! ```
//!
//! Node (0, …) lies at the origin, nodes are h apart, and the domain spans nodes 0..=cells. Kernels wider than linear
//! and mirrored walls use ghost nodes outside. The files build on each other in this order: `field` (nodes), `blocks`
//! (the sparse grid), `kernel` and `stencil` (the nodes around a point with their weights), `ghost`, `small_mass`; `folded_stencil` (the nodes around a
//! point, with walls, for contact and obstacles).

mod blocks;
mod field;
pub mod folded_stencil;
pub mod ghost;
pub mod kernel;
pub mod small_mass;
pub mod stencil;
#[cfg(test)]
pub(in crate::mpm) mod testing;

pub use blocks::{EDGE, Grid};
pub use field::{Fold, GhostShares, MassCutoffs, Node, NodeMotion, SmallMassNode, VelocityField};
pub use ghost::Ghosts;
pub use kernel::Kernel;
