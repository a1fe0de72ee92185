//! The volume of each fluid: what it was, what has left, what level set or shares show (theory G.6).

use super::level_set::{self, LevelSet, Opening, Origins};
use super::phases::Phases;
use super::share_weights;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::Pfem2;
use crate::pfem2::particles::reseed::ParticleSource;
use crate::pfem2::setup::VolumeCorrection;

/// Most shifts of the level set in a step; more than two are rare.
const SHIFTS: usize = 8;

/// A part of the volume at the start that may be missing without a word.
const MISSED: f64 = 1e-6;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Begins to follow the volumes, at the start.
    pub(in crate::pfem2) fn follow_volumes(&mut self, correction: VolumeCorrection) {
        let shifts = correction == VolumeCorrection::Shift;
        let mesh = &self.system.mesh;
        let several = self.density.len() > 2 && self.is_closed();
        self.kept_volumes = (several && shifts).then(|| self.phases().volumes(mesh, mesh.elements().len(), |e| e));
        let Some(set) = &self.sharp else { return };
        let boundary = &self.system.boundary;
        let facets = mesh.boundary().iter().enumerate().filter(|(place, _)| boundary.kinds[*place].is_open());
        let opening = |(place, &facet)| Some(Opening { facet, brings: self.supply.level(place)? });
        self.openings = facets.filter_map(opening).collect();
        self.kept_volume = shifts.then(|| level_set::negative_volume(mesh, &set.level));
    }

    /// Shows the interface as the particles show it, from the start on: averages round the corners of a shape, and the volume that
    /// this takes comes back elsewhere. In the first step that would be energy from nothing.
    pub(in crate::pfem2) fn begin_interface(&mut self) {
        if self.sharp.is_some() {
            self.follow_interface();
            self.project();
            self.settle();
        }
    }

    /// A sharp level set follows the particles and keeps its volume.
    pub(in crate::pfem2) fn follow_interface(&mut self) {
        let (mesh, reach) = (&self.system.mesh, self.system.shortest());
        let Some(sharp) = &mut self.sharp else { return };
        let before = sharp.level.clone();
        sharp.update(mesh, &mut self.particles, &self.openings);
        level_set::absorb_isolated_nodes(mesh, &mut sharp.level);
        let Some(start) = self.kept_volume else { return };
        self.shift = 0.0;
        let booked = start - self.outflow[0];
        let wanted = held(mesh, &sharp.level, booked, !self.openings.is_empty());
        self.outflow[0] += booked - wanted;
        let (particles, openings) = (&self.particles, &self.openings[..]);
        let origins = Origins { before: &before, inside: sharp.inside, particles, openings };
        // A shift may leave nodes alone that weren't before; they change sides, and the volume is sought again.
        for _ in 0..SHIFTS {
            let left = reach - self.shift.abs();
            self.shift += level_set::shift_to_volume(mesh, &mut sharp.level, wanted, left);
            let back = level_set::revert_spurious_nodes(mesh, &origins, &mut sharp.level);
            if back + level_set::absorb_isolated_nodes(mesh, &mut sharp.level) == 0 {
                break;
            }
        }
        let missing = wanted - level_set::negative_volume(mesh, &sharp.level);
        if missing.abs() > MISSED * start.max(wanted) {
            self.notices.volume(&self.system.physics.fluids[usize::from(sharp.inside)].name);
        }
    }

    /// Nothing can leave.
    pub(in crate::pfem2) fn is_closed(&self) -> bool {
        !self.system.boundary.kinds.iter().any(|kind| kind.is_open())
    }

    /// Phases at the nodes.
    pub(in crate::pfem2) fn phases(&self) -> Phases<'_> {
        Phases { density: &self.density, fraction: &self.fraction, level: &self.level }
    }

    /// The shares of several fluids take weights that keep their volumes.
    pub(in crate::pfem2) fn weigh_shares(&mut self) {
        let mesh = &self.system.mesh;
        level_set::absorb_isolated_fluids(mesh, &self.density, &mut self.fraction);
        let Some(wanted) = &self.kept_volumes else { return };
        self.weight = 1.0;
        // Weights may leave nodes alone that weren't before, as shifts may.
        for _ in 0..SHIFTS {
            self.weight *= share_weights::keep_volumes(mesh, &self.density, &mut self.fraction, wanted);
            if level_set::absorb_isolated_fluids(mesh, &self.density, &mut self.fraction) == 0 {
                break;
            }
        }
    }

    /// What has left of each fluid [m³], if anything can.
    pub(in crate::pfem2) fn left(&self) -> Vec<(usize, f64)> {
        let Some(set) = self.sharp.as_ref().filter(|_| !self.openings.is_empty()) else { return Vec::new() };
        let ([inside, all], own) = (self.outflow, usize::from(set.inside));
        (0..2).map(|fluid| (fluid, if fluid == own { inside } else { all - inside })).collect()
    }
}

/// What the mesh holds of the fluid inside the level set, where `booked` should be left of it [m³].
///
/// What leaves or comes in during a step is known within a part of an element: the mesh holds neither less than nothing nor more than its
/// volume, and a fluid whose last part is gone through an opening holds nothing, even if the books have some crumb of it.
fn held<const D: usize, const N: usize>(mesh: &Mesh<D, N>, level: &[f64], booked: f64, open: bool) -> f64 {
    let alone = level.iter().all(|&level| level < 0.0) || level.iter().all(|&level| level >= 0.0);
    if open && alone {
        let shown = level_set::negative_volume(mesh, level);
        let largest = (0..mesh.elements().len()).map(|e| mesh.simplex(e).volume).fold(0.0, f64::max);
        if (booked - shown).abs() <= largest {
            return shown;
        }
    }
    booked.clamp(0.0, mesh.volume())
}

/// Volume that leaves in a step of the carrier v* [m/s]: of the fluid inside the level set, and of both [m³].
pub(in crate::pfem2) fn left<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    set: &LevelSet,
    openings: &[Opening<D>],
    carrier: &[Vector<D>],
    origin: &ParticleSource<D, N>,
) -> [f64; 2] {
    level_set::outflow(mesh, openings, carrier, origin.dt, |place, time| {
        let (newcomer, _) = origin.of(mesh, place, time);
        set.signed(newcomer.fluid, newcomer.depth)
    })
}
