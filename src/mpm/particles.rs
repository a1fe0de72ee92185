//! Material points, column by column.

use super::kernel::Kernel;
use super::transfer_gather::Motion;
use crate::material::{PointBatch, PointLaw, Storage};
use crate::math::{Signal, SymTensor, Tensor, Vector};
use rayon::prelude::*;

/// Particles that one call of a law updates.
const BATCH: usize = 1024;

/// The material points of one continuum with one law.
#[derive(Debug)]
pub struct Body<const D: usize> {
    /// Name, as the case gives it.
    pub name: String,
    /// Its law.
    pub law: Box<dyn PointLaw>,
    /// The grid velocity field that it moves in; bodies in different fields meet by contact.
    pub field: usize,
    /// Its shape functions (the size of GIMP particles differs from body to body).
    pub kernel: Kernel,
    /// Its particles.
    pub particles: Particles<D>,
    /// Surface tractions: particle identity, area [m²] and traction [Pa].
    pub traction: Vec<(u32, f64, [Signal; 3])>,
    /// What lives during a step only.
    pub work: Work<D>,
}

/// Columns that live during a step only.
#[derive(Debug, Clone, Default)]
pub struct Work<const D: usize> {
    /// Velocity gradient L_p [1/s].
    pub gradient: Vec<Tensor<3>>,
    /// Volume ratio of the increment.
    pub stretch: Vec<f64>,
    /// External force [N]; empty where there is none.
    pub external: Vec<Vector<D>>,
    /// The tractions among the external forces: particle index and force [N].
    pub traction: Vec<(usize, Vector<D>)>,
    /// Motion gathered from the grid.
    pub motion: Motion<D>,
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
    /// Speed that bounds the step, dt ≤ h/(signal + |v|) [m/s].
    pub signal: Vec<f64>,
}

impl<const D: usize> Body<D> {
    /// External forces on the particles at time `t` [N]: gravity and tractions.
    pub fn find_external_forces(&mut self, gravity: &[Signal; D], t: f64) {
        let Self { particles, traction, work, .. } = self;
        work.external.clear();
        work.traction.clear();
        if traction.is_empty() && gravity.iter().all(Signal::is_zero) {
            return;
        }
        let columns = particles.position.par_iter().zip(&particles.mass);
        columns
            .map(|(x, &m)| Vector::from_fn(|a| gravity[a].value(x.to3(), t)) * m)
            .collect_into_vec(&mut work.external);
        for (id, area, traction) in traction {
            if let Some(p) = particles.index_of(*id) {
                let x = particles.position[p].to3();
                let force = Vector::from_fn(|a| traction[a].value(x, t)) * *area;
                work.external[p] += force;
                work.traction.push((p, force));
            }
        }
    }

    /// Work of all external forces and of the tractions among them over `dt` [J], and their impulse [N s].
    pub fn external_work(&self, dt: f64) -> (f64, f64, Vector<D>) {
        let (external, mean) = (&self.work.external, &self.work.motion.mean);
        let all = crate::parallel::sum(external.len(), |p| external[p].dot(mean[p])) * dt;
        let tractions = self.work.traction.iter().map(|&(p, force)| force.dot(mean[p])).sum::<f64>() * dt;
        let sum = |range: std::ops::Range<usize>| range.map(|p| external[p]).sum::<Vector<D>>();
        let force = crate::parallel::reduce(external.len(), sum, |a, b| a + b).unwrap_or_default();
        (all, tractions, force * dt)
    }

    /// Calls the law for all particles with the gradients and stretches of `work`, over `dt` [s];
    /// `length` is the cell size [m].
    pub fn update_law(&mut self, dt: f64, length: f64) {
        let stride = self.law.storage().history.len();
        let Particles { mass, volume, energy, pressure, stress, deformation, history, signal, .. } =
            &mut self.particles;
        let count = mass.len();
        let (mut mass, mut volume, mut energy) = (mass.as_slice(), volume.as_mut_slice(), energy.as_mut_slice());
        let (mut pressure, mut stress) = (pressure.as_mut_slice(), stress.as_mut_slice());
        let (mut deformation, mut history) = (deformation.as_mut_slice(), history.as_mut_slice());
        let (mut signal, mut gradient) = (signal.as_mut_slice(), self.work.gradient.as_slice());
        let mut stretch = self.work.stretch.as_slice();
        let batches: Vec<PointBatch<'_>> = (0..count.div_ceil(BATCH))
            .map(|_| PointBatch {
                dt,
                length,
                gradient: split(&mut gradient, BATCH),
                stretch: split(&mut stretch, BATCH),
                mass: split(&mut mass, BATCH),
                volume: split_mut(&mut volume, BATCH),
                energy: split_mut(&mut energy, BATCH),
                pressure: split_mut(&mut pressure, BATCH),
                stress: split_mut(&mut stress, BATCH),
                deformation: split_mut(&mut deformation, BATCH),
                history: split_mut(&mut history, BATCH * stride),
                signal: split_mut(&mut signal, BATCH),
            })
            .collect();
        batches.into_par_iter().for_each(|mut batch| self.law.update(&mut batch));
    }
}

/// Splits at most `n` entries off the front.
fn split<'a, T>(rest: &mut &'a [T], n: usize) -> &'a [T] {
    let (head, tail) = rest.split_at(n.min(rest.len()));
    *rest = tail;
    head
}

/// Splits at most `n` entries off the front.
fn split_mut<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let n = n.min(rest.len());
    let (head, tail) = std::mem::take(rest).split_at_mut(n);
    *rest = tail;
    head
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
        crate::parallel::sum(self.len(), |p| self.mass[p])
    }

    /// Allocates the optional columns that a law needs, for all particles.
    pub fn allocate(&mut self, storage: Storage) {
        let n = self.len();
        self.stress.resize(if storage.stress { n } else { 0 }, SymTensor::ZERO);
        self.deformation.resize(if storage.deformation { n } else { 0 }, Tensor::identity());
        self.history.resize(storage.history.len() * n, 0.0);
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

    /// The index of the particle with this identity.
    pub fn index_of(&self, id: u32) -> Option<usize> {
        let unsorted = id as usize;
        if self.id.get(unsorted) == Some(&id) { Some(unsorted) } else { self.id.iter().position(|&other| other == id) }
    }

    /// Kinetic energy Σ ½ m v² [J].
    pub fn kinetic_energy(&self) -> f64 {
        crate::parallel::sum(self.len(), |p| 0.5 * self.mass[p] * self.velocity[p].norm_squared())
    }

    /// Internal energy [J].
    pub fn internal_energy(&self) -> f64 {
        crate::parallel::sum(self.len(), |p| self.energy[p])
    }
}
