//! The background grid: uniform, in sparse blocks of 4ᴰ nodes whose memory follows the material.
//!
//! Node (0, …) lies at `origin`, nodes are `cell` apart. The domain spans nodes 0..=cells; kernels wider than
//! linear and mirrored walls use ghost nodes outside. A node is addressed by its number, slot · 4ᴰ + local,
//! with x running fastest inside a block. All fields share the block numbering.
//!
//! During a step a node holds, in this order: (m, p⁻, f) after the particles' scatter, then (m, p̄, f) with
//! p̄ = p⁻ + Δt f — walls and contact change p̄ *and* f together, so that p⁻ = p − Δt f always — and at last
//! (m, v⁺, a) for the gather.

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
    /// Velocity fields.
    pub fields: Vec<Field<D>>,
    slots: HashMap<[i32; D], u32>,
    blocks: Vec<[i32; D]>,
}

/// One velocity field.
#[derive(Debug, Clone, Default)]
pub struct Field<const D: usize> {
    /// Nodes of all active blocks, 4ᴰ per block.
    pub nodes: Vec<Node<D>>,
}

/// One node of one field: a cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub struct Node<const D: usize> {
    /// Mass m_I [kg].
    pub mass: f64,
    /// Momentum [N s]; velocity v⁺ [m/s] after [`Grid`] has finished the step.
    pub momentum: Vector<D>,
    /// Force [N], walls and contact included; acceleration [m/s²] after the grid has finished the step.
    pub force: Vector<D>,
}

impl<const D: usize> Grid<D> {
    /// Nodes per block.
    pub const BLOCK: usize = EDGE.pow(D as u32);

    /// An empty grid.
    pub fn new(origin: Vector<D>, cell: f64, cells: [i32; D], fields: usize) -> Self {
        Self {
            origin,
            cell,
            cells,
            fields: vec![Field { nodes: Vec::new() }; fields],
            slots: HashMap::new(),
            blocks: Vec::new(),
        }
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

    /// Position of a node [m].
    #[inline]
    pub fn position(&self, node: usize) -> Vector<D> {
        let ijk = self.coordinates(node);
        self.origin + Vector::from_fn(|axis| f64::from(ijk[axis])) * self.cell
    }

    /// Makes exactly these blocks active (sorted, without repetition) and zeroes every field.
    pub fn set_blocks(&mut self, blocks: Vec<[i32; D]>) {
        if blocks != self.blocks {
            self.slots = blocks.iter().enumerate().map(|(slot, &block)| (block, slot as u32)).collect();
            self.blocks = blocks;
        }
        let count = self.node_count();
        for field in &mut self.fields {
            field.nodes.clear();
            field.nodes.resize(count, Node::default());
        }
    }
}
