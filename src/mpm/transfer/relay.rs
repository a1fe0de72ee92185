//! Grid to particles to grid in one visit: what particles make of the nodes is sent on while they are at hand.

use super::Sweep;
use super::frame::Frame;
use super::gather::{Chunk, GatherFields, Reader, Reduce};
use super::scatter::{SharedNodes, Target};
use super::source::{Content, Source};
use super::tile::Record;
use super::view::View;
use crate::parallel::parts_mut;
use rayon::prelude::*;

impl<const D: usize> Sweep<'_, D> {
    /// Visits all particles, a chunk at a time, with what the nodes say there (as [`Self::gather`] does), and then
    /// scatters them to `targets` (as [`Self::scatter`]), whose nodes are others than those that are read.
    pub fn relay<T: Target<D>, A: Reduce>(
        &self,
        node: impl Fn(usize, &mut Record) + Sync,
        particles: View<'_, D>,
        fields: GatherFields,
        content: Content,
        targets: &mut [T],
        visit: impl Fn(&mut Chunk<'_, D>) -> A + Sync,
    ) -> A {
        let bins = self.bins;
        let targets = SharedNodes::new(targets);
        let mut views = particles.in_parts(bins.bins.iter().map(|bin| bin.range.len()));
        let mut sums: Vec<A> = bins.bins.iter().map(|_| A::default()).collect();
        for colour in &bins.colours {
            let views = parts_mut(&mut views, colour.iter().map(|&b| b..b + 1));
            let scratch = || (Reader::default(), T::tile());
            let work = colour.par_iter().zip(views).with_min_len(4);
            let done = work.map_init(scratch, |(reader, tile), (&b, view)| {
                let frame = Frame::new(self, bins.bins[b].block);
                let (slots, extent) = (&bins.slots[b], &bins.extents[b]);
                reader.fill(slots, extent, &node);
                let mine = std::mem::take(&mut view[0]);
                let sum = reader.read(self.kernel, frame, mine, fields, |chunk, places| {
                    let sum = visit(chunk);
                    T::collect(tile, self.kernel, frame, places, &Source::of_view(&chunk.particles, content));
                    sum
                });
                targets.add(slots, extent, tile, content);
                sum
            });
            let done: Vec<A> = done.collect();
            for (&b, sum) in colour.iter().zip(done) {
                sums[b] = sum;
            }
        }
        sums.into_iter().fold(A::default(), A::plus)
    }
}
