//! Forces of walls and obstacles on one velocity field during a step, their work and losses (theory E.9).

use super::pushes::MirroredGhost;
use super::surface::{SurfacePoint, SurfacePoints};
use super::{WallWork, Walls, lasting};
use crate::math::Vector;
use crate::mpm::grid::{GhostFractions, Ghosts, NodeMotion};
use crate::mpm::{Grid, LeapfrogStep, Node};
use crate::parallel;

/// Forces and impulses of the walls on one velocity field during a step.
#[derive(Debug, Clone, Default)]
pub struct FieldReaction<const D: usize> {
    /// Force of each condition [N].
    pub force: Vec<Vector<D>>,
    /// Gap at the node of each condition [m], and whether it closes in this step.
    pub gap: Vec<f64>,
    pub closed: Vec<bool>,
    /// The contacts that held at the end of the last step, and for each condition true if it is one of them.
    pub contacts_before: Vec<lasting::NodeContact>,
    pub held: Vec<bool>,
    /// Changes of p⁻ per boundary [N s].
    pub start_change: Vec<Vector<D>>,
    /// Mirrored force per side [N].
    pub mirrored: Vec<Vector<D>>,
    /// Mirrored momentum per side [N s].
    pub mirrored_start: Vec<Vector<D>>,
    /// Mirrored ghosts with a mass.
    pub ghosts: Vec<MirroredGhost>,
    /// Contact of the field with surfaces of obstacles, and the particles in contact at the end of the last step.
    pub surface: SurfacePoints<D>,
    pub particle_contacts_before: Vec<lasting::ParticleContact>,
}

/// Sums over conditions: impulses on the material by boundary [N s], work of the moving walls and of all forces [J].
struct ReactionSums<const D: usize> {
    impulse: Vec<Vector<D>>,
    work: f64,
    total: f64,
}

/// Force of a boundary on the material at one place during a step.
struct ForceAtPlace<const D: usize> {
    boundary: u32,
    /// Place [m].
    x: Vector<D>,
    /// Force [N].
    force: Vector<D>,
    /// Mean velocity of the material there [m/s].
    velocity: Vector<D>,
}

impl<const D: usize> ReactionSums<D> {
    /// Adds impulse and work of a force during a step.
    fn add(&mut self, walls: &Walls<D>, at: ForceAtPlace<D>, step: &LeapfrogStep) {
        let ForceAtPlace { boundary, x, force, velocity } = at;
        let (boundary, dt) = (boundary as usize, step.momentum_dt);
        let wall = |t: f64| walls.velocity(boundary, x, t);
        self.impulse[boundary] += force * dt;
        self.total += force.dot(velocity) * dt;
        self.work += force.dot(wall(step.before()) + wall(step.after())) * (0.5 * dt);
    }

    fn plus(mut self, other: Self) -> Self {
        self.impulse.iter_mut().zip(other.impulse).for_each(|(sum, impulse)| *sum += impulse);
        Self { work: self.work + other.work, total: self.total + other.total, ..self }
    }
}

impl<const D: usize> Walls<D> {
    /// Starts a step: no reactions yet.
    pub fn start_step(&mut self, grid: &Grid<D>) {
        self.find_lasting_contacts(grid);
        self.force.fill(Vector::ZERO);
        for reaction in &mut self.field_reactions {
            let zero = |column: &mut Vec<Vector<D>>, len: usize| {
                column.clear();
                column.resize(len, Vector::ZERO);
            };
            zero(&mut reaction.force, self.conditions.len());
            reaction.closed.clear();
            reaction.closed.resize(self.conditions.len(), false);
            zero(&mut reaction.start_change, self.boundaries.len());
            zero(&mut reaction.mirrored, 2 * D);
            zero(&mut reaction.mirrored_start, 2 * D);
            reaction.ghosts.clear();
        }
    }

    /// Folds the ghosts of a field's nodes into the domain, and records the momentum and force that mirrors reflect.
    pub fn fold(&mut self, ghosts: &Ghosts<D>, limits: &GhostFractions, field: usize, nodes: &mut [Node<D>]) {
        let reaction = &mut self.field_reactions[field];
        ghosts.fold(limits, nodes, |side, node, ghost| {
            let axis = Vector::unit(side / 2);
            reaction.mirrored[side] -= axis * (2.0 * ghost.force[side / 2]);
            reaction.mirrored_start[side] -= axis * (2.0 * ghost.momentum[side / 2]);
            if ghost.mass > 0.0 {
                reaction.ghosts.push(MirroredGhost { side: side as u32, node: node as u32, mass: ghost.mass });
            }
        });
    }

    /// Closes a field's step: work, losses and impulses of the walls. Nodes hold (m, v⁺, a) with the ghosts
    /// filled; `pic_fraction` is the part of the particles' velocity that comes from v⁺ itself (PIC, APIC).
    pub fn finish_reactions(
        &mut self,
        grid: &Grid<D>,
        field: usize,
        nodes: &[NodeMotion<D>],
        step: &LeapfrogStep,
        pic_fraction: f64,
    ) -> WallWork<D> {
        let dt = step.momentum_dt;
        let reaction = &self.field_reactions[field];
        let ReactionSums { mut impulse, work, total } = self.sum_reactions(grid, field, nodes, step);
        for (boundary, &start) in reaction.start_change.iter().enumerate() {
            impulse[boundary] += start * pic_fraction;
        }
        let mirrored = reaction.mirrored.iter().zip(&reaction.mirrored_start);
        for (impulse, (&force, &start)) in impulse.iter_mut().zip(mirrored) {
            *impulse += force * dt + start * pic_fraction;
        }
        for &MirroredGhost { side, node, mass } in &reaction.ghosts {
            let (v, a) = (nodes[node as usize].velocity(), nodes[node as usize].acceleration());
            let carried = a * dt + (v - a * dt) * pic_fraction;
            impulse[side as usize] += Vector::unit(side as usize / 2) * (2.0 * mass * carried[side as usize / 2]);
        }
        for (force, impulse) in self.force.iter_mut().zip(&impulse) {
            *force += *impulse / dt;
        }
        WallWork { work, dissipation: work - total, impulse: impulse.into_iter().sum() }
    }

    /// Impulses and work of the conditions of a field, summed over nodes and points.
    fn sum_reactions(
        &self,
        grid: &Grid<D>,
        field: usize,
        nodes: &[NodeMotion<D>],
        step: &LeapfrogStep,
    ) -> ReactionSums<D> {
        let none = || ReactionSums { impulse: vec![Vector::ZERO; self.boundaries.len()], work: 0.0, total: 0.0 };
        let force = &self.field_reactions[field].force;
        let mean = |node: usize| nodes[node].midstep_velocity(step.momentum_dt);
        let sum = |range: std::ops::Range<usize>| {
            let mut sums = none();
            for (condition, &force) in self.conditions[range.clone()].iter().zip(&force[range]) {
                let (node, boundary) = (condition.node as usize, condition.boundary);
                sums.add(self, ForceAtPlace { boundary, x: grid.position(node), force, velocity: mean(node) }, step);
            }
            sums
        };
        let mut sums = parallel::reduce(self.conditions.len(), sum, ReactionSums::plus).unwrap_or_else(none);
        for (point, velocity) in self.field_reactions[field].surface.velocities(mean) {
            let SurfacePoint { boundary, place, force, .. } = *point;
            sums.add(self, ForceAtPlace { boundary, x: place, force, velocity }, step);
        }
        sums
    }
}
