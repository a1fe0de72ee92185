//! Contact of a sheet with walls and obstacles, at its nodes and, over curved or sharp surfaces, at points of its elements.
//!
//! ```text
//! w = Σ_K W_K v_K − v_w,   g = φ(x) − ½ t |n·ν|,   a = max(g, 0)/Δt                    φ: distance, n = ∇φ, ν: normal of the sheet
//! J_n ≥ 0,   w·n + a ≥ 0,   J_n (w·n + a) = 0,   ‖J_t‖ ≤ μ J_n,   v_K += W_K J/m_K
//! ```
//!
//! Moreau's law at the level of velocities: the gap closes at the end of a sub-step at the earliest, what meets stays
//! together (restitution 0), and nothing is pulled. The sheet's edge counts with its thickness only as far as it lies along the
//! surface, so that one that stands on a plane of symmetry is not pushed off. Overlaps are undone by positions alone, a
//! fifth of them in each sub-step.
//!
//! The wall has the last word in each sweep of the iteration: the impulses of bodies that press a sheet against it go through
//! to it at once ([`Rigid::give`]), since a light node between a heavy body and a wall would take as many sweeps to do so as
//! it is lighter.

mod squeeze;

pub use squeeze::Squeeze;

use super::impulse::Impulse;
use super::sample::Facet;
use super::sheet::Surface;
use crate::math::Vector;
use crate::mpm::wall::{SheetPush, Solid, Walls};
use crate::mpm::{Friction, SubStep};
use crate::parallel;

/// How near to a surface points are listed [cells]; the list is made anew when something may have moved that far.
const REACH: f64 = 0.25;

/// A point that has moved this far [cells] is measured again: on its way along a tangent it leaves what is curved, and what falls
/// back is lost, as by a friction of half of this over the radius.
const MOVED: f64 = 1e-3;

/// The fraction of an overlap that is undone in a sub-step, and the most, in half thicknesses.
const RECOVERY: f64 = 0.2;
const MOST: f64 = 0.05;

/// A sheet counts as at least this thick where overlaps are undone [element sizes].
const THIN: f64 = 0.02;

/// An element of size L may cut this deep into what is curved [L]: its nodes lie on a surface whose radius is above 2 L.
const SAGITTA: f64 = 1.0 / 16.0;

/// Points of a segment, a triangle and a quadrilateral besides the nodes: weights of the corners.
const ON_SEGMENT: [[f64; 4]; 3] = [[0.75, 0.25, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.25, 0.75, 0.0, 0.0]];
const ON_TRIANGLE: [[f64; 4]; 4] =
    [[0.5, 0.5, 0.0, 0.0], [0.0, 0.5, 0.5, 0.0], [0.5, 0.0, 0.5, 0.0], [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0]];
const ON_QUADRILATERAL: [[f64; 4]; 5] =
    [[0.5, 0.5, 0.0, 0.0], [0.0, 0.5, 0.5, 0.0], [0.0, 0.0, 0.5, 0.5], [0.5, 0.0, 0.0, 0.5], [0.25; 4]];

/// Sweeps where nothing but walls acts, and the change of an impulse, relative to the largest one, that ends them.
const SWEEPS: usize = 30;
const SETTLED: f64 = 1e-10;

/// A point of the sheet next to a wall or an obstacle.
#[derive(Debug, Clone)]
struct Rest<const D: usize> {
    /// The wall or obstacle.
    solid: u32,
    /// K and W_K; a node has one.
    nodes: [u32; 4],
    weights: [f64; 4],
    /// What of the thickness, less what an element may cut in, lies between it and the surface [m].
    offset: f64,
    /// The step in which overlaps are undone is measured by this length [m].
    thickness: f64,
    normal: Vector<D>,
    /// g where it was measured last, relative to the solid [m].
    measured: f64,
    anchor: Vector<D>,
    /// g at the start of the sub-step [m].
    gap: f64,
    /// v_w [m/s].
    wall: Vector<D>,
    friction: f64,
    /// J of this sub-step on the sheet, and what of it the nodes have got [N s].
    impulse: Impulse<D>,
    given: Vector<D>,
}

/// A sheet next to walls and obstacles.
#[derive(Debug, Default)]
pub(super) struct Rigid<const D: usize> {
    /// Walls and obstacles whose friction with this sheet is not their own, by name.
    listed: Vec<(String, Friction)>,
    /// μ with each wall and obstacle; `None` where the sheet doesn't meet it.
    friction: Vec<Option<f64>>,
    rests: Vec<Rest<D>>,
    /// The first of a node's rests, which follow each other; `NONE` without.
    first: Vec<u32>,
    /// How far anything may have moved since the list was made [m].
    travel: f64,
    /// Sums of the step, by boundary.
    pub pushes: Vec<SheetPush<D>>,
    /// Per node the share of its mass that solids held along each axis at the end of the last step.
    pub held: Vec<Vector<D>>,
}

const NONE: u32 = u32::MAX;

impl<const D: usize> Rigid<D> {
    /// For a sheet of so many nodes, and what the case says of its friction.
    pub fn new(nodes: usize, listed: Vec<(String, Friction)>) -> Self {
        Self { held: vec![Vector::ZERO; nodes], listed, ..Self::default() }
    }

    /// True if nothing is near.
    pub fn is_empty(&self) -> bool {
        self.rests.is_empty()
    }

    /// Starts a step: no sums yet, and a new list.
    pub fn begin_step(&mut self, walls: &Walls<D>) {
        let count = walls.solids().map(|solid| solid.number() + 1).max().unwrap_or(0);
        self.pushes.clear();
        self.pushes.resize(count, SheetPush::default());
        self.friction.clear();
        self.friction.resize(count, None);
        for solid in walls.solids() {
            let listed = self.listed.iter().find(|(name, _)| solid.is_named(name));
            self.friction[solid.number()] = match listed.map(|(_, friction)| *friction) {
                None => Some(solid.friction()),
                Some(Friction::None) => None,
                Some(Friction::Slip(coefficient)) => Some(coefficient),
                Some(Friction::Stick) => Some(f64::INFINITY),
            };
        }
        self.travel = f64::INFINITY;
    }

    /// Starts a sub-step: gaps as they are now, no impulses yet.
    pub fn begin(&mut self, walls: &Walls<D>, facets: &[Facet], surface: &Surface<'_, D>, at: &SubStep<'_>, cell: f64) {
        if self.pushes.is_empty() {
            return;
        }
        let speed = |v: Option<f64>| v.unwrap_or(0.0).sqrt();
        let sheet = speed(surface.velocity.iter().map(|v| v.norm_squared()).reduce(f64::max));
        let origin = surface.position.first().copied().unwrap_or_default();
        let solid = walls.solids().map(|solid| solid.velocity(origin, at.step).norm()).fold(0.0, f64::max);
        self.travel += (sheet + solid) * at.dt;
        if self.travel.is_nan() || self.travel > REACH * cell {
            self.list(walls, facets, surface, at, cell);
            self.travel = (sheet + solid) * at.dt;
        }
        if self.rests.is_empty() {
            return;
        }
        let solids: Vec<Option<Solid<'_, D>>> = self.by_number(walls);
        for rest in &mut self.rests {
            let Some(solid) = solids[rest.solid as usize] else { continue };
            let x = rest.place(surface.position);
            rest.wall = solid.velocity(x, at.step);
            rest.friction = self.friction[rest.solid as usize].unwrap_or(0.0);
            rest.measure(solid, x, rest.wall * at.elapsed, MOVED * cell);
            rest.impulse = Impulse::default();
            rest.given = Vector::ZERO;
        }
    }

    fn by_number<'a>(&self, walls: &'a Walls<D>) -> Vec<Option<Solid<'a, D>>> {
        let mut solids = vec![None; self.pushes.len()];
        walls.solids().for_each(|solid| solids[solid.number()] = Some(solid));
        solids
    }

    /// Lists what is near to walls and obstacles: nodes, and points of elements over what isn't flat.
    fn list(&mut self, walls: &Walls<D>, facets: &[Facet], surface: &Surface<'_, D>, at: &SubStep<'_>, cell: f64) {
        self.rests.clear();
        self.first.clear();
        self.first.resize(surface.position.len(), NONE);
        let corner = |pick: fn(f64, f64) -> f64| {
            Vector::from_fn(|a| surface.position.iter().map(|x| x[a]).reduce(pick).unwrap_or(0.0))
        };
        let (lower, upper) = (corner(f64::min), corner(f64::max));
        let meets = |solid: &Solid<'_, D>| self.friction[solid.number()].is_some();
        let near: Vec<_> = walls.solids().filter(meets).filter(|s| s.is_near(lower, upper, 2.0 * cell)).collect();
        if near.is_empty() {
            return;
        }
        let nodes = Nodes::of(facets, surface);
        let of_node = |k: usize| near.iter().filter_map(|&solid| nodes.rest(solid, k, surface, at, cell)).collect();
        let lists: Vec<Vec<Rest<D>>> = parallel::collect(surface.position.len(), 256, of_node);
        for (k, rests) in lists.into_iter().enumerate().filter(|(_, rests)| !rests.is_empty()) {
            self.first[k] = self.rests.len() as u32;
            self.rests.extend(rests);
        }
        let first = &self.first;
        let of_facet = |e: usize| -> Vec<Rest<D>> {
            let facet = &facets[e];
            let close = facet.nodes().iter().any(|&k| first[k as usize] != NONE);
            let size = facet.size(surface.position);
            near.iter()
                .filter(|solid| !solid.is_flat() && (close || size > REACH * cell))
                .flat_map(|&solid| nodes.rests_within(solid, facet, surface, at, cell))
                .collect()
        };
        self.rests.extend(parallel::collect_all(facets.len(), 256, of_facet));
    }

    /// One sweep over all contacts: the largest change of an impulse, and the largest impulse [N s]. The nodes have the
    /// velocities `v` [m/s] and 1/m `soft` [1/kg].
    pub fn sweep(&mut self, v: &mut [Vector<D>], soft: &impl Fn(usize) -> Vector<D>, dt: f64) -> (f64, f64) {
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for rest in &mut self.rests {
            let delta = rest.push(v, soft, dt);
            change = change.max(delta.norm());
            largest = largest.max(rest.impulse.normal.norm());
            if delta != Vector::ZERO {
                for (&k, &weight) in rest.nodes.iter().zip(&rest.weights).filter(|(_, weight)| **weight > 0.0) {
                    let soft = soft(k as usize);
                    v[k as usize] += Vector::from_fn(|a| delta[a] * weight * soft[a]);
                }
            }
        }
        (change, largest)
    }

    /// Sweeps until nothing changes.
    pub fn settle(&mut self, v: &mut [Vector<D>], soft: &impl Fn(usize) -> Vector<D>, dt: f64) {
        for _ in 0..SWEEPS {
            let (change, largest) = self.sweep(v, soft, dt);
            if change <= SETTLED * largest {
                break;
            }
        }
    }

    /// True if one of these nodes is next to a wall or an obstacle.
    #[inline(always)]
    pub fn touches_any(&self, nodes: &[u32; 4]) -> bool {
        !self.rests.is_empty() && nodes.iter().any(|&k| self.first.get(k as usize).is_some_and(|&first| first != NONE))
    }

    /// The rests of a node that hold it.
    fn holding(&self, node: usize) -> impl Iterator<Item = &Rest<D>> {
        let first = self.first.get(node).copied().unwrap_or(NONE) as usize;
        let own = self.rests.iter().skip(first).take_while(move |rest| rest.nodes == [node as u32; 4]);
        own.filter(|rest| rest.impulse.normal != Vector::ZERO)
    }

    /// n·(1/m)·n of a node that may be pressed against a wall [1/kg].
    pub fn compliance(&self, node: usize, soft: Vector<D>, n: Vector<D>) -> f64 {
        let mut free = n;
        for rest in self.holding(node) {
            if rest.sticks() {
                return 0.0;
            }
            free -= rest.normal * free.dot(rest.normal);
        }
        (0..D).map(|a| n[a] * soft[a] * free[a]).sum::<f64>().max(0.0)
    }

    /// True if a rest that holds a node would let go of it under the impulse `j` [N s], or slip.
    pub fn loosens(&self, node: usize, j: Vector<D>) -> bool {
        let mut left = j;
        for rest in self.holding(node) {
            let mut after = rest.clone();
            left = after.take(left);
            if left != Vector::ZERO && (after.impulse == rest.impulse || rest.sticks()) {
                return true;
            }
        }
        false
    }

    /// Gives the impulse `j` [N s] to a node; what it presses against a wall, the wall takes. Returns the change of the node's
    /// velocity [m/s].
    pub fn give(&mut self, node: usize, j: Vector<D>, soft: Vector<D>) -> Vector<D> {
        let mut left = j;
        let first = self.first.get(node).copied().unwrap_or(NONE) as usize;
        let own = self.rests.iter_mut().skip(first).take_while(|rest| rest.nodes == [node as u32; 4]);
        for rest in own.filter(|rest| rest.impulse.normal != Vector::ZERO) {
            left = rest.take(left);
        }
        Vector::from_fn(|a| left[a] * soft[a])
    }

    /// Adds what the nodes have not got yet to their forces in a sub-step of the momentum `dt` [N, s].
    pub fn hand_over(&mut self, forces: &mut [Vector<D>], dt: f64) {
        for rest in &mut self.rests {
            let total = rest.impulse.total();
            let force = (total - rest.given) / dt;
            rest.given = total;
            for (&k, &weight) in rest.nodes.iter().zip(&rest.weights).filter(|(_, weight)| **weight > 0.0) {
                forces[k as usize] += force * weight;
            }
        }
    }

    /// Books the sub-step, with the velocities that the nodes have in the end.
    pub fn conclude(&mut self, surface: &Surface<'_, D>) {
        for rest in self.rests.iter().filter(|rest| rest.impulse.normal != Vector::ZERO) {
            let j = rest.impulse.total();
            let push = &mut self.pushes[rest.solid as usize];
            push.impulse += j;
            push.work += j.dot(rest.wall);
            push.received += j.dot((rest.at(surface.velocity) + rest.at(surface.previous)) * 0.5);
        }
    }

    /// Undoes a part of what overlaps after the nodes have moved until `elapsed` [s] after the start of the step, except along the axes on which they are held.
    pub fn part(&self, position: &mut [Vector<D>], soft: &impl Fn(usize) -> Vector<D>, elapsed: f64) {
        for rest in &self.rests {
            let gap = rest.gap_after(position, elapsed);
            if gap < 0.0 {
                let by = rest.normal * (-RECOVERY * gap).min(MOST * rest.thickness);
                for (&k, &weight) in rest.nodes.iter().zip(&rest.weights).filter(|(_, weight)| **weight > 0.0) {
                    let soft = soft(k as usize);
                    position[k as usize] += Vector::from_fn(|a| if soft[a] > 0.0 { by[a] * weight } else { 0.0 });
                }
            }
        }
    }

    /// Notes which nodes solids hold at the end of a step.
    pub fn note(&mut self) {
        self.held.fill(Vector::ZERO);
        for rest in self.rests.iter().filter(|rest| rest.impulse.normal != Vector::ZERO && rest.weights[0] == 1.0) {
            let held = &mut self.held[rest.nodes[0] as usize];
            let share = |a: usize| if rest.sticks() { 1.0 } else { rest.normal[a] * rest.normal[a] };
            *held = Vector::from_fn(|a| (held[a] + share(a)).min(1.0));
        }
    }
}

impl<const D: usize> Rest<D> {
    fn place(&self, position: &[Vector<D>]) -> Vector<D> {
        self.at(position)
    }

    /// Σ W_K of values at the nodes.
    fn at(&self, values: &[Vector<D>]) -> Vector<D> {
        if self.weights[0] == 1.0 {
            return values[self.nodes[0] as usize];
        }
        self.nodes.iter().zip(self.weights).map(|(&k, weight)| values[k as usize] * weight).sum()
    }

    /// The gap of the point at `x` [m] from a solid that has moved on by `ahead` [m]: from its surface, if the point has
    /// moved further than `far` since it was last measured.
    fn measure(&mut self, solid: Solid<'_, D>, x: Vector<D>, ahead: Vector<D>, far: f64) {
        let there = x - ahead;
        if (there - self.anchor).norm_squared() > far * far {
            let (distance, normal) = solid.distance(x, ahead);
            (self.measured, self.normal, self.anchor) = (distance - self.offset, normal, there);
        }
        self.gap = self.measured + (there - self.anchor).dot(self.normal);
    }

    /// g [m] at these positions [m], `elapsed` [s] after the start of the step.
    fn gap_after(&self, position: &[Vector<D>], elapsed: f64) -> f64 {
        self.measured + (self.place(position) - self.wall * elapsed - self.anchor).dot(self.normal)
    }

    /// Improves the impulse; returns its change [N s].
    fn push(&mut self, v: &[Vector<D>], soft: &impl Fn(usize) -> Vector<D>, dt: f64) -> Vector<D> {
        let n = self.normal;
        let (mut along, mut across) = (0.0, 0.0_f64);
        for (&k, weight) in self.nodes.iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0) {
            let soft = soft(k as usize);
            along += weight * weight * (0..D).map(|a| n[a] * n[a] * soft[a]).sum::<f64>();
            across += weight * weight * (0..D).map(|a| soft[a]).fold(0.0, f64::max);
        }
        if along == 0.0 {
            return Vector::ZERO;
        }
        let (w, before) = (self.at(v) - self.wall, self.impulse);
        let pressed = (before.normal.dot(n) - (w.dot(n) + self.gap.max(0.0) / dt) / along).max(0.0);
        self.impulse.normal = n * pressed;
        self.impulse.tangent = Vector::ZERO;
        if self.friction > 0.0 && pressed > 0.0 {
            let wanted = before.tangent - (w - n * w.dot(n)) / across;
            let (size, most) = (wanted.norm(), self.friction * pressed);
            self.impulse.tangent = if size > most { wanted * (most / size) } else { wanted };
        }
        self.impulse.total() - before.total()
    }

    /// True if friction holds the point.
    fn sticks(&self) -> bool {
        self.friction > 0.0 && self.impulse.tangent.norm() < self.friction * self.impulse.normal.norm()
    }

    /// Takes what the impulse `j` presses against the solid, as long as that doesn't pull; returns the rest [N s].
    fn take(&mut self, j: Vector<D>) -> Vector<D> {
        let n = self.normal;
        let (along, pressed) = (j.dot(n), self.impulse.normal.dot(n));
        if pressed - along < 0.0 {
            return j;
        }
        let tangent = self.impulse.tangent - (j - n * along);
        if self.sticks() && tangent.norm() <= self.friction * (pressed - along) {
            self.impulse = Impulse { normal: n * (pressed - along), tangent };
            return Vector::ZERO;
        }
        self.impulse.normal = n * (pressed - along);
        j - n * along
    }
}

/// Areas and thicknesses around the nodes of a sheet.
struct Nodes<const D: usize> {
    /// Sum of the area vectors, and of their sizes [m²].
    area: Vec<Vector<D>>,
    size: Vec<f64>,
    /// Mean half thickness times the sum of areas [m³], and of element sizes [m].
    thickness: Vec<f64>,
    length: Vec<f64>,
}

impl<const D: usize> Nodes<D> {
    fn of(facets: &[Facet], surface: &Surface<'_, D>) -> Self {
        let count = surface.position.len();
        let zeros = || vec![0.0; count];
        let mut nodes = Self { area: vec![Vector::ZERO; count], size: zeros(), thickness: zeros(), length: zeros() };
        for (e, facet) in facets.iter().enumerate() {
            let (area, half) = (facet.area(surface.position), surface.offset.get(e).copied().unwrap_or(0.0));
            let (size, length) = (area.norm(), facet.size(surface.position));
            for &k in facet.nodes() {
                let k = k as usize;
                nodes.area[k] += area;
                nodes.size[k] += size;
                nodes.thickness[k] += half * size;
                nodes.length[k] = nodes.length[k].max(length);
            }
        }
        nodes
    }

    /// ½ t |n·ν| at a node; where the sheet is folded, it lies along everything [m].
    fn offset(&self, k: usize, normal: Vector<D>) -> f64 {
        let (area, size) = (self.area[k], self.size[k]);
        if size == 0.0 {
            return 0.0;
        }
        let along = if area.norm() > FOLDED * size { area.dot(normal).abs() / area.norm() } else { 1.0 };
        self.thickness[k] / size * along
    }

    /// A node, if it is near.
    fn rest(
        &self,
        solid: Solid<'_, D>,
        k: usize,
        surface: &Surface<'_, D>,
        at: &SubStep<'_>,
        cell: f64,
    ) -> Option<Rest<D>> {
        let weights = [1.0, 0.0, 0.0, 0.0];
        self.near(solid, ([k as u32; 4], weights), (0.0, self.length[k]), surface, at, cell)
    }

    /// Points of an element that are near.
    fn rests_within(
        &self,
        solid: Solid<'_, D>,
        facet: &Facet,
        surface: &Surface<'_, D>,
        at: &SubStep<'_>,
        cell: f64,
    ) -> Vec<Rest<D>> {
        let points: &[[f64; 4]] = match facet.count {
            2 => &ON_SEGMENT,
            3 => &ON_TRIANGLE,
            _ => &ON_QUADRILATERAL,
        };
        let size = facet.size(surface.position);
        let of_point =
            |weights: &[f64; 4]| self.near(solid, (facet.nodes, *weights), (SAGITTA * size, size), surface, at, cell);
        points.iter().filter_map(of_point).collect()
    }

    /// A point with these nodes and weights, if it is near; `less` [m] of the distance is let through.
    fn near(
        &self,
        solid: Solid<'_, D>,
        (nodes, weights): ([u32; 4], [f64; 4]),
        (less, size): (f64, f64),
        surface: &Surface<'_, D>,
        at: &SubStep<'_>,
        cell: f64,
    ) -> Option<Rest<D>> {
        let mean = |values: &[Vector<D>]| -> Vector<D> {
            nodes.iter().zip(weights).map(|(&k, weight)| values[k as usize] * weight).sum()
        };
        let x = mean(surface.position);
        let wall = solid.velocity(x, at.step);
        let ahead = wall * at.elapsed;
        let (distance, normal) = solid.distance(x, ahead);
        let half: f64 = nodes.iter().zip(weights).map(|(&k, weight)| self.offset(k as usize, normal) * weight).sum();
        let offset = half - less;
        (distance - offset <= REACH * cell).then(|| Rest {
            solid: solid.number() as u32,
            nodes,
            weights,
            offset,
            thickness: half.max(THIN * size),
            normal,
            measured: distance - offset,
            anchor: x - ahead,
            gap: distance - offset,
            wall,
            friction: 0.0,
            impulse: Impulse::default(),
            given: Vector::ZERO,
        })
    }
}

/// Where the vector area is less than this share of the area, the sheet is folded.
const FOLDED: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;

    /// A node that is pressed on a floor with 2 N s, in friction of 0.5: it is held against what presses it, and against
    /// pulls up to 2 N s and slides up to half of what is left.
    #[test]
    fn a_floor_lets_go_of_what_is_pulled_or_slides() {
        let impulse = Impulse { normal: Vector([0.0, 2.0]), tangent: Vector::ZERO };
        let rest = Rest {
            solid: 0,
            nodes: [0; 4],
            weights: [1.0, 0.0, 0.0, 0.0],
            offset: 0.0,
            thickness: 0.0,
            normal: Vector([0.0, 1.0]),
            measured: 0.0,
            anchor: Vector::ZERO,
            gap: 0.0,
            wall: Vector::ZERO,
            friction: 0.5,
            impulse,
            given: Vector::ZERO,
        };
        let rigid = Rigid { rests: vec![rest], first: vec![0], ..Rigid::default() };
        for (j, loosens) in
            [([0.0, -5.0], false), ([0.0, 1.5], false), ([0.0, 2.5], true), ([0.9, 0.0], false), ([1.1, 0.0], true)]
        {
            assert_eq!(rigid.loosens(0, Vector(j)), loosens, "{j:?}");
        }
    }
}
