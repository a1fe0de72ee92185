//! Contacts that last from one step to the next (theory E.4).
//!
//! A wall that a body may leave stops what runs into it: the velocity v⁻ of a node whose gap closes is lost, ½ m
//! (v⁻·ν)². A contact that held through the step before binds p⁻ as a slip wall does, while p̄ goes into the wall:
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
use crate::simulation::Column;

/// A contact that held: boundary and indices of the node, i, j, k.
pub(super) type NodeContact = [u32; 4];

/// A particle in contact with an obstacle: boundary, number of the body, and of the particle.
pub(super) type ParticleContact = [u32; 3];

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
                    let mut contacts_before = [boundary, 0, 0, 0];
                    for (index, place) in contacts_before[1..].iter_mut().zip(grid.coordinates(node as usize)) {
                        *index = place as u32;
                    }
                    reaction.contacts_before.push(contacts_before);
                }
            }
        }
    }

    /// Finds the conditions of the contacts that held in the step before.
    pub(super) fn find_lasting_contacts(&mut self, grid: &Grid<D>) {
        for reaction in &mut self.field_reactions {
            reaction.held.clear();
            reaction.held.resize(self.conditions.len(), false);
            for &[boundary, ref place @ ..] in &reaction.contacts_before {
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

    /// The velocity along the normal of contacts that held is that of the wall at time `t` [s]: of velocities at the
    /// start of a step that strain the particles.
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
