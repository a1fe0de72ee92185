//! Bounds of the step, and what a run is watched for.

use super::Pfem2;
use super::available::{Available, Verdict};
use super::setup::Scheme;
use crate::error::StepError;

/// Part of the bound by capillary waves that an automatic step takes. At the bound a drop of water of ten elements in air
/// stirs up the air by 7 m/s, at half of it by 4 m/s, at a quarter by 0.1 m/s; heavier gases are calm at the bound.
const CAPILLARY_FRACTION: f64 = 0.25;

/// ωΔt of the shortest wave up to which water in a box of 20 × 20 cells is calm; at 1.73 it sloshes ever higher.
const CALM_WATER: f64 = 1.5;

/// Part of the largest other energy so far that errors may take, or give, without a word.
const TAKEN: f64 = 0.05;
const GIVEN: f64 = 0.02;

/// The same for a viscous dissipation below zero.
const NEGATIVE: f64 = 0.01;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// The longest step in which the shortest wave on an interface doesn't grow [s] (theory H.7).
    pub(super) fn wave_dt(&self) -> f64 {
        self.steepest() / self.implicit.fastest_wave()
    }

    /// The longest step with which surface tension leaves the lighter fluid calm [s] (theory H.8).
    pub(super) fn capillary_dt(&self) -> f64 {
        CAPILLARY_FRACTION * self.steepest() / self.implicit.fastest_ripple()
    }

    /// Bound of ωΔt. The interface moves with a velocity that is known before the pressure is: the paper's scheme bears 2 (theory
    /// H.7). The second order's bears √(1/(2θ − 1)), where the shortest wave changes its sign from step to step; below that
    /// its waves grow a little in theory, and the damping of the scheme outweighs it up to [`CALM_WATER`].
    fn steepest(&self) -> f64 {
        match self.scheme {
            Scheme::SecondOrder { theta } => CALM_WATER.min((2.0 * theta - 1.0).max(0.0).sqrt().recip()),
            Scheme::BackwardEuler => 2.0,
        }
    }

    /// The step in which no particle crosses more elements than asked for [s].
    pub(super) fn courant_dt(&self) -> f64 {
        if self.courant.is_finite() { self.implicit.crossing_time() * self.courant } else { f64::INFINITY }
    }

    /// Keeps what the start says about what may come.
    pub(super) fn begin_watch(&mut self) {
        self.available = Available::new(&self.implicit, &self.totals);
        if self.is_closed() {
            self.closed = self.implicit.volumes.clone();
        }
    }

    /// What errors are measured by: the largest other energy so far, and no less than what counts in this run [J].
    pub(super) fn largest_energy(&self) -> f64 {
        let least = self.available.as_ref().map_or(0.0, |available| available.least(&self.books));
        self.books.largest().max(least)
    }

    /// Looks at what errors have taken of the energy, or given.
    fn watch_energy(&mut self) {
        let largest = self.largest_energy();
        let gained = self.books.gained(&self.totals, self.implicit.surface_energy());
        let part = if largest > 0.0 { -gained / largest } else { 0.0 };
        self.notices.errors(part, !(-GIVEN..=TAKEN).contains(&part));
        if self.books.viscous() < -NEGATIVE * largest {
            self.notices.friction();
        }
    }

    /// Looks for what should not come: fluid that is lost, and energy from nothing.
    ///
    /// # Errors
    /// The flow has gained many times the energy that there was.
    pub(super) fn watch(&mut self) -> Result<(), StepError> {
        let Self { implicit, notices, .. } = self;
        notices.losses(&implicit.physics.fluids, &self.closed, &implicit.volumes);
        if self.kept_volumes.is_some() {
            notices.weights(&implicit.physics.fluids, &self.closed, &implicit.volumes);
        }
        self.watch_energy();
        let Self { implicit, notices, .. } = self;
        let Some(available) = &self.available else { return Ok(()) };
        if available.judge(&self.books, &self.totals, implicit)? == Verdict::TooMuch {
            notices.energy();
        }
        Ok(())
    }
}
