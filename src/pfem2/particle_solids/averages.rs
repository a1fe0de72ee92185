//! Sums over the particles of an element, and averages at the nodes, as they are kept (theory (K.4), (K.5)).

use crate::math::{SymTensor, Vector};

/// Sums over the particles of an element; of pairs the first is that of fluids, the second that of solids.
#[derive(Debug, Clone, Copy)]
pub struct ElementSums<const D: usize, const N: usize> {
    /// Numbers of particles.
    pub count: [f64; 2],
    /// Σ N_k.
    pub shape: [[f64; N]; 2],
    /// Σ N_k p_p [Pa].
    pub pressure: [[f64; N]; 2],
    /// Σ N_k a_p of solids [m/s²].
    pub acceleration: [Vector<D>; N],
    /// Σ N_k ρ_p [kg/m³].
    pub density: [f64; N],
    /// Σ σ'_p of solids [Pa].
    pub stress: SymTensor,
    /// Σ μ of solids [Pa].
    pub shear: f64,
    /// Σ 1/κ of solids [1/Pa].
    pub compliance: f64,
    /// Σ ρ of solids [kg/m³].
    pub solid_density: f64,
    /// Phase of its first particle of a solid, if there is one.
    pub solid: Option<u8>,
}

impl<const D: usize, const N: usize> ElementSums<D, N> {
    /// No particles.
    pub const NONE: Self = Self {
        count: [0.0; 2],
        shape: [[0.0; N]; 2],
        pressure: [[0.0; N]; 2],
        acceleration: [Vector::ZERO; N],
        density: [0.0; N],
        stress: SymTensor::ZERO,
        shear: 0.0,
        compliance: 0.0,
        solid_density: 0.0,
        solid: None,
    };

    /// Part of the element's particles that are of solids, n_s/n_e; `None` without particles.
    pub fn solid_fraction(&self) -> Option<f64> {
        let all = self.count[0] + self.count[1];
        (all > 0.0).then(|| self.count[1] / all)
    }
}

/// Averages at the nodes.
#[derive(Debug, Clone, Default)]
pub struct NodalAverages<const D: usize> {
    /// p̂ [Pa].
    pub pressure: Vec<f64>,
    /// â of solids [m/s²].
    pub acceleration: Vec<Vector<D>>,
    /// True for nodes of solids.
    pub solid: Vec<bool>,
}
