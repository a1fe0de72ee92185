//! Particles to grid: mass and momentum (60, 61), internal and body force (17, 18).

use super::dispatch::{Task, widest};
use super::kernel;
use super::lanes::{Lanes, Record};
use super::shape::{Axes, Cubic, Gimp, Linear, Quadratic, Shape, Weights};
use super::tile::{Extent, TILE, TILE_NODES, Target, Tile, for_each_run};
use super::{Kernel, Sweep, bins::tile_origin, with_shape};
use crate::math::Vector;
use crate::mpm::ghost::Fold;
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

/// Positions to tile coordinates: s = x · scale − shift.
#[derive(Clone, Copy)]
pub(crate) struct Frame<const D: usize> {
    scale: f64,
    shift: Axes,
    ends: Ends<D>,
}

/// Ends of the domain beyond which ghosts extrapolate, in tile coordinates; `None` where there is none in the tile.
type Ends<const D: usize> = [[Option<f64>; 2]; D];

impl<const D: usize> Frame<D> {
    pub fn new(sweep: &Sweep<'_, D>, block: [i32; D]) -> Self {
        let scale = 1.0 / sweep.cell;
        let tile = tile_origin(block);
        let end = |a: usize, end: usize| {
            let plane = if end == 0 { 0.0 } else { f64::from(sweep.cells[a]) } - tile[a];
            let extrapolates = sweep.folds[a][end] == Fold::Extrapolate && (0.0..TILE as f64).contains(&plane);
            extrapolates.then_some(plane)
        };
        Self {
            scale,
            shift: std::array::from_fn(|a| if a < D { sweep.origin[a] * scale + tile[a] } else { 0.0 }),
            ends: std::array::from_fn(|a| [end(a, 0), end(a, 1)]),
        }
    }

    /// Gives the affine parts next to walls that extrapolate the places of the nodes that receive them.
    #[inline(always)]
    fn correct_offsets<const W: usize>(&self, w: &mut Weights<W>) {
        for (axis, ends) in self.ends.iter().enumerate() {
            for (plane, inward) in ends.iter().zip([1.0, -1.0]) {
                if let Some(plane) = plane {
                    w.fold_offsets(axis, *plane, inward);
                }
            }
        }
    }

    #[inline(always)]
    pub fn coordinates(&self, x: Vector<D>) -> Axes {
        kernel::array(0.0, |a| if a < D { x[a] * self.scale - self.shift[a] } else { 0.0 })
    }
}

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

    /// What averaging adds to the pressure of particle `p` [Pa].
    #[inline(always)]
    fn excess(&self, p: usize) -> f64 {
        self.work.excess.get(p).copied().unwrap_or_default()
    }

    /// Value of particle `p` without shear stress: (m, m v, V p/h in every force lane).
    #[inline(always)]
    fn simple_lanes<L: Lanes>(&self, p: usize, cell: f64) -> L {
        let mut value = [0.0; 8];
        let all = self.particles;
        let average = match self.content {
            Content::Volumes => Some(self.work.stretch[p]),
            Content::Pressures => Some(all.mean_pressure(p)),
            _ => None,
        };
        if let Some(average) = average {
            (value[0], value[1]) = (all.volume[p], all.volume[p] * average);
            return L::set(value);
        }
        if self.content != Content::Force {
            let (m, v) = (all.mass[p], all.velocity[p]);
            value[0] = m;
            for a in 0..D {
                value[1 + a] = m * v[a];
            }
        }
        if self.content != Content::Momentum {
            let force = all.volume[p] * (all.pressure[p] + self.excess(p)) / cell;
            value[1 + D..1 + 2 * D].fill(force);
        }
        L::set(value)
    }

    /// Value and slopes of particle `p` in the lanes (m, p, f): (m, m v, F) and, per axis,
    /// h m C in the momentum lanes and −V σ/h in the force lanes.
    #[inline(always)]
    fn lanes<L: Lanes, const AFFINE: bool>(&self, p: usize, cell: f64) -> (L, [L; D]) {
        let (mut value, mut slopes) = ([0.0; 8], [[0.0; 8]; D]);
        let all = self.particles;
        let m = all.mass[p];
        if self.content != Content::Force {
            let v = all.velocity[p];
            value[0] = m;
            for a in 0..D {
                value[1 + a] = m * v[a];
            }
            if AFFINE {
                let c = &all.affine[p];
                for axis in 0..D {
                    for a in 0..D {
                        slopes[axis][1 + a] = m * cell * c[a][axis];
                    }
                }
            }
        }
        if self.content != Content::Momentum {
            let v = all.volume[p] / cell;
            if !self.work.external.is_empty() {
                value[1 + D..1 + 2 * D].copy_from_slice(&self.work.external[p].0);
            }
            if all.stress.is_empty() {
                let force = v * (all.pressure[p] + self.excess(p));
                for axis in 0..D {
                    slopes[axis][1 + D + axis] = force;
                }
            } else {
                let [xx, yy, zz, xy, yz, zx] = all.stress[p].0;
                let sigma = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
                for axis in 0..D {
                    for a in 0..D {
                        slopes[axis][1 + D + a] = -v * sigma[a][axis];
                    }
                    slopes[axis][1 + D + axis] += v * self.excess(p);
                }
            }
        }
        (L::set(value), kernel::array(L::splat(0.0), |axis| L::set(slopes[axis])))
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
        let mut extent = Extent::EMPTY;
        let cell = 1.0 / self.frame.scale;
        let simple = !AFFINE && self.source.is_simple();
        let at_wall = AFFINE && self.frame.ends.iter().flatten().any(Option::is_some);
        for p in self.range {
            let mut w = self.shape.weights(self.frame.coordinates(self.source.particles.position[p]));
            if at_wall {
                self.frame.correct_offsets(&mut w);
            }
            let first = if simple {
                kernel::scatter_simple::<L, W, D>(self.tile, &w, self.source.simple_lanes::<L>(p, cell))
            } else {
                let (value, slopes) = self.source.lanes::<L, AFFINE>(p, cell);
                kernel::scatter::<L, W, D, AFFINE>(self.tile, &w, value, slopes)
            };
            extent.include::<W, D>(first);
        }
        extent
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
