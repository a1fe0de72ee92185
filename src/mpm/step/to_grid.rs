//! From the particles to the grid: mass, momentum and forces on the nodes, and the trial momentum, Lian (60–64).

use super::{Step, in_field};
use crate::error::StepError;
use crate::math::{Signal, Vector};
use crate::mpm::grid::Ghosts;
use crate::mpm::grid::small_mass::{self, TrialMomentum};
use crate::mpm::state::health;
use crate::mpm::stress::average::Average;
use crate::mpm::stress::update::{Strain, update_stress_and_push};
use crate::mpm::transfer::{Bins, Content, Sweep};
use crate::mpm::wall::Bodies;
use crate::mpm::{Field, Locking, Mpm, StressUpdate};
use crate::parallel;

impl<const D: usize> Mpm<D> {
    /// Sorts the bodies whose particles have left their blocks, activates the blocks that they reach, and finds
    /// the ghosts and wall nodes.
    pub(super) fn activate(&mut self) {
        let mut sorted = false;
        for (body, bins) in self.bodies.iter_mut().zip(&mut self.bins) {
            if bins.stale(body.kernel, body.particles.len()) {
                *bins = Bins::sort(&mut body.particles, body.kernel, self.grid.origin, self.grid.cell);
            }
            sorted |= bins.lost();
        }
        let changed = sorted && self.grid.set_blocks(Bins::blocks(&self.bins));
        if sorted {
            self.bins.iter_mut().for_each(|bins| bins.locate(&self.grid));
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

    /// True if the forces are known when mass and momentum are scattered.
    fn scatters_at_once(&self) -> bool {
        let late = matches!(self.stress_update, StressUpdate::Last | StressUpdate::ModifiedLast);
        late && self.locking == Locking::None
    }

    /// m_I and p_I⁻ with the binding walls, Lian (60, 61).
    pub(super) fn scatter_particles(&mut self, field: usize, step: &Step) -> Result<(), StepError> {
        let content = if self.scatters_at_once() { Content::MomentumAndForce } else { Content::Momentum };
        let Self { grid, bodies, bins, ghosts, walls, cutoff, gravity, coupling, .. } = self;
        grid.with_field(field, |grid, own| {
            for (body, bins) in in_field(bodies, bins, field) {
                body.find_external_forces(gravity, step.t);
                health::check_external(body)?;
                bins.extents = Sweep::new(grid, body, bins).scatter(&mut own.nodes, body, content);
            }
            own.limits.measure(ghosts, grid.folds_in(field), &own.nodes);
            walls.fold((ghosts, &own.limits), field, &mut own.nodes);
            own.small = small_mass::find(grid, &mut own.nodes, &cutoff[field]);
            let shielded = |x, normal, distance| coupling.lies_between((grid.cell, field), x, normal, distance);
            let bodies = Bodies::of_field(bodies, bins, field, &shielded);
            walls.constrain_start((grid, field), &mut own.nodes, &bodies, step);
            Ok(())
        })
    }

    /// f_I of stresses and of forces on particles, Lian (17, 18), where they could not be scattered with the momentum; before
    /// that the stress update over the interval that led here, Lian (62, 63), if that is its place.
    pub(super) fn stress_and_force(&mut self, field: usize, step: &Step) -> Result<(), StepError> {
        if self.scatters_at_once() {
            return Ok(());
        }
        let dt = match self.stress_update {
            StressUpdate::First => Some(step.dt_before),
            StressUpdate::Average => Some(0.5 * step.dt_before),
            StressUpdate::Last | StressUpdate::ModifiedLast => None,
        };
        let Self { grid, bodies, bins, ghosts, walls, locking, .. } = self;
        grid.with_field(field, |grid, own| {
            let Field { nodes, velocity, sums, means, limits, .. } = own;
            if dt.is_some() {
                parallel::map_into(nodes, velocity, |node| {
                    if node.mass > 0.0 { node.momentum / node.mass } else { Vector::ZERO }
                });
                walls.hold_velocity(grid, field, velocity, step.before());
                ghosts.fill(limits, velocity);
            }
            let mut average = Average { ghosts: (ghosts, limits), locking: *locking, sums, means };
            for (body, bins) in in_field(bodies, bins, field) {
                let sweep = Sweep::new(grid, body, bins);
                match dt {
                    Some(dt) => {
                        let strain = Strain { velocity, dt, backwards: true, moves: false, heat: &[] };
                        update_stress_and_push(&sweep, &mut average, strain, body, nodes)?;
                    }
                    None => average.push(&sweep, body, nodes),
                }
            }
            walls.fold((ghosts, limits), field, nodes);
            Ok(())
        })
    }

    /// Gravity that is the same everywhere at time `t` acts on the nodes [m/s²]; other gravity on the particles.
    pub(in crate::mpm) fn uniform_gravity(&self, t: f64) -> Vector<D> {
        let uniform = self.gravity.iter().all(Signal::is_uniform);
        Vector::from_fn(|a| if uniform { self.gravity[a].value([0.0; 3], t) } else { 0.0 })
    }

    /// p̄_I ← p_I⁻ + Δt f_I with gravity among the forces, then the walls, Lian (64).
    pub(super) fn advance_momentum(&mut self, field: usize, step: &Step) {
        let (gravity, dt) = (self.uniform_gravity(step.t), step.momentum_dt);
        let Self { grid, walls, bodies, bins, cutoff, coupling, .. } = self;
        grid.with_field(field, |grid, own| {
            let Field { nodes, applied, .. } = own;
            applied.resize(nodes.len(), Vector::ZERO);
            TrialMomentum { gravity, dt, cutoffs: cutoff[field] }.advance(grid, nodes, applied);
            let shielded = |x, normal, distance| coupling.lies_between((grid.cell, field), x, normal, distance);
            walls.measure(grid, field, &Bodies::of_field(bodies, bins, field, &shielded));
            walls.constrain_trial(grid, field, nodes, step);
        });
    }

    /// The walls once more, after contact, which may have pushed into them.
    pub(super) fn constrain_walls(&mut self, step: &Step) {
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
