//! A run of element blocks as one parallel task: gather the nodes, update, scatter the forces.

use super::element::{self, HistoryBlock, MembraneParameters, MembraneSums, MovingTangents, ReferenceBlock};
use super::lanes::{LANES, LaneVector};
use super::shape::ElementShape;
use crate::material::Sheet;
use crate::math::Vector;
use crate::math::simd::{self, widest};
use std::marker::PhantomData;

/// The columns that the element tasks of one shape read.
pub(super) struct ElementTask<'a, const D: usize> {
    /// Nodes of the elements, one after the other.
    pub nodes: &'a [u32],
    /// Reference states, one per quadrature point; empty for rate laws.
    pub references: &'a [ReferenceBlock],
    /// Positions of all nodes.
    pub position: &'a [Vector<D>],
    /// Velocities of all nodes.
    pub velocity: &'a [Vector<D>],
    /// The parameters that all elements share.
    pub parameters: &'a MembraneParameters,
    /// The law.
    pub sheet: &'a dyn Sheet,
}

/// A run of blocks and what it writes.
pub(super) struct Run<'a, const D: usize> {
    /// Number of the first block of its shape.
    pub first: usize,
    /// History of the elements, one per quadrature point.
    pub blocks: &'a mut [HistoryBlock],
    /// Nodal forces, element by element [N].
    pub force: &'a mut [Vector<D>],
    /// Area vectors over the number of nodes [m²]; empty if they aren't needed.
    pub area: &'a mut [Vector<D>],
}

impl<const D: usize> ElementTask<'_, D> {
    /// Updates a run of blocks with the widest vector instructions of this machine. The arithmetic, and so the result,
    /// is the same with all of them.
    pub fn run<S: ElementShape<N>, const N: usize>(&self, run: Run<'_, D>) -> MembraneSums {
        widest(Update::<S, D, N> { task: self, run, shape: PhantomData })
    }
}

/// The update of a run as a task for the registers of this machine.
struct Update<'a, 'b, S, const D: usize, const N: usize> {
    task: &'a ElementTask<'a, D>,
    run: Run<'b, D>,
    shape: PhantomData<S>,
}

impl<S: ElementShape<N>, const D: usize, const N: usize> simd::Task for Update<'_, '_, S, D, N> {
    type Output = MembraneSums;

    #[inline(always)]
    fn run<L: simd::Lanes>(self) -> MembraneSums {
        let Run { first, blocks, force, area } = self.run;
        let task = self.task;
        let mut sums = MembraneSums::default();
        for (index, (blocks, force)) in blocks.chunks_mut(S::POINTS).zip(force.chunks_mut(LANES * N)).enumerate() {
            let count = force.len() / N;
            let start = (first + index) * LANES * N;
            let nodes = &task.nodes[start..start + count * N];
            let points = (first + index) * S::POINTS..(first + index + 1) * S::POINTS;
            let references = task.references.get(points).unwrap_or(&[]);
            let (x, v) = (gather(nodes, count, task.position), gather(nodes, count, task.velocity));
            let motion = MovingTangents::of_nodes::<S, N>(x, v);
            let updated = element::update::<S, N>(&motion, task.parameters, task.sheet, blocks, references, count);
            scatter(&updated.force, force);
            if let Some(area) = area.get_mut(index * LANES..index * LANES + count) {
                scatter(&[updated.area], area);
            }
            sums = sums.plus(updated.sums);
        }
        sums
    }
}

/// Nodal vectors of a block; lanes beyond `count` repeat the last element.
#[inline(always)]
pub(super) fn gather<const D: usize, const N: usize>(
    nodes: &[u32],
    count: usize,
    vectors: &[Vector<D>],
) -> [LaneVector; N] {
    let mut lanes = [LaneVector::ZERO; N];
    for k in 0..LANES {
        let element = k.min(count - 1);
        for (corner, lane) in lanes.iter_mut().enumerate() {
            let vector = vectors[nodes[element * N + corner] as usize];
            (0..D).for_each(|axis| lane.0[axis].0[k] = vector[axis]);
        }
    }
    lanes
}

/// Writes the nodal forces of a block, element by element.
#[inline(always)]
fn scatter<const D: usize, const N: usize>(lanes: &[LaneVector; N], force: &mut [Vector<D>]) {
    for (k, element) in force.chunks_exact_mut(N).enumerate() {
        for (corner, force) in element.iter_mut().enumerate() {
            *force = Vector::from_fn(|axis| lanes[corner].0[axis].0[k]);
        }
    }
}
