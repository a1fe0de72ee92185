//! Between particles and grid: the sums of every step, as visits that a schedule lists.
//!
//! ```text
//! scatter   m_I = Σ m_p N_Ip,  p_I = Σ m_p v_p N_Ip,  f_I = −Σ V_p σ_p ∇N_Ip + Σ F_p N_Ip      Lian (60, 61; 17, 18)
//! gather    Σ N_Ip a_I,  Σ N_Ip v_I,  L_p = Σ v_I ⊗ ∇N_Ip                                      Lian (65, 19, 62)
//! relay     a gather, operations on the particles, and a scatter, in one sweep
//! ```
//!
//! `visit` is the language of the schedule, `executor` runs it on a body, and two executors compute the sums: `plain`
//! as plain loops, the specification; `tiles`, which runs use, fast: particles sorted by block (`bins`, `sort`), a
//! private copy of the grid per block (`tile`), whole records at once (`scatter_kernel`, `gather_kernel`).
//!
//! A scatter visits the blocks colour by colour (tiles of one colour are disjoint); a gather visits them in
//! any order, since each particle belongs to one block. All give the same bits for any number of threads.

mod bins;
mod column;
mod executor;
mod frame;
mod gather;
mod gather_kernel;
mod group;
mod operations;
mod place;
mod plain;
mod relay;
mod rows;
mod scatter;
mod scatter_kernel;
mod sort;
mod source;
#[cfg(test)]
mod tests;
mod tile;
mod tiles;
mod view;
mod visit;

pub(crate) use bins::Bins;
pub(crate) use column::{CHUNK_LEN, ChunkColumn};
pub(in crate::mpm) use executor::{Executor, Gathering, Nodal, Scattering, Targets, Visitor};
pub(crate) use gather::{Chunk, GatherFields, Reduce};
pub(in crate::mpm) use operations::{OperationParameters, Operations};
pub(in crate::mpm) use plain::Plain;
pub(crate) use rows::Rows;
pub(crate) use source::{ScatterContent, mean_pressure};
pub(crate) use tile::{NodeRecord, put_scalar, put_velocity};
pub(in crate::mpm) use tiles::Tiles;
pub(crate) use view::View;
pub(in crate::mpm) use visit::{MoveBy, Onto, Operation, Positions, Read, Visit};

use super::grid::{Fold, Grid, Kernel};
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
    /// A sweep of the particles of a body.
    pub fn new(grid: &Grid<D>, body: &'a Body<D>) -> Self {
        Self::over(grid, body.field, body.kernel, &body.bins)
    }

    /// A sweep of particles in these bins, of a velocity field, with their kernel.
    pub fn over(grid: &Grid<D>, field: usize, kernel: Kernel, bins: &'a Bins<D>) -> Self {
        let folds = *grid.folds_in(field);
        Self { bins, kernel, origin: grid.origin, cell: grid.cell, cells: grid.cells, folds }
    }
}
