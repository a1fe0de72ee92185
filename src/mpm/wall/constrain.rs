//! The conditions on momentum, velocity and corrections, in parallel: conditions are in the order of their nodes, so
//! that parts of them have nodes of their own (theory E.1, E.4, E.7).

use super::gap::BodiesAtWalls;
use super::{FieldReaction, NodeCondition, Pushes, Walls};
use crate::math::Vector;
use crate::mpm::{Grid, LeapfrogStep, Node};
use crate::parallel::{map_parts, parts_mut};
use std::ops::Range;

/// Conditions of a part, about.
const PART: usize = 1024;

/// Consecutive conditions, and the range of their nodes.
#[derive(Debug, Clone)]
pub(super) struct ConditionRange {
    conditions: Range<usize>,
    nodes: Range<usize>,
}

/// Most alternations between conditions at nodes and at surfaces of obstacles that share nodes.
const TURNS: usize = 5;

/// Change of impulses by conditions at nodes, relative to the largest impulse at a surface, that ends the alternations.
const AGREED: f64 = 1e-4;

/// A condition at its node's place [m], with the gap there [m]; `held` if it was in contact in the step before.
#[derive(Debug, Clone, Copy)]
struct GapCondition<'a, const D: usize> {
    condition: &'a NodeCondition<D>,
    x: Vector<D>,
    gap: f64,
    held: bool,
}

/// Parts the conditions so that no node is in two of them.
pub(super) fn ranges<const D: usize>(conditions: &[NodeCondition<D>]) -> Vec<ConditionRange> {
    let (mut parts, mut start) = (Vec::new(), 0);
    while start < conditions.len() {
        let last = conditions[(start + PART).min(conditions.len()) - 1].node;
        let end = start + conditions[start..].partition_point(|condition| condition.node <= last);
        parts
            .push(ConditionRange { conditions: start..end, nodes: conditions[start].node as usize..last as usize + 1 });
        start = end;
    }
    parts
}

impl<const D: usize> Walls<D> {
    /// Calls `run` with every part's conditions and the values of its nodes, which begin with the node of that number.
    fn for_each_range<'a, T: Send, R: Send>(
        &'a self,
        values: &'a mut [T],
        run: impl Fn(&ConditionRange, usize, &mut [T]) -> R + Sync,
    ) -> Vec<R> {
        let values = parts_mut(values, self.ranges.iter().map(|part| part.nodes.clone()));
        map_parts(self.ranges.iter().zip(values), |(part, values)| run(part, part.nodes.start, values))
    }

    /// Finds the points at which bodies of a field may touch surfaces of obstacles; applies the binding conditions on
    /// p⁻ (Lian, Liu & Zhang 2014, section 6, 2 b; theory E.1).
    pub(in crate::mpm) fn constrain_start(
        &mut self,
        grid: &Grid<D>,
        field: usize,
        nodes: &mut [Node<D>],
        bodies: &BodiesAtWalls<'_, D>,
        step: &LeapfrogStep,
    ) {
        let t = step.before();
        self.find_surface(grid, field, nodes, bodies, step);
        self.surface_start(field, nodes, t);
        let changes = self.for_each_range(nodes, |part, first, nodes| {
            let mut start = vec![Vector::ZERO; self.boundaries.len()];
            for &NodeCondition { node, boundary, normal } in &self.conditions[part.conditions.clone()] {
                let (boundary, kind) = (boundary as usize, self.boundaries[boundary as usize].kind);
                let Node { mass, momentum, .. } = &mut nodes[node as usize - first];
                if kind.binds() && *mass > 0.0 {
                    let wall = self.velocity(boundary, grid.position(node as usize), t);
                    let constrained = kind.constrain(*momentum / *mass, wall, normal) * *mass;
                    start[boundary] += constrained - *momentum;
                    *momentum = constrained;
                }
            }
            start
        });
        for change in changes {
            self.field_reactions[field].start_change.iter_mut().zip(change).for_each(|(sum, change)| *sum += change);
        }
    }

    /// All conditions on p̄ whose gaps close, on p⁻ too where they held in the step before (theory E.1, E.4): the
    /// paper's step 2 e, and once more after contact.
    pub fn constrain_trial(&mut self, grid: &Grid<D>, field: usize, nodes: &mut [Node<D>], step: &LeapfrogStep) {
        self.constrain_nodes(grid, field, nodes, step);
        self.bind_lasting_contacts(field, nodes, step);
        for _ in 0..TURNS {
            let pushed = self.surface_trial(field, nodes, step);
            if pushed == 0.0 || self.constrain_nodes(grid, field, nodes, step) <= AGREED * pushed {
                return;
            }
        }
    }

    /// The conditions at nodes among them; returns the largest change of a node's momentum [N s].
    fn constrain_nodes(&mut self, grid: &Grid<D>, field: usize, nodes: &mut [Node<D>], step: &LeapfrogStep) -> f64 {
        let mut reaction = std::mem::take(&mut self.field_reactions[field]);
        let conditions = || self.ranges.iter().map(|part| part.conditions.clone());
        let (force, closed) =
            (parts_mut(&mut reaction.force, conditions()), parts_mut(&mut reaction.closed, conditions()));
        let nodes = parts_mut(nodes, self.ranges.iter().map(|part| part.nodes.clone()));
        let parts = self.ranges.iter().zip(nodes).zip(force.into_iter().zip(closed));
        let (gap, held) = (&reaction.gap, &reaction.held);
        let changes = map_parts(parts, |((part, nodes), (forces, closed))| {
            let (mut start, mut most) = (vec![Vector::ZERO; self.boundaries.len()], 0.0_f64);
            for (k, (sum, closed)) in part.conditions.clone().zip(forces.iter_mut().zip(closed)) {
                let condition = &self.conditions[k];
                let node = &mut nodes[condition.node as usize - part.nodes.start];
                let condition_with_gap =
                    GapCondition { condition, x: grid.position(condition.node as usize), gap: gap[k], held: held[k] };
                let [bound, force] = self.impulse_and_force(&condition_with_gap, node, closed, step);
                let change = bound + force * step.momentum_dt;
                most = most.max(change.norm());
                node.momentum += change;
                node.force += force;
                start[condition.boundary as usize] += bound;
                *sum += force;
            }
            (start, most)
        });
        let mut largest = 0.0_f64;
        for (change, most) in changes {
            reaction.start_change.iter_mut().zip(change).for_each(|(sum, change)| *sum += change);
            largest = largest.max(most);
        }
        self.field_reactions[field] = reaction;
        largest
    }

    /// Change of p⁻ [N s] and force [N] of a condition on a node with (m, p̄), if its gap closes.
    fn impulse_and_force(
        &self,
        condition_with_gap: &GapCondition<'_, D>,
        node: &Node<D>,
        closed: &mut bool,
        step: &LeapfrogStep,
    ) -> [Vector<D>; 2] {
        let &GapCondition { condition, x, gap, held } = condition_with_gap;
        if node.mass <= 0.0 {
            return [Vector::ZERO; 2];
        }
        let (boundary, normal, dt) = (condition.boundary as usize, condition.normal, step.momentum_dt);
        let (kind, wall) = (self.boundaries[boundary].kind, self.velocity(boundary, x, step.after()));
        let approach = (node.momentum / node.mass - wall).dot(normal);
        *closed |= !self.has_gap(condition) || gap + dt * approach <= 0.0;
        if !*closed {
            return [Vector::ZERO; 2];
        }
        let bound = if held && approach < 0.0 {
            let before = (node.momentum - node.force * dt) / node.mass - self.velocity(boundary, x, step.before());
            normal * (-before.dot(normal) * node.mass)
        } else {
            Vector::ZERO
        };
        let trial = node.momentum + bound;
        [bound, (kind.constrain(trial / node.mass, wall, normal) * node.mass - trial) / dt]
    }

    /// Applies the conditions that acted on a field's momentum to velocities at time `t` [s]. Returns their impulses on
    /// particles that take these velocities; velocities that only strain particles have none.
    ///
    /// At a contact that acted in this step, the velocity along the normal is that of the wall, whatever its sign: if
    /// only velocities into the wall were removed, the noise about zero would keep its other half, and a body at rest
    /// would be strained without end.
    pub fn constrain_velocity(
        &self,
        grid: &Grid<D>,
        field: usize,
        nodes: &[Node<D>],
        velocity: &mut [Vector<D>],
        t: f64,
    ) -> Pushes<D> {
        let at_surface = self.surface_velocity(field, velocity, t);
        let FieldReaction { closed, force, .. } = &self.field_reactions[field];
        let parts = self.for_each_range(velocity, |part, first, velocity| {
            let mut pushes = self.pushes();
            let own = part.conditions.clone().filter(|&k| closed[k]);
            for (condition, force) in own.map(|k| (&self.conditions[k], force[k])) {
                let (node, boundary) = (condition.node as usize, condition.boundary as usize);
                let (v, wall) = (&mut velocity[node - first], self.velocity(boundary, grid.position(node), t));
                let (kind, normal) = (self.boundaries[boundary].kind, condition.normal);
                let mut constrained = kind.constrain(*v, wall, normal);
                if !kind.binds() && force != Vector::ZERO {
                    constrained -= normal * (constrained - wall).dot(normal);
                }
                pushes.add(condition.boundary, (constrained - *v) * nodes[node].mass, wall);
                *v = constrained;
            }
            pushes
        });
        parts.into_iter().fold(at_surface, Pushes::plus)
    }

    /// Removes from velocity corrections at time `t` [s] what binding conditions don't allow; returns what that pushes.
    pub fn constrain_correction(
        &self,
        grid: &Grid<D>,
        field: usize,
        nodes: &[Node<D>],
        correction: &mut [Vector<D>],
        t: f64,
    ) -> Pushes<D> {
        let at_surface = self.surface_correction(field, correction, t);
        let parts = self.for_each_range(correction, |part, first, correction| {
            let mut pushes = self.pushes();
            for condition in &self.conditions[part.conditions.clone()] {
                let (node, boundary) = (condition.node as usize, condition.boundary as usize);
                let kind = self.boundaries[boundary].kind;
                if kind.binds() {
                    let c = &mut correction[node - first];
                    let constrained = kind.constrain(*c, Vector::ZERO, condition.normal);
                    let wall = self.velocity(boundary, grid.position(node), t);
                    pushes.add(condition.boundary, (constrained - *c) * nodes[node].mass, wall);
                    *c = constrained;
                }
            }
            pushes
        });
        parts.into_iter().fold(at_surface, Pushes::plus)
    }
}
