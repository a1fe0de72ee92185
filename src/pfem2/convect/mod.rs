//! Stage 1: particles move along the frozen streamlines of the mesh (eqs. 34–36; theory section 3),
//!
//! ```text
//! x_p(t + dt) = x_p + ∫ v(x_p(τ)) dτ
//! ```
//!
//! exactly within every element (see `streamline`), whatever the step. Walls hold particles back, other boundaries
//! let them out; particles of dense fluids may fly through a light one (see `projectile`).

mod crossing;
mod projectile;
mod streamline;
#[cfg(test)]
mod tests;

pub use projectile::Continued;
pub use streamline::{End, Place, Walk};

use super::boundary::BoundaryKind;
use super::particles::{GONE, Particles};
use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use projectile::{HeavyField, Projectile};
use rayon::prelude::*;
use streamline::{Rate, Stream, walk};

/// Particles per parallel task.
const TASK: usize = 1024;

/// The velocity that carries the particles, and what bounds it.
#[derive(Debug, Clone, Copy)]
pub struct Flow<'a, const D: usize> {
    /// Velocity of the nodes [m/s].
    pub velocity: &'a [Vector<D>],
    /// What each facet of [`Mesh::boundary`] is.
    pub boundary: &'a [BoundaryKind],
    /// Set if dense fluids follow their own side of the interface.
    pub projectiles: Option<Projectiles<'a, D>>,
}

/// The projectile rule (eq. 36).
#[derive(Debug, Clone, Copy)]
pub struct Projectiles<'a, const D: usize> {
    /// True for the fluids that it holds for.
    pub fluids: &'a [bool],
    /// Level set at the nodes, negative in these fluids [m].
    pub level: &'a [f64],
    /// Gravity [m/s²].
    pub gravity: Vector<D>,
}

/// What became of the particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Convected {
    /// Left the mesh through outlets or inlets.
    pub left: usize,
    /// Crossed too many elements and stopped on their way.
    pub stuck: usize,
}

impl std::ops::Add for Convected {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { left: self.left + other.left, stuck: self.stuck + other.stuck }
    }
}

impl<const D: usize> Particles<D> {
    /// Moves all particles along the streamlines for `dt` [s], drops those that leave, and sorts the rest.
    pub fn convect<const N: usize>(&mut self, lines: &Streamlines<D, N>, dt: f64) -> Convected {
        let &Streamlines { mesh, flow, .. } = lines;
        let heavy = flow.projectiles.map(|rule| (rule, HeavyField::new(mesh, flow.velocity, rule.level)));
        let columns = self.position.par_chunks_mut(TASK).zip(self.element.par_chunks_mut(TASK));
        let columns = columns.zip(self.velocity.par_chunks(TASK).zip(self.fluid.par_chunks(TASK)));
        let moved = columns.map(|((position, element), (velocity, fluid))| {
            let mut fate = Convected::default();
            for (p, x) in position.iter_mut().enumerate() {
                let from = Place::of(mesh, element[p] as usize, *x);
                let end = match &heavy {
                    Some((rule, field)) if rule.fluids[fluid[p] as usize] => {
                        lines.fly(rule, field, velocity[p], from, dt)
                    }
                    _ => lines.trace(from, dt, 1.0),
                };
                *x = end.place.position(mesh);
                element[p] = end.place.element as u32;
                match end.end {
                    End::Inside => {}
                    End::Boundary(_) => {
                        element[p] = GONE;
                        fate.left += 1;
                    }
                    End::Stuck => fate.stuck += 1,
                }
            }
            fate
        });
        let fate = moved.reduce(Convected::default, |a, b| a + b);
        self.sort();
        fate
    }
}

/// The streamlines of a flow.
pub struct Streamlines<'a, const D: usize, const N: usize> {
    mesh: &'a Mesh<D, N>,
    flow: Flow<'a, D>,
    rates: Vec<Rate<N>>,
}

impl<'a, const D: usize, const N: usize> Streamlines<'a, D, N> {
    /// Prepares the elements of the mesh.
    pub fn new(mesh: &'a Mesh<D, N>, flow: &Flow<'a, D>) -> Self {
        Self { mesh, flow: *flow, rates: rates(mesh, flow.velocity) }
    }

    /// Follows the streamline for `time` [s], forwards (`sign` 1) or backwards (−1).
    #[inline(always)]
    pub fn trace(&self, from: Place<N>, time: f64, sign: f64) -> Walk<N> {
        walk(self.mesh, &mut Stream { rates: &self.rates, sign }, from, time, |e, k| self.holds(e, k))
    }

    fn fly(
        &self,
        rule: &Projectiles<D>,
        field: &HeavyField<N>,
        velocity: Vector<D>,
        from: Place<N>,
        time: f64,
    ) -> Walk<N> {
        let stream = Stream { rates: &field.rates, sign: 1.0 };
        let mut projectile =
            Projectile { stream, carried: &field.carried, velocity, flying: false, gravity: rule.gravity };
        walk(self.mesh, &mut projectile, from, time, |e, k| self.holds(e, k))
    }

    /// The kind of the boundary facet of an element opposite to a local node.
    pub fn kind(&self, element: usize, opposite: usize) -> BoundaryKind {
        let facet = Facet { element: element as u32, opposite: opposite as u32 };
        self.mesh.boundary().binary_search(&facet).map_or(BoundaryKind::Wall, |place| self.flow.boundary[place])
    }

    fn holds(&self, element: usize, opposite: usize) -> bool {
        matches!(self.kind(element, opposite), BoundaryKind::Wall | BoundaryKind::Slip)
    }
}

fn rates<const D: usize, const N: usize>(mesh: &Mesh<D, N>, velocity: &[Vector<D>]) -> Vec<Rate<N>> {
    let rate = |(e, nodes): (usize, &[u32; N])| {
        Rate::new(&mesh.simplex(e).gradient, nodes.map(|node| velocity[node as usize]))
    };
    mesh.elements().par_iter().enumerate().map(rate).collect()
}
