//! The method as a solver that the time loop steps (theory H.1, H.9).

use super::{checkpoint, snapshot};
use crate::error::StepError;
use crate::linalg::SolverState;
use crate::pfem2::ThetaStep;
use crate::pfem2::history::LARGEST_CHANGE;
use crate::pfem2::setup::InitialState;
use crate::pfem2::step::Pfem2;
use crate::pfem2::theta_step::Scheme;
use crate::pfem2::time::step_bounds::foreseen_speed;
use crate::simulation::{Column, Snapshot, Solver};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

impl<const D: usize, const N: usize> Solver for Pfem2<D, N> {
    fn stable_dt(&self) -> f64 {
        self.limits.stable_dt(&self.system)
    }

    fn recommended_dt(&self) -> f64 {
        self.limits.automatic_dt(&self.system, self.steps)
    }

    fn foreseen_dt(&self, end: f64) -> Option<[f64; 2]> {
        if !self.limits.control.is_active() {
            return Some([self.recommended_dt(); 2]);
        }
        self.limits.foreseen(&self.system, foreseen_speed(&self.system, &self.balance, end))
    }

    fn largest_change(&self) -> f64 {
        if self.limits.control.is_active() { LARGEST_CHANGE } else { f64::INFINITY }
    }

    fn begin(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        self.solver_state = SolverState::default();
        if self.start == InitialState::Equilibrium {
            self.find_equilibrium(dt)?;
        }
        self.predict_start(ThetaStep { t, dt, theta: 1.0 });
        Ok(())
    }

    fn stop_on(&mut self, flag: Arc<AtomicBool>) {
        self.stop = flag;
    }

    fn step(&mut self, t: f64, dt: f64) -> Result<(), StepError> {
        self.solver_state = SolverState::default();
        let at = |error| StepError { time: t, ..error };
        // Predicted already, unless the step is another one than was foreseen.
        if self.steps == 0 && self.history.scheme != Scheme::BackwardEuler && self.history.dt_previous != dt {
            self.predict_first_step(ThetaStep { t, dt, theta: 1.0 }).map_err(at)?;
        }
        let theta = self.history.implicit_weight(dt);
        self.advance(ThetaStep { t, dt, theta }).map_err(at)?;
        let solids = self.solids.as_mut().map(|solids| (&mut solids.structure, solids.last.prediction_error));
        self.limits.control.estimate(dt, &self.system, &self.history, self.balance.ledger.peak, solids);
        if let Some(solids) = self.solids.as_ref().filter(|_| self.limits.control.is_active()) {
            let peak = self.limits.control.solids_peak;
            self.limits.control.shorten(solids.longest_before_impact(&self.system.mesh, dt, peak));
        }
        self.history.advance(dt);
        self.steps += 1;
        if let (Some(solids), Some(immersed)) = (&self.solids, &self.system.immersed) {
            let own = solids.structure.volume(&solids.structure.positions(&solids.last.predicted));
            self.notices.solid_volume(immersed.cut.volume_inside(&self.system.mesh), own);
            self.notices.imbalance(solids.last.imbalance);
            self.notices.last_correction(solids.last.last_correction);
            self.notices.contacts(solids.last.has_wrong_contacts);
        }
        self.notices.check_fluids(&self.system, &self.particles.columns, &self.interface.fraction);
        self.balance.check(&self.system, &self.interface, &mut self.notices).map_err(at)
    }

    fn notices(&mut self) -> Vec<String> {
        self.notices.take()
    }

    fn snapshot(&self) -> Snapshot<'_> {
        snapshot::snapshot(self)
    }

    fn forces(&self, visit: &mut dyn FnMut([f64; 3])) {
        self.forces.on_parts.mean.iter().for_each(|force| visit(force.to3()));
        let solids = self.solids.iter().flat_map(|solids| &solids.last.forces.mean);
        solids.for_each(|force| visit(force.to3()));
        let holding = self.solids.iter().flat_map(|solids| &solids.last.holding.mean);
        holding.for_each(|force| visit(force.to3()));
        let on_particles = self.system.particle_solids.iter().flat_map(|solids| &solids.forces);
        on_particles.for_each(|force| visit(force.to3()));
        snapshot::moments(self).for_each(|(_, moment)| visit(moment));
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        checkpoint::columns(self, visit);
    }

    fn misfit(&self) -> Option<String> {
        checkpoint::misfit(self)
    }

    fn restored(&mut self) {
        self.particles.columns.sort();
        if let Some(solids) = &self.solids {
            solids.immerse(&mut self.system);
        }
        self.update_contents();
        self.system.restore_solver(&std::mem::take(&mut self.solver_state));
    }

    fn stage_times(&self) -> Vec<(&'static str, f64)> {
        self.timer.seconds()
    }

    fn particle_count(&self) -> usize {
        self.particles.columns.len()
    }
}
