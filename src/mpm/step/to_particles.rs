//! From the grid back to the particles: velocities, stresses, places, Lian (65, 19); theory A.5, A.8.

use super::LeapfrogStep;
use super::filter::{Filter, divide_by_mass};
use super::schedule::StrainVelocity;
use crate::error::StepError;
use crate::math::Vector;
use crate::mpm::executor::Visitor;
use crate::mpm::grid::NodeMotion;
use crate::mpm::motion::Landing;
use crate::mpm::particles::health;
use crate::mpm::state::energy::ForceWork;
use crate::mpm::state::health::check_membrane;
use crate::mpm::stress::heat;
use crate::mpm::{Mpm, Node, VelocityField};
use crate::parallel;

impl<const D: usize> Mpm<D> {
    /// Turns (m, p⁺, f) into (m, v⁺, a), adds the work of the forces to the ledger, and fills the ghosts.
    pub(super) fn finish_nodes(&mut self, field: usize, step: &LeapfrogStep) {
        let (pic_fraction, dt) = (self.method.pic_fraction(step.momentum_dt), step.momentum_dt);
        let gravity = self.method.uniform_gravity(step.t);
        let Self { grid, walls, ghosts, energy, .. } = self;
        grid.with_field(field, |grid, own| {
            let VelocityField { nodes, applied, limits, .. } = own;
            let finish = |node: &mut Node<D>, applied: &mut Vector<D>| {
                if node.mass <= 0.0 {
                    return ForceWork::default();
                }
                let (mass, force) = (node.mass, node.force);
                let mean = node.finish().midstep_velocity(dt);
                let (all, applied, weight) = (force.dot(mean), applied.dot(mean), mass * gravity.dot(mean));
                ForceWork { all: all * dt, applied: applied * dt, weight: weight * dt, mass }
            };
            let work = parallel::reduce_pair_mut(nodes, applied, finish, ForceWork::plus).unwrap_or_default();
            energy.add_nodes(work, gravity, dt);
            ghosts.fill(limits, nodes);
            energy.add_walls(&walls.finish_reactions(grid, field, NodeMotion::of(&own.nodes), step, pic_fraction));
        });
    }

    /// The end of the step: where the particles are then.
    pub(super) fn landing(&self, step: &LeapfrogStep) -> Landing<D> {
        Landing::new(&self.grid, |axis, end| self.walls.stands(axis, end), step.dt)
    }

    /// v_p and ẋ_p, Lian (65, 19), and the work of external forces; with them all that the schedule does in the same
    /// sweep: the stress update and x_p, or the particles' new momentum at the nodes.
    pub(super) fn update_velocities(&mut self, field: usize, step: &LeapfrogStep) -> Result<(), StepError> {
        let strain_dt = self.method.schedule.strain_after(step.dt).unwrap_or(0.0);
        let parameters = self.method.parameters(step, strain_dt, self.landing(step));
        let Self { grid, bodies, ghosts, method, executor, energy, filter_order, .. } = self;
        let sweeps = method.schedule.after_contact(*filter_order);
        grid.with_field(field, |grid, own| {
            if sweeps.strain_velocity == StrainVelocity::Remapped {
                own.velocity.clear();
                own.velocity.resize(own.nodes.len(), Vector::ZERO);
            }
            let visitor = Visitor { executor: &**executor, grid, field, ghosts, parameters };
            bodies.field_mut(field).iter_mut().try_for_each(|body| {
                visitor.run(&sweeps.motion, own, body)?;
                energy.add_external(body, step.momentum_dt);
                Ok(())
            })
        })
    }

    /// The noise filter, if it is due.
    pub(super) fn filter_noise(&mut self, field: usize, step: &LeapfrogStep) {
        let (order, t) = (self.filter_order, step.after());
        if order == 0 {
            return;
        }
        let parameters = self.method.parameters(step, 0.0, self.landing(step));
        let Self { grid, bodies, ghosts, walls, energy, executor, .. } = self;
        let visitor = Visitor { executor: &**executor, grid, field, ghosts, parameters };
        let (heat, pushes) = Filter { visitor, walls, t, order }.apply(bodies.field_mut(field));
        energy.add_filter(heat, &walls.book(pushes, step.momentum_dt));
    }

    /// The stress update that follows the new velocities, with v⁺ or with the re-mapped velocity (theory A.8), where
    /// there is one and it isn't done; then x_p += Δt ẋ_p.
    pub(super) fn complete_stresses(&mut self, field: usize, step: &LeapfrogStep) -> Result<(), StepError> {
        let strain_dt = self.method.schedule.strain_after(step.dt).unwrap_or(0.0);
        let parameters = self.method.parameters(step, strain_dt, self.landing(step));
        match self.method.schedule.after_contact(self.filter_order).strain_velocity {
            StrainVelocity::None => return Ok(()),
            StrainVelocity::Nodes => {
                let VelocityField { nodes, velocity, .. } = &mut self.grid.fields[field];
                parallel::map_into(NodeMotion::of(nodes), velocity, NodeMotion::velocity);
            }
            StrainVelocity::Remapped => self.remap(field, step)?,
        }
        let Self { grid, bodies, ghosts, method, executor, filter_order, .. } = self;
        let visits = &method.schedule.after_contact(*filter_order).stress;
        grid.with_field(field, |grid, own| {
            let visitor = Visitor { executor: &**executor, grid, field, ghosts, parameters };
            bodies.field_mut(field).iter_mut().try_for_each(|body| visitor.run(visits, own, body))
        })
    }

    /// Maps the particles' new velocity to the nodes, ṽ (theory A.8), and finds the heat that they hand to the
    /// particles.
    fn remap(&mut self, field: usize, step: &LeapfrogStep) -> Result<(), StepError> {
        let parameters = self.method.parameters(step, 0.0, self.landing(step));
        let (gravity, dt) = (self.method.uniform_gravity(step.t), step.momentum_dt);
        let Self { grid, bodies, ghosts, walls, method, executor, energy, filter_order, .. } = self;
        let visits = &method.schedule.after_contact(*filter_order).remap;
        grid.with_field(field, |grid, own| {
            let visitor = Visitor { executor: &**executor, grid, field, ghosts, parameters };
            bodies.field_mut(field).iter_mut().try_for_each(|body| visitor.run(visits, own, body))?;
            let VelocityField { nodes, velocity, limits, small, .. } = own;
            ghosts.fold(limits, velocity, |_, _, _| {});
            divide_by_mass(nodes, small, velocity);
            walls.constrain_velocity(grid, field, nodes, velocity, step.after());
            own.heat = if bodies.field(field).iter().any(|body| method.dissipation.warms(body)) {
                heat::of_contact(ghosts, own, dt)
            } else {
                Vec::new()
            };
            ghosts.fill(&own.limits, &mut own.velocity);
            energy.leave_unspent(own, gravity, dt, 1.0 - method.pic_fraction(dt));
            Ok(())
        })
    }

    /// x_p += Δt ẋ_p where no sweep has moved the particles yet; sees that all are sound, and finds what the next step
    /// needs of them.
    pub(super) fn finish_particles(&mut self, step: &LeapfrogStep) -> Result<(), StepError> {
        let parameters = self.method.parameters(step, 0.0, self.landing(step));
        let Self { grid, ghosts, bodies, method, executor, filter_order, .. } = self;
        let visits = &method.schedule.after_contact(*filter_order).landing;
        for (field, body) in bodies.with_fields_mut() {
            grid.with_field(field, |grid, own| {
                Visitor { executor: &**executor, grid, field, ghosts, parameters }.run(visits, own, body)
            })?;
            if body.summary.lost {
                health::check_particles(grid, body)?;
            }
            body.bins.disorder.drift += body.summary.shift / grid.cell;
            body.bins.disorder.note(body.summary.visits);
            body.largest_wave_speed = body.summary.largest_wave_speed;
        }
        Ok(())
    }

    /// Keeps the contacts with walls and obstacles that last, and moves the obstacles.
    pub(super) fn advance_obstacles(&mut self, step: &LeapfrogStep) {
        self.walls.record_contacts(&self.grid);
        self.walls.advance(step.t, step.dt);
    }

    /// Sees that the membranes are sound.
    pub(super) fn check_membranes(&self) -> Result<(), StepError> {
        let mut membranes = self.coupling.membranes.iter();
        membranes.try_for_each(|membrane| check_membrane(&self.grid, &self.walls, membrane))
    }
}
