//! The sums over the nodes around a few consecutive particles, number by number.

use super::column::{CHUNK_LEN, ChunkColumn, get, put};
use crate::math::simd::Lanes;
use crate::math::{Tensor, Vector};

/// Gathered numbers of a chunk of particles. Those that were not gathered have no meaning.
#[repr(C, align(64))]
pub(crate) struct Rows<const D: usize> {
    /// Σ N s of the scalar slot.
    pub scalar: ChunkColumn,
    /// Σ N v [m/s] by component.
    pub velocity: [ChunkColumn; D],
    /// Σ N a [m/s²] by component.
    pub acceleration: [ChunkColumn; D],
    /// Σ v ⊗ ∇N [1/s] by axis and component: entry [b][a] is ∂v_a/∂x_b.
    pub gradient: [[ChunkColumn; D]; D],
    /// Σ N v ⊗ (x_I − x_p) [m²/s] by axis and component.
    pub moment: [[ChunkColumn; D]; D],
}

impl<const D: usize> Default for Rows<D> {
    fn default() -> Self {
        let zero = [0.0; CHUNK_LEN + 8];
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

    /// The velocity gradients at eight particles from `p` on [1/s].
    #[inline(always)]
    pub fn gradients<L: Lanes>(&self, p: usize) -> [[L; D]; D] {
        let mut gradients = [[L::splat(0.0); D]; D];
        for a in 0..D {
            for b in 0..D {
                gradients[a][b] = get(p, &self.gradient[b][a]);
            }
        }
        gradients
    }

    /// Replaces the velocity gradients at eight particles from `p` on [1/s].
    #[inline(always)]
    pub fn set_gradients<L: Lanes>(&mut self, p: usize, gradients: &[[L; D]; D]) {
        for a in 0..D {
            for b in 0..D {
                put(gradients[a][b], p, &mut self.gradient[b][a]);
            }
        }
    }
}
