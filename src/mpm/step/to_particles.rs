//! From the grid back to the particles: velocities, stresses, places, Lian (65, 19), and what the step has done.

use super::{Step, of_field};
use crate::error::StepError;
use crate::math::Vector;
use crate::mpm::particles::motion::{Landing, Transport, gather_mean, gather_motion};
use crate::mpm::state::energy::NodeWork;
use crate::mpm::state::health;
use crate::mpm::stress::average::Average;
use crate::mpm::stress::filter::{Filter, divide_by_mass, velocity_on_grid};
use crate::mpm::stress::heat;
use crate::mpm::stress::update::{Strain, strain_and_land, update_stress};
use crate::mpm::transfer::{Sweep, View};
use crate::mpm::{Field, Locking, Mpm, Node, StressUpdate, Transfer};
use crate::parallel;

impl<const D: usize> Mpm<D> {
    /// Turns (m, p⁺, f) into (m, v⁺, a), settles the work of the forces, and fills the ghosts.
    pub(super) fn finish_nodes(&mut self, field: usize, step: &Step) {
        let share = self.pic_share(step.momentum_dt);
        let gravity = self.uniform_gravity(step.t);
        let Self { grid, walls, ghosts, tally, books, accounts, .. } = self;
        grid.with_field(field, |grid, own| {
            let dt = step.momentum_dt;
            let Field { nodes, applied, limits, .. } = own;
            let finish = |node: &mut Node<D>, applied: &mut Vector<D>| {
                if node.mass <= 0.0 {
                    return NodeWork::default();
                }
                let force = node.force;
                (node.momentum, node.force) = (node.momentum / node.mass, force / node.mass);
                let mean = node.momentum - node.force * (0.5 * dt);
                let (all, applied, weight) = (force.dot(mean), applied.dot(mean), node.mass * gravity.dot(mean));
                NodeWork { all: all * dt, applied: applied * dt, weight: weight * dt, mass: node.mass }
            };
            let sum = parallel::reduce_pair_mut(nodes, applied, finish, NodeWork::and).unwrap_or_default();
            tally.nodes += sum.all;
            tally.applied += sum.applied;
            tally.external += sum.weight;
            books.add(accounts.gravity, sum.weight);
            books.push((gravity * (sum.mass * dt)).to3());
            ghosts.fill(limits, nodes);
            let done = walls.settle(grid, field, &own.nodes, step, share);
            books.add(accounts.wall, done.work);
            books.add(accounts.wall_loss, done.dissipation);
            books.push(done.impulse.to3());
        });
    }

    /// The part of the particles' velocity that comes from v⁺ itself.
    pub(in crate::mpm) fn pic_share(&self, dt: f64) -> f64 {
        match self.transfer {
            Transfer::Flip { relaxation, .. } => -(-dt / relaxation).exp_m1(),
            Transfer::Apic => 1.0,
        }
    }

    /// Order of the noise filter if it is due in this step, else 0. It is due by time, not by steps: a viscous gas or
    /// a short step would be filtered more often for no more noise.
    pub(super) fn due_filter(&self, step: &Step) -> u32 {
        match self.transfer {
            Transfer::Flip { filter_order, .. }
                if ((step.t + step.dt) / self.filter_time).floor() > (step.t / self.filter_time).floor() =>
            {
                filter_order
            }
            _ => 0,
        }
    }

    /// True if the particles can move, strain and land in one sweep: nothing needs the grid in between.
    pub(super) fn lands_at_once(&self) -> bool {
        self.stress_update == StressUpdate::Last && self.locking == Locking::None && self.filter_order == 0
    }

    /// True if the stress update wants the particles' new velocity on the grid (theory A.8).
    fn remaps(&self) -> bool {
        matches!(self.stress_update, StressUpdate::ModifiedLast | StressUpdate::Average)
    }

    /// True if that can be scattered while the particles get it: nothing changes it any more.
    fn remaps_at_once(&self) -> bool {
        self.remaps() && self.filter_order == 0
    }

    /// Where the particles are at the end of the step.
    pub(super) fn landing(&self, step: &Step) -> Landing<D> {
        Landing::new(&self.grid, |axis, end| self.walls.stands(axis, end), step.dt)
    }

    /// v_p and ẋ_p, Lian (65, 19), and the work of external forces; all that remains of the step where that can be done
    /// in the same sweep.
    pub(super) fn gather_particles(&mut self, field: usize, step: &Step) -> Result<(), StepError> {
        let dt = step.momentum_dt;
        let share = self.pic_share(dt);
        let (at_once, remaps, landing) = (self.lands_at_once(), self.remaps_at_once(), self.landing(step));
        let Self { grid, bodies, bins, tally, books, accounts, summaries, .. } = self;
        let mut momentum = std::mem::take(&mut grid.fields[field].velocity);
        let (grid, own) = (&*grid, &grid.fields[field]);
        if remaps {
            momentum.clear();
            momentum.resize(own.nodes.len(), Vector::ZERO);
        }
        for (index, (body, bins)) in
            bodies.iter_mut().zip(&*bins).enumerate().filter(|(_, (body, _))| body.field == field)
        {
            let sweep = Sweep::new(grid, body, bins);
            let transport = Transport::new(dt, share, body.kernel, grid.cell);
            gather_mean(&sweep, &own.nodes, dt, body);
            if at_once {
                summaries[index] = strain_and_land(&sweep, &own.nodes, transport, step.dt, body, landing)?;
            } else {
                gather_motion(&sweep, &own.nodes, transport, body, remaps.then_some(&mut momentum));
            }
            let (all, tractions, impulse) = body.external_work(dt);
            tally.external += all;
            books.add(accounts.gravity, all - tractions);
            books.add(accounts.traction, tractions);
            books.push(impulse.to3());
        }
        self.grid.fields[field].velocity = momentum;
        self.filter_noise(field, step);
        Ok(())
    }

    /// The noise filter, if it is due.
    fn filter_noise(&mut self, field: usize, step: &Step) {
        let (order, dissipation, t) = (self.filter_order, self.dissipation, step.after());
        if order == 0 {
            return;
        }
        let Self { grid, bodies, bins, ghosts, walls, tally, books, accounts, .. } = self;
        let mut bodies: Vec<_> = bodies.iter_mut().zip(&*bins).filter(|(body, _)| body.field == field).collect();
        let (heat, pushes) = Filter { grid, ghosts, walls, field, t, order, dissipation }.apply(&mut bodies);
        let done = walls.book(pushes, step.momentum_dt);
        tally.heat += heat;
        // What moving walls do here, the particles get or the filter takes.
        tally.nodes += done.work;
        books.add(accounts.wall, done.work);
        books.push(done.impulse.to3());
    }

    /// The stress update after the motion, with v⁺ or with the re-mapped velocity (theory A.8); then x_p += Δt ẋ_p.
    pub(super) fn stress_last(&mut self, field: usize, step: &Step) -> Result<(), StepError> {
        if self.lands_at_once() {
            return Ok(());
        }
        let dt = match self.stress_update {
            StressUpdate::First => return Ok(()),
            StressUpdate::Last | StressUpdate::ModifiedLast => step.dt,
            StressUpdate::Average => 0.5 * step.dt,
        };
        let remapped = self.remaps();
        let heat = if remapped { self.remap(field, step) } else { Vec::new() };
        let (landing, dissipation) = (self.landing(step), self.dissipation);
        let Self { grid, bodies, bins, ghosts, locking, summaries, .. } = self;
        grid.with_field(field, |grid, own| {
            let Field { nodes, velocity, sums, means, limits, .. } = own;
            if !remapped {
                parallel::map_into(nodes, velocity, |node| node.momentum);
            }
            let mut average = Average { ghosts: (ghosts, limits), locking: *locking, sums, means };
            for (index, (body, bins)) in
                bodies.iter_mut().zip(&*bins).enumerate().filter(|(_, (body, _))| body.field == field)
            {
                let sweep = Sweep::new(grid, body, bins);
                let heat = if dissipation.warms(body) { &*heat } else { &[] };
                let moves = remapped && body.particles.affine.is_empty() && body.law.keeps_shape();
                let strain = Strain { velocity, dt, backwards: false, moves, heat };
                summaries[index] = update_stress(&sweep, &mut average, strain, body, landing)?;
            }
            Ok(())
        })
    }

    /// Maps the particles' new velocity to the nodes, ṽ (theory A.8); returns the heat per mass that they hand to the particles.
    fn remap(&mut self, field: usize, step: &Step) -> Vec<[f64; 1]> {
        let (at_once, dissipation) = (self.remaps_at_once(), self.dissipation);
        let Self { grid, bodies, bins, ghosts, walls, .. } = self;
        let mut heat = Vec::new();
        grid.with_field(field, |grid, own| {
            let mut velocity = std::mem::take(&mut own.velocity);
            if at_once {
                ghosts.fold(&own.limits, &mut velocity, |_, _, _| {});
                divide_by_mass(own, &mut velocity);
            } else {
                velocity = velocity_on_grid(grid, ghosts, own, of_field(bodies, bins, field), velocity);
            }
            own.velocity = velocity;
            walls.constrain_velocity((grid, field), &own.nodes, &mut own.velocity, step.after());
            if bodies.iter().any(|body| body.field == field && dissipation.warms(body)) {
                heat = heat::of_contact(ghosts, own, step.momentum_dt);
            }
            ghosts.fill(&own.limits, &mut own.velocity);
        });
        self.leave_unspent(field, step);
        heat
    }

    /// Lands the particles that have not yet, and sees that they are sound.
    pub(super) fn move_particles(&mut self, step: &Step) -> Result<(), StepError> {
        let landing = self.landing(step);
        let landed = self.stress_update != StressUpdate::First;
        for (index, body) in self.bodies.iter_mut().enumerate() {
            if !landed {
                self.summaries[index] = body.view().1.visit(&|chunk: &mut View<'_, D>| landing.land(chunk));
            }
            let summary = &self.summaries[index];
            if summary.lost {
                health::check_particles(&self.grid, body)?;
            }
            self.bins[index].disorder.drift += summary.shift / self.grid.cell;
            self.bins[index].disorder.note(summary.visits);
            self.fastest[index] = summary.fastest;
        }
        Ok(())
    }

    /// Moves the obstacles, and sees that the membranes are sound.
    pub(super) fn finish_step(&mut self, step: &Step) -> Result<(), StepError> {
        self.walls.note_contacts(&self.grid);
        self.walls.advance(step.t, step.dt);
        let mut membranes = self.coupling.membranes.iter();
        membranes.try_for_each(|membrane| health::check_membrane(&self.grid, &self.walls, membrane))
    }
}
