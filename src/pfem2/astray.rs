//! Particles of one fluid where the level set shows the other (theory G.5).
//!
//! A particle keeps its fluid whatever φ says, so that films thinner than an element come back when they grow: near the
//! interface. Farther than an edge inside the other fluid it belongs to nothing that could grow. The level set has its
//! volume, and with it its mass, elsewhere: the equations count the fluid that φ shows, and the shift has given the volume back
//! to the rest. Such a particle joins the fluid around it, with the velocity that this has there: mass and momentum of the
//! mesh stay what they are.

use super::Pfem2;
use super::convect::Place;
use super::correct;
use super::implicit::Implicit;
use rayon::prelude::*;

/// Edges inside the other fluid from which a particle joins it.
const DEEP: f64 = 1.0;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Particles deep inside the other fluid join it, where the level set keeps the volumes.
    pub(super) fn join(&mut self) {
        let Some(set) = self.sharp.as_ref().filter(|_| self.kept_volume.is_some()) else { return };
        if self.flying.contains(&true) {
            return;
        }
        let Implicit { mesh, velocity, .. } = &self.implicit;
        let deep = DEEP * set.edge();
        let particles = &mut self.particles;
        let columns = particles.fluid.par_iter_mut().zip(&mut particles.depth).zip(&mut particles.velocity);
        let places = particles.position.par_iter().zip(&particles.element);
        let joined = columns.zip(places).map(|(((own, own_depth), v), (&x, &e))| {
            let place = Place { element: e as usize, shape: mesh.shape_functions(e as usize, x) };
            let (fluid, depth) = set.at(mesh, &place, 1 - set.inside);
            if fluid == *own || depth <= deep {
                return 0;
            }
            (*own, *own_depth) = (fluid, depth);
            *v = correct::at(&place.shape, &mesh.elements()[place.element], velocity);
            1_u64
        });
        self.counts.joined += joined.sum::<u64>();
    }

    /// Volume of the particles of each fluid where the level set shows the other [m³].
    pub(super) fn astray(&self) -> Vec<f64> {
        let (mesh, particles) = (&self.implicit.mesh, &self.particles);
        let Some(set) = &self.sharp else { return Vec::new() };
        let mut volumes = vec![0.0; self.density.len()];
        for e in 0..mesh.elements().len() {
            let own = particles.of(e);
            let share = mesh.simplex(e).volume / own.len().max(1) as f64;
            for p in own {
                let place = Place { element: e, shape: mesh.shape_functions(e, particles.position[p]) };
                if set.at(mesh, &place, 1 - set.inside).0 != particles.fluid[p] {
                    volumes[usize::from(particles.fluid[p])] += share;
                }
            }
        }
        volumes
    }
}
