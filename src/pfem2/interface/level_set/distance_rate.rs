//! Depths of particles beside the interface change as their distance from it does (theory (G.3a)).
//!
//! ```text
//! foot of a particle     x_f = x − φ ∇φ/|∇φ|², twice,   φ(x_f) = 0
//! rate of its depth      ḋ = s n·(v*(x) − v*(x_f)),     n = ∇φ/|∇φ| at the foot
//! ```
//!
//! This is the extension velocity of Adalsteinsson & Sethian (1999), for depths that particles carry. Kept as they are,
//! depths would move the interface with the mean velocity of what lies on both sides of it, that of the light fluid
//! included, while forces work with the velocity of the interface itself: waves as short as a few elements gain energy
//! from that. A particle on the interface keeps its depth.

use super::{CORRECTION_BAND, LevelSet, value};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::particles::convect::MeshPoint;
use crate::pfem2::particles::{Particles, interpolate_nodal};

/// Part of an edge by which φ may differ from zero at a foot. Beyond a ridge of φ, as in the middle of a film, there is
/// none.
const MISSED: f64 = 0.1;

/// Part of its depth that a particle may lose or win in a step.
const LARGEST_CHANGE: f64 = 0.5;

impl LevelSet {
    /// Changes the depths [m] of the particles near the interface over a step of `dt` [s] that moves all with the velocity
    /// v* [m/s] of the nodes; before they move.
    pub fn change_depths<const D: usize, const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        velocity: &[Vector<D>],
        dt: f64,
        particles: &mut Particles<D>,
    ) {
        let gradients = self.gradients(mesh);
        let near = CORRECTION_BAND * self.edge();
        let Particles { position, element, phase, depth, .. } = particles;
        parallel::change(depth, 256, |p, depth| {
            if *depth >= near {
                return;
            }
            let sign = self.sign(phase[p]);
            let place = MeshPoint::of(mesh, element[p] as usize, position[p]);
            if sign * value(mesh, &place, &self.level) <= 0.0 {
                return;
            }
            let Some((foot, normal)) = self.foot(mesh, &gradients, place, position[p]) else { return };
            let at = |place: &MeshPoint<N>| interpolate_nodal(&place.shape, &mesh.elements()[place.element], velocity);
            let change = sign * dt * (at(&place) - at(&foot)).dot(normal);
            let most = LARGEST_CHANGE * *depth;
            *depth += change.clamp(-most, most);
        });
    }

    /// The point of the interface that is nearest to a place at `x` [m], and the normal there.
    fn foot<const D: usize, const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        gradients: &[Vector<D>],
        mut place: MeshPoint<N>,
        mut x: Vector<D>,
    ) -> Option<(MeshPoint<N>, Vector<D>)> {
        let slope = |place: &MeshPoint<N>| interpolate_nodal(&place.shape, &mesh.elements()[place.element], gradients);
        for _ in 0..2 {
            let (phi, slope) = (value(mesh, &place, &self.level), slope(&place));
            x -= slope * (phi / slope.norm_squared());
            if !x.is_finite() {
                return None;
            }
            let (element, shape) = mesh.reach(x, place.element)?;
            place = MeshPoint { element, shape };
        }
        let is_near = value(mesh, &place, &self.level).abs() <= MISSED * self.edge();
        Some((place, slope(&place).normalized()?)).filter(|_| is_near)
    }

    /// ∇φ at the nodes: the mean of the elements around, by volume; zero at nodes beyond the band.
    pub(super) fn gradients<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>) -> Vec<Vector<D>> {
        let mean = |node: usize| {
            if self.level[node].abs() >= self.band {
                return Vector::ZERO;
            }
            let around = || mesh.elements_around(node).iter().map(|&e| (e as usize, mesh.simplex(e as usize).volume));
            let sum: Vector<D> = around().map(|(e, volume)| self.gradient(mesh, e) * volume).sum();
            sum / around().map(|(_, volume)| volume).sum::<f64>()
        };
        parallel::collect(mesh.nodes().len(), 256, mean)
    }
}
