//! Particles of one fluid where the level set shows the other (theory G.5).
//!
//! A particle keeps its fluid whatever φ says, so that films thinner than an element come back when they grow: near the
//! interface. Farther than an edge inside the other fluid it belongs to nothing that could grow. The level set has its
//! volume, and with it its mass, elsewhere: the equations count the fluid that φ shows, and the shift has given the
//! volume back to the rest. Such a particle joins the fluid around it, with the velocity that this has there: mass and
//! momentum of the mesh stay what they are.

use super::interface::InterfaceTracking;
use super::particles::ParticleTracking;
use crate::parallel;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::convect::MeshPoint;
use crate::pfem2::particles::interpolate_nodal;
use crate::pfem2::phases::FluidRegion;

/// Edges inside the other fluid from which a particle joins it.
const DEEP: f64 = 1.0;

impl<const D: usize> ParticleTracking<D> {
    /// Particles deep inside the other fluid join it, where the level set keeps the volumes.
    pub(super) fn join_surrounding_fluid<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
    ) {
        let Some(set) = interface.sharp.as_ref().filter(|_| interface.kept_volume.is_some()) else { return };
        if self.rules.has_projectiles() {
            return;
        }
        let VelocityPressureSystem { mesh, velocity, .. } = system;
        let deep = DEEP * set.edge();
        let Particles { position, velocity: v, phase, depth, element, .. } = &mut self.columns;
        let columns = (&mut phase[..], &mut depth[..], &mut v[..], &position[..], &element[..]);
        let joined = parallel::map_chunks(columns, 256, |_, (own, own_depth, v, x, element)| {
            let mut joined = 0_u64;
            for p in 0..own.len() {
                let e = element[p] as usize;
                let place = MeshPoint { element: e, shape: mesh.shape_functions(e, x[p]) };
                let (fluid, depth) = set.at(mesh, &place);
                if fluid == own[p] || depth <= deep {
                    continue;
                }
                (own[p], own_depth[p]) = (fluid, depth);
                v[p] = interpolate_nodal(&place.shape, &mesh.elements()[e], velocity);
                joined += 1;
            }
            joined
        });
        self.events.joined += joined.into_iter().sum::<u64>();
    }

    /// Volume of the particles of each fluid where the level set shows the other [m³].
    pub(in crate::pfem2) fn stray_volumes<const N: usize>(
        &self,
        region: &FluidRegion<D, N>,
        interface: &InterfaceTracking<D>,
    ) -> Vec<f64> {
        let (mesh, particles) = (region.mesh, &self.columns);
        let Some(set) = &interface.sharp else { return Vec::new() };
        let mut volumes = vec![0.0; interface.list.count()];
        for e in 0..mesh.elements().len() {
            let own = particles.of(e);
            let particle_volume = region.volume(e) / own.len().max(1) as f64;
            for p in own {
                let place = MeshPoint { element: e, shape: mesh.shape_functions(e, particles.position[p]) };
                if set.at(mesh, &place).0 != particles.phase[p] {
                    volumes[usize::from(particles.phase[p])] += particle_volume;
                }
            }
        }
        volumes
    }
}
