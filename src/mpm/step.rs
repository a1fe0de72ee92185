//! One explicit step of the coupled method (Lian, Liu & Zhang 2014, section 6; corrected as in theory A.5, A.19).
//!
//! Positions and stresses live at full steps, velocities half a step earlier; the first step starts from the
//! velocity at t = 0 with half a step of momentum, so that the scheme is second order from the start.

mod to_grid;
mod to_particles;

use super::coupling::Coupling;
use super::grid::Ghosts;
use super::grid::small_mass::MassCutoffs;
use super::particles::Body;
use super::particles::motion::Summary;
use super::state::energy::{Accounts, Tally};
use super::state::ledger::Books;
use super::state::notices::Notices;
use super::state::proximity::Proximity;
use super::state::stability::GROWTH;
use super::state::{columns, health, snapshot};
use super::transfer::Bins;
use super::wall::Walls;
use super::{Dissipation, Grid, Locking, StressUpdate, Transfer};
use crate::error::StepError;
use crate::math::Signal;
use crate::simulation::{Column, Snapshot, Solver, Timer};
use crate::timed;

/// How much steps may differ from one to the next where there are membranes.
const CHANGE: f64 = 1.5;

/// The times of one step [s].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Start, tⁿ.
    pub t: f64,
    /// Positions move by dt^{n+½}.
    pub dt: f64,
    /// The step before, dt^{n−½}; 0 at the start.
    pub dt_before: f64,
    /// Momentum advances by dtⁿ = ½(dt^{n−½} + dt^{n+½}).
    pub momentum_dt: f64,
}

impl Step {
    fn new(t: f64, dt: f64, dt_before: f64) -> Self {
        Self { t, dt, dt_before, momentum_dt: 0.5 * (dt_before + dt) }
    }

    /// What has to be stable [s]: where a short step follows a long one, the momentum takes half of both.
    pub fn longer(&self) -> f64 {
        self.dt.max(self.momentum_dt)
    }

    /// When the velocities before the step hold, t^{n−½}.
    pub fn before(&self) -> f64 {
        self.t - 0.5 * self.dt_before
    }

    /// When the velocities after the step hold, t^{n+½}.
    pub fn after(&self) -> f64 {
        self.t + 0.5 * self.dt
    }
}

/// The material point method in `D` dimensions.
#[derive(Debug)]
pub struct Mpm<const D: usize> {
    pub(super) grid: Grid<D>,
    pub(super) ghosts: Ghosts<D>,
    pub(super) walls: Walls<D>,
    pub(super) bodies: Vec<Body<D>>,
    /// How the particles of each body are sorted.
    pub(super) bins: Vec<Bins<D>>,
    /// The largest signal + |v| of each body [m/s].
    pub(super) fastest: Vec<f64>,
    pub(super) coupling: Coupling<D>,
    /// Membranes that meet each other or themselves.
    pub(super) proximity: Proximity<D>,
    pub(super) transfer: Transfer,
    /// Time between two noise filters [s].
    pub(super) filter_time: f64,
    /// Where the energy goes that the transfer dissipates.
    pub(super) dissipation: Dissipation,
    /// Order of the noise filter in this step; 0: none.
    pub(super) filter_order: u32,
    pub(super) stress_update: StressUpdate,
    pub(super) locking: Locking,
    pub(super) safety: f64,
    pub(super) gravity: [Signal; D],
    /// The masses below which the nodes of each field are small.
    pub(super) cutoff: Vec<MassCutoffs>,
    pub(super) books: Books,
    pub(super) accounts: Accounts,
    /// Kinetic and internal energy of the bodies [J].
    pub(super) energy: [f64; 2],
    /// What the volumes of gases hold off of their atmosphere, Σ p_a V_p [J].
    pub(super) displaced: f64,
    pub(super) tally: Tally,
    pub(super) summaries: Vec<Summary>,
    /// What the books show.
    pub(super) notices: Notices,
    /// The last step [s].
    pub(super) dt_before: f64,
    /// The bound of the next step [s].
    pub(super) bound: f64,
    pub(super) steps: u64,
    pub(super) timer: Timer,
}

impl<const D: usize> Solver for Mpm<D> {
    fn stable_dt(&self) -> f64 {
        self.bound
    }

    /// The momentum of a step takes half of it and half of the one before. A membrane that takes sub-steps feels forces
    /// that long while its nodes move for the step alone: after a long step, a tiny one would be a blow.
    fn largest_change(&self) -> f64 {
        if self.coupling.membranes.is_empty() { f64::INFINITY } else { CHANGE }
    }

    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        let step = Step::new(t, dt, self.dt_before);
        self.advance(&step).map_err(|error| StepError { time: t, ..error })?;
        self.dt_before = dt;
        self.steps += 1;
        self.bound = self.step_bound().min(GROWTH * self.bound);
        self.watch(t + dt);
        Ok(())
    }

    fn snapshot(&self) -> Snapshot<'_> {
        snapshot::snapshot(self)
    }

    fn forces(&self, visit: &mut dyn FnMut([f64; 3])) {
        snapshot::forces(self, visit);
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        columns::visit(self, visit);
    }

    fn misfit(&self) -> Option<String> {
        columns::misfit(self)
    }

    fn restored(&mut self) {
        self.proximity.forget();
        self.coupling.contact.restored();
    }

    fn notices(&mut self) -> Vec<String> {
        let mut said = self.coupling.contact.notices();
        said.extend(self.notices.take());
        said.extend(self.proximity.take());
        said
    }

    fn stage_times(&self) -> Vec<(&'static str, f64)> {
        self.timer.seconds()
    }

    fn particle_count(&self) -> usize {
        self.bodies.iter().map(|body| body.particles.len()).sum()
    }

    fn element_count(&self) -> usize {
        self.coupling.membranes.iter().map(|membrane| membrane.elements.len()).sum()
    }

    fn substeps(&self, dt: f64) -> u64 {
        let count = || self.coupling.substeps(Step::new(0.0, dt, self.dt_before).longer());
        if self.coupling.membranes.is_empty() { 0 } else { count() as u64 }
    }
}

impl<const D: usize> Mpm<D> {
    /// The step: trial momentum of the bodies, walls, then back to the particles.
    fn advance(&mut self, step: &Step) -> Result<(), StepError> {
        timed!(self.timer, "activate", self.activate());
        self.tally = Tally::default();
        self.filter_order = self.due_filter(step);
        self.summaries = vec![Summary::default(); self.bodies.len()];
        for field in 0..self.grid.fields.len() {
            timed!(self.timer, "p2g", self.scatter_particles(field, step)?); // m_I, p_I⁻         Lian (60, 61)
            timed!(self.timer, "stress", self.stress_and_force(field, step)?); // σ, f_I Lian (62, 63; 17, 18)
            timed!(self.timer, "grid", self.advance_momentum(field, step)); // p̄_I ← p_I + Δt f_I  Lian (64)
        }
        let Self { grid, walls, bodies, coupling, proximity, timer, .. } = self;
        coupling.advance((grid, walls), bodies, step, (proximity, timer))?; // membranes, J_I             Lian (39–59)
        self.book_walls_of_sheets(step);
        timed!(self.timer, "stress", self.lead_volumes());
        timed!(self.timer, "shift", self.even_out(step));
        timed!(self.timer, "grid", self.constrain_walls(step)); // once more
        timed!(self.timer, "contact", self.coupling.contact.account(&self.grid));
        for field in 0..self.grid.fields.len() {
            timed!(self.timer, "grid", self.finish_nodes(field, step)); // v_I⁺, a_I
            timed!(self.timer, "g2p", self.gather_particles(field, step)?); // v_p, ẋ_p           Lian (65, 19)
            timed!(self.timer, "stress", self.stress_last(field, step)?);
        }
        timed!(self.timer, "g2p", self.move_particles(step)?);
        timed!(self.timer, "shift", self.displace_particles(step));
        self.finish_step(step)?;
        self.close_books();
        health::check_energy(self.energy.iter().sum::<f64>() + self.books.sum())
    }
}

/// The bodies of a field with their bins.
fn in_field<'a, const D: usize>(
    bodies: &'a mut [Body<D>],
    bins: &'a mut [Bins<D>],
    field: usize,
) -> impl Iterator<Item = (&'a mut Body<D>, &'a mut Bins<D>)> {
    bodies.iter_mut().zip(bins).filter(move |(body, _)| body.field == field)
}

/// The same, to be read only.
pub(super) fn of_field<'a, const D: usize>(
    bodies: &'a [Body<D>],
    bins: &'a [Bins<D>],
    field: usize,
) -> impl Iterator<Item = (&'a Body<D>, &'a Bins<D>)> {
    bodies.iter().zip(bins).filter(move |(body, _)| body.field == field)
}
