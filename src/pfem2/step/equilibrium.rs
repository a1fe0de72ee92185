//! A start at rest: solids bear their weight, their loads and the pressure of the fluids at time 0 (theory J.14).
//!
//! ```text
//! [M/τ + τ K(u_k)] v = f − F(u_k) + forces of the fluid,   u_k+1 = u_k + τ v,   v ← 0,   τ ← τ min(2, √(h/2 / |τ v|))
//! ```
//!
//! Steps of backward Euler in an artificial time, each from rest: short ones follow the way that the forces lead, long
//! ones are those of Newton's method. The fluid that the solids push away takes its particles and interfaces along.
//! Forces of fluids that carry a solid without supports are not in K, and along a floor nothing may hold it at all:
//! with such solids τ is at most the time in which gravity, or without weight what their loads do to them at first,
//! moves them by an element.

use super::startup::impulsive_energy;
use crate::error::{Place, StepError};
use crate::math::Vector;
use crate::pfem2::Pfem2;
use crate::pfem2::ThetaStep;
use crate::pfem2::balance::SolidsAtStart;
use crate::pfem2::checks::notices::Notices;
use crate::pfem2::tracking::particles::ParticleEvents;
use crate::pfem2::tracking::solids::SolidTracking;
use std::sync::atomic::Ordering;

/// The last displacement, over the largest in all, and the last acceleration, over the largest of all, at which solids
/// are at rest.
const TOLERANCE: f64 = 1e-6;

/// Bounds for solids without supports to be at rest: the last acceleration over the largest, and the last displacement
/// over an element.
const FREE_TOLERANCE: f64 = 1e-3;

/// The search goes on, down to rounding, while an iteration moves the solids by less than this part of the least motion
/// in one before it.
const FALLS: f64 = 0.9;

/// Iterations after which there is no equilibrium.
const ITERATIONS: usize = 400;

/// Iterations without a smaller motion than all before, after which there is no equilibrium either: a gas that falls
/// out of its box never comes to rest.
const STALLED: usize = 100;

/// Elements that a solid may move in an iteration.
const WAY: f64 = 0.5;

/// The artificial time step doubles, or falls to a quarter.
const FACTORS: [f64; 2] = [0.25, 2.0];

/// Motion of the solids in an iteration.
#[derive(Debug, Clone, Copy, Default)]
struct IterationMotion {
    /// Largest displacement in the iteration [m].
    change: f64,
    /// Largest displacement since the reference state [m].
    displacement: f64,
    /// Largest acceleration [m/s²].
    acceleration: f64,
}

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Moves the solids to where they rest under the loads at time 0; the first artificial step is `dt` [s]. Returns
    /// the number of iterations.
    ///
    /// # Errors
    /// Solids don't come to rest; an element turns inside out, or the system isn't solved.
    pub(in crate::pfem2) fn find_equilibrium(&mut self, dt: f64) -> Result<usize, StepError> {
        let bounded = |step: f64, longest: Option<f64>| longest.map_or(step, |longest| step.min(longest));
        let (mut next, mut last) = (bounded(dt, self.longest(0.0)), 0.0);
        let (mut largest, mut best, mut since): (f64, f64, usize) = (0.0, f64::INFINITY, 0);
        for iteration in 1..=ITERATIONS {
            let motion = self.relax(next, last)?;
            largest = largest.max(motion.acceleration);
            let longest = self.longest(largest);
            let (tolerance, way) = match longest {
                Some(_) => (FREE_TOLERANCE, FREE_TOLERANCE * self.system.shortest()),
                None => (TOLERANCE, TOLERANCE * motion.displacement),
            };
            let is_at_rest = motion.change <= way && motion.acceleration <= tolerance * largest;
            if is_at_rest && (motion.change >= FALLS * best || iteration == ITERATIONS) {
                self.begin_at_rest(next)?;
                return Ok(iteration);
            }
            since = if motion.change < best { 0 } else { since + 1 };
            best = best.min(motion.change);
            if since > STALLED {
                return Err(self.never_at_rest(iteration));
            }
            // The state found so far isn't used.
            if self.stop.load(Ordering::Relaxed) {
                return Ok(iteration);
            }
            last = next;
            let room = (WAY * self.system.shortest() / motion.change).sqrt();
            next = bounded(next * room.clamp(FACTORS[0], FACTORS[1]), longest);
        }
        Err(self.never_at_rest(ITERATIONS))
    }

    /// Bound of the artificial step [s], where the largest acceleration so far is `largest` [m/s²]; none where all
    /// solids have supports, or nothing has moved them yet.
    fn longest(&self, largest: f64) -> Option<f64> {
        let setups = self.solids.iter().flat_map(|solids| solids.structure.setups());
        if setups.into_iter().all(|setup| setup.held.iter().any(|held| !held.nodes.is_empty())) {
            return None;
        }
        let gravity = self.system.force.iter().map(|force| force.norm()).fold(0.0, f64::max);
        let acceleration = if gravity > 0.0 { gravity } else { largest };
        Some((self.system.shortest() / acceleration).sqrt()).filter(|longest| longest.is_finite())
    }

    /// An iteration of `dt` [s], after one of `last` [s].
    fn relax(&mut self, dt: f64, last: f64) -> Result<IterationMotion, StepError> {
        let step = at_start(dt);
        self.predict_solids(step)?;
        self.follow_solids(last);
        let convected = self.system.imposed(step, &vec![Vector::ZERO; self.places.len()]);
        self.system.solve(step, &self.interface.phases(), &convected)?;
        self.advance_solids(step)?;
        let Some(solids) = &mut self.solids else { return Ok(IterationMotion::default()) };
        let state = &mut solids.structure.state;
        let most = |values: &[Vector<D>]| values.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let speed = most(&state.velocity);
        let displacement = most(&state.displacement);
        state.rest();
        Ok(IterationMotion { change: speed * dt, displacement, acceleration: speed / dt })
    }

    /// Takes the fluid along with the motion of an iteration of `last` [s], and brings it to rest.
    fn follow_solids(&mut self, last: f64) {
        if last > 0.0 {
            self.transport(at_start(last));
            self.interface.project(&self.system, &self.particles.columns, self.particles.rules.kernel);
        }
        self.system.velocity.fill(Vector::ZERO);
        self.particles.columns.velocity.fill(Vector::ZERO);
        self.history.clear(&self.system.velocity);
    }

    /// Begins the run in the state that was found, in which the last iteration of `last` [s] left the fluid.
    fn begin_at_rest(&mut self, last: f64) -> Result<(), StepError> {
        self.predict_solids(at_start(last))?;
        self.follow_solids(last);
        self.interface.project(&self.system, &self.particles.columns, self.particles.rules.kernel);
        self.update_contents();
        self.particles.events = ParticleEvents::default();
        self.notices = Notices::of_the_start(&self.system, &self.particles.columns, &self.interface.fraction);
        let at_start = |solids: &mut SolidTracking<D>| {
            Ok(SolidsAtStart { energies: solids.open_energies()?, mass: solids.structure.mass() })
        };
        let solids = self.solids.as_mut().map(at_start).transpose()?;
        self.balance.open(&self.system, impulsive_energy(&self.system), solids);
        Ok(())
    }

    fn never_at_rest(&self, iterations: usize) -> StepError {
        let advice = "hold solids that can move freely, or let them sink to a wall or float; close sides through which a heavy fluid \
                      falls; start without equilibrium, with damping, where solids buckle";
        let what = "the solids find no equilibrium at the start";
        StepError::new(Place::Everywhere, what, "iterations", iterations as f64, advice)
    }
}

/// A step of backward Euler of `dt` [s] that ends at time 0.
fn at_start(dt: f64) -> ThetaStep {
    ThetaStep { t: -dt, dt, theta: 1.0 }
}
