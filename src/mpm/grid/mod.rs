//! The background grid: velocity fields on a uniform lattice, and what happens at its ends.
//!
//! ```text
//! u_{−k} = u_k mirrored,  or  (1 + k θ) u_0 − k θ u_1               ghosts beyond walls (`ghost`, theory A.3)
//! m_I ≤ m_cut:  f_J ← f_J + f_I m_J / Σ_K m_K,  f_I ← 0            nodes of small mass (`small_mass`, theory A.4)
//! ```
//!
//! Node (0, …) lies at the origin, nodes are h apart, and the domain spans nodes 0..=cells. Kernels wider than linear
//! and mirrored walls use ghost nodes outside. The files build on each other in this order: `field` (nodes), `blocks`
//! (the sparse grid), `stencil` (the nodes around a point with their weights), `ghost`, `small_mass`;
//! `tile`, the private copy of a block's surroundings that transfers work on.

mod blocks;
mod field;
pub mod ghost;
pub mod small_mass;
pub mod stencil;
#[cfg(test)]
pub(in crate::mpm) mod testing;
pub(in crate::mpm) mod tile;

pub use blocks::{EDGE, Grid};
pub use field::{Fold, GhostFractions, MassCutoffs, Node, NodeMotion, SmallMassNode, VelocityField};
pub use ghost::Ghosts;
