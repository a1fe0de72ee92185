//! Grid to particles to grid in one sweep: particles are scattered right after their update, while they are in the
//! cache.

use super::Sweep;
use super::frame::TileFrame;
use super::gather::{Chunk, FillTile, GatherFields, NodeReader, fill_tile};
use super::scatter::{SharedNodes, Target};
use super::source::{ScatterContent, ScatterSource};
use super::view::View;
use crate::mpm::grid::tile::{Extent, NodeRecord, Tile};
use crate::mpm::particles::Reduce;
use crate::parallel::parts_mut;
use rayon::prelude::*;

impl<const D: usize> Sweep<'_, D> {
    /// Visits all particles, a chunk at a time, with nodal values interpolated to them (as [`Self::gather`] does), and
    /// then scatters them to `targets` (as [`Self::scatter`]), other nodal fields than those that are read.
    pub fn relay<T: Target<D>, A: Reduce>(
        &self,
        node: impl Fn(usize, &mut NodeRecord) + Sync,
        particles: View<'_, D>,
        fields: GatherFields,
        content: ScatterContent,
        targets: &mut [T],
        visit: impl Fn(&mut Chunk<'_, D>) -> A + Sync,
    ) -> A {
        let fill = |slots: &[u32], extent: &Extent, tile: &mut Tile| fill_tile::<D>(slots, extent, tile, &node);
        self.relay_filled(&fill, particles, fields, content, targets, &visit)
    }

    fn relay_filled<T: Target<D>, A: Reduce>(
        &self,
        fill: FillTile<'_>,
        particles: View<'_, D>,
        fields: GatherFields,
        content: ScatterContent,
        targets: &mut [T],
        visit: &(dyn Fn(&mut Chunk<'_, D>) -> A + Sync),
    ) -> A {
        let bins = self.bins;
        let targets = SharedNodes::new(targets);
        let mut views = particles.in_parts(bins.bins.iter().map(|bin| bin.range.len()));
        let mut sums: Vec<A> = bins.bins.iter().map(|_| A::default()).collect();
        for colour in &bins.colours {
            let views = parts_mut(&mut views, colour.iter().map(|&b| b..b + 1));
            let scratch = || (NodeReader::default(), T::tile());
            let work = colour.par_iter().zip(views).with_min_len(4);
            let done = work.map_init(scratch, |(reader, tile), (&b, view)| {
                let frame = TileFrame::new(self, bins.bins[b].block);
                let (slots, extent) = (&bins.slots[b], &bins.extents[b]);
                fill(slots, extent, &mut reader.tile);
                let mine = std::mem::take(&mut view[0]);
                let sum = reader.read(self.kernel, frame, mine, fields, |chunk, places| {
                    let sum = visit(chunk);
                    T::collect(tile, self.kernel, frame, places, &ScatterSource::of_view(&chunk.particles, content));
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
