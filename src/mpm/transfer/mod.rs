//! The transfers, fast: particles sorted by block, tiles, whole records at once.
//!
//! The plain loops of [`plain`] are the specification; these sweeps compute the same sums.
//! A scatter visits the blocks colour by colour (tiles of one colour are disjoint); a gather visits them in
//! any order, since each particle belongs to one block; a relay gathers and scatters in one visit. All give the same bits
//! for any number of threads.

mod bins;
mod frame;
mod gather;
mod group;
mod kernel;
mod parcels;
mod place;
#[cfg(test)]
mod plain;
mod relay;
mod rows;
mod scatter;
mod sort;
mod source;
#[cfg(test)]
mod tests;
mod tile;
mod view;

pub(crate) use bins::Bins;
pub(crate) use gather::{Answer, Chunk, Wanted};
pub(crate) use rows::{CHUNK, Column, Rows};
pub(crate) use source::{Content, mean_pressure};
pub(crate) use tile::{Record, put_acceleration, put_scalar, put_velocity};
pub(crate) use view::View;

use super::grid::Fold;
use super::particles::Body;
use super::{Grid, Kernel};
use crate::math::Vector;

/// What all sweeps of a body over a grid share.
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
    /// How ghosts follow the domain.
    pub folds: [[Fold; 2]; D],
}

impl<'a, const D: usize> Sweep<'a, D> {
    /// A sweep of the particles of a body, in their `bins`.
    pub fn new(grid: &Grid<D>, body: &Body<D>, bins: &'a Bins<D>) -> Self {
        let folds = *grid.folds_in(body.field);
        Self { bins, kernel: body.kernel, origin: grid.origin, cell: grid.cell, cells: grid.cells, folds }
    }
}
