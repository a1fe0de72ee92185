//! Material points, column by column.

use super::Summary;
use crate::geometry::SkinPoint;
use crate::material::{PointLaw, Storage};
use crate::math::{Signal, SymTensor, Tensor, Vector};
use crate::mpm::bins::Bins;
use crate::mpm::kernel::Kernel;
use crate::mpm::traction::Traction;
use crate::parallel;
use std::sync::Arc;

/// The material points of one continuum with one law, or those of its parts that lie in one region of closed membranes.
#[derive(Debug)]
pub struct Body<const D: usize> {
    /// Name, as the case gives it; parts of one body share it.
    pub name: String,
    /// The part of the body that this is.
    pub part: Part,
    /// Law of the particles.
    pub law: Arc<dyn PointLaw>,
    /// Shape functions of the particles (the size of GIMP particles differs from body to body).
    pub kernel: Kernel,
    /// Columns of the particles.
    pub particles: Particles<D>,
    /// Points on the surface of a body that keeps its shape, carried along by particles (by identity); empty where
    /// there are none: then every particle may come to the surface, and reaches half its size.
    pub skin: Vec<SkinPoint>,
    /// Depth of each particle below the body's surface at the start, in edges of its volume, by identity; empty: half
    /// an edge. The ball of this radius around the particle lies inside the body and touches its surface.
    pub depth: Vec<f64>,
    /// Loads on the surface.
    pub traction: Vec<Traction>,
    /// Pressure of the atmosphere around a gas [Pa], from which its forces count (`ambient`).
    pub ambient: f64,
    /// Columns that live during a step only.
    pub work: Work<D>,
    /// The order of its particles by blocks of the grid.
    pub(in crate::mpm) bins: Bins<D>,
    /// The largest wave speed + |v| of its particles [m/s].
    pub(in crate::mpm) largest_wave_speed: f64,
    /// Sums over its particles of the visits of the step so far.
    pub(in crate::mpm) summary: Summary,
}

/// A part of a body that lies on both sides of closed membranes; of other bodies, all of it (theory D.13).
#[derive(Debug, Clone, Default)]
pub struct Part {
    /// Number of this part among those of the body, which follow one another, from 0.
    pub number: usize,
    /// Number of particles of the parts before it: in outputs, identities go on from there.
    pub before: u32,
    /// The side of each membrane on which all of it stays: +1 where normals point, −1 behind; 0, or none for a
    /// membrane, where only the place of a particle tells.
    pub sides: Vec<f64>,
}

/// Columns that live during a step only.
#[derive(Debug, Clone, Default)]
pub struct Work<const D: usize> {
    /// Volume ratio of the increment.
    pub volume_ratio: Vec<f64>,
    /// Difference between the averaged pressure, which makes forces, and that of the particle [Pa]; empty without the
    /// cure of locking.
    pub excess: Vec<f64>,
    /// External force [N]; empty where there is none.
    pub external: Vec<Vector<D>>,
    /// The tractions among the external forces: particle index and force [N].
    pub traction: Vec<(usize, Vector<D>)>,
    /// Rate of the position ẋ_p = Σ N v⁺ [m/s]; empty where that is the velocity (APIC).
    pub rate: Vec<Vector<D>>,
    /// Rest of the velocity in the noise filter, u_j [m/s]; empty but in the filter of bodies that keep its heat.
    pub noise: Vec<Vector<D>>,
    /// Displacement by particle shifting at the end of the step [m]; empty in most steps.
    pub shift: Vec<Vector<D>>,
    /// Σ N ½(v⁻ + v⁺) [m/s], what external forces work on; empty where there are none.
    pub mean: Vec<Vector<D>>,
}

/// Columns of material points; the same index in every column is the same particle.
/// Optional columns are empty when the law or the transfer doesn't need them.
/// In 2D all extensive quantities are per metre of depth.
#[derive(Debug, Clone, Default)]
pub struct Particles<const D: usize> {
    /// Identity, stable through sorting.
    pub id: Vec<u32>,
    /// Position x_p [m].
    pub position: Vec<Vector<D>>,
    /// Velocity v_p at half steps [m/s].
    pub velocity: Vec<Vector<D>>,
    /// Mass m_p [kg].
    pub mass: Vec<f64>,
    /// Current volume V_p [m³].
    pub volume: Vec<f64>,
    /// Internal energy e_p [J].
    pub energy: Vec<f64>,
    /// Pressure −⅓ tr σ [Pa], artificial viscosity included.
    pub pressure: Vec<f64>,
    /// Cauchy stress σ_p [Pa]; empty for laws without deviator.
    pub stress: Vec<SymTensor>,
    /// Deformation gradient F_p; empty for laws that don't need it.
    pub deformation: Vec<Tensor<3>>,
    /// Affine velocity matrix C_p of APIC [1/s]; empty for FLIP.
    pub affine: Vec<Tensor<D>>,
    /// History variables of the law, a fixed number per particle.
    pub history: Vec<f64>,
    /// Speed c of waves in the particle, which bounds the step, dt ≤ h/(c + |v|) [m/s].
    pub wave_speed: Vec<f64>,
}

/// Depth [edges] of the particles that show where the surface is: a square of 1½ edges from the surface down, however
/// it is turned, holds one of a lattice.
const SURFACE: f64 = 1.5;

impl<const D: usize> Body<D> {
    /// A body without a surface layer and loads, its particles not yet sorted.
    pub fn new(name: String, law: Arc<dyn PointLaw>, kernel: Kernel, particles: Particles<D>) -> Self {
        let n = particles.len();
        // With APIC the velocity is the rate of the position.
        let rate = vec![Vector::ZERO; if particles.affine.is_empty() { n } else { 0 }];
        Self {
            name,
            part: Part::default(),
            law,
            kernel,
            particles,
            skin: Vec::new(),
            depth: Vec::new(),
            traction: Vec::new(),
            ambient: 0.0,
            work: Work { volume_ratio: vec![1.0; n], rate, ..Work::default() },
            bins: Bins::default(),
            largest_wave_speed: 0.0,
            summary: Summary::default(),
        }
    }

    /// Depth of particle `p` below the body's surface at the start [edges of its volume].
    #[inline]
    pub fn depth(&self, p: usize) -> f64 {
        self.depth.get(self.particles.id[p] as usize).copied().unwrap_or(0.5)
    }

    /// True if particle `p` was so near the body's surface at the start that it shows where the surface is. Between
    /// deeper ones and the surface the body may be deformed differently.
    #[inline]
    pub fn shows_surface(&self, p: usize) -> bool {
        self.depth(p) < SURFACE
    }

    /// The map of the unit ball to that of particle `p` [m]: the ball around it that touched the surface at the start,
    /// which follows the deformation where that is known; for fluids at most half the edge of its volume, kept within
    /// 0.3 to 1 half cells (theory D.3).
    pub fn ball(&self, p: usize, cell: f64) -> Tensor<D> {
        let particles = &self.particles;
        let edge = |volume: f64| if D == 2 { volume.sqrt() } else { volume.cbrt() };
        match particles.deformation.get(p) {
            Some(f) => {
                let radius = self.depth(p) * edge(particles.volume[p] / f.determinant());
                Tensor::from_fn(|i, k| f[i][k] * radius)
            }
            None if self.law.keeps_shape() => Tensor::identity() * (self.depth(p) * edge(particles.volume[p])),
            None => Tensor::identity() * (self.depth(p) * edge(particles.volume[p]).clamp(0.3 * cell, cell)),
        }
    }

    /// Reach of the body from the centre of particle `p` along the unit vector `normal` [m], rᵢ = |Sᵀn| with the
    /// ball S.
    pub fn reach(&self, p: usize, normal: Vector<D>, cell: f64) -> f64 {
        self.ball(p, cell).transpose().apply(normal).norm()
    }

    /// Half size of the patch of the surface that particle `p` stands for [m]: every such patch of the
    /// surface, ¾ edges to each side, holds a particle that does, however the particles lie.
    pub fn patch(&self, p: usize) -> f64 {
        0.75 * ((D - 1) as f64).sqrt() * self.particles.volume[p].powf(1.0 / D as f64)
    }

    /// Sorts the particles by the blocks and cells of a grid with this origin and these cells [m].
    pub(in crate::mpm) fn sort(&mut self, origin: Vector<D>, cell: f64) {
        let (bins, order) = Bins::sort(&self.particles.position, self.kernel, origin, cell);
        if !order.is_sorted() {
            self.particles.permute(&order);
        }
        self.bins = bins;
    }

    /// External forces on the particles at time `t` [N]: tractions, and gravity that varies in space (theory A.14).
    pub fn find_external_forces(&mut self, gravity: &[Signal; D], t: f64) {
        let Self { particles, traction, work, .. } = self;
        work.external.clear();
        work.traction.clear();
        work.mean.clear();
        let uniform = gravity.iter().all(Signal::is_uniform);
        if traction.is_empty() && uniform {
            return;
        }
        work.mean.resize(particles.len(), Vector::ZERO);
        work.external.resize(particles.len(), Vector::ZERO);
        if !uniform {
            let at = |x: Vector<D>| Vector::from_fn(|a| gravity[a].value(x.to3(), t));
            parallel::fill(&mut work.external, 256, |p| at(particles.position[p]) * particles.mass[p]);
        }
        let mut index = vec![0u32; if traction.is_empty() { 0 } else { particles.len() }];
        if !traction.is_empty() {
            particles.id.iter().zip(0..).for_each(|(&id, p)| index[id as usize] = p);
        }
        for traction in traction {
            let force = traction.force(t, |id| particles.position[index[id as usize] as usize]);
            let p = index[traction.particle as usize] as usize;
            work.external[p] += force;
            work.traction.push((p, force));
        }
    }

    /// Work of all external forces and of the tractions among them over `dt` [J], and their impulse [N s].
    pub fn external_work(&self, dt: f64) -> (f64, f64, Vector<D>) {
        let (external, traction, mean) = (&self.work.external, &self.work.traction, &self.work.mean);
        let all = parallel::sum(external.len(), |p| external[p].dot(mean[p])) * dt;
        let tractions = parallel::sum(traction.len(), |n| traction[n].1.dot(mean[traction[n].0])) * dt;
        let force = parallel::sum(external.len(), |p| external[p]);
        (all, tractions, force * dt)
    }
}

impl<const D: usize> Particles<D> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Total mass [kg].
    pub fn total_mass(&self) -> f64 {
        parallel::sum(self.len(), |p| self.mass[p])
    }

    /// Allocates the optional columns that a law needs, for all particles.
    pub fn allocate(&mut self, storage: Storage) {
        let n = self.len();
        self.stress.resize(if storage.stress { n } else { 0 }, SymTensor::ZERO);
        self.deformation.resize(if storage.deformation { n } else { 0 }, Tensor::identity());
        self.history.resize(storage.history.len() * n, 0.0);
    }

    /// Reorders every column: particle `p` becomes what was `order[p]`. Particles that `order` leaves out are gone.
    pub(crate) fn permute(&mut self, order: &[u32]) {
        fn permuted<T: Copy + Default + Send + Sync>(column: &mut Vec<T>, order: &[u32]) {
            if !column.is_empty() {
                let from = std::mem::take(column);
                parallel::map_into(order, column, |&p| from[p as usize]);
            }
        }
        let stride = self.history.len().checked_div(self.len()).unwrap_or(0);
        permuted(&mut self.id, order);
        permuted(&mut self.position, order);
        permuted(&mut self.velocity, order);
        permuted(&mut self.mass, order);
        permuted(&mut self.volume, order);
        permuted(&mut self.energy, order);
        permuted(&mut self.pressure, order);
        permuted(&mut self.stress, order);
        permuted(&mut self.deformation, order);
        permuted(&mut self.affine, order);
        permuted(&mut self.wave_speed, order);
        if stride > 0 {
            self.history =
                order.iter().flat_map(|&p| &self.history[p as usize * stride..][..stride]).copied().collect();
        }
    }

    /// The affine velocity matrix of a particle; zero for FLIP.
    #[inline(always)]
    pub fn affine(&self, p: usize) -> Tensor<D> {
        self.affine.get(p).copied().unwrap_or_default()
    }

    /// The Cauchy stress of a particle [Pa].
    #[inline(always)]
    pub fn stress(&self, p: usize) -> SymTensor {
        self.stress.get(p).copied().unwrap_or_else(|| SymTensor::isotropic(-self.pressure[p]))
    }

    /// Kinetic energy Σ ½ m v² [J].
    pub fn kinetic_energy(&self) -> f64 {
        parallel::sum(self.len(), |p| 0.5 * self.mass[p] * self.velocity[p].norm_squared())
    }

    /// Internal energy [J].
    pub fn internal_energy(&self) -> f64 {
        parallel::sum(self.len(), |p| self.energy[p])
    }
}
