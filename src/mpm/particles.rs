//! Material points, column by column.

use crate::material::{PointLaw, Storage};
use crate::math::{SymTensor, Tensor, Vector};

/// The material points of one continuum with one law.
#[derive(Debug)]
pub struct Body<const D: usize> {
    /// Name, as the case gives it.
    pub name: String,
    /// Its law.
    pub law: Box<dyn PointLaw>,
    /// The grid velocity field that it moves in; bodies in different fields meet by contact.
    pub field: usize,
    /// Its particles.
    pub particles: Particles<D>,
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
}
