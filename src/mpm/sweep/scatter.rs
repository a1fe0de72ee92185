//! Particles to grid: mass and momentum (60, 61), internal and body force (17, 18).

use super::frame::{self, Frame};
use super::group::Group;
use super::kernel::{self, WeightRows};
use super::shape::{Cubic, Gimp, Linear, Quadratic, Shape};
use super::tile::{Extent, Record, TILE, TILE_NODES, Target, Tile, for_each_run};
use super::{Kernel, Sweep, with_shape};
use crate::math::simd::{Lanes, Row, Task, WIDTH, widest};
use crate::mpm::particles::{Body, Particles, Work};
use rayon::prelude::*;
use std::ops::Range;

/// What a scatter sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Content {
    /// Mass and momentum, with the affine part if the particles have one.
    Momentum,
    /// Internal force, and the body force if given.
    Force,
    /// Both.
    MomentumAndForce,
    /// Volume before and after an increment, V and V ΔJ, as two scalars.
    Volumes,
    /// Volume and its product with the pressure, V and V p, as two scalars.
    Pressures,
}

impl Content {
    /// True if momentum is among it.
    fn moves(self) -> bool {
        matches!(self, Self::Momentum | Self::MomentumAndForce)
    }
}

impl<const D: usize> Sweep<'_, D> {
    /// Adds the particles' contributions to `nodes`. Returns the part of each tile that was reached.
    pub fn scatter<T: Target>(&self, nodes: &mut [T], body: &Body<D>, content: Content) -> Vec<Extent> {
        let source = Source { particles: &body.particles, work: &body.work, content };
        let affine = content.moves() && !body.particles.affine.is_empty();
        // Behind a pointer, so that targets are not compiled once more for every shape function.
        let scatter: &BlockFn<'_, D> = with_shape!(self, shape => if affine {
            &move |tile, frame, range| widest(BlockScatter::<_, _, D, true> { tile, shape, frame, source, range })
        } else {
            &move |tile, frame, range| widest(BlockScatter::<_, _, D, false> { tile, shape, frame, source, range })
        });
        let nodes = SharedNodes::new(nodes);
        let mut extents = vec![Extent::EMPTY; self.bins.bins.len()];
        for colour in &self.bins.colours {
            let reached = colour.par_iter().with_min_len(4).map_init(
                || Box::new([Record::default(); TILE_NODES]),
                |tile, &b| {
                    let bin = &self.bins.bins[b];
                    let extent = scatter(tile, Frame::new(self, bin.block), bin.range.clone());
                    for_each_run::<D>(&self.bins.slots[b], &extent, |node, t, count| {
                        nodes.add(node, &mut tile[t..t + count]);
                    });
                    extent
                },
            );
            let reached: Vec<Extent> = reached.collect();
            for (&b, extent) in colour.iter().zip(reached) {
                extents[b] = extent;
            }
        }
        extents
    }
}

/// Scatters the particles of a block into its tile.
type BlockFn<'a, const D: usize> = dyn Fn(&mut Tile, Frame<D>, Range<usize>) -> Extent + Sync + 'a;

#[derive(Clone, Copy)]
struct Source<'a, const D: usize> {
    particles: &'a Particles<D>,
    work: &'a Work<D>,
    content: Content,
}

impl<const D: usize> Source<'_, D> {
    /// True if every lane is a product of one number and one-dimensional weights.
    fn is_simple(&self) -> bool {
        let free = self.particles.stress.is_empty() && self.work.external.is_empty();
        free || !matches!(self.content, Content::Force | Content::MomentumAndForce)
    }

    /// Pressures that make forces [Pa]: with what averaging adds.
    #[inline(always)]
    fn pressure<L: Lanes>(&self, group: Group) -> L {
        let p = group.scalars::<L>(&self.particles.pressure);
        if self.work.excess.is_empty() { p } else { p.add(group.scalars(&self.work.excess)) }
    }

    /// Values of particles without shear stress: (m, m v, V p/h in every force lane).
    #[inline(always)]
    fn simple_lanes<L: Lanes>(&self, group: Group, per_cell: f64) -> [L; WIDTH] {
        let mut value = [L::splat(0.0); WIDTH];
        let all = self.particles;
        let average = match self.content {
            Content::Volumes => Some(group.scalars(&self.work.stretch)),
            Content::Pressures => Some(group.each::<L>(|p| all.mean_pressure(p))),
            _ => None,
        };
        if let Some(average) = average {
            value[0] = group.scalars(&all.volume);
            value[1] = value[0].mul(average);
            return value;
        }
        if self.content != Content::Force {
            self.put_momentum(group, &mut value);
        }
        if self.content != Content::Momentum {
            let area = group.scalars::<L>(&all.volume).mul(L::splat(per_cell));
            value[1 + D..1 + 2 * D].fill(area.mul(self.pressure(group)));
        }
        value
    }

    /// m and m v.
    #[inline(always)]
    fn put_momentum<L: Lanes>(&self, group: Group, value: &mut [L; WIDTH]) {
        let v = group.vectors::<L, D>(&self.particles.velocity);
        value[0] = group.scalars(&self.particles.mass);
        for a in 0..D {
            value[1 + a] = value[0].mul(v[a]);
        }
    }

    /// Values and slopes of particles in the lanes (m, p, f): (m, m v, F) and, per axis,
    /// h m C in the momentum lanes and −V σ/h in the force lanes.
    #[inline(always)]
    fn lanes<L: Lanes, const AFFINE: bool>(&self, group: Group, per_cell: f64) -> ([L; WIDTH], [[L; WIDTH]; D]) {
        let zero = L::splat(0.0);
        let (mut value, mut slopes) = ([zero; WIDTH], [[zero; WIDTH]; D]);
        if self.content != Content::Force {
            self.put_momentum(group, &mut value);
            if AFFINE {
                let weight = value[0].mul(L::splat(1.0 / per_cell));
                for axis in 0..D {
                    for a in 0..D {
                        let c = group.each::<L>(|p| self.particles.affine[p][a][axis]);
                        slopes[axis][1 + a] = weight.mul(c);
                    }
                }
            }
        }
        if self.content != Content::Momentum {
            self.put_force(group, per_cell, &mut value, &mut slopes);
        }
        (value, slopes)
    }

    /// F and −V σ/h.
    #[inline(always)]
    fn put_force<L: Lanes>(&self, group: Group, per_cell: f64, value: &mut [L; WIDTH], slopes: &mut [[L; WIDTH]; D]) {
        if !self.work.external.is_empty() {
            value[1 + D..1 + 2 * D].copy_from_slice(&group.vectors::<L, D>(&self.work.external));
        }
        let area = group.scalars::<L>(&self.particles.volume).mul(L::splat(per_cell));
        let minus_area = L::splat(0.0).sub(area);
        for axis in 0..D {
            if self.particles.stress.is_empty() {
                slopes[axis][1 + D + axis] = area.mul(self.pressure(group));
                continue;
            }
            for a in 0..D {
                let sigma = group.each::<L>(|p| self.particles.stress[p].0[VOIGT[a][axis]]);
                slopes[axis][1 + D + a] = minus_area.mul(sigma);
            }
            if !self.work.excess.is_empty() {
                let slope = &mut slopes[axis][1 + D + axis];
                *slope = area.mul_add(group.scalars(&self.work.excess), *slope);
            }
        }
    }
}

/// Where the components of a symmetric tensor lie.
const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// What the particles of a group send, one record after the other.
struct Parcels<const W: usize> {
    weights: WeightRows<W>,
    value: [Row; WIDTH],
    slopes: [[Row; WIDTH]; 3],
    first: Row,
}

impl<const W: usize> Default for Parcels<W> {
    fn default() -> Self {
        let rows = [Row::default(); WIDTH];
        Self { weights: WeightRows::default(), value: rows, slopes: [rows; 3], first: Row::default() }
    }
}

/// Turns lanes of particles into records.
#[inline(always)]
fn put_records<L: Lanes>(lanes: [L; WIDTH], records: &mut [Row; WIDTH]) {
    for (record, lanes) in records.iter_mut().zip(L::transpose(lanes)) {
        lanes.store(&mut record.0);
    }
}

struct BlockScatter<'a, S, const W: usize, const D: usize, const AFFINE: bool> {
    tile: &'a mut Tile,
    shape: S,
    frame: Frame<D>,
    source: Source<'a, D>,
    range: Range<usize>,
}

impl<S: Shape<W>, const W: usize, const D: usize, const AFFINE: bool> Task for BlockScatter<'_, S, W, D, AFFINE> {
    type Output = Extent;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Extent {
        let simple = !AFFINE && self.source.is_simple();
        let mut parcels = Parcels::<W>::default();
        let (mut lowest, mut highest) = ([L::splat(TILE as f64); D], [L::splat(0.0); D]);
        let mut p = self.range.start;
        while p < self.range.end {
            let group = Group::new(p, self.range.end);
            let s = self.frame.coordinates::<L>(group, &self.source.particles.position);
            let mut base = s;
            for axis in 0..D {
                base[axis] = frame::base(self.shape, s[axis]);
                lowest[axis] = lowest[axis].min(base[axis]);
                highest[axis] = highest[axis].max(base[axis]);
            }
            let mut weights = frame::weights(self.shape, &s, &base);
            if AFFINE {
                self.frame.fold_moments(&mut weights, &base);
            }
            parcels.weights.put::<L, D, AFFINE>(&weights);
            frame::tile_number(&base).store(&mut parcels.first.0);
            if simple {
                put_records(self.source.simple_lanes::<L>(group, self.frame.scale), &mut parcels.value);
                parcels.scatter_simple::<L, D>(self.tile, group.count());
            } else {
                let (value, slopes) = self.source.lanes::<L, AFFINE>(group, self.frame.scale);
                put_records(value, &mut parcels.value);
                for axis in 0..D {
                    put_records(slopes[axis], &mut parcels.slopes[axis]);
                }
                parcels.scatter::<L, D, AFFINE>(self.tile, group.count());
            }
            p += group.count();
        }
        Extent::around::<L, W, D>(&lowest, &highest)
    }
}

impl<const W: usize> Parcels<W> {
    #[inline(always)]
    fn scatter_simple<L: Lanes, const D: usize>(&self, tile: &mut Tile, count: usize) {
        for k in 0..count.min(WIDTH) {
            let first = self.first.0[k] as usize;
            kernel::scatter_simple::<L, W, D>(tile, (&self.weights, k), first, L::load(&self.value[k].0));
        }
    }

    #[inline(always)]
    fn scatter<L: Lanes, const D: usize, const AFFINE: bool>(&self, tile: &mut Tile, count: usize) {
        for k in 0..count.min(WIDTH) {
            let first = self.first.0[k] as usize;
            let mut slopes = [L::splat(0.0); D];
            for axis in 0..D {
                slopes[axis] = L::load(&self.slopes[axis][k].0);
            }
            kernel::scatter::<L, W, D, AFFINE>(tile, (&self.weights, k), first, L::load(&self.value[k].0), slopes);
        }
    }
}

/// Nodes that the blocks of one colour may write at the same time.
struct SharedNodes<'a, T> {
    first: *mut T,
    len: usize,
    lifetime: std::marker::PhantomData<&'a mut [T]>,
}

// SAFETY: only `add` reaches the nodes, and blocks that run at the same time have disjoint tiles (`colour`).
#[allow(unsafe_code)]
unsafe impl<T: Send> Sync for SharedNodes<'_, T> {}

impl<'a, T: Target> SharedNodes<'a, T> {
    fn new(nodes: &'a mut [T]) -> Self {
        Self { first: nodes.as_mut_ptr(), len: nodes.len(), lifetime: std::marker::PhantomData }
    }

    /// Adds a tile's records to consecutive nodes and clears them.
    #[inline(always)]
    #[allow(unsafe_code)]
    fn add(&self, first: usize, records: &mut [Record]) {
        assert!(first + records.len() <= self.len);
        // SAFETY: in bounds, and no other block of this colour reaches these nodes.
        let nodes = unsafe { std::slice::from_raw_parts_mut(self.first.add(first), records.len()) };
        for (node, record) in nodes.iter_mut().zip(records) {
            node.add(record);
            *record = Record::default();
        }
    }
}
