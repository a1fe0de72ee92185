//! Sizes of particles (theory D.3).

use crate::math::Vector;
use crate::mpm::Particles;

/// Half the size of a particle along `normal` [m] (theory (D.6)).
///
/// From its deformation gradient where it has one; else half the edge of its volume, kept within 0.3 to 1
/// half cells.
pub fn half_size<const D: usize>(particles: &Particles<D>, p: usize, normal: Vector<D>, cell: f64) -> f64 {
    let edge = |volume: f64| if D == 2 { volume.sqrt() } else { volume.cbrt() };
    match particles.deformation.get(p) {
        Some(f) => {
            let size = edge(particles.volume[p] / f.determinant());
            let extent = |k: usize| (0..D).map(|i| f[i][k] * normal[i]).sum::<f64>().abs();
            0.5 * size * (0..D).map(extent).sum::<f64>()
        }
        None => 0.5 * edge(particles.volume[p]).clamp(0.3 * cell, cell),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Tensor;

    /// A cube stretched along x is longer along x, and a fluid's particle is kept within half a cell.
    #[test]
    fn particle_sizes_follow_the_deformation() {
        let mut particles = Particles::<3> { volume: vec![2.0 * 0.001], ..Particles::default() };
        assert!((half_size(&particles, 0, Vector::unit(0), 1.0) - 0.15).abs() < 1e-15);
        assert!((half_size(&particles, 0, Vector::unit(0), 0.1) - 0.05).abs() < 1e-15);
        particles.deformation = vec![Tensor([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])];
        assert!((half_size(&particles, 0, Vector::unit(0), 1.0) - 0.1).abs() < 1e-15);
        assert!((half_size(&particles, 0, Vector::unit(1), 1.0) - 0.05).abs() < 1e-15);
    }
}
