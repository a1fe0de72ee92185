//! Bounds of the step by waves on interfaces and by the flow (theory H.6–H.8).

use crate::pfem2::Pfem2;
use crate::pfem2::setup::Scheme;

/// Part of the bound by capillary waves that an automatic step takes. At the bound a drop of water of ten elements in air
/// stirs up the air by 7 m/s, at half of it by 4 m/s, at a quarter by 0.1 m/s; heavier gases are calm at the bound.
const CAPILLARY_FRACTION: f64 = 0.25;

/// ωΔt of the shortest wave up to which water in a box of 20 × 20 cells is calm; at 1.73 it sloshes ever higher.
const CALM_WATER: f64 = 1.5;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// The longest step in which the shortest wave on an interface doesn't grow [s] (theory H.7).
    pub(in crate::pfem2) fn wave_dt(&self) -> f64 {
        self.max_omega_dt() / self.system.wave_frequency()
    }

    /// The longest step with which surface tension leaves the lighter fluid calm [s] (theory H.8).
    pub(in crate::pfem2) fn capillary_dt(&self) -> f64 {
        CAPILLARY_FRACTION * self.max_omega_dt() / self.system.capillary_frequency()
    }

    /// Bound of ωΔt. The interface moves with a velocity that is known before the pressure is: the paper's scheme bears 2 (theory
    /// H.7). The second order's bears √(1/(2θ − 1)), where the shortest wave changes its sign from step to step; below that
    /// its waves grow a little in theory, and the damping of the scheme outweighs it up to [`CALM_WATER`].
    fn max_omega_dt(&self) -> f64 {
        match self.scheme {
            Scheme::SecondOrder { theta } => CALM_WATER.min((2.0 * theta - 1.0).max(0.0).sqrt().recip()),
            Scheme::BackwardEuler => 2.0,
        }
    }

    /// The step in which no particle crosses more elements than asked for [s].
    pub(in crate::pfem2) fn courant_dt(&self) -> f64 {
        if self.courant.is_finite() { self.system.crossing_time() * self.courant } else { f64::INFINITY }
    }
}
