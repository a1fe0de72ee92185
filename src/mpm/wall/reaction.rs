//! Forces of walls and obstacles on one velocity field during a step, their work and losses (theory E.9).

use super::{Walls, hold, surface};
use crate::math::Vector;
use crate::mpm::ghost::{Ghosts, Limits};
use crate::mpm::{Grid, Node, Step};
use crate::parallel;

/// What the walls did to one velocity field during a step.
#[derive(Debug, Clone, Default)]
pub struct Reaction<const D: usize> {
    /// Force of each condition [N].
    pub force: Vec<Vector<D>>,
    /// Gap at the node of each condition [m], and whether it closes in this step.
    pub gap: Vec<f64>,
    pub closed: Vec<bool>,
    /// The contacts that held at the end of the last step; the conditions of them are true.
    pub holding: Vec<hold::Holding>,
    pub held: Vec<bool>,
    /// Changes of p⁻ per boundary [N s].
    pub start: Vec<Vector<D>>,
    /// Mirrored force and momentum per side, and the masses of the mirrored ghosts.
    pub mirrored: Vec<Vector<D>>,
    pub mirrored_start: Vec<Vector<D>>,
    pub ghosts: Vec<(u32, u32, f64)>,
    /// Where the field meets the surfaces of obstacles, and what was in contact there at the end of the last step.
    pub surface: surface::Surface<D>,
    pub resting: Vec<hold::Resting>,
}

/// Work of a step [J], and the impulse on the particles [N s].
#[derive(Debug, Clone, Copy, Default)]
pub struct WallWork<const D: usize> {
    /// Work that moving walls did on the material.
    pub work: f64,
    /// Energy lost to friction and stopping.
    pub dissipation: f64,
    /// Impulse on the particles.
    pub impulse: Vector<D>,
}

/// Sums over conditions: impulses on the material by boundary [N s], work of the moving walls and of all forces [J].
struct Sums<const D: usize> {
    impulse: Vec<Vector<D>>,
    work: f64,
    total: f64,
}

impl<const D: usize> Sums<D> {
    /// Adds what a boundary did at `x` [m] with a force [N] on what moved with `velocity` [m/s] on average.
    fn add(
        &mut self,
        walls: &Walls<D>,
        (boundary, x): (u32, Vector<D>),
        (force, velocity): (Vector<D>, Vector<D>),
        step: &Step,
    ) {
        let (boundary, dt) = (boundary as usize, step.momentum_dt);
        let wall = |t: f64| walls.velocity(boundary, x, t);
        self.impulse[boundary] += force * dt;
        self.total += force.dot(velocity) * dt;
        self.work += force.dot(wall(step.before()) + wall(step.after())) * (0.5 * dt);
    }

    fn and(mut self, other: Self) -> Self {
        self.impulse.iter_mut().zip(other.impulse).for_each(|(sum, impulse)| *sum += impulse);
        Self { work: self.work + other.work, total: self.total + other.total, ..self }
    }
}

impl<const D: usize> Walls<D> {
    /// Starts a step: no reactions yet.
    pub fn start_step(&mut self, grid: &Grid<D>) {
        self.recall_contacts(grid);
        self.force.fill(Vector::ZERO);
        for reaction in &mut self.reactions {
            let zero = |column: &mut Vec<Vector<D>>, len: usize| {
                column.clear();
                column.resize(len, Vector::ZERO);
            };
            zero(&mut reaction.force, self.conditions.len());
            reaction.closed.clear();
            reaction.closed.resize(self.conditions.len(), false);
            zero(&mut reaction.start, self.boundaries.len());
            zero(&mut reaction.mirrored, 2 * D);
            zero(&mut reaction.mirrored_start, 2 * D);
            reaction.ghosts.clear();
        }
    }

    /// Folds the ghosts of a field's nodes into the domain and books what mirrors reflect.
    pub fn fold(&mut self, (ghosts, limits): (&Ghosts<D>, &Limits), field: usize, nodes: &mut [Node<D>]) {
        let reaction = &mut self.reactions[field];
        ghosts.fold(limits, nodes, |side, node, ghost| {
            let axis = Vector::unit(side / 2);
            reaction.mirrored[side] -= axis * (2.0 * ghost.force[side / 2]);
            reaction.mirrored_start[side] -= axis * (2.0 * ghost.momentum[side / 2]);
            if ghost.mass > 0.0 {
                reaction.ghosts.push((side as u32, node as u32, ghost.mass));
            }
        });
    }

    /// Closes a field's step: work, losses and impulses of the walls. Nodes hold (m, v⁺, a) with the ghosts
    /// filled; `share` is the part of the particles' velocity that comes from v⁺ itself (PIC, APIC).
    pub fn settle(&mut self, grid: &Grid<D>, field: usize, nodes: &[Node<D>], step: &Step, share: f64) -> WallWork<D> {
        let dt = step.momentum_dt;
        let reaction = &self.reactions[field];
        let Sums { mut impulse, work, total } = self.sum_reactions(grid, field, nodes, step);
        for (boundary, &start) in reaction.start.iter().enumerate() {
            impulse[boundary] += start * share;
        }
        let mirrored = reaction.mirrored.iter().zip(&reaction.mirrored_start);
        for (impulse, (&force, &start)) in impulse.iter_mut().zip(mirrored) {
            *impulse += force * dt + start * share;
        }
        for &(side, node, mass) in &reaction.ghosts {
            let Node { momentum: v, force: a, .. } = nodes[node as usize];
            let carried = a * dt + (v - a * dt) * share;
            impulse[side as usize] += Vector::unit(side as usize / 2) * (2.0 * mass * carried[side as usize / 2]);
        }
        for (force, impulse) in self.force.iter_mut().zip(&impulse) {
            *force += *impulse / dt;
        }
        WallWork { work, dissipation: work - total, impulse: impulse.into_iter().sum() }
    }

    /// What the conditions of a field did, summed over their nodes.
    fn sum_reactions(&self, grid: &Grid<D>, field: usize, nodes: &[Node<D>], step: &Step) -> Sums<D> {
        let none = || Sums { impulse: vec![Vector::ZERO; self.boundaries.len()], work: 0.0, total: 0.0 };
        let force = &self.reactions[field].force;
        let mean = |node: usize| nodes[node].momentum - nodes[node].force * (0.5 * step.momentum_dt);
        let sum = |range: std::ops::Range<usize>| {
            let mut sums = none();
            for (condition, &force) in self.conditions[range.clone()].iter().zip(&force[range]) {
                let node = condition.node as usize;
                sums.add(self, (condition.boundary, grid.position(node)), (force, mean(node)), step);
            }
            sums
        };
        let mut sums = parallel::reduce(self.conditions.len(), sum, Sums::and).unwrap_or_else(none);
        for (point, velocity) in self.reactions[field].surface.velocities(mean) {
            sums.add(self, (point.boundary, point.place), (point.force, velocity), step);
        }
        sums
    }
}
