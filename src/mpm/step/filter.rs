//! The FMPM(k) filter: an approximate inverse of the full mass matrix (theory A.7; Nairn & Hammerquist 2021).
//!
//! FLIP keeps velocity modes that the grid can't see. One update of order k now and then replaces the
//! particles' velocity v_p by Σ N v⁽ᵏ⁾, where
//!
//! ```text
//! A = M⁻¹ Σ m_p N_Ip N_Jp,   w₁ = M⁻¹ Σ m_p N_Ip v_p,   w_{j+1} = w_j − A w_j,   v⁽ᵏ⁾ = Σ_{j=1..k} w_j
//! ```
//!
//! With w₁ = v⁺, as in FMPM, the nodes would give once more what the particles had not taken of their increments; so it
//! is an operator with eigenvalues in 0..=1, which never adds energy.
//!
//! Order 1 is PIC; higher orders keep more of what the grid can see. Corrections don't act along axes
//! that a wall binds.

use crate::math::Vector;
use crate::mpm::executor::{Gathering, Nodal, Operation, Operations, Scattering, Targets, Visitor};
use crate::mpm::grid::{Node, SmallMassNode};
use crate::mpm::particles::Body;
use crate::mpm::stress::heat::nodal;
use crate::mpm::transfer::ScatterContent;
use crate::mpm::wall::{Pushes, Walls};
use crate::parallel::{self, CHUNK};

/// The filter of one velocity field.
pub(super) struct Filter<'a, const D: usize> {
    /// The sweeps over the particles; the nodes of the grid hold (m, v⁺, a).
    pub visitor: Visitor<'a, D>,
    /// The walls and obstacles that bind its nodes.
    pub walls: &'a Walls<D>,
    /// The time at which the velocities hold [s].
    pub t: f64,
    /// Order k.
    pub order: u32,
}

impl<const D: usize> Filter<'_, D> {
    /// Replaces the velocities of the field's bodies by Σ N v⁽ᵏ⁾. Returns the heat [J] that it becomes in the bodies
    /// that keep it, and the impulses of walls.
    pub fn apply(&self, bodies: &mut [Body<D>]) -> (f64, Pushes<D>) {
        let &Self { walls, t, order, .. } = self;
        let Visitor { grid, field, ghosts, parameters, .. } = self.visitor;
        let (nodes, limits, mut pushes) = (&grid.fields[field].nodes, &grid.fields[field].limits, walls.pushes());
        let mut w = self.on_grid(bodies, Vec::new(), &mut pushes, 1.0);
        pushes = pushes.plus(walls.constrain_velocity(grid, field, nodes, &mut w, t));
        ghosts.fill(limits, &mut w);
        let (mut v, mut smooth) = (w.clone(), Vec::new());
        for body in bodies.iter_mut().filter(|body| parameters.dissipation.warms(body)) {
            body.work.noise.clone_from(&body.particles.velocity);
        }
        let mut heat = self.gather(&w, bodies, 1);
        for j in 2..=order {
            smooth = self.on_grid(bodies, smooth, &mut pushes, -1.0);
            w.iter_mut().zip(&smooth).for_each(|(w, s)| *w -= *s);
            pushes = pushes.plus(walls.constrain_correction(grid, field, nodes, &mut w, t));
            ghosts.fill(limits, &mut w);
            v.iter_mut().zip(&w).for_each(|(v, w)| *v += *w);
            heat += self.gather(&w, bodies, j);
        }
        for body in bodies {
            body.work.noise.clear();
            self.gather_from(&v, &[], &[Operation::TakeVelocity], body);
        }
        (heat, pushes.plus(walls.reflect(field, &w)))
    }

    /// Σ m_p N_Ip v_p / m_I [m/s], in the memory of `velocity`; counts so many times the impulse of mirrors.
    fn on_grid(
        &self,
        bodies: &mut [Body<D>],
        mut velocity: Vec<Vector<D>>,
        pushes: &mut Pushes<D>,
        times: f64,
    ) -> Vec<Vector<D>> {
        let Visitor { grid, field, ghosts, executor, .. } = self.visitor;
        let own = &grid.fields[field];
        velocity.clear();
        velocity.resize(own.nodes.len(), Vector::ZERO);
        for body in bodies {
            let targets = Targets::Momentum(&mut velocity);
            executor.scatter(grid, field, body, Scattering { content: ScatterContent::Momentum, targets });
        }
        pushes.fold(ghosts, &own.limits, &mut velocity, times);
        divide_by_mass(&own.nodes, &own.small, &mut velocity);
        velocity
    }

    /// v_p = Σ N w_j; returns the heat of the bodies that keep it [J].
    fn gather(&self, w: &[Vector<D>], bodies: &mut [Body<D>], j: u32) -> f64 {
        let limits = &self.visitor.grid.fields[self.visitor.field].limits;
        let warmed = bodies.iter().any(|body| !body.work.noise.is_empty());
        let squares = |n: usize| w[n].norm_squared();
        let squares = if warmed { nodal(self.visitor.ghosts, limits, w.len(), squares) } else { Vec::new() };
        let warm = [Operation::TakeVelocity, Operation::FilterHeat { stage: j, order: self.order }];
        let mut heat = 0.0;
        for body in bodies {
            if !body.work.noise.is_empty() {
                heat += self.gather_from(w, &squares, &warm, body);
            } else if j < self.order {
                self.gather_from(w, &[], &warm[..1], body);
            }
        }
        heat
    }

    /// Performs operations with a velocity and a scalar of the nodes; returns the heat [J].
    fn gather_from(&self, velocity: &[Vector<D>], scalar: &[[f64; 1]], list: &[Operation], body: &mut Body<D>) -> f64 {
        let Visitor { grid, field, executor, parameters, .. } = &self.visitor;
        let operations = Operations::new(list, parameters, grid, body);
        executor.gather(grid, *field, body, Gathering { nodal: Nodal::Velocity { velocity, scalar }, operations }).heat
    }
}

/// Makes velocities of momentum that was scattered and folded; nodes of small mass follow their neighbours.
pub fn divide_by_mass<const D: usize>(nodes: &[Node<D>], small: &[SmallMassNode], momentum: &mut [Vector<D>]) {
    let velocity = |(v, node): (&mut Vector<D>, &Node<D>)| {
        *v = if node.mass > 0.0 { *v / node.mass } else { Vector::ZERO };
    };
    parallel::for_each_chunk((&mut *momentum, nodes), CHUNK, |_, (momentum, nodes)| {
        momentum.iter_mut().zip(nodes).for_each(velocity);
    });
    small.iter().for_each(|node| node.follow(momentum));
}
