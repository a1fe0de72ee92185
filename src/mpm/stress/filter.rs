//! The FMPM(k) filter: an approximate inverse of the full mass matrix (theory A.7; Nairn & Hammerquist 2021).
//!
//! FLIP keeps velocity modes that the grid can't see. One update of order k now and then replaces the
//! particles' velocity v_p by Σ N v⁽ᵏ⁾, where
//!
//! ```text
//! A = M⁻¹ Σ m_p N_Ip N_Jp,   w₁ = M⁻¹ Σ m_p N_Ip v_p,   w_{j+1} = w_j − A w_j,   v⁽ᵏ⁾ = Σ_{j=1..k} w_j
//! ```
//!
//! With w₁ = v⁺, as in FMPM, the nodes would give once more what the particles had not taken of their increments; so it is an
//! operator with eigenvalues in 0..=1, which never adds energy.
//!
//! Order 1 is PIC; higher orders keep more of what the grid can see. Corrections don't act along axes
//! that a wall binds.

use super::heat::{nodal, warm_by_filter};
use crate::math::Vector;
use crate::mpm::Dissipation;
use crate::mpm::grid::{Field, Ghosts, Grid, Limits, Node, SmallMassNode};
use crate::mpm::particles::Body;
use crate::mpm::particles::motion::keep_velocity;
use crate::mpm::transfer::{Content, GatherFields, Record, Sweep, put_scalar, put_velocity};
use crate::mpm::wall::{Pushes, Walls};
use crate::parallel::{self, CHUNK};

/// The filter of one velocity field.
pub struct Filter<'a, const D: usize> {
    /// The grid, whose nodes hold (m, v⁺, a).
    pub grid: &'a Grid<D>,
    /// Its ghosts.
    pub ghosts: &'a Ghosts<D>,
    /// What binds its nodes.
    pub walls: &'a Walls<D>,
    /// Number of the velocity field.
    pub field: usize,
    /// The time at which the velocities hold [s].
    pub t: f64,
    /// Order k.
    pub order: u32,
    /// Where the energy goes that the filter takes.
    pub dissipation: Dissipation,
}

impl<const D: usize> Filter<'_, D> {
    /// Replaces the velocities of the field's bodies by Σ N v⁽ᵏ⁾. Returns the heat [J] that it becomes in the bodies that keep
    /// it, and what walls gave.
    pub fn apply(&self, bodies: &mut [&mut Body<D>]) -> (f64, Pushes<D>) {
        let &Self { grid, ghosts, walls, field, t, order, .. } = self;
        let (nodes, limits, mut pushes) = (&grid.fields[field].nodes, &grid.fields[field].limits, walls.pushes());
        let mut w = self.on_grid(bodies, Vec::new(), (&mut pushes, 1.0));
        pushes = pushes.and(walls.constrain_velocity((grid, field), nodes, &mut w, t));
        ghosts.fill(limits, &mut w);
        let (mut v, mut smooth) = (w.clone(), Vec::new());
        for body in bodies.iter_mut().filter(|body| self.dissipation.warms(body)) {
            body.work.noise.clone_from(&body.particles.velocity);
        }
        let mut heat = gather(grid, (ghosts, limits), &w, bodies, (1, order));
        for j in 2..=order {
            smooth = self.on_grid(bodies, smooth, (&mut pushes, -1.0));
            w.iter_mut().zip(&smooth).for_each(|(w, s)| *w -= *s);
            pushes = pushes.and(walls.constrain_correction((grid, field), nodes, &mut w, t));
            ghosts.fill(limits, &mut w);
            v.iter_mut().zip(&w).for_each(|(v, w)| *v += *w);
            heat += gather(grid, (ghosts, limits), &w, bodies, (j, order));
        }
        for body in bodies {
            body.work.noise.clear();
            gather_velocity(grid, &v, body);
        }
        (heat, pushes.and(walls.reflect(field, &w)))
    }

    /// Σ m_p N_Ip v_p / m_I [m/s], in the memory of `velocity`; counts so many times what mirrors make of the momentum.
    fn on_grid(
        &self,
        bodies: &[&mut Body<D>],
        velocity: Vec<Vector<D>>,
        (pushes, times): (&mut Pushes<D>, f64),
    ) -> Vec<Vector<D>> {
        let field = &self.grid.fields[self.field];
        let mut velocity = momentum_on_grid(self.grid, field, bodies, velocity);
        pushes.fold((self.ghosts, &field.limits), &mut velocity, times);
        divide_by_mass(&field.nodes, &field.small, &mut velocity);
        velocity
    }
}

/// Σ m_p N_Ip v_p [N s] of the bodies of a field, in the memory of `momentum`; ghosts not yet folded.
fn momentum_on_grid<const D: usize>(
    grid: &Grid<D>,
    field: &Field<D>,
    bodies: &[&mut Body<D>],
    mut momentum: Vec<Vector<D>>,
) -> Vec<Vector<D>> {
    momentum.clear();
    momentum.resize(field.nodes.len(), Vector::ZERO);
    for body in bodies {
        Sweep::new(grid, body).scatter(&mut momentum, body, Content::Momentum);
    }
    momentum
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

/// v_p = Σ N w_j; of bodies that keep the heat, what that becomes [J].
fn gather<const D: usize>(
    grid: &Grid<D>,
    (ghosts, limits): (&Ghosts<D>, &Limits),
    w: &[Vector<D>],
    bodies: &mut [&mut Body<D>],
    (j, order): (u32, u32),
) -> f64 {
    let warmed = bodies.iter().any(|body| !body.work.noise.is_empty());
    let squares = if warmed { nodal((ghosts, limits), w.len(), |n| w[n].norm_squared()) } else { Vec::new() };
    let mut heat = 0.0;
    for body in bodies {
        if !body.work.noise.is_empty() {
            let node = |n: usize, record: &mut Record| {
                put_scalar(record, squares[n][0]);
                put_velocity(record, &w[n]);
            };
            let (sweep, _, view) = body.sweep(grid);
            heat += sweep.gather(node, view, GatherFields::Gradient, |chunk| {
                keep_velocity(chunk.particles.velocity, chunk.rows);
                warm_by_filter(chunk, j, order)
            });
        } else if j < order {
            gather_velocity(grid, w, body);
        }
    }
    heat
}

/// v_p = Σ N_Ip u_I.
fn gather_velocity<const D: usize>(grid: &Grid<D>, nodal: &[Vector<D>], body: &mut Body<D>) {
    let node = |n: usize, record: &mut Record| put_velocity(record, &nodal[n]);
    let (sweep, _, view) = body.sweep(grid);
    sweep.gather(node, view, GatherFields::Motion, |chunk| keep_velocity(chunk.particles.velocity, chunk.rows));
}
