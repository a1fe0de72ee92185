//! Impulses of walls on the velocities of the noise filter (`filter`; theory E.9).
//!
//! With masses m_I, changes Δw_jI by conditions, and ghosts g of mass m_g and momentum p_g beyond mirrors of normal ν,
//! a filter of order k hands the particles the impulse
//!
//! ```text
//! J = s(v_p) − Σ_{j<k} s(Σ N w_j) + Σ_{j≤k} Σ_I m_I Δw_jI + Σ_g 2 m_g (w_kg·ν) ν,      s(v) = −Σ_g 2 (p_g·ν) ν
//! ```
//!
//! since w_{j+1} removes from w_j the part that the particles would bring back: of the sum of all w_j the changes by
//! conditions and mirrors remain.

use super::Walls;
use crate::math::Vector;
use crate::mpm::grid::{GhostFractions, Ghosts};

/// Work of a step [J], and the impulse on the particles [N s].
#[derive(Debug, Clone, Copy, Default)]
pub struct WallWork<const D: usize> {
    /// Work that moving walls did on the material.
    pub work: f64,
    /// Energy lost to friction and stopping.
    pub dissipation: f64,
    /// Impulse on the particles.
    pub impulse: Vector<D>,
}

/// Impulses on the material by boundary [N s], and the work of moving boundaries [J].
#[derive(Debug, Clone)]
pub struct Pushes<const D: usize> {
    impulse: Vec<Vector<D>>,
    work: f64,
}

impl<const D: usize> Pushes<D> {
    /// The sum of both.
    #[must_use]
    pub fn plus(mut self, other: Self) -> Self {
        self.impulse.iter_mut().zip(other.impulse).for_each(|(sum, impulse)| *sum += impulse);
        Self { work: self.work + other.work, ..self }
    }

    /// Counts the impulse [N s] of a condition whose boundary moves with `wall` [m/s].
    pub(super) fn add(&mut self, boundary: u32, impulse: Vector<D>, wall: Vector<D>) {
        self.impulse[boundary as usize] += impulse;
        self.work += impulse.dot(wall);
    }

    /// Folds momentum [N s], and adds `times` its change by mirrors.
    pub fn fold(&mut self, ghosts: &Ghosts<D>, limits: &GhostFractions, momentum: &mut [Vector<D>], times: f64) {
        ghosts.fold(limits, momentum, |side, _, ghost| {
            self.impulse[side] -= Vector::unit(side / 2) * (2.0 * times * ghost[side / 2]);
        });
    }
}

/// A ghost whose mass a side of the grid mirrors.
#[derive(Debug, Clone, Copy)]
pub(super) struct MirroredGhost {
    pub side: u32,
    pub node: u32,
    /// Mass [kg].
    pub mass: f64,
}

impl<const D: usize> Walls<D> {
    /// Zero impulses and work.
    pub fn pushes(&self) -> Pushes<D> {
        Pushes { impulse: vec![Vector::ZERO; self.boundaries.len()], work: 0.0 }
    }

    /// Impulses of mirrors on the particles of a field that take the velocities `w` [m/s], ghosts filled.
    pub fn reflect(&self, field: usize, w: &[Vector<D>]) -> Pushes<D> {
        let mut pushes = self.pushes();
        for &MirroredGhost { side, node, mass } in &self.field_reactions[field].ghosts {
            let (side, axis) = (side as usize, side as usize / 2);
            pushes.impulse[side] += Vector::unit(axis) * (2.0 * mass * w[node as usize][axis]);
        }
        pushes
    }

    /// Adds impulses and work during a step of the momentum `dt` [s] to the reactions.
    pub fn book(&mut self, pushes: Pushes<D>, dt: f64) -> WallWork<D> {
        for (force, &impulse) in self.force.iter_mut().zip(&pushes.impulse) {
            *force += impulse / dt;
        }
        WallWork { work: pushes.work, dissipation: 0.0, impulse: pushes.impulse.into_iter().sum() }
    }
}
