//! The call of the law with the strain increments of a chunk (theory A.8): volume ratios, and gradients for laws that
//! read them, as `strain` made them. The order of all this is in `step::schedule`.

use crate::material::PointLaw;
use crate::math::Tensor;
use crate::math::simd::{Lanes, Task, widest};
use crate::mpm::transfer::{CHUNK_LEN, Chunk};

/// True if a volume ratio is not positive or not finite.
struct AnyUnsound<'a>(&'a [f64]);

impl Task for AnyUnsound<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        // A count instead of an early end: the loop becomes vectors.
        self.0.iter().fold(0, |count, &j| count + u64::from(!(j > 0.0 && j < f64::INFINITY))) > 0
    }
}

/// Updates the stresses of a chunk over `dt` [s] in cells of size `cell` [m]; false if a particle was turned inside
/// out.
pub(in crate::mpm) fn update_stress<const D: usize>(
    law: &dyn PointLaw,
    chunk: &mut Chunk<'_, D>,
    dt: f64,
    cell: f64,
) -> bool {
    let particles = &mut chunk.particles;
    if widest(AnyUnsound(particles.volume_ratio)) {
        return false;
    }
    if law.needs_gradient() {
        let mut gradient = [Tensor::ZERO; CHUNK_LEN];
        let n = particles.len();
        gradient[..n].iter_mut().enumerate().for_each(|(p, l)| *l = chunk.rows.gradient(p).embed(0.0));
        particles.update_law(law, &gradient[..n], dt, cell);
    } else {
        particles.update_law(law, &[], dt, cell);
    }
    true
}
