//! A run of element blocks as one parallel task: gather the nodes, update, scatter the forces.

use super::element::{self, Block, Parameters, Reference, Sums};
use super::lanes::{LANES, LaneVector};
use super::shape::Shape;
use crate::material::Sheet;
use crate::math::Vector;

/// What the element tasks of one shape read.
pub(super) struct Task<'a, const D: usize> {
    /// Nodes of the elements, one after the other.
    pub nodes: &'a [u32],
    /// Reference states; empty for rate laws.
    pub references: &'a [Reference],
    /// Positions of all nodes.
    pub position: &'a [Vector<D>],
    /// Velocities of all nodes.
    pub velocity: &'a [Vector<D>],
    /// What all elements share.
    pub parameters: &'a Parameters,
    /// The law.
    pub sheet: &'a dyn Sheet,
}

impl<const D: usize> Task<'_, D> {
    /// Updates a run of blocks, the first of which is number `first` of its shape, with the widest vector instructions
    /// of this machine. The arithmetic, and so the result, is the same with all of them.
    #[allow(unsafe_code)]
    pub fn run<S: Shape<N>, const N: usize>(
        &self,
        first: usize,
        blocks: &mut [Block],
        force: &mut [Vector<D>],
    ) -> Sums {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl") {
                // SAFETY: the processor has these instructions.
                return unsafe { self.run_avx512::<S, N>(first, blocks, force) };
            }
            if is_x86_feature_detected!("avx2") {
                // SAFETY: as above.
                return unsafe { self.run_avx2::<S, N>(first, blocks, force) };
            }
        }
        self.run_blocks::<S, N>(first, blocks, force)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512vl")]
    fn run_avx512<S: Shape<N>, const N: usize>(
        &self,
        first: usize,
        blocks: &mut [Block],
        force: &mut [Vector<D>],
    ) -> Sums {
        self.run_blocks::<S, N>(first, blocks, force)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn run_avx2<S: Shape<N>, const N: usize>(
        &self,
        first: usize,
        blocks: &mut [Block],
        force: &mut [Vector<D>],
    ) -> Sums {
        self.run_blocks::<S, N>(first, blocks, force)
    }

    #[inline(always)]
    fn run_blocks<S: Shape<N>, const N: usize>(
        &self,
        first: usize,
        blocks: &mut [Block],
        force: &mut [Vector<D>],
    ) -> Sums {
        let mut sums = Sums::default();
        let no_reference = Reference::default();
        for (index, (block, force)) in blocks.iter_mut().zip(force.chunks_mut(LANES * N)).enumerate() {
            let count = force.len() / N;
            let start = (first + index) * LANES * N;
            let nodes = &self.nodes[start..start + count * N];
            let reference = self.references.get(first + index).unwrap_or(&no_reference);
            let (x, v) = (gather(nodes, count, self.position), gather(nodes, count, self.velocity));
            let (corners, part) =
                element::update::<S, N>((x, v), self.parameters, self.sheet, (block, reference), count);
            scatter(&corners, force);
            sums = sums.and(part);
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
