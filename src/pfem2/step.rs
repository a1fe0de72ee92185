//! The step: particles carry what moves, the fixed mesh solves the rest, all fluids in one system
//! (Becker, Idelsohn & Oñate 2015; theory F.2).
//!
//! ```text
//! paper         x_p along vⁿ for Δt                          M (vⁿ⁺¹ − v̂)/Δt = forces(vⁿ⁺¹, pⁿ⁺¹)
//! second order  v_p += Δt (β₁ aⁿ + β₂ aⁿ⁻¹)                  explicit share, before the particle moves
//!               x_p along v* = vⁿ + ½Δt (vⁿ − vⁿ⁻¹)/Δtⁿ      the velocity at the middle of the step
//!               M (vⁿ⁺¹ − v̂)/(θΔt) = forces(vⁿ⁺¹, pⁿ⁺¹)      implicit share, aⁿ⁺¹ = (vⁿ⁺¹ − v̂)/(θΔt)
//!               β₂ = (θ − ½) Δt/Δtⁿ,   β₁ = 1 − θ − β₂
//! ```
//!
//! The second integrates forces along the paths of the particles: each acceleration is taken where the particle is at
//! its time, and vⁿ⁺¹ is free of divergence at the time and place at which it is shown. aⁿ⁻¹ is carried to where the
//! particles are now by tracing the nodes back. At θ = ½ these are the trapezoidal rule (theory F.2); with it, what
//! the nodes take from the particles comes back with the opposite sign, and noise never dies. θ = 9/16 are the weights
//! of Ascher, Ruuth & Wetton (1995); all θ ≥ ½ are A-stable and of second order. The first step is rehearsed (see
//! `start`). All of it is linear: convection and geometry come from the particles.

use crate::error::StepError;
use crate::linalg::SolverState;
use crate::math::Vector;
use crate::pfem2::Boundary;
use crate::pfem2::equations::system::{Physics, TimeStep, VelocityPressureSystem};
use crate::pfem2::interface::inflow::InflowComposition;
use crate::pfem2::interface::level_set::{self, LevelSet, Opening};
use crate::pfem2::interface::outline::Outline;
use crate::pfem2::interface::phases::Phases;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::convect::Projectiles;
use crate::pfem2::particles::correct::{self, Correction};
use crate::pfem2::particles::project::{ConvectedVelocity, Kernel, project};
use crate::pfem2::particles::reseed::{self, ParticleCounts, Reseeding};
use crate::pfem2::report::available::AvailablePotentialEnergy;
use crate::pfem2::report::forces::{self, BoundaryPart};
use crate::pfem2::report::friction::Friction;
use crate::pfem2::report::health;
use crate::pfem2::report::ledger::{EnergyLedger, ExternalRates, FlowTotals};
use crate::pfem2::report::notices::Notices;
use crate::pfem2::report::snapshot;
use crate::pfem2::report::through::OpenBoundaryFlux;
use crate::pfem2::setup::{Scheme, Setup, Unresolved};
use crate::pfem2::time::step_control::StepControl;
use crate::simulation::{Column, Snapshot, Solver, Timer};
use crate::timed;

/// A step may be as many times longer than the one before: twice as long, from two to one between outputs, at most.
const LARGEST_CHANGE: f64 = 2.0;

/// Room for rounding where times are compared.
const ROUNDING: f64 = 1.0 + 1e-9;

/// PFEM-2 in `D` dimensions on simplices with `N` = `D` + 1 nodes.
pub struct Pfem2<const D: usize, const N: usize> {
    pub(super) system: VelocityPressureSystem<D, N>,
    pub(super) particles: Particles<D>,
    /// vⁿ⁻¹ at the nodes [m/s].
    pub(super) before: Vec<Vector<D>>,
    /// vⁿ⁻² at the nodes [m/s].
    pub(super) earlier: Vec<Vector<D>>,
    /// aⁿ at the nodes [m/s²].
    pub(super) acceleration: Vec<Vector<D>>,
    /// aⁿ⁻¹ of what is at the nodes now [m/s²].
    pub(super) carried: Vec<Vector<D>>,
    /// Fraction of each fluid at the nodes.
    pub(super) fraction: Vec<Vec<f64>>,
    /// Level set at the nodes, negative in the heavier of two fluids.
    pub(super) level: Vec<f64>,
    /// Source of `level`, if it is sharp.
    pub(super) sharp: Option<LevelSet>,
    /// Volume of the heavier fluid at the start, if shifts of the level set keep it [m³].
    pub(super) kept_volume: Option<f64>,
    /// Volume of each of several fluids at the start, if weights of their shares keep them [m³].
    pub(super) kept_volumes: Option<Vec<f64>>,
    /// The largest factor between the last weights.
    pub(super) weight: f64,
    /// Volume that has left through open boundaries, of the fluid where the level set is negative and of both [m³].
    pub(super) outflow: [f64; 2],
    /// Facets through which it may leave.
    pub(super) openings: Vec<Opening<D>>,
    /// What flows in.
    pub(super) supply: InflowComposition<D>,
    /// The last shift [m].
    pub(super) shift: f64,
    pub(super) density: Vec<f64>,
    pub(super) scheme: Scheme,
    kernel: Kernel,
    pub(super) reseeding: Reseeding,
    pub(super) crowd: ParticleCounts,
    /// Fluids that follow their own side of the interface.
    pub(super) is_projectile: Vec<bool>,
    pub(super) relaxation: f64,
    pub(super) unresolved: Unresolved,
    /// Energy that the bound of what particles have against the mesh has taken [J].
    pub(super) unresolved_energy: f64,
    pub(super) courant: f64,
    pub(super) step_control: StepControl,
    pub(super) parts: Vec<BoundaryPart<D>>,
    /// Forces of the fluid on the parts at the end of the last step [N].
    pub(super) forces: Vec<Vector<D>>,
    /// Those at the end of the step before [N].
    pub(super) earlier_forces: Vec<Vector<D>>,
    /// Their means over the last step [N], with the shares that the step takes of them.
    pub(super) mean_forces: Vec<Vector<D>>,
    /// Where fluids meet after the last step.
    pub(super) outline: Outline,
    pub(super) totals: FlowTotals,
    pub(super) books: EnergyLedger,
    /// What viscosity takes.
    pub(super) friction: Friction<D>,
    pub(super) counts: RunCounts,
    pub(super) places: Vec<[f64; 3]>,
    /// The last step [s]; 0 before the first.
    pub(super) dt_before: f64,
    /// The step before it [s].
    pub(super) dt_earlier: f64,
    pub(super) steps: u64,
    /// What the linear solver carries over steps, while a checkpoint is written or read.
    pub(super) memory: SolverState,
    pub(super) notices: Notices,
    /// What gravity can do, where that can be told.
    pub(super) available: Option<AvailablePotentialEnergy>,
    /// Volume of each fluid at the start [m³]; empty where fluid may come in or leave.
    pub(super) closed: Vec<f64>,
    timer: Timer,
}

/// What happened so far, for histories.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RunCounts {
    /// Particles that left through open boundaries.
    pub left: u64,
    /// Particles that crossed too many elements and stopped on their way.
    pub stuck: u64,
    /// Particles added where there were none.
    pub added: u64,
    /// Of these, those that came in through an open boundary.
    pub inflow: u64,
    /// Particles merged where there were too many.
    pub merged: u64,
    /// Particles that joined the other fluid, deep inside of it.
    pub joined: u64,
    /// Elements found empty.
    pub empty: u64,
}

impl<const D: usize, const N: usize> Solver for Pfem2<D, N> {
    fn stable_dt(&self) -> f64 {
        self.wave_dt().min(self.courant_dt())
    }

    fn recommended_dt(&self) -> f64 {
        self.automatic_dt()
    }

    fn foreseen_dt(&self, end: f64) -> Option<[f64; 2]> {
        if self.step_control.is_active() { self.foreseen(end) } else { Some([self.automatic_dt(); 2]) }
    }

    fn largest_change(&self) -> f64 {
        if self.step_control.is_active() { LARGEST_CHANGE } else { f64::INFINITY }
    }

    fn begin(&mut self, t: f64, dt: f64) {
        self.memory = SolverState::default();
        self.show_pressure(TimeStep { t, dt, theta: 1.0 });
    }

    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        self.memory = SolverState::default();
        let at = |error| StepError { time: t, ..error };
        // Rehearsed already, unless the step is another one than was foreseen.
        if self.steps == 0 && self.scheme != Scheme::BackwardEuler && self.dt_before != dt {
            self.rehearse(TimeStep { t, dt, theta: 1.0 }).map_err(at)?;
        }
        let theta = match self.scheme {
            Scheme::SecondOrder { theta } if self.follows(dt) => theta,
            _ => 1.0,
        };
        self.advance(TimeStep { t, dt, theta }).map_err(at)?;
        self.estimate(dt);
        self.dt_earlier = self.dt_before;
        self.dt_before = dt;
        self.steps += 1;
        self.notices.look(&self.system, &self.particles, &self.fraction);
        self.watch().map_err(at)
    }

    fn notices(&mut self) -> Vec<String> {
        self.notices.take()
    }

    fn snapshot(&self) -> Snapshot<'_> {
        snapshot::snapshot(self)
    }

    fn forces(&self, visit: &mut dyn FnMut([f64; 3])) {
        self.mean_forces.iter().for_each(|force| visit(force.to3()));
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        snapshot::columns(self, visit);
    }

    fn misfit(&self) -> Option<String> {
        snapshot::misfit(self)
    }

    fn restored(&mut self) {
        self.particles.sort();
        self.settle();
        self.system.recall(&std::mem::take(&mut self.memory));
    }

    fn stage_times(&self) -> Vec<(&'static str, f64)> {
        self.timer.seconds()
    }

    fn particle_count(&self) -> usize {
        self.particles.len()
    }
}

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// The state at the start.
    pub fn new(setup: Setup<D, N>) -> Self {
        let Setup { mesh, boundaries, fluids, tension, gravity, velocity, .. } = setup;
        let (stabilisation, mass, enrichment) = (setup.stabilisation, setup.mass, setup.enrichment);
        let down = Vector::from_fn(|i| gravity[i].value([0.0; 3], 0.0));
        let boundary = Boundary::new(&mesh, boundaries, down).pinned(&mesh, setup.pin.as_ref());
        let parts = forces::parts(&mesh, &boundary);
        let nodes = mesh.nodes().len();
        let density: Vec<f64> = fluids.iter().map(|fluid| fluid.density).collect();
        let lightest = density.iter().copied().fold(f64::INFINITY, f64::min);
        let nominal = setup.particles.len() / mesh.elements().len();
        let physics = Physics { fluids, tension, gravity, mass, stabilisation, enrichment };
        let places = mesh.nodes().iter().map(|x| x.to3()).collect();
        let system = VelocityPressureSystem::new(mesh, boundary, physics, velocity, setup.linear);
        let mut pfem = Self {
            particles: setup.particles,
            before: system.velocity.clone(),
            earlier: system.velocity.clone(),
            acceleration: vec![Vector::ZERO; nodes],
            carried: vec![Vector::ZERO; nodes],
            fraction: Vec::new(),
            level: Vec::new(),
            kept_volume: None,
            kept_volumes: None,
            weight: 1.0,
            outflow: [0.0; 2],
            openings: Vec::new(),
            supply: InflowComposition::default(),
            sharp: setup.level_set.filter(|_| density.len() == 2),
            shift: 0.0,
            scheme: setup.scheme,
            kernel: setup.kernel,
            reseeding: setup.reseeding,
            crowd: ParticleCounts::new::<D>(nominal),
            is_projectile: density
                .iter()
                .map(|rho| density.len() == 2 && *rho >= setup.projectile_ratio * lightest)
                .collect(),
            density,
            relaxation: setup.relaxation,
            unresolved: setup.unresolved,
            unresolved_energy: 0.0,
            courant: setup.courant,
            step_control: StepControl::new(setup.step_tolerance),
            forces: vec![Vector::ZERO; parts.len()],
            earlier_forces: vec![Vector::ZERO; parts.len()],
            mean_forces: vec![Vector::ZERO; parts.len()],
            parts,
            outline: Outline::default(),
            totals: FlowTotals::default(),
            books: EnergyLedger::default(),
            friction: Friction::at_rest(nodes),
            counts: RunCounts::default(),
            places,
            dt_before: 0.0,
            dt_earlier: 0.0,
            steps: 0,
            memory: SolverState::default(),
            notices: Notices::default(),
            available: None,
            closed: Vec::new(),
            timer: Timer::default(),
            system,
        };
        pfem.project();
        pfem.settle();
        pfem.notices = Notices::of_the_start(&pfem.system, &pfem.particles, &pfem.fraction);
        pfem.supply = pfem.supply_at_the_start();
        pfem.follow_volumes(setup.volume);
        pfem.begin_interface();
        pfem.begin_watch();
        pfem.books = EnergyLedger::open(pfem.totals.kinetic, pfem.system.surface_energy(), pfem.jolt());
        pfem
    }

    /// The step of the method.
    fn advance(&mut self, step: TimeStep) -> Result<(), StepError> {
        timed!(self.timer, "correct", self.kick(step)); // Δt (β₁ aⁿ + β₂ aⁿ⁻¹)        theory (F.3)
        timed!(self.timer, "convect", self.convect(step)); // streamlines                  Becker (34)–(36), theory (F.4)
        timed!(self.timer, "interface", self.follow_interface()); // φ, sharp, V         theory G.2–G.6
        let seen = timed!(self.timer, "project", self.project()); // v̂, φ                  Becker (37)–(39), theory G.11
        let mut convected = seen.mean.clone();
        self.system.boundary.impose(&self.system.mesh, [step.t, step.dt, step.theta], &mut convected);
        std::mem::swap(&mut self.earlier, &mut self.before);
        self.before.copy_from_slice(&self.system.velocity);
        timed!(self.timer, "solve", self.solve(step, &convected)?); // v, p, condensed          Becker (20), (29)–(33), theory F.6, G.8
        timed!(self.timer, "correct", self.correct(step, &seen, &convected)); // v_p += N δv    Becker (40), theory F.11
        timed!(self.timer, "account", self.account(step, &convected));
        health::check_particles(&self.particles)?;
        health::check_nodes(&self.system)
    }

    /// β₁ and β₂ (theory (F.8)).
    fn explicit_shares(&self, step: TimeStep) -> [f64; 2] {
        match self.scheme {
            Scheme::SecondOrder { theta } if self.follows(step.dt) => {
                let earlier = (theta - 0.5) * step.dt / self.dt_before;
                [1.0 - theta - earlier, earlier]
            }
            _ => [0.0, 0.0],
        }
    }

    /// What the explicit share of the step gives the nodes [m/s].
    pub(in crate::pfem2) fn kicks(&self, step: TimeStep) -> Vec<Vector<D>> {
        let [now, earlier] = self.explicit_shares(step).map(|share| share * step.dt);
        self.acceleration.iter().zip(&self.carried).map(|(a, carried)| *a * now + *carried * earlier).collect()
    }

    /// Gives the particles the explicit share of the step.
    fn kick(&mut self, step: TimeStep) {
        let [now, earlier] = self.explicit_shares(step);
        if now + earlier != 0.0 {
            let kicks = self.kicks(step);
            self.give(&vec![&kicks[..]; self.density.len()], (now + earlier) * step.dt, 0.0);
        }
    }

    /// Gives nodal increments for each fluid [m/s], which took the time `dt` [s], to the particles.
    fn give(&mut self, increment: &[&[Vector<D>]], dt: f64, filter: f64) {
        let gravity = self.system.force[0];
        let (heavy, light) = extremes(&self.density);
        let rule = Projectiles { fluids: &self.is_projectile, level: &self.level, gravity };
        let projectiles = self.flies().then_some((rule, gravity * (dt * (1.0 - light / heavy))));
        let correction = Correction { increment, velocity: &self.system.velocity, filter, projectiles };
        self.particles.correct(&self.system.mesh, &correction);
    }

    /// True if some fluid follows its own side of the interface.
    fn flies(&self) -> bool {
        self.is_projectile.contains(&true)
    }

    /// True if the last step says how the flow changes over the next: after a much shorter one, as outputs may cut
    /// it, the extrapolation would multiply what is left of round-off, and the step starts anew with first order.
    pub(in crate::pfem2) fn follows(&self, dt: f64) -> bool {
        self.dt_before > 0.0 && dt <= LARGEST_CHANGE * ROUNDING * self.dt_before
    }

    /// True if the last two steps say how the change of the flow changes.
    pub(in crate::pfem2) fn follows_twice(&self, dt: f64) -> bool {
        self.follows(dt) && self.dt_earlier > 0.0 && self.dt_before <= LARGEST_CHANGE * ROUNDING * self.dt_earlier
    }

    /// Velocity and phases at the nodes; returns v̂ [m/s].
    pub(in crate::pfem2) fn project(&mut self) -> ConvectedVelocity<D> {
        let VelocityPressureSystem { mesh, velocity, .. } = &self.system;
        let projected = project(mesh, &self.particles, &self.density, self.kernel, velocity);
        self.fraction = projected.fraction;
        let heavy = usize::from(self.density.len() == 2 && self.density[1] > self.density[0]);
        self.level = match (&self.sharp, self.density.len()) {
            (Some(sharp), _) => sharp.level.clone(),
            (None, 2) => {
                let mut level = level_set::pseudo(&self.fraction[heavy]);
                level_set::absorb_isolated_nodes(mesh, &mut level);
                level
            }
            _ => Vec::new(),
        };
        if self.density.len() > 2 {
            self.weigh_shares();
        }
        projected.velocity
    }

    fn solve(&mut self, step: TimeStep, convected: &[Vector<D>]) -> Result<(), StepError> {
        let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
        self.system.solve(step, &phases, convected)
    }

    /// Gives the particles what the nodes have and they don't show.
    ///
    /// What particles show at a node with a prescribed velocity enters no equation; unless they are led back to it, it
    /// drifts away.
    fn correct(&mut self, step: TimeStep, seen: &ConvectedVelocity<D>, convected: &[Vector<D>]) {
        let missing = seen.missing(&self.system.velocity, self.density.len());
        let missing: Vec<&[Vector<D>]> = missing.iter().map(|own| &own[..]).collect();
        self.give(&missing, step.delta(), correct::filter(step.dt, self.relaxation));
        self.bound_unresolved();
        if self.reseeding == Reseeding::Elements {
            let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
            let VelocityPressureSystem { mesh, velocity, .. } = &self.system;
            self.counts.added += reseed::refill(&mut self.particles, mesh, velocity, &phases) as u64;
        }
        self.join();
        self.remember(step, convected);
    }

    /// Keeps the acceleration for the next step [m/s²].
    pub(in crate::pfem2) fn remember(&mut self, step: TimeStep, convected: &[Vector<D>]) {
        self.acceleration.clear();
        let both = self.system.velocity.iter().zip(convected);
        self.acceleration.extend(both.map(|(v, hat)| (*v - *hat) / step.delta()));
    }

    /// Forces on the boundary, and the books.
    fn account(&mut self, step: TimeStep, convected: &[Vector<D>]) {
        let [last, earlier] = self.explicit_shares(step);
        let before = self.forces.clone();
        let outside = self.push(step, convected);
        let all = self.earlier_forces.iter().zip(&before).zip(&self.forces);
        self.mean_forces = all.map(|((f0, f1), f2)| *f0 * earlier + *f1 * last + *f2 * step.theta).collect();
        self.earlier_forces = before;
        self.trace_interface();
        let shares = [step.theta, last, earlier];
        let viscous = self.friction.take(&self.system, step.dt, shares, self.steps == 0);
        self.books.add(step.dt, shares, &outside, viscous);
        let kept = self.density.len() == 1 || self.kept_volume.is_some() || self.kept_volumes.is_some();
        let fallen = self.available.as_ref().filter(|_| kept).map(|available| available.fallen(&self.totals));
        fallen.iter().for_each(|fallen| self.books.fall(*fallen));
        self.books.note(&self.totals, self.system.surface_energy());
    }

    /// Finds the forces on the parts, and what acts from outside, at the end of a step.
    pub(in crate::pfem2) fn push(&mut self, step: TimeStep, convected: &[Vector<D>]) -> ExternalRates<D> {
        let elements = self.system.elements(convected);
        let (mut outside, mut power) = (Vector::<D>::ZERO, 0.0);
        let mut loads = vec![Vector::ZERO; self.system.velocity.len()];
        self.system.boundary.load(&self.system.mesh, step.end(), |node, traction| {
            outside += traction;
            power += traction.dot(self.system.velocity[node]);
            loads[node] += traction;
        });
        let force = |part: &BoundaryPart<D>| part.force(&elements, &loads, &self.system.unknowns);
        let pushes: Vec<_> = self.parts.iter().map(force).collect();
        for (force, work) in &pushes {
            outside -= *force;
            power += work;
        }
        forces::open_boundary_load(&elements, &self.system.velocity, |node, traction| {
            outside += traction;
            power += traction.dot(self.system.velocity[node]);
        });
        self.forces = pushes.into_iter().map(|(force, _)| force).collect();
        self.totals = FlowTotals::of(&self.system);
        let FlowTotals { gravity, weight, .. } = self.totals;
        let force = std::array::from_fn(|i| outside.to3()[i] + weight[i]);
        ExternalRates {
            gravity,
            boundary: power,
            force,
            through: OpenBoundaryFlux::of(&self.system, |place| self.density_brought(place)),
        }
    }

    /// Rebuilds what follows from the columns: contents of the elements, sums over the mesh, the interface.
    pub(in crate::pfem2) fn settle(&mut self) {
        let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
        self.system.fill(&phases, &self.before);
        self.totals = FlowTotals::of(&self.system);
        self.trace_interface();
    }

    /// Where fluids meet now.
    fn trace_interface(&mut self) {
        let VelocityPressureSystem { mesh, velocity, .. } = &self.system;
        let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
        self.outline = Outline::new(mesh, &phases, velocity);
    }
}

/// The largest and the smallest density [kg/m³].
fn extremes(density: &[f64]) -> (f64, f64) {
    let largest = density.iter().copied().fold(0.0, f64::max);
    (largest, density.iter().copied().fold(f64::INFINITY, f64::min))
}
