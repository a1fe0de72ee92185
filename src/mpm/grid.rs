//! The background grid: uniform, in sparse blocks of 4ᴰ nodes whose memory follows the material.
//!
//! Node (0, …) lies at `origin`, nodes are `cell` apart. The domain spans nodes 0..=cells; kernels wider than
//! linear and mirrored walls use ghost nodes outside. A node is addressed by its number, slot · 4ᴰ + local,
//! with x running fastest inside a block. All fields share the block numbering.
//!
//! During a step a node holds, in this order: (m, p⁻, f) after the particles' scatter, then (m, p̄, f) with
//! p̄ = p⁻ + Δt f — walls and contact change p̄ *and* f together, so that p⁻ = p − Δt f always — and at last
//! (m, v⁺, a) for the gather.

use super::ghost::{Fold, Limits};
use super::kernel::Kernel;
use super::light::Faint;
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
    /// How the ghosts beyond both ends of each axis follow the domain; mirrors until told otherwise.
    pub folds: [[Fold; 2]; D],
    /// How they follow it in each field, if that is not the same for all (`wall::domain`).
    pub own_folds: Vec<[[Fold; 2]; D]>,
    /// Velocity fields.
    pub fields: Vec<Field<D>>,
    slots: HashMap<[i32; D], u32>,
    blocks: Vec<[i32; D]>,
    corners: Vec<[u32; 8]>,
}

/// One velocity field.
#[derive(Debug, Clone, Default)]
pub struct Field<const D: usize> {
    /// Nodes of all active blocks, 4ᴰ per block.
    pub nodes: Vec<Node<D>>,
    /// The velocity that gradients are taken of [m/s]: v⁻, v⁺ or the re-mapped one, by the stress update.
    pub velocity: Vec<Vector<D>>,
    /// The force of stresses, gravity and tractions alone [N], kept for the energy ledger.
    pub applied: Vec<Vector<D>>,
    /// How much of what they bring the ghosts may extrapolate, in this step.
    pub limits: Limits,
    /// Nodes of which only rounding is left, in this step.
    pub faint: Vec<Faint>,
    /// Room for averages over the nodes, Σ V N and Σ V q N.
    pub sums: Vec<[f64; 2]>,
    /// Room for their quotients.
    pub means: Vec<[f64; 1]>,
}

/// The number of an inactive block in the corner table.
const NONE: u32 = u32::MAX;

/// One node of one field: a cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub struct Node<const D: usize> {
    /// Mass m_I [kg].
    pub mass: f64,
    /// Momentum [N s]; velocity v⁺ [m/s] after the nodes have been finished (`finish_nodes`).
    pub momentum: Vector<D>,
    /// Force [N], walls and contact included; acceleration [m/s²] after that.
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
            folds: [[Fold::Mirror; 2]; D],
            own_folds: Vec::new(),
            fields: vec![Field::default(); fields],
            slots: HashMap::new(),
            blocks: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// How the ghosts of a field follow the domain.
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
    pub fn with_field<R>(&mut self, field: usize, run: impl FnOnce(&Self, &mut Field<D>) -> R) -> R {
        let mut lent = std::mem::take(&mut self.fields[field]);
        let result = run(self, &mut lent);
        self.fields[field] = lent;
        result
    }
}

/// Collects the blocks that points touch, each once, in sorted order, for tests; a step takes those of its bins.
#[derive(Debug)]
pub struct ActiveBlocks<const D: usize> {
    origin: Vector<D>,
    inverse_cell: f64,
    cells: [i32; D],
    seen: hashbrown::HashSet<[i32; D]>,
    last: Option<([i32; D], [i32; D])>,
}

impl<const D: usize> ActiveBlocks<D> {
    /// Nothing yet, on the lattice of `grid`.
    pub fn new(grid: &Grid<D>) -> Self {
        let seen = hashbrown::HashSet::new();
        Self { origin: grid.origin, inverse_cell: 1.0 / grid.cell, cells: grid.cells, seen, last: None }
    }

    /// Adds the blocks in the support of the point `x` [m], and those that ghosts in it are folded into.
    #[inline]
    pub fn touch(&mut self, kernel: Kernel, x: Vector<D>) {
        let first: [i32; D] = std::array::from_fn(|a| kernel.first((x[a] - self.origin[a]) * self.inverse_cell));
        let last = first.map(|i| i + kernel.support() - 1);
        let block = |i: i32| i.div_euclid(EDGE as i32);
        let lower = std::array::from_fn(|a| block(first[a].min(2 * self.cells[a] - last[a]).max(first[a] - 1)));
        let upper = std::array::from_fn(|a| block(last[a].max(-first[a]).min(last[a] + 1)));
        if self.last == Some((lower, upper)) {
            return;
        }
        self.last = Some((lower, upper));
        for corner in 0..1 << D {
            let block = std::array::from_fn(|a| if corner >> a & 1 == 0 { lower[a] } else { upper[a] });
            self.seen.insert(block);
        }
    }

    /// The blocks, sorted with the last axis slowest.
    pub fn into_sorted(self) -> Vec<[i32; D]> {
        let mut blocks: Vec<_> = self.seen.into_iter().collect();
        blocks.sort_unstable_by_key(|block| {
            let mut key = *block;
            key.reverse();
            key
        });
        blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpm::KernelKind;

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

    #[test]
    fn stencils_visit_the_nodes_around_a_point_across_blocks() {
        let mut grid = Grid::<2>::new(Vector::ZERO, 0.25, [40, 40], 1);
        for kind in [KernelKind::Linear, KernelKind::Gimp, KernelKind::Quadratic, KernelKind::Cubic] {
            let kernel = Kernel::new(kind, 0.25);
            for x in [Vector([0.9, 1.02]), Vector([0.01, 0.99]), Vector([1.88, 3.12])] {
                let mut active = ActiveBlocks::new(&grid);
                active.touch(kernel, x);
                grid.set_blocks(active.into_sorted());
                let (mut centre, mut sum, mut slope) = (Vector::ZERO, 0.0, Vector::ZERO);
                assert!(kernel.for_each(&grid, x, |node, weight, gradient| {
                    centre += grid.position(node) * weight;
                    sum += weight;
                    slope += gradient * grid.position(node)[0];
                }));
                assert!((centre - x).norm() < 1e-15 * 8.0 && (sum - 1.0).abs() < 1e-14);
                assert!((slope - Vector([1.0, 0.0])).norm() < 1e-13);
            }
        }
    }
}
