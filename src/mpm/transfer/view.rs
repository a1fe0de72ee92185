//! Mutable columns of consecutive particles, which can be split between threads.

use super::{CHUNK_LEN, Sweep};
use crate::material::{PointBatch, PointLaw};
use crate::math::{SymTensor, Tensor, Vector};
use crate::mpm::Grid;
use crate::mpm::particles::{Body, Particles, Reduce, Work};

macro_rules! view {
    (particles { $($kept:ident: $K:ty),+ $(,)? } work { $($passing:ident: $P:ty),+ $(,)? }) => {
        /// Mutable columns of consecutive particles. Optional columns are empty.
        #[derive(Default)]
        pub(crate) struct View<'a, const D: usize> {
            $(pub $kept: &'a mut [$K],)+
            $(pub $passing: &'a mut [$P],)+
            /// History variables, `stride` per particle.
            pub history: &'a mut [f64],
            /// Mass [kg].
            pub mass: &'a [f64],
            /// External force [N].
            pub external: &'a [Vector<D>],
            /// Pressure of the atmosphere [Pa].
            pub ambient: f64,
            stride: usize,
        }

        impl<'a, const D: usize> View<'a, D> {
            /// All columns of a body, with so many history variables per particle and the pressure of the atmosphere
            /// [Pa].
            fn whole(particles: &'a mut Particles<D>, work: &'a mut Work<D>, stride: usize, ambient: f64) -> Self {
                Self {
                    $($kept: &mut particles.$kept,)+
                    $($passing: &mut work.$passing,)+
                    history: &mut particles.history,
                    mass: &particles.mass,
                    external: &work.external,
                    ambient,
                    stride,
                }
            }

            /// The first `n` particles and the rest.
            pub fn split_at(self, n: usize) -> (Self, Self) {
                $(let $kept = self.$kept.split_at_mut(if self.$kept.is_empty() { 0 } else { n });)+
                $(let $passing = self.$passing.split_at_mut(if self.$passing.is_empty() { 0 } else { n });)+
                let history = self.history.split_at_mut(n * self.stride);
                let mass = self.mass.split_at(n);
                let external = self.external.split_at(if self.external.is_empty() { 0 } else { n });
                let (ambient, stride) = (self.ambient, self.stride);
                (
                    Self {
                        $($kept: $kept.0,)+
                        $($passing: $passing.0,)+
                        history: history.0, mass: mass.0, external: external.0, ambient, stride,
                    },
                    Self {
                        $($kept: $kept.1,)+
                        $($passing: $passing.1,)+
                        history: history.1, mass: mass.1, external: external.1, ambient, stride,
                    },
                )
            }
        }
    };
}

view! {
    particles {
        position: Vector<D>,
        velocity: Vector<D>,
        volume: f64,
        energy: f64,
        pressure: f64,
        stress: SymTensor,
        deformation: Tensor<3>,
        affine: Tensor<D>,
        wave_speed: f64,
    }
    work {
        volume_ratio: f64,
        excess: f64,
        rate: Vector<D>,
        mean: Vector<D>,
        noise: Vector<D>,
        shift: Vector<D>,
    }
}

impl<const D: usize> Body<D> {
    /// The law and all particles.
    pub(crate) fn view(&mut self) -> (&dyn PointLaw, View<'_, D>) {
        let stride = self.law.storage().history.len();
        (&*self.law, View::whole(&mut self.particles, &mut self.work, stride, self.ambient))
    }
}

impl<const D: usize> Body<D> {
    /// A sweep over all particles, with the velocity field number `field`, the law, and the particles.
    pub(crate) fn sweep(&mut self, grid: &Grid<D>, field: usize) -> (Sweep<'_, D>, &dyn PointLaw, View<'_, D>) {
        let Self { law, particles, work, bins, kernel, ambient, .. } = self;
        let view = View::whole(particles, work, law.storage().history.len(), *ambient);
        (Sweep::over(grid, field, *kernel, bins), &**law, view)
    }
}

impl<'a, const D: usize> View<'a, D> {
    /// Consecutive parts of as many particles as `lengths` say.
    pub fn in_parts(mut self, lengths: impl Iterator<Item = usize>) -> Vec<Self> {
        let part = |n| {
            let (part, rest) = std::mem::take(&mut self).split_at(n);
            self = rest;
            part
        };
        lengths.map(part).collect()
    }
}

impl<const D: usize> View<'_, D> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Minus the mean of the normal stresses of particle `p` along the D axes [Pa].
    #[inline(always)]
    pub fn mean_pressure(&self, p: usize) -> f64 {
        if D == 3 || self.stress.is_empty() { self.pressure[p] } else { mean_pressure(&self.stress[p], D) }
    }

    /// Calls the law with the velocity gradients and the volume ratios over `dt` [s]; `length` is
    /// the cell size [m].
    pub fn update_law(&mut self, law: &dyn PointLaw, gradient: &[Tensor<3>], dt: f64, length: f64) {
        law.update(&mut PointBatch {
            dt,
            length,
            room: length.powi(D as i32),
            gradient,
            volume_ratio: self.volume_ratio,
            mass: self.mass,
            volume: self.volume,
            energy: self.energy,
            pressure: self.pressure,
            stress: self.stress,
            deformation: self.deformation,
            history: self.history,
            wave_speed: self.wave_speed,
        });
    }
}

/// Minus the mean of the normal stresses along the first `axes` axes [Pa]: what works on volume changes in as many
/// dimensions.
#[inline(always)]
pub(crate) fn mean_pressure(stress: &SymTensor, axes: usize) -> f64 {
    -stress.0[..axes].iter().sum::<f64>() / axes as f64
}

/// Particles that one thread visits at least.
const GRAIN: usize = 32 * CHUNK_LEN;

impl<const D: usize> View<'_, D> {
    /// Visits all particles, a chunk at a time, in parallel; the sums are added in a fixed order.
    pub fn visit<A: Reduce>(mut self, visit: &(dyn Fn(&mut View<'_, D>) -> A + Sync)) -> A {
        let len = self.len();
        if len > GRAIN {
            let (left, right) = self.split_at(len / 2);
            let (a, b) = rayon::join(|| left.visit(visit), || right.visit(visit));
            return a.plus(b);
        }
        let mut sum = A::default();
        while self.len() > 0 {
            let len = CHUNK_LEN.min(self.len());
            let (mut chunk, rest) = self.split_at(len);
            sum = sum.plus(visit(&mut chunk));
            self = rest;
        }
        sum
    }
}
