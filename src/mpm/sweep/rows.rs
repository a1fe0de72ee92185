//! What the grid says at a few consecutive particles, number by number.

use crate::math::{Tensor, Vector};

/// Particles per call of a visitor: their gathered values stay in the first-level cache.
pub(crate) const CHUNK: usize = 128;

/// A number of each particle of a chunk. Eight are stored at a time, so the end may overrun.
pub(crate) type Column = [f64; CHUNK + 8];

/// Gathered numbers of a chunk of particles. Those that were not wanted have no meaning.
#[repr(C, align(64))]
pub(crate) struct Rows<const D: usize> {
    /// Σ N s of the scalar slot.
    pub scalar: Column,
    /// Σ N v [m/s] by component.
    pub velocity: [Column; D],
    /// Σ N a [m/s²] by component.
    pub acceleration: [Column; D],
    /// Σ v ⊗ ∇N [1/s] by axis and component: entry [b][a] is ∂v_a/∂x_b.
    pub gradient: [[Column; D]; D],
    /// Σ N v ⊗ (x_I − x_p) [m²/s] by axis and component.
    pub moment: [[Column; D]; D],
}

impl<const D: usize> Default for Rows<D> {
    fn default() -> Self {
        let zero = [0.0; CHUNK + 8];
        Self {
            scalar: zero,
            velocity: [zero; D],
            acceleration: [zero; D],
            gradient: [[zero; D]; D],
            moment: [[zero; D]; D],
        }
    }
}

impl<const D: usize> Rows<D> {
    /// Σ N v of particle `p` [m/s].
    #[inline(always)]
    pub fn velocity(&self, p: usize) -> Vector<D> {
        Vector::from_fn(|a| self.velocity[a][p])
    }

    /// The velocity gradient at particle `p` [1/s].
    #[inline(always)]
    pub fn gradient(&self, p: usize) -> Tensor<D> {
        Tensor::from_fn(|a, b| self.gradient[b][a][p])
    }

    /// Replaces the velocity gradient at particle `p` [1/s].
    #[inline(always)]
    pub fn set_gradient(&mut self, p: usize, gradient: &Tensor<D>) {
        for a in 0..D {
            for b in 0..D {
                self.gradient[b][a][p] = gradient[a][b];
            }
        }
    }

    /// Σ N v ⊗ (x_I − x_p) of particle `p` [m²/s].
    #[inline(always)]
    pub fn moment(&self, p: usize) -> Tensor<D> {
        Tensor::from_fn(|a, b| self.moment[b][a][p])
    }
}
