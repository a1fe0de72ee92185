//! Blocks of the grid in which the supports of particles that reach given nodes begin.

use crate::math::Vector;
use crate::mpm::wall::folded_stencil::FoldedStencil;
use crate::mpm::{EDGE, Grid};
use crate::parallel;

/// Marked blocks of a grid.
#[derive(Debug, Default)]
pub struct SupportBlocks {
    blocks: Vec<bool>,
}

impl SupportBlocks {
    /// Unmarks all blocks of this grid.
    pub fn clear<const D: usize>(&mut self, grid: &Grid<D>) {
        self.blocks.clear();
        self.blocks.resize(grid.blocks().len(), false);
    }

    /// Marks the blocks in which the support of a particle that reaches `node` may start.
    pub fn mark<const D: usize>(&mut self, grid: &Grid<D>, stencil: &FoldedStencil<D>, node: usize) {
        let ijk = grid.coordinates(node);
        for corner in 0..1 << D {
            let first = std::array::from_fn(|a| ijk[a] - (corner >> a & 1) * (stencil.support() - 1));
            if let Some(start) = grid.find(first) {
                self.blocks[start / Grid::<D>::BLOCK] = true;
            }
        }
    }

    /// Indices of the particles whose support starts in a marked block, ascending.
    pub fn particles<const D: usize>(
        &self,
        grid: &Grid<D>,
        stencil: &FoldedStencil<D>,
        position: &[Vector<D>],
    ) -> Vec<u32> {
        if !self.blocks.contains(&true) {
            return Vec::new();
        }
        let collect = |range: std::ops::Range<usize>| {
            let (mut found, mut last, mut marked) = (Vec::new(), None, false);
            for p in range {
                let first = stencil.first(grid, position[p]);
                let block = first.map(|i| i.div_euclid(EDGE as i32));
                if last != Some(block) {
                    last = Some(block);
                    marked = grid.find(first).is_some_and(|node| self.blocks[node / Grid::<D>::BLOCK]);
                }
                if marked {
                    found.push(p as u32);
                }
            }
            found
        };
        let join = |mut all: Vec<u32>, mut more: Vec<u32>| {
            all.append(&mut more);
            all
        };
        if position.len() <= parallel::CHUNK {
            return collect(0..position.len());
        }
        parallel::reduce(position.len(), collect, join).unwrap_or_default()
    }
}
