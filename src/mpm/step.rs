//! One explicit step of the coupled method (Lian, Liu & Zhang 2014, section 6; corrected as in theory A.5, A.19).
//!
//! Positions and stresses live at full steps, velocities half a step earlier; the first step starts from the
//! velocity at t = 0 with half a step of momentum, so that the scheme is second order from the start.
//!
//! The sweeps over the particles that each stage makes depend on the stress update (theory A.8);
//! [`schedule::SweepSchedule`] lists them, and stages without any do nothing:
//!
//! | stage | first | last | modified last | average |
//! |---|---|---|---|---|
//! | `scatter_momentum` | m, p | m, p, f | m, p, f | m, p |
//! | `complete_forces` | σ by v⁻, f | | | σ by v⁻ over ½ Δt, f |
//! | `update_velocities` | v | v, σ by v⁺, x | v, ṽ | v, ṽ |
//! | `filter_noise` | if it is due | if it is due | if it is due | if it is due |
//! | `complete_stresses` | | | σ by ṽ, x | σ by ṽ over ½ Δt, x |
//! | `finish_particles` | x, checks | checks | checks | checks |
//!
//! `last` updates stresses and moves the particles in `complete_stresses` with a cure of locking, or where the filter
//! is due; with a cure of locking forces are scattered in `complete_forces` always. Whatever the stress update, the
//! nodes have f_I after `complete_forces`; the particles have v_p after `filter_noise`, σ_p after `complete_stresses`,
//! x_p after `finish_particles`.

mod filter;
pub(super) mod method;
pub(super) mod schedule;
mod to_grid;
mod to_particles;

use super::corrections::shifting::{self, GridContext};
use super::corrections::volumes;
use super::coupling::Coupling;
use super::executor::Executor;
use super::grid::Ghosts;
use super::particles::Bodies;
use super::state::energy::{Energy, GridWork};
use super::state::health;
use super::state::notices::Notices;
use super::wall::Walls;
use super::{Grid, LeapfrogStep};
use crate::error::StepError;
use crate::simulation::Timer;
use crate::timed;
use method::{MethodChoices, StepCount};

/// The material point method in `D` dimensions.
#[derive(Debug)]
pub struct Mpm<const D: usize> {
    pub(super) grid: Grid<D>,
    pub(super) ghosts: Ghosts<D>,
    pub(super) walls: Walls<D>,
    pub(super) bodies: Bodies<D>,
    pub(super) coupling: Coupling<D>,
    pub(super) method: MethodChoices<D>,
    /// The executor of the sweeps over the particles.
    pub(super) executor: Box<dyn Executor<D>>,
    /// Order of the noise filter in this step; 0: none.
    pub(super) filter_order: u32,
    pub(super) energy: Energy,
    pub(super) notices: Notices,
    pub(super) clock: StepCount,
    pub(super) timer: Timer,
}

impl<const D: usize> Mpm<D> {
    /// The step: trial momentum of the bodies, membranes and contact, walls, then back to the particles.
    pub(super) fn advance(&mut self, step: &LeapfrogStep) -> Result<(), StepError> {
        timed!(self.timer, "activate", self.prepare_grid());
        self.energy.work = GridWork::default();
        self.filter_order = self.method.due_filter(step);
        for field in 0..self.grid.fields.len() {
            timed!(self.timer, "p2g", self.scatter_momentum(field, step)?); // m_I, p_I⁻        Lian (60, 61)
            timed!(self.timer, "stress", self.complete_forces(field, step)?); // σ, f_I   Lian (62, 63; 17, 18)
            timed!(self.timer, "grid", self.advance_momentum(field, step)); // p̄_I ← p_I + Δt f_I  Lian (64)
        }
        self.advance_membranes(step)?; // membranes, J_I                                            Lian (32–59)
        self.correct_volumes(step);
        timed!(self.timer, "grid", self.constrain_by_walls(step)); // once more
        timed!(self.timer, "contact", self.coupling.contact.account(&self.grid));
        for field in 0..self.grid.fields.len() {
            timed!(self.timer, "grid", self.finish_nodes(field, step)); // v_I⁺, a_I
            timed!(self.timer, "g2p", self.update_velocities(field, step)?); // v_p, ẋ_p           Lian (65, 19)
            timed!(self.timer, "g2p", self.filter_noise(field, step));
            timed!(self.timer, "stress", self.complete_stresses(field, step)?); // σ, x_p  Lian (62, 63; 19)
        }
        timed!(self.timer, "g2p", self.finish_particles(step)?);
        timed!(self.timer, "shift", self.displace_particles(step));
        self.advance_obstacles(step);
        self.check_membranes()?;
        self.energy.close_step(&self.bodies);
        health::check_energy(self.energy.sum())
    }

    /// The membranes take their steps and meet the bodies, walls and obstacles.
    fn advance_membranes(&mut self, step: &LeapfrogStep) -> Result<(), StepError> {
        let Self { grid, walls, bodies, coupling, energy, timer, .. } = self;
        coupling.advance(grid, walls, bodies, step, timer)?;
        energy.add_walls(&walls.book_sheets(&coupling.contact.wall_pushes(), step.momentum_dt));
        Ok(())
    }

    /// Leads the volumes of gases and liquids to what the grid shows, and finds where the particles of liquids are to
    /// go.
    fn correct_volumes(&mut self, step: &LeapfrogStep) {
        let parameters = self.method.parameters(step, step.dt, self.landing(step));
        let Self { grid, ghosts, walls, bodies, coupling, energy, clock, timer, executor, .. } = self;
        let context = GridContext { grid, ghosts, walls, executor: &**executor };
        timed!(timer, "stress", volumes::correct(clock.steps, context, bodies, &coupling.contact));
        let contact = &mut coupling.contact;
        let works = timed!(timer, "shift", shifting::even_out(clock.steps, parameters, context, bodies, contact));
        works.into_iter().for_each(|work| energy.add_volume_corrections(work));
    }

    /// Shifts the particles of liquids, and parts particles from membranes and obstacles.
    fn displace_particles(&mut self, step: &LeapfrogStep) {
        let Self { grid, ghosts, walls, bodies, coupling, energy, executor, .. } = self;
        let context = GridContext { grid, ghosts, walls, executor: &**executor };
        let work = shifting::displace(context, bodies, coupling, step);
        energy.sums.add(energy.terms.displacement, work);
    }
}
