//! The sparse blocks of the grid: 4ᴰ nodes each, whose memory follows the material (theory A.1).
//!
//! A node is addressed by its number, slot · 4ᴰ + local, with x running fastest inside a block. All fields share the
//! numbering of the blocks.

use super::field::{Fold, Node, VelocityField};
use crate::math::Vector;
use hashbrown::HashMap;

/// Nodes along a block edge.
pub const EDGE: usize = 4;

/// The background grid with one velocity field per body (or group of bodies).
#[derive(Debug, Clone)]
pub struct Grid<const D: usize> {
    /// Position of node (0, …) [m].
    pub origin: Vector<D>,
    /// Cell size h [m].
    pub cell: f64,
    /// Cells of the domain along each axis.
    pub cells: [i32; D],
    /// The rules of the ghosts beyond both ends of each axis; mirrors until told otherwise.
    pub folds: [[Fold; 2]; D],
    /// The rules of each field, if they are not the same for all (`wall::domain`).
    pub own_folds: Vec<[[Fold; 2]; D]>,
    /// Velocity fields.
    pub fields: Vec<VelocityField<D>>,
    slots: HashMap<[i32; D], u32>,
    blocks: Vec<[i32; D]>,
    corners: Vec<[u32; 8]>,
}

/// The number of an inactive block in the corner table.
const NONE: u32 = u32::MAX;

impl<const D: usize> Grid<D> {
    /// Nodes per block.
    pub const BLOCK: usize = EDGE.pow(D as u32);

    /// An empty grid.
    pub fn new(origin: Vector<D>, cell: f64, cells: [i32; D], fields: usize) -> Self {
        Self {
            origin,
            cell,
            cells,
            folds: [[Fold::Mirror; 2]; D],
            own_folds: Vec::new(),
            fields: vec![VelocityField::default(); fields],
            slots: HashMap::new(),
            blocks: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// The rules of the ghosts of a field.
    pub fn folds_in(&self, field: usize) -> &[[Fold; 2]; D] {
        self.own_folds.get(field).unwrap_or(&self.folds)
    }

    /// Coordinates of the active blocks, in slot order.
    pub fn blocks(&self) -> &[[i32; D]] {
        &self.blocks
    }

    /// Number of active nodes per field.
    pub fn node_count(&self) -> usize {
        self.blocks.len() * Self::BLOCK
    }

    /// The number of the node with integer coordinates `ijk`, if its block is active.
    #[inline]
    pub fn find(&self, ijk: [i32; D]) -> Option<usize> {
        let block = ijk.map(|i| i.div_euclid(EDGE as i32));
        let slot = *self.slots.get(&block)? as usize;
        let mut local = 0;
        for axis in (0..D).rev() {
            local = local * EDGE + ijk[axis].rem_euclid(EDGE as i32) as usize;
        }
        Some(slot * Self::BLOCK + local)
    }

    /// Integer coordinates of a node.
    #[inline]
    pub fn coordinates(&self, node: usize) -> [i32; D] {
        let block = self.blocks[node / Self::BLOCK];
        let mut local = node % Self::BLOCK;
        let mut ijk = [0; D];
        for axis in 0..D {
            ijk[axis] = block[axis] * EDGE as i32 + (local % EDGE) as i32;
            local /= EDGE;
        }
        ijk
    }

    /// Numbers of the active nodes around a node, diagonal ones included.
    pub fn neighbours(&self, node: usize) -> impl Iterator<Item = usize> {
        let ijk = self.coordinates(node);
        let around = (0..3_i32.pow(D as u32))
            .filter_map(move |n| self.find(std::array::from_fn(|a| ijk[a] + n / 3_i32.pow(a as u32) % 3 - 1)));
        around.filter(move |&other| other != node)
    }

    /// Position of a node [m].
    #[inline]
    pub fn position(&self, node: usize) -> Vector<D> {
        let ijk = self.coordinates(node);
        self.origin + Vector::from_fn(|axis| f64::from(ijk[axis])) * self.cell
    }

    /// Numbers of the first nodes of the blocks `block` + {0, 1}ᴰ (bit a of the index: upper along axis a);
    /// `u32::MAX` for inactive ones. `None` if `block` itself is not active.
    #[inline]
    pub fn corners(&self, block: [i32; D]) -> Option<&[u32; 8]> {
        self.slots.get(&block).map(|&slot| &self.corners[slot as usize])
    }

    /// True for nodes of the domain, false for ghosts.
    #[inline]
    pub fn contains(&self, ijk: [i32; D]) -> bool {
        (0..D).all(|axis| (0..=self.cells[axis]).contains(&ijk[axis]))
    }

    /// Upper corner of the domain [m].
    pub fn upper(&self) -> Vector<D> {
        self.origin + Vector::from_fn(|axis| f64::from(self.cells[axis])) * self.cell
    }

    /// Makes exactly these blocks active (sorted, without repetition) and zeroes every field;
    /// `true` if they differ from before, so that node numbers changed.
    pub fn set_blocks(&mut self, blocks: Vec<[i32; D]>) -> bool {
        let changed = blocks != self.blocks;
        if changed {
            self.slots = blocks.iter().enumerate().map(|(slot, &block)| (block, slot as u32)).collect();
            self.blocks = blocks;
            self.corners = self.blocks.iter().map(|&block| self.find_corners(block)).collect();
        }
        self.clear();
        changed
    }

    /// Zeroes every field.
    pub fn clear(&mut self) {
        let count = self.node_count();
        for field in &mut self.fields {
            field.nodes.resize(count, Node::default());
            crate::parallel::for_each_mut(&mut field.nodes, |node| *node = Node::default());
        }
    }

    fn find_corners(&self, block: [i32; D]) -> [u32; 8] {
        std::array::from_fn(|corner| {
            let neighbour = std::array::from_fn(|axis| block[axis] + (corner >> axis & 1) as i32);
            self.slots.get(&neighbour).map_or(NONE, |slot| slot * Self::BLOCK as u32)
        })
    }

    /// Lends one field to `run` together with the geometry of the grid.
    pub fn with_field<R>(&mut self, field: usize, run: impl FnOnce(&Self, &mut VelocityField<D>) -> R) -> R {
        let mut lent = std::mem::take(&mut self.fields[field]);
        let result = run(self, &mut lent);
        self.fields[field] = lent;
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_coordinates_are_inverse() {
        let mut grid = Grid::<3>::new(Vector([-1.0, 0.0, 2.0]), 0.5, [8, 8, 8], 1);
        grid.set_blocks(vec![[-1, 0, 0], [0, 0, 0], [0, 1, 0]]);
        for node in 0..grid.node_count() {
            assert_eq!(grid.find(grid.coordinates(node)), Some(node));
        }
        assert_eq!(grid.find([4, 0, 0]), None);
        assert_eq!(grid.position(grid.find([-1, 2, 3]).unwrap()), Vector([-1.5, 1.0, 3.5]));
    }
}
