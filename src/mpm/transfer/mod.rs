//! Between particles and grid: sums over the particles of a body, or over the nodes around each, block by block.
//!
//! ```text
//! scatter   m_I = Σ m_p N_Ip,  p_I = Σ m_p v_p N_Ip,  f_I = −Σ V_p σ_p ∇N_Ip + Σ F_p N_Ip      Lian (60, 61; 17, 18)
//! gather    Σ N_Ip a_I,  Σ N_Ip v_I,  L_p = Σ v_I ⊗ ∇N_Ip                                      Lian (65, 19, 62)
//! relay     a gather, operations on the particles, and a scatter, in one sweep
//! ```
//!
//! Particles are sorted by block (`bins`); each block has a private copy of the grid (`grid::tile`), and whole records
//! are added and read at once (`scatter_kernel`, `gather_kernel`). `executor` has the same sums as plain loops.
//!
//! A scatter visits the blocks colour by colour (tiles of one colour are disjoint); a gather visits them in
//! any order, since each particle belongs to one block. All give the same bits for any number of threads.

mod column;
mod frame;
mod gather;
mod gather_kernel;
mod group;
mod place;
mod relay;
mod rows;
mod scatter;
mod scatter_kernel;
mod source;
mod view;

pub(crate) use column::{CHUNK_LEN, ChunkColumn};
pub(crate) use gather::{Chunk, GatherFields};
pub(crate) use rows::Rows;
pub(crate) use source::ScatterContent;
pub(crate) use view::{View, mean_pressure};

use super::bins::Bins;
use super::grid::{Fold, Grid};
use super::kernel::Kernel;
use super::particles::Body;
use crate::math::Vector;

/// The body and the grid of a sweep.
#[derive(Clone, Copy)]
pub(crate) struct Sweep<'a, const D: usize> {
    /// The body's blocks.
    pub bins: &'a Bins<D>,
    /// Shape function.
    pub kernel: Kernel,
    /// Position of grid node (0, …) [m].
    pub origin: Vector<D>,
    /// Cell size [m].
    pub cell: f64,
    /// Number of the last node of the domain along each axis.
    pub cells: [i32; D],
    /// The rules of the ghosts.
    pub folds: [[Fold; 2]; D],
}

impl<'a, const D: usize> Sweep<'a, D> {
    /// A sweep of the particles of a body of the velocity field number `field`.
    pub fn new(grid: &Grid<D>, field: usize, body: &'a Body<D>) -> Self {
        Self::over(grid, field, body.kernel, &body.bins)
    }

    /// A sweep of particles in these bins, of a velocity field, with their kernel.
    pub fn over(grid: &Grid<D>, field: usize, kernel: Kernel, bins: &'a Bins<D>) -> Self {
        let folds = *grid.folds_in(field);
        Self { bins, kernel, origin: grid.origin, cell: grid.cell, cells: grid.cells, folds }
    }
}
