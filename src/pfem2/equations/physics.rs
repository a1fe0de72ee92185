//! The fluids and the choices of a run that all steps share.

use crate::math::{Signal, Vector};
use crate::pfem2::cut_element::Enrichment;
use crate::pfem2::element::{Mass, Stabilisation};
use crate::pfem2::fluid::FluidSetup;

/// Data that stay the same during a run: fluids, surface tensions, the formula of gravity, and choices.
#[derive(Debug, Clone)]
pub struct Physics<const D: usize> {
    /// The fluids.
    pub fluids: Vec<FluidSetup>,
    /// Surface tension of pairs of fluids [N/m].
    pub tension: Vec<([usize; 2], f64)>,
    /// Body force per unit mass, a formula per axis [m/s²].
    pub gravity: [Signal; D],
    /// Mass matrix.
    pub mass: Mass,
    /// Stabilisation.
    pub stabilisation: Stabilisation,
    /// Enrichment of cut elements without surface tension.
    pub enrichment: Enrichment,
}

impl<const D: usize> Physics<D> {
    /// Gravity [m/s²], if it is the same everywhere and always.
    pub fn steady_gravity(&self) -> Option<Vector<D>> {
        let same = self.gravity.iter().all(|g| g.is_uniform() && g.is_steady());
        same.then(|| Vector::from_fn(|i| self.gravity[i].value([0.0; 3], 0.0)))
    }

    /// Surface tension between two fluids [N/m].
    pub(super) fn tension_between(&self, pair: [usize; 2]) -> f64 {
        let same = |other: &[usize; 2]| *other == pair || *other == [pair[1], pair[0]];
        self.tension.iter().find(|(other, _)| same(other)).map_or(0.0, |(_, tension)| *tension)
    }
}
