//! One explicit step of the coupled method (Lian, Liu & Zhang 2014, section 6; corrected as in theory 9).
//!
//! Positions and stresses live at full steps, velocities half a step earlier; the first step starts from the
//! velocity at t = 0 with half a step of momentum, so that the scheme is second order from the start.

use super::coupling::Coupling;
use super::filter::filter;
use super::ghost::Ghosts;
use super::ledger::{AccountId, Books};
use super::motion::{Landing, Summary, Transport, gather_mean, gather_motion};
use super::particles::Body;
use super::stability::GROWTH;
use super::stress::{Strain, average_pressure, strain_and_land, update_stress};
use super::sweep::{Answer, Bins, Content, Sweep, View};
use super::wall::Walls;
use super::{Field, Grid, Locking, Node, StressUpdate, Transfer, columns, health, snapshot};
use crate::error::StepError;
use crate::math::{Signal, Vector};
use crate::parallel;
use crate::simulation::{Column, Snapshot, Solver, TermKind, Timer};
use crate::timed;

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

    /// When the velocities before the step hold, t^{n−½}.
    pub fn before(&self) -> f64 {
        self.t - 0.5 * self.dt_before
    }

    /// When the velocities after the step hold, t^{n+½}.
    pub fn after(&self) -> f64 {
        self.t + 0.5 * self.dt
    }
}

/// The accounts that the bodies book to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accounts {
    gravity: AccountId,
    traction: AccountId,
    wall: AccountId,
    wall_loss: AccountId,
    transfer: AccountId,
    stress: AccountId,
}

impl Accounts {
    /// Opens the accounts, in the order in which the ledger shows them.
    pub(super) fn open() -> (Books, Self) {
        let mut books = Books::default();
        let accounts = Self {
            gravity: books.open("work of gravity", TermKind::Gain),
            traction: books.open("work of tractions", TermKind::Gain),
            wall: books.open("work of walls", TermKind::Gain),
            stress: books.open("stress update error", TermKind::Gain),
            wall_loss: books.open("wall dissipation", TermKind::Loss),
            transfer: books.open("transfer dissipation", TermKind::Loss),
        };
        (books, accounts)
    }
}

/// What the grid did to the bodies during a step [J].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    /// Δt Σ f_I · v̂_I over all forces.
    nodes: f64,
    /// The same over the forces of stresses, gravity and tractions.
    applied: f64,
    /// Of gravity and tractions.
    external: f64,
}

/// What the forces on nodes did during a step [J], and the mass they act on [kg].
#[derive(Debug, Clone, Copy, Default)]
struct NodeWork {
    all: f64,
    applied: f64,
    weight: f64,
    mass: f64,
}

impl NodeWork {
    fn and(self, other: Self) -> Self {
        Self {
            all: self.all + other.all,
            applied: self.applied + other.applied,
            weight: self.weight + other.weight,
            mass: self.mass + other.mass,
        }
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
    pub(super) transfer: Transfer,
    /// Time between two noise filters [s].
    pub(super) filter_time: f64,
    /// Order of the noise filter in this step; 0: none.
    pub(super) filter_order: u32,
    pub(super) stress_update: StressUpdate,
    pub(super) locking: Locking,
    pub(super) safety: f64,
    pub(super) gravity: [Signal; D],
    /// Nodes up to this mass have no velocity [kg].
    pub(super) cutoff: f64,
    pub(super) books: Books,
    pub(super) accounts: Accounts,
    /// Kinetic and internal energy of the bodies [J].
    pub(super) energy: [f64; 2],
    pub(super) tally: Tally,
    pub(super) summaries: Vec<Summary>,
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

    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        let step = Step::new(t, dt, self.dt_before);
        self.advance(&step).map_err(|error| StepError { time: t, ..error })?;
        self.dt_before = dt;
        self.steps += 1;
        self.bound = self.step_bound().min(GROWTH * self.bound);
        Ok(())
    }

    fn snapshot(&self) -> Snapshot<'_> {
        snapshot::snapshot(self)
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        columns::visit(self, visit);
    }

    fn stage_times(&self) -> Vec<(&'static str, f64)> {
        self.timer.seconds()
    }

    fn particle_count(&self) -> usize {
        self.bodies.iter().map(|body| body.particles.len()).sum()
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
            timed!(self.timer, "p2g", self.scatter_particles(field, step)); // m_I, p_I⁻        (60, 61)
            timed!(self.timer, "stress", self.stress_first(field, step)?); // Δε, Ω, σ          (62, 63)
            timed!(self.timer, "force", self.scatter_forces(field)); // f_I                     (17, 18)
            timed!(self.timer, "grid", self.advance_momentum(field, step)); // p̄_I ← p_I + Δt f_I  (64)
        }
        let Self { grid, bodies, coupling, timer, .. } = self;
        coupling.advance(grid, bodies, step, timer)?; // membranes, J_I                     (39–59)
        timed!(self.timer, "grid", self.constrain_walls(step)); // contact may have pushed into them
        timed!(self.timer, "contact", self.coupling.contact.account(&self.grid));
        for field in 0..self.grid.fields.len() {
            timed!(self.timer, "grid", self.finish_nodes(field, step)); // v_I⁺, a_I
            timed!(self.timer, "g2p", self.gather_particles(field, step)?); // v_p, ẋ_p           (65, 19)
            timed!(self.timer, "stress", self.stress_last(field, step)?);
        }
        timed!(self.timer, "g2p", self.move_particles(step)?);
        self.close_books();
        Ok(())
    }

    /// Sorts the bodies whose particles have left their blocks, activates the blocks that they reach, and finds
    /// the ghosts and wall nodes.
    fn activate(&mut self) {
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
        self.walls.start_step();
    }

    /// True if the stresses that make the forces are known when mass and momentum are scattered.
    fn scatters_at_once(&self) -> bool {
        matches!(self.stress_update, StressUpdate::Last | StressUpdate::ModifiedLast)
    }

    /// m_I and p_I⁻ with the binding walls (60, 61).
    fn scatter_particles(&mut self, field: usize, step: &Step) {
        let content = if self.scatters_at_once() { Content::MomentumAndForce } else { Content::Momentum };
        let Self { grid, bodies, bins, ghosts, walls, cutoff, gravity, locking, .. } = self;
        grid.with_field(field, |grid, own| {
            for (body, bins) in in_field(bodies, bins, field) {
                body.find_external_forces(gravity, step.t);
                if content == Content::MomentumAndForce {
                    average_pressure((grid, ghosts), *locking, body, bins);
                }
                bins.extents = Sweep::new(grid, body.kernel, bins).scatter(&mut own.nodes, body, content);
            }
            walls.fold(ghosts, field, &mut own.nodes);
            // Nodes that are too light have no velocity; nothing may push them (theory 2.5).
            parallel::for_each_mut(&mut own.nodes, |node| {
                if node.mass <= *cutoff {
                    *node = Node::default();
                }
            });
            walls.constrain_start(grid, field, &mut own.nodes, step.before());
        });
    }

    /// The stress update before the forces, over the interval that led here (62, 63).
    fn stress_first(&mut self, field: usize, step: &Step) -> Result<(), StepError> {
        let dt = match self.stress_update {
            StressUpdate::First => step.dt_before,
            StressUpdate::Average => 0.5 * step.dt_before,
            StressUpdate::Last | StressUpdate::ModifiedLast => return Ok(()),
        };
        let Self { grid, bodies, bins, ghosts, locking, .. } = self;
        grid.with_field(field, |grid, own| {
            let velocity = |node: &Node<D>| {
                if node.mass > 0.0 { node.momentum / node.mass } else { Vector::ZERO }
            };
            parallel::map_into(&own.nodes, &mut own.velocity, velocity);
            ghosts.fill(&mut own.velocity);
            let strain = Strain { velocity: &own.velocity, dt, locking: *locking, backwards: true };
            in_field(bodies, bins, field).try_for_each(|(body, bins)| {
                let sweep = Sweep::new(grid, body.kernel, bins);
                update_stress(&sweep, (grid, ghosts), strain, body, Landing::Stay).map(|_| ())
            })
        })
    }

    /// f_I of stresses and of forces on particles (17, 18), where they could not be scattered with the momentum.
    fn scatter_forces(&mut self, field: usize) {
        if self.scatters_at_once() {
            return;
        }
        let Self { grid, bodies, bins, ghosts, walls, locking, .. } = self;
        grid.with_field(field, |grid, own| {
            for (body, bins) in in_field(bodies, bins, field) {
                average_pressure((grid, ghosts), *locking, body, bins);
                Sweep::new(grid, body.kernel, bins).scatter(&mut own.nodes, body, Content::Force);
            }
            walls.fold(ghosts, field, &mut own.nodes);
        });
    }

    /// Gravity that is the same everywhere at time `t` acts on the nodes [m/s²]; other gravity on the particles.
    fn uniform_gravity(&self, t: f64) -> Vector<D> {
        let uniform = self.gravity.iter().all(Signal::is_uniform);
        Vector::from_fn(|a| if uniform { self.gravity[a].value([0.0; 3], t) } else { 0.0 })
    }

    /// p̄_I ← p_I⁻ + Δt f_I with gravity among the forces, then the walls (64).
    fn advance_momentum(&mut self, field: usize, step: &Step) {
        let (gravity, dt) = (self.uniform_gravity(step.t), step.momentum_dt);
        let Self { grid, walls, .. } = self;
        grid.with_field(field, |grid, own| {
            let Field { nodes, applied, .. } = own;
            applied.resize(nodes.len(), Vector::ZERO);
            parallel::for_each_pair_mut(nodes, applied, |node, applied| {
                node.force = if node.mass > 0.0 { node.force + gravity * node.mass } else { Vector::ZERO };
                node.momentum += node.force * dt;
                *applied = node.force;
            });
            walls.constrain_trial(grid, field, nodes, step.after(), dt);
        });
    }

    /// The walls once more, after contact.
    fn constrain_walls(&mut self, step: &Step) {
        let Self { grid, walls, .. } = self;
        for field in 0..grid.fields.len() {
            grid.with_field(field, |grid, own| {
                walls.constrain_trial(grid, field, &mut own.nodes, step.after(), step.momentum_dt);
            });
        }
    }

    /// Turns (m, p⁺, f) into (m, v⁺, a), settles the work of the forces, and fills the ghosts.
    fn finish_nodes(&mut self, field: usize, step: &Step) {
        let share = self.pic_share(step.momentum_dt);
        let gravity = self.uniform_gravity(step.t);
        let Self { grid, walls, ghosts, tally, books, accounts, .. } = self;
        grid.with_field(field, |grid, own| {
            let dt = step.momentum_dt;
            let Field { nodes, applied, .. } = own;
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
            ghosts.fill(&mut own.nodes);
            let done = walls.settle(grid, field, &own.nodes, step, share);
            books.add(accounts.wall, done.work);
            books.add(accounts.wall_loss, done.dissipation);
            books.push(done.impulse.to3());
        });
    }

    /// The part of the particles' velocity that comes from v⁺ itself.
    fn pic_share(&self, dt: f64) -> f64 {
        match self.transfer {
            Transfer::Flip { relaxation, .. } => -(-dt / relaxation).exp_m1(),
            Transfer::Apic => 1.0,
        }
    }

    /// Order of the noise filter if it is due in this step, else 0. It is due by time, not by steps: a viscous gas or
    /// a short step would be filtered more often for no more noise.
    fn due_filter(&self, step: &Step) -> u32 {
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
    fn lands_at_once(&self) -> bool {
        self.stress_update == StressUpdate::Last && self.locking == Locking::None && self.filter_order == 0
    }

    /// Where the particles are at the end of the step.
    fn landing(&self, step: &Step) -> Landing<D> {
        Landing::Move { dt: step.dt, domain: [self.grid.origin, self.grid.upper()] }
    }

    /// v_p and ẋ_p (65, 19), and the work of external forces; all that remains of the step where that can be done
    /// in the same sweep.
    fn gather_particles(&mut self, field: usize, step: &Step) -> Result<(), StepError> {
        let dt = step.momentum_dt;
        let (share, order) = (self.pic_share(dt), self.filter_order);
        let (at_once, landing) = (self.lands_at_once(), self.landing(step));
        let Self { grid, bodies, bins, ghosts, walls, tally, books, accounts, summaries, .. } = self;
        let (grid, own) = (&*grid, &grid.fields[field]);
        for (index, (body, bins)) in
            bodies.iter_mut().zip(&*bins).enumerate().filter(|(_, (body, _))| body.field == field)
        {
            let sweep = Sweep::new(grid, body.kernel, bins);
            let transport = Transport::new(dt, share, body.kernel, grid.cell);
            gather_mean(&sweep, &own.nodes, dt, body);
            if at_once {
                summaries[index] = strain_and_land(&sweep, &own.nodes, transport, step.dt, body, landing)?;
            } else {
                gather_motion(&sweep, &own.nodes, transport, body);
            }
            let (all, tractions, impulse) = body.external_work(dt);
            tally.external += all;
            books.add(accounts.gravity, all - tractions);
            books.add(accounts.traction, tractions);
            books.push(impulse.to3());
        }
        if order > 0 {
            let mut bodies: Vec<_> = bodies.iter_mut().zip(&*bins).filter(|(body, _)| body.field == field).collect();
            filter(grid, (ghosts, walls), own, &mut bodies, order);
        }
        Ok(())
    }

    /// The stress update after the motion, with v⁺ or with the re-mapped velocity (theory 2.4); then x_p += Δt ẋ_p.
    fn stress_last(&mut self, field: usize, step: &Step) -> Result<(), StepError> {
        if self.lands_at_once() {
            return Ok(());
        }
        let (dt, remapped) = match self.stress_update {
            StressUpdate::First => return Ok(()),
            StressUpdate::Last => (step.dt, false),
            StressUpdate::ModifiedLast => (step.dt, true),
            StressUpdate::Average => (0.5 * step.dt, true),
        };
        let landing = self.landing(step);
        let Self { grid, bodies, bins, ghosts, walls, locking, summaries, .. } = self;
        grid.with_field(field, |grid, own| {
            if remapped {
                own.velocity.clear();
                own.velocity.resize(own.nodes.len(), Vector::ZERO);
                for (body, bins) in in_field(bodies, bins, field) {
                    Sweep::new(grid, body.kernel, bins).scatter(&mut own.velocity, body, Content::Momentum);
                }
                ghosts.fold(&mut own.velocity, |_, _, _| {});
                parallel::for_each_pair_mut(&mut own.velocity, &mut own.nodes, |v, node| {
                    *v = if node.mass > 0.0 { *v / node.mass } else { Vector::ZERO };
                });
                walls.constrain_velocity(grid, &mut own.velocity, step.after());
                ghosts.fill(&mut own.velocity);
            } else {
                parallel::map_into(&own.nodes, &mut own.velocity, |node| node.momentum);
            }
            let strain = Strain { velocity: &own.velocity, dt, locking: *locking, backwards: false };
            for (index, (body, bins)) in
                bodies.iter_mut().zip(&*bins).enumerate().filter(|(_, (body, _))| body.field == field)
            {
                let sweep = Sweep::new(grid, body.kernel, bins);
                summaries[index] = update_stress(&sweep, (grid, ghosts), strain, body, landing)?;
            }
            Ok(())
        })
    }

    /// Lands the particles that have not yet, moves the obstacles, and sees that everything is sound.
    fn move_particles(&mut self, step: &Step) -> Result<(), StepError> {
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
        let put_back = self.coupling.contact.restore(&mut self.bodies);
        self.bins.iter_mut().for_each(|bins| bins.disorder.drift += put_back / self.grid.cell);
        self.walls.advance(step.t, step.dt);
        Ok(())
    }

    /// Kinetic and internal energy of all bodies [J].
    pub(super) fn body_energies(&self) -> [f64; 2] {
        let kinetic = self.bodies.iter().map(|body| body.particles.kinetic_energy()).sum();
        let internal = self.bodies.iter().map(|body| body.particles.internal_energy()).sum();
        [kinetic, internal]
    }

    /// Books what the transfers lost and what the stress update made up (theory 10).
    fn close_books(&mut self) {
        let all = self.summaries.iter().fold(Summary::default(), |sum, &summary| sum.and(summary));
        let Summary { kinetic, internal, .. } = all;
        let [kinetic_before, internal_before] = self.energy;
        self.books.add(self.accounts.transfer, self.tally.nodes - (kinetic - kinetic_before));
        let internal_work = self.tally.applied - self.tally.external;
        self.books.add(self.accounts.stress, internal - internal_before + internal_work);
        self.energy = [kinetic, internal];
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
