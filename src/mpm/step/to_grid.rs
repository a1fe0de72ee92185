//! From the particles to the grid: mass, momentum and forces on the nodes, and the trial momentum, Lian (60–64);
//! theory A.5, A.8.

use super::LeapfrogStep;
use crate::error::StepError;
use crate::math::Vector;
use crate::mpm::bins::Bins;
use crate::mpm::executor::Visitor;
use crate::mpm::grid::Ghosts;
use crate::mpm::grid::small_mass::{self, TrialMomentum};
use crate::mpm::particles::{Summary, health};
use crate::mpm::wall::BodiesAtWalls;
use crate::mpm::{Mpm, VelocityField};
use crate::parallel;

impl<const D: usize> Mpm<D> {
    /// Sorts the bodies whose particles have left their blocks, activates the blocks that they reach, and finds
    /// the ghosts and wall nodes.
    pub(super) fn prepare_grid(&mut self) {
        let mut sorted = false;
        for body in self.bodies.iter_mut() {
            body.summary = Summary::default();
            if body.bins.stale(body.kernel, body.particles.len()) {
                body.sort(self.grid.origin, self.grid.cell);
            }
            sorted |= body.bins.lost();
        }
        let changed = sorted && self.grid.set_blocks(Bins::blocks(self.bodies.iter().map(|body| &body.bins)));
        if sorted {
            self.bodies.iter_mut().for_each(|body| body.bins.locate(&self.grid));
        } else {
            self.grid.clear();
        }
        if changed {
            self.ghosts = Ghosts::new(&self.grid);
        }
        if changed || self.walls.moving() {
            self.walls.find_nodes(&self.grid);
        }
        self.walls.start_step(&self.grid);
        self.coupling.find_membranes(&self.walls, self.grid.cell);
    }

    /// m_I and p_I⁻ with the binding walls, Lian (60, 61); f_I too, where the stresses are known.
    pub(super) fn scatter_momentum(&mut self, field: usize, step: &LeapfrogStep) -> Result<(), StepError> {
        let parameters = self.method.parameters(step, 0.0, self.landing(step));
        let Self { grid, bodies, ghosts, walls, method, coupling, executor, .. } = self;
        grid.with_field(field, |grid, own| {
            let visitor = Visitor { executor: &**executor, grid, field, ghosts, parameters };
            for body in bodies.field_mut(field) {
                body.find_external_forces(&method.gravity, step.t);
                health::check_external(body)?;
                visitor.run(&method.schedule.momentum, own, body)?;
            }
            own.limits.measure(ghosts, grid.folds_in(field), &own.nodes);
            walls.fold(ghosts, &own.limits, field, &mut own.nodes);
            own.small = small_mass::find(grid, &mut own.nodes, &own.cutoffs);
            let shielded = |x, normal, distance| coupling.lies_between(grid.cell, field, x, normal, distance);
            let bodies = BodiesAtWalls::of_field(bodies, field, &shielded);
            walls.constrain_start(grid, field, &mut own.nodes, &bodies, step);
            Ok(())
        })
    }

    /// f_I of stresses and of forces on particles, Lian (17, 18), where they could not be scattered with the momentum;
    /// before that the stress update over the interval that led here, Lian (62, 63), if that is its place.
    pub(super) fn complete_forces(&mut self, field: usize, step: &LeapfrogStep) -> Result<(), StepError> {
        let strain_dt = self.method.schedule.strain_before(step.dt_previous);
        let parameters = self.method.parameters(step, strain_dt.unwrap_or(0.0), self.landing(step));
        let Self { grid, bodies, ghosts, walls, method, executor, .. } = self;
        let visits = method.schedule.force(step.dt_previous);
        if visits.is_empty() {
            return Ok(());
        }
        grid.with_field(field, |grid, own| {
            if strain_dt.is_some() {
                let VelocityField { nodes, velocity, limits, .. } = own;
                parallel::map_into(nodes, velocity, |node| {
                    if node.mass > 0.0 { node.momentum / node.mass } else { Vector::ZERO }
                });
                walls.bind_lasting_velocities(grid, field, velocity, step.before());
                ghosts.fill(limits, velocity);
            }
            let visitor = Visitor { executor: &**executor, grid, field, ghosts, parameters };
            bodies.field_mut(field).iter_mut().try_for_each(|body| visitor.run(visits, own, body))?;
            walls.fold(ghosts, &own.limits, field, &mut own.nodes);
            Ok(())
        })
    }

    /// p̄_I ← p_I⁻ + Δt f_I with gravity among the forces, then the walls.
    pub(super) fn advance_momentum(&mut self, field: usize, step: &LeapfrogStep) {
        let (gravity, dt) = (self.method.uniform_gravity(step.t), step.momentum_dt);
        let Self { grid, walls, bodies, coupling, .. } = self;
        grid.with_field(field, |grid, own| {
            let VelocityField { nodes, applied, cutoffs, .. } = own;
            applied.resize(nodes.len(), Vector::ZERO);
            // Lian (64).
            TrialMomentum { gravity, dt, cutoffs: *cutoffs }.advance(grid, nodes, applied);
            let shielded = |x, normal, distance| coupling.lies_between(grid.cell, field, x, normal, distance);
            walls.measure(grid, field, &BodiesAtWalls::of_field(bodies, field, &shielded));
            walls.constrain_trial(grid, field, nodes, step);
        });
    }

    /// The walls once more, after contact, which may have pushed into them.
    pub(super) fn constrain_by_walls(&mut self, step: &LeapfrogStep) {
        let Self { grid, walls, coupling, .. } = self;
        if coupling.membranes.is_empty() && grid.fields.len() < 2 {
            return;
        }
        for field in 0..grid.fields.len() {
            grid.with_field(field, |grid, own| {
                walls.constrain_trial(grid, field, &mut own.nodes, step);
            });
        }
    }
}
