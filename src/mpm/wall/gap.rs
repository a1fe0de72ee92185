//! Gaps between bodies and the walls and obstacles that they may leave (theory E.3).
//!
//! ```text
//! g_I = min_p [ d(x_p) − r_p(n) ]         over the particles that show the surface next to the node along the obstacle
//! contact:  g_I + Δt (v̄_I − v_w)·n ≤ 0
//! ```
//!
//! with the distance d from the obstacle and the reach r of the body around a particle. A node knows that a body is
//! near as soon as it lies in a particle's support, one and a half cells ahead; without the gap the body would float
//! there, and a disc that rolls would be held far from where it touches.
//!
//! Particles with a membrane between them and the obstacle don't count: the membrane has contact with both.

use super::{NodeCondition, Walls};
use crate::math::Vector;
use crate::mpm::grid::EDGE;
use crate::mpm::particles::{Bodies, Body};
use crate::mpm::{Grid, Kernel};
use crate::parallel;

/// Bins of particles per parallel task.
const BINS: usize = 4;

/// The conditions with gaps, by node; rebuilt with the conditions.
#[derive(Debug, Default)]
pub(super) struct GapConditions {
    /// First condition with a gap of each node that has one; empty without any.
    first: Vec<u32>,
    /// Grid blocks with such nodes.
    blocks: Vec<bool>,
}

const NONE: u32 = u32::MAX;

impl GapConditions {
    /// The gaps at conditions in the order of their nodes; `has_gap` is true for those that act only where a gap
    /// closes.
    pub fn new<const D: usize>(
        grid: &Grid<D>,
        conditions: &[NodeCondition<D>],
        has_gap: impl Fn(&NodeCondition<D>) -> bool,
    ) -> Self {
        let mut gap_conditions = Self::default();
        for (k, condition) in conditions.iter().enumerate().filter(|(_, condition)| has_gap(condition)) {
            if gap_conditions.first.is_empty() {
                gap_conditions.first = vec![NONE; grid.node_count()];
                gap_conditions.blocks = vec![false; grid.blocks().len()];
            }
            let node = condition.node as usize;
            gap_conditions.first[node] = gap_conditions.first[node].min(k as u32);
            gap_conditions.blocks[node / Grid::<D>::BLOCK] = true;
        }
        gap_conditions
    }

    /// True if there are any.
    pub fn any(&self) -> bool {
        !self.first.is_empty()
    }
}

/// A wall or obstacle, as a particle measured it last.
#[derive(Clone, Copy)]
struct MeasuredWall {
    boundary: u32,
    /// Distance of the particle from it [m].
    distance: f64,
    /// True if a membrane lies between the two.
    is_shielded: bool,
}

/// The bodies of a field, and whether a membrane lies between `x` [m] and something rigid with the normal `n` at
/// the distance `d` [m].
pub(in crate::mpm) struct BodiesAtWalls<'a, const D: usize> {
    /// The bodies with their numbers in the case.
    pub all: Vec<(usize, &'a Body<D>)>,
    /// `shielded(x, n, d)`.
    pub shielded: &'a (dyn Fn(Vector<D>, Vector<D>, f64) -> bool + Sync),
}

impl<'a, const D: usize> BodiesAtWalls<'a, D> {
    /// The bodies of a field among all.
    pub fn of_field(
        bodies: &'a Bodies<D>,
        field: usize,
        shielded: &'a (dyn Fn(Vector<D>, Vector<D>, f64) -> bool + Sync),
    ) -> Self {
        Self { all: bodies.numbered(field).collect(), shielded }
    }

    /// The results of `visit` for the particles that show the surface of their body (number and body, particle) and for
    /// whose bin's grid block `near` is true, in order.
    pub fn collect<T: Send>(
        &self,
        near: impl Fn(usize) -> bool + Sync,
        visit: impl Fn((usize, &Body<D>), usize) -> Vec<T> + Sync,
    ) -> Vec<T> {
        let mut all = Vec::new();
        for &(number, body) in &self.all {
            let (visit, bins) = (&visit, &body.bins);
            all.extend(parallel::collect_all(bins.slots.len(), BINS, |n| {
                let is_near = near(bins.slots[n][bins.slots[n].len() / 2] as usize);
                surface_particles(body, n, is_near).flat_map(move |p| visit((number, body), p))
            }));
        }
        all
    }
}

/// The particles of a bin that show the surface of their body; none if the bin isn't near a wall.
fn surface_particles<const D: usize>(body: &Body<D>, bin: usize, is_near: bool) -> impl Iterator<Item = usize> {
    let range = if is_near { body.bins.bins[bin].range.clone() } else { 0..0 };
    range.filter(|&p| body.shows_surface(p))
}

impl<const D: usize> Walls<D> {
    /// Measures the gaps between the bodies of a field and the walls and obstacles that they may leave [m].
    pub(in crate::mpm) fn measure(&mut self, grid: &Grid<D>, field: usize, bodies: &BodiesAtWalls<'_, D>) {
        let mut gaps = std::mem::take(&mut self.field_reactions[field].gap);
        gaps.clear();
        gaps.resize(self.conditions.len(), f64::INFINITY);
        if self.gap_conditions.any() {
            for &(_, body) in &bodies.all {
                for (condition, gap) in self.gaps(grid, field, body, bodies.shielded) {
                    let least = &mut gaps[condition as usize];
                    *least = least.min(gap);
                }
            }
        }
        self.field_reactions[field].gap = gaps;
    }

    /// Conditions near the particles of a body of a field, and how far the particles are from their walls [m].
    fn gaps(
        &self,
        grid: &Grid<D>,
        field: usize,
        body: &Body<D>,
        shielded: &(dyn Fn(Vector<D>, Vector<D>, f64) -> bool + Sync),
    ) -> Vec<(u32, f64)> {
        let near = |slots: &[u32]| slots.iter().any(|&slot| self.gap_conditions.blocks[slot as usize]);
        let bins = &body.bins;
        parallel::collect_all(bins.slots.len(), BINS, |n| {
            let (bin, slots) = (&bins.bins[n], &bins.slots[n]);
            surface_particles(body, n, near(slots)).flat_map(move |p| {
                let node = |ijk: [i32; D]| node_number(bin.block, slots, ijk);
                self.gaps_of(grid, field, body, p, shielded, node)
            })
        })
    }

    /// The gaps that particle `p` shows to the nodes of its support.
    fn gaps_of(
        &self,
        grid: &Grid<D>,
        field: usize,
        body: &Body<D>,
        p: usize,
        shielded: &dyn Fn(Vector<D>, Vector<D>, f64) -> bool,
        node: impl Fn([i32; D]) -> usize,
    ) -> Vec<(u32, f64)> {
        let x = body.particles.position[p];
        let (first, support) = (first(grid, body.kernel, x), body.kernel.support());
        let (mut gaps, patch) = (Vec::new(), body.patch(p) * (1.0 + 1e-9));
        let mut measured: Option<MeasuredWall> = None;
        for n in 0..support.pow(D as u32) {
            let node = node(std::array::from_fn(|a| first[a] + n / support.pow(a as u32) % support));
            let offset = x - grid.position(node);
            for (k, condition) in self.conditions_with_gap(node, field) {
                let (boundary, normal) = (condition.boundary, condition.normal);
                // Nothing may pass a wall of the domain by even a rounding: there all nodes of the support act.
                let aside = (offset - normal * offset.dot(normal)).norm();
                if aside > patch && boundary as usize >= 2 * D {
                    continue;
                }
                let wall = measured.filter(|wall| wall.boundary == boundary).unwrap_or_else(|| {
                    let distance = self.distance(boundary as usize, x);
                    MeasuredWall { boundary, distance, is_shielded: shielded(x, normal, distance) }
                });
                measured = Some(wall);
                if !wall.is_shielded {
                    gaps.push((k as u32, wall.distance - body.reach(p, normal, grid.cell)));
                }
            }
        }
        gaps
    }

    /// The conditions of a node that act on a field where a gap closes, by number.
    fn conditions_with_gap(&self, node: usize, field: usize) -> impl Iterator<Item = (usize, &NodeCondition<D>)> {
        let from = match self.gap_conditions.first[node] {
            NONE => self.conditions.len(),
            first => first as usize,
        };
        let own = self.conditions.iter().enumerate().skip(from);
        let own = own.take_while(move |(_, condition)| condition.node as usize == node);
        own.filter(move |(_, condition)| self.has_gap(condition) && !self.continues(field, condition.boundary as usize))
    }
}

/// First node of the support of `x` [m].
fn first<const D: usize>(grid: &Grid<D>, kernel: Kernel, x: Vector<D>) -> [i32; D] {
    std::array::from_fn(|a| kernel.first((x[a] - grid.origin[a]) / grid.cell))
}

/// Number of the node `ijk` in one of the 3ᴰ blocks around `block` with these slots.
fn node_number<const D: usize>(block: [i32; D], slots: &[u32], ijk: [i32; D]) -> usize {
    let edge = EDGE as i32;
    let (mut around, mut local) = (0, 0);
    for a in (0..D).rev() {
        around = around * 3 + (ijk[a].div_euclid(edge) - block[a] + 1) as usize;
        local = local * EDGE + ijk[a].rem_euclid(edge) as usize;
    }
    slots[around] as usize * EDGE.pow(D as u32) + local
}
