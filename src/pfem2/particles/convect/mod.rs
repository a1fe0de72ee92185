//! Stage `convect`: particles move along the frozen streamlines of the mesh (Becker (34)–(36); theory F.4, G.13),
//!
//! ```text
//! x_p(t + dt) = x_p + ∫ v(x_p(τ)) dτ
//! ```
//!
//! exactly within every element (see `streamline`), whatever the step. Walls hold particles back, other boundaries
//! let them out; particles of dense fluids may be projectiles in a light one (see `projectile`).

mod crossing;
mod eight;
mod projectile;
mod streamline;
#[cfg(test)]
mod tests;

pub(in crate::pfem2) use eight::Rates;
pub use projectile::Continued;
pub use streamline::{End, MeshPoint, Walk};

use super::{GONE, Particles, interpolate_nodal};
use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::parallel;
use crate::pfem2::boundary::BoundaryKind;
use eight::{Travellers, travel};
use projectile::{HeavyField, Projectile};
use std::borrow::Cow;
use streamline::{Stream, walk};

/// Particles per parallel task.
const TASK: usize = 1024;

/// The velocity that carries the particles, and what bounds it.
#[derive(Debug, Clone, Copy)]
pub struct Flow<'a, const D: usize> {
    /// Velocity of the nodes [m/s].
    pub velocity: &'a [Vector<D>],
    /// Kind of each facet of [`Mesh::boundary`].
    pub boundary: &'a [BoundaryKind],
    /// Set if dense fluids follow their side of the interface.
    pub projectiles: Option<Projectiles<'a, D>>,
}

/// The projectile rule (Becker (36); theory G.13).
#[derive(Debug, Clone, Copy)]
pub struct Projectiles<'a, const D: usize> {
    /// True for the fluids that it holds for.
    pub fluids: &'a [bool],
    /// Level set at the nodes, negative in these fluids [m].
    pub level: &'a [f64],
    /// Body force at the nodes [m/s²].
    pub body_force: &'a [Vector<D>],
}

impl<const D: usize> Projectiles<'_, D> {
    /// The body force at a point of an element, from its shape functions and nodes [m/s²]; one that is the same at all
    /// nodes is that to the last bit.
    pub(super) fn body_force_at<const N: usize>(&self, shape: &[f64; N], nodes: &[u32; N]) -> Vector<D> {
        let first = self.body_force[nodes[0] as usize];
        let is_uniform = nodes.iter().all(|&node| self.body_force[node as usize] == first);
        if is_uniform { first } else { interpolate_nodal(shape, nodes, self.body_force) }
    }
}

/// Counts of particles that left the mesh or stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ConvectionCounts {
    /// Left the mesh through outlets or inlets.
    pub left: usize,
    /// Crossed too many elements and stopped on their way.
    pub stuck: usize,
}

impl std::ops::Add for ConvectionCounts {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { left: self.left + other.left, stuck: self.stuck + other.stuck }
    }
}

impl<const D: usize> Particles<D> {
    /// Moves all particles along the streamlines for `dt` [s], drops those that leave, and sorts the rest.
    pub fn convect<const N: usize>(&mut self, lines: &Streamlines<D, N>, dt: f64) -> ConvectionCounts {
        let fate = self.carry(lines, dt);
        self.sort();
        fate
    }

    /// Moves all particles along the streamlines for `dt` [s]. [`Particles::sort`] has to follow.
    pub fn carry<const N: usize>(&mut self, lines: &Streamlines<D, N>, dt: f64) -> ConvectionCounts {
        let &Streamlines { mesh, flow, ref rates, .. } = lines;
        let heavy = flow.projectiles.map(|rule| (rule, HeavyField::new(mesh, flow.velocity, rule.level)));
        let columns = (&mut self.position[..], &mut self.element[..], &self.velocity[..], &self.phase[..]);
        let moved = parallel::map_chunks(columns, TASK, |_, (position, element, velocity, phase)| {
            let mut group = Group {
                lines,
                heavy: None,
                position,
                element,
                velocity,
                phase,
                seen: 0,
                fate: ConvectionCounts::default(),
            };
            // Becker (35), exactly, in place of the integral of Becker (34).
            if let Some((rule, field)) = &heavy {
                group.heavy = Some((rule, field, true));
                travel(mesh, &field.rates, [dt, 1.0], &mut group);
                (group.heavy, group.seen) = (Some((rule, field, false)), 0);
            }
            travel(mesh, rates, [dt, 1.0], &mut group);
            group.fate
        });
        moved.into_iter().fold(ConvectionCounts::default(), |a, b| a + b)
    }
}

/// Some particles on their way.
struct Group<'a, const D: usize, const N: usize> {
    lines: &'a Streamlines<'a, D, N>,
    /// The projectile rule with its field, if a fluid has projectiles, and whether these are the ones that travel now.
    heavy: Option<(&'a Projectiles<'a, D>, &'a HeavyField<D>, bool)>,
    position: &'a mut [Vector<D>],
    element: &'a mut [u32],
    velocity: &'a [Vector<D>],
    phase: &'a [u8],
    /// Next particle to look at; those before it have been traced, or are left out of this pass.
    seen: usize,
    fate: ConvectionCounts,
}

impl<const D: usize, const N: usize> Travellers<N> for Group<'_, D, N> {
    #[inline(always)]
    fn next(&mut self) -> Option<(usize, MeshPoint<N>)> {
        let count = self.position.len();
        if let Some((rule, _, now)) = self.heavy {
            while self.seen < count && rule.fluids[self.phase[self.seen] as usize] != now {
                self.seen += 1;
            }
        }
        if self.seen == count {
            return None;
        }
        let p = self.seen;
        self.seen += 1;
        Some((p, MeshPoint::of(self.lines.mesh, self.element[p] as usize, self.position[p])))
    }

    fn alone(&self, p: usize, from: MeshPoint<N>, rest: f64) -> Walk<N> {
        match self.heavy {
            Some((rule, field, true)) => self.lines.trace_projectile(rule, field, self.velocity[p], from, rest),
            _ => self.lines.trace(from, rest, 1.0),
        }
    }

    #[inline(always)]
    fn arrive(&mut self, p: usize, walk: Walk<N>) {
        self.position[p] = walk.place.position(self.lines.mesh);
        self.element[p] = walk.place.element as u32;
        match walk.end {
            End::Inside => {}
            End::Boundary(_) => {
                self.element[p] = GONE;
                self.fate.left += 1;
            }
            End::Stuck => self.fate.stuck += 1,
        }
    }
}

/// Places that are traced.
struct Traces<'a, const D: usize, const N: usize> {
    lines: &'a Streamlines<'a, D, N>,
    sign: f64,
    from: &'a [MeshPoint<N>],
    walks: &'a mut [Walk<N>],
    seen: usize,
}

impl<const D: usize, const N: usize> Travellers<N> for Traces<'_, D, N> {
    #[inline(always)]
    fn next(&mut self) -> Option<(usize, MeshPoint<N>)> {
        let place = *self.from.get(self.seen)?;
        self.seen += 1;
        Some((self.seen - 1, place))
    }

    fn alone(&self, _: usize, from: MeshPoint<N>, rest: f64) -> Walk<N> {
        self.lines.trace(from, rest, self.sign)
    }

    #[inline(always)]
    fn arrive(&mut self, number: usize, walk: Walk<N>) {
        self.walks[number] = walk;
    }
}

/// The streamlines of a flow.
pub struct Streamlines<'a, const D: usize, const N: usize> {
    mesh: &'a Mesh<D, N>,
    flow: Flow<'a, D>,
    rates: Cow<'a, Rates>,
}

impl<'a, const D: usize, const N: usize> Streamlines<'a, D, N> {
    /// Prepares the elements of the mesh.
    pub fn new(mesh: &'a Mesh<D, N>, flow: &Flow<'a, D>) -> Self {
        Self { mesh, flow: *flow, rates: Cow::Owned(Rates::new(mesh, flow.velocity, |_| true)) }
    }

    /// With the elements as [`Streamlines::new`] prepared them for the same velocity.
    pub(in crate::pfem2) fn with_rates(mesh: &'a Mesh<D, N>, flow: &Flow<'a, D>, rates: &'a Rates) -> Self {
        Self { mesh, flow: *flow, rates: Cow::Borrowed(rates) }
    }

    /// The prepared elements.
    pub(in crate::pfem2) fn into_rates(self) -> Rates {
        self.rates.into_owned()
    }

    /// Follows the streamline for `time` [s], forwards (`sign` 1) or backwards (−1).
    pub fn trace(&self, from: MeshPoint<N>, time: f64, sign: f64) -> Walk<N> {
        let mut stream = Stream { velocity: self.flow.velocity, sign };
        walk(self.mesh, &mut stream, from, time, |e, k| self.holds(e, k))
    }

    /// Follows the streamlines from many places, as [`Streamlines::trace`] does from one.
    pub fn trace_all(&self, from: &[MeshPoint<N>], time: f64, sign: f64) -> Vec<Walk<N>> {
        let mut walks: Vec<_> = from.iter().map(|&place| Walk { place, end: End::Inside, rest: time }).collect();
        parallel::for_each_chunk((&mut walks[..], from), TASK, |_, (walks, from)| {
            let mut traces = Traces { lines: self, sign, from, walks, seen: 0 };
            travel(self.mesh, &self.rates, [time, sign], &mut traces);
        });
        walks
    }

    /// Follows a projectile of this velocity [m/s] for a time [s].
    fn trace_projectile(
        &self,
        rule: &Projectiles<D>,
        field: &HeavyField<D>,
        velocity: Vector<D>,
        from: MeshPoint<N>,
        time: f64,
    ) -> Walk<N> {
        let stream = Stream { velocity: &field.velocity, sign: 1.0 };
        let mut projectile = Projectile { stream, carried: &field.carried, velocity, rule, body_force: None };
        walk(self.mesh, &mut projectile, from, time, |e, k| self.holds(e, k))
    }

    /// The kind of the boundary facet of an element opposite to a local node.
    pub fn kind(&self, element: usize, opposite: usize) -> BoundaryKind {
        let facet = Facet { element: element as u32, opposite: opposite as u32 };
        self.mesh.boundary().binary_search(&facet).map_or(BoundaryKind::Wall, |place| self.flow.boundary[place])
    }

    /// True if the boundary facet of an element opposite to a local node holds particles back.
    pub fn holds(&self, element: usize, opposite: usize) -> bool {
        !self.kind(element, opposite).admits_flow()
    }
}
