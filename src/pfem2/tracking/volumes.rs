//! The volume of each fluid: what it was, what has left, what level set or fractions show (theory G.6).

use super::interface::InterfaceTracking;
use super::transport::FrozenFlow;
use crate::pfem2::checks::notices::Notices;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::interface::fraction_weights;
use crate::pfem2::interface::level_set::{self, OpenFacet, Origins};
use crate::pfem2::particles::Particles;
use crate::pfem2::phases::FluidRegion;

/// Most shifts of the level set in a step; more than two are rare.
const SHIFTS: usize = 8;

/// Missing volume, over that at the start, from which a notice is given.
const MISSED: f64 = 1e-6;

/// A shift that lacks less than this part of what is allowed is the largest.
const LARGEST_SHIFT: f64 = 1e-3;

/// Treatment of the volumes of several fluids (theory G.6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VolumeCorrection {
    /// Changes of volume are only reported.
    None,
    /// A sharp level set is shifted to the volume at the start, less what has left; three and more fluids in a closed
    /// box take weights of their fractions. Both are reported.
    #[default]
    Shift,
}

impl<const D: usize> InterfaceTracking<D> {
    /// Begins to keep the volumes, at the start.
    pub fn keep_volumes<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        correction: VolumeCorrection,
    ) {
        let VelocityPressureSystem { mesh, boundary, .. } = system;
        let shifts = correction == VolumeCorrection::Shift;
        let several = self.list.count() > 2 && boundary.is_closed();
        let region = system.fluid_region();
        self.kept_volumes = (several && shifts).then(|| self.phases().volumes(&region));
        let Some(set) = &self.sharp else { return };
        let facets = mesh.boundary().iter().enumerate().filter(|(place, _)| boundary.kinds[*place].admits_flow());
        let opening = |(place, &facet)| Some(OpenFacet { facet, inflow_level: self.inflow.level(place)? });
        self.open_facets = facets.filter_map(opening).collect();
        self.kept_volume = shifts.then(|| level_set::negative_volume(&region, &set.level));
    }

    /// True if the volume of every fluid is kept.
    pub fn keeps_volumes(&self) -> bool {
        self.list.count() == 1 || self.kept_volume.is_some() || self.kept_volumes.is_some()
    }

    /// A sharp level set follows the particles and keeps its volume (theory G.2–G.6).
    pub fn follow<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        particles: &mut Particles<D>,
        notices: &mut Notices,
    ) {
        let (region, reach) = (system.fluid_region(), system.shortest());
        let mesh = region.mesh;
        let Some(sharp) = &mut self.sharp else { return };
        let before = sharp.level.clone();
        sharp.update(&region, particles, &self.open_facets);
        level_set::absorb_isolated_nodes(mesh, &mut sharp.level);
        level_set::absorb_unresolved_films(&region, &mut sharp.level);
        let Some(start) = self.kept_volume else { return };
        self.shift = 0.0;
        let booked = start - self.outflow[0];
        let wanted = volume_to_keep(&region, &sharp.level, booked, !self.open_facets.is_empty());
        self.outflow[0] += booked - wanted;
        let (particles, open_facets) = (&*particles, &self.open_facets[..]);
        let origins = Origins { before: &before, inside: sharp.inside, particles, open_facets };
        // A shift may isolate nodes that weren't before; they change sides, and the volume is sought again.
        for _ in 0..SHIFTS {
            let left = reach - self.shift.abs();
            self.shift += level_set::shift_to_volume(&region, &mut sharp.level, wanted, left);
            let reverted = level_set::revert_spurious_nodes(&region, &origins, &mut sharp.level);
            let isolated = level_set::absorb_isolated_nodes(mesh, &mut sharp.level);
            if reverted + isolated + level_set::absorb_unresolved_films(&region, &mut sharp.level) == 0 {
                break;
            }
        }
        let missing = wanted - level_set::negative_volume(&region, &sharp.level);
        if missing.abs() > MISSED * start.max(wanted) {
            let fluid = &system.physics.fluids[usize::from(sharp.inside)].name;
            let is_largest = self.shift.abs() >= (1.0 - LARGEST_SHIFT) * reach;
            if is_largest { notices.volume(fluid) } else { notices.volume_of_step(fluid) }
        }
    }

    /// The fractions of several fluids take weights that keep their volumes.
    pub(super) fn weigh_fractions<const N: usize>(&mut self, region: &FluidRegion<D, N>) {
        let mesh = region.mesh;
        level_set::absorb_isolated_fluids(mesh, &self.list, &mut self.fraction);
        let Some(wanted) = &self.kept_volumes else { return };
        self.weight = 1.0;
        // Weights may isolate nodes that weren't before, as shifts may.
        for _ in 0..SHIFTS {
            self.weight *= fraction_weights::keep_volumes(region, &self.list, &mut self.fraction, wanted);
            if level_set::absorb_isolated_fluids(mesh, &self.list, &mut self.fraction) == 0 {
                break;
            }
        }
    }

    /// Counts the volumes that leave in a step: of the fluid inside the level set, and of both (theory G.6).
    pub fn count_outflow<const N: usize>(&mut self, flow: &FrozenFlow<D>, system: &VelocityPressureSystem<D, N>) {
        let Some(set) = &self.sharp else { return };
        let mesh = &system.mesh;
        let left = flow.with_source(system, self, |source| {
            level_set::outflow(mesh, &self.open_facets, &flow.velocity, source.dt, |place, time| {
                let (particle, _) = source.of(mesh, place, time);
                set.signed(particle.fluid, particle.depth)
            })
        });
        (0..2).for_each(|k| self.outflow[k] += left[k]);
    }

    /// Volume of each fluid that has left [m³], if any can.
    pub fn outflow_by_fluid(&self) -> Vec<(usize, f64)> {
        let Some(set) = self.sharp.as_ref().filter(|_| !self.open_facets.is_empty()) else { return Vec::new() };
        let ([inside, all], own) = (self.outflow, usize::from(set.inside));
        (0..2).map(|fluid| (fluid, if fluid == own { inside } else { all - inside })).collect()
    }
}

/// Volume of the fluid inside the level set to be kept on the mesh, where `booked` should be left of it [m³].
///
/// The volume that leaves or comes in during a step is known within a part of an element: the mesh holds neither less
/// than nothing nor more than solids leave of its volume, and a fluid whose last part is gone through an opening holds
/// nothing, even if the count leaves a rest of it. Fluids that solids part have what these leave them.
fn volume_to_keep<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    level: &[f64],
    booked: f64,
    open: bool,
) -> f64 {
    if is_within_solids(region, level) {
        return level_set::negative_volume(region, level);
    }
    let mesh = region.mesh;
    let alone = level.iter().all(|&level| level < 0.0) || level.iter().all(|&level| level >= 0.0);
    if open && alone {
        let shown = level_set::negative_volume(region, level);
        let largest = (0..mesh.elements().len()).map(|e| mesh.simplex(e).volume).fold(0.0, f64::max);
        if (booked - shown).abs() <= largest {
            return shown;
        }
    }
    booked.clamp(0.0, region.total())
}

/// True if solids lie all along the interface: each element with fluid holds one alone, so that no shift would change
/// its volume.
fn is_within_solids<const D: usize, const N: usize>(region: &FluidRegion<D, N>, level: &[f64]) -> bool {
    /// Part of the fluid in an element that counts as none.
    const ROUND_OFF: f64 = 1e-9;
    let holds_one = |e: usize| {
        let own = region.mesh.elements()[e].map(|node| level[node as usize]);
        if own.iter().all(|&phi| phi < 0.0) || own.iter().all(|&phi| phi >= 0.0) {
            return true;
        }
        let volume = region.volume(e);
        let inside = || region.negative_volume(e, &own) / volume;
        let is_pure = |inside: f64| inside.min(1.0 - inside) < ROUND_OFF;
        volume == 0.0 || volume < region.mesh.simplex(e).volume && is_pure(inside())
    };
    region.covered().next().is_some() && (0..region.mesh.elements().len()).all(holds_one)
}
