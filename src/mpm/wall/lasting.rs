//! Contacts that last from one step to the next (theory E.4).
//!
//! A wall that a body may leave stops what runs into it: with the velocity v⁻ of a node whose gap closes its kinetic
//! energy ½ m (v⁻·ν)² is lost. A contact that held through the step before acts as a slip wall on p⁻, the momentum that
//! the particles scatter, as long as the mean momentum p̄ of the step points into the wall:
//!
//! ```text
//! held and (p̄ − m v_w)·ν < 0:   p⁻ ← p⁻ − ((p⁻ − m v_w)·ν) ν,   p̄ likewise;   v⁻ that strains, too
//! ```
//!
//! The motion of particles above the wall relative to it shows at its nodes, but is no approach of the body. If it is
//! stopped anew in every step, the particles lose their momentum, and the wall's force f does the work Δt f·½v⁻ on
//! nodes that don't move: it takes energy from bodies that it compresses, and gives more to those that rebound, since
//! Δt a of the nodes above always points away from it.

use super::{NodeCondition, Walls};
use crate::math::Vector;
use crate::mpm::Grid;
use crate::simulation::{Column, Record};
use bytemuck::{Pod, Zeroable};

/// A contact that held at a node.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct NodeContact {
    /// Number of the wall or obstacle.
    boundary: u32,
    /// Indices i, j, k of the node; k is 0 in 2D.
    place: [u32; 3],
}

impl Record for NodeContact {
    type Number = u32;
}

/// A particle in contact with an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ParticleContact {
    /// Number of the obstacle among the boundaries.
    pub boundary: u32,
    /// Number of the body.
    pub body: u32,
    /// Identity of the particle in it.
    pub particle: u32,
}

impl Record for ParticleContact {
    type Number = u32;
}

impl<const D: usize> Walls<D> {
    /// Records the contacts that hold at the end of a step.
    pub fn record_contacts(&mut self, grid: &Grid<D>) {
        self.record_particle_contacts();
        for reaction in &mut self.field_reactions {
            reaction.contacts_before.clear();
            let acts = |k: &usize| reaction.closed[*k] && reaction.force[*k] != Vector::ZERO;
            for NodeCondition { node, boundary, .. } in
                (0..self.conditions.len()).filter(acts).map(|k| self.conditions[k])
            {
                if !self.boundaries[boundary as usize].kind.binds() {
                    let mut place = [0; 3];
                    for (index, coordinate) in place.iter_mut().zip(grid.coordinates(node as usize)) {
                        *index = coordinate as u32;
                    }
                    reaction.contacts_before.push(NodeContact { boundary, place });
                }
            }
        }
    }

    /// Finds the conditions of the contacts that held in the step before.
    pub(super) fn find_lasting_contacts(&mut self, grid: &Grid<D>) {
        for reaction in &mut self.field_reactions {
            reaction.held.clear();
            reaction.held.resize(self.conditions.len(), false);
            for &NodeContact { boundary, place } in &reaction.contacts_before {
                let node = grid.find(std::array::from_fn(|a| place[a] as i32));
                let Some(node) = node.and_then(|node| u32::try_from(node).ok()) else { continue };
                let first = self.conditions.partition_point(|condition| condition.node < node);
                let own = self.conditions[first..].iter().take_while(|condition| condition.node == node);
                for (k, _) in own.enumerate().filter(|(_, condition)| condition.boundary == boundary) {
                    reaction.held[first + k] = true;
                }
            }
        }
    }

    /// Sets the normal part of the velocity to that of the wall at time `t` [s], at nodes in contacts that held. For
    /// velocities at the start of a step, which strain the particles.
    pub fn bind_lasting_velocities(&self, grid: &Grid<D>, field: usize, velocity: &mut [Vector<D>], t: f64) {
        self.bind_lasting_at_surface(field, velocity, t);
        let held = self.conditions.iter().zip(&self.field_reactions[field].held).filter(|(_, held)| **held);
        for (&NodeCondition { node, boundary, normal }, _) in held {
            let wall = self.velocity(boundary as usize, grid.position(node as usize), t);
            let v = &mut velocity[node as usize];
            *v -= normal * (*v - wall).dot(normal);
        }
    }

    /// The contacts that hold, for checkpoints.
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        for (field, reaction) in self.field_reactions.iter_mut().enumerate() {
            visit(&format!("mpm.contacts.{field}"), Column::growing(&mut reaction.contacts_before));
            visit(&format!("mpm.particle-contacts.{field}"), Column::growing(&mut reaction.particle_contacts_before));
        }
    }
}
