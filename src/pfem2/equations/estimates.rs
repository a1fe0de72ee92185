//! Estimates that bound the length of steps: the highest frequency of waves on interfaces, and the time in which the
//! flow crosses an element (theory H.6–H.8).

use super::system::VelocityPressureSystem;
use crate::math::Vector;
use crate::parallel;

impl<const D: usize, const N: usize> VelocityPressureSystem<D, N> {
    /// The highest frequency of waves on the interfaces that are there [1/s]; zero where there is none.
    ///
    /// ω² = (|ρ_1 − ρ_2| g k + σ k³)/(ρ_1 + ρ_2) between deep fluids, with the shortest wave of an element, k = π/h.
    /// Theory (H.9).
    pub fn wave_frequency(&self) -> f64 {
        let gravity = |e: usize| {
            let nodes = &self.mesh.elements()[e];
            nodes.iter().map(|&i| self.force[i as usize].norm()).fold(0.0, f64::max)
        };
        self.fastest(gravity)
    }

    /// Largest frequency of capillary waves, without gravity [1/s].
    pub fn capillary_frequency(&self) -> f64 {
        self.fastest(|_| 0.0)
    }

    fn fastest(&self, gravity: impl Fn(usize) -> f64) -> f64 {
        let mixed = (0..self.mesh_data.size.len()).filter(|&e| !self.contents.pure[e] && !self.holds_solid(e));
        let square = mixed.map(|e| self.wave(gravity(e), std::f64::consts::PI / self.mesh_data.size[e]));
        square.fold(0.0, f64::max).sqrt()
    }

    /// ω² of the fastest waves that two of the fluids could make [1/s²].
    fn wave(&self, gravity: f64, k: f64) -> f64 {
        let fluids = self.contents.density.len();
        let pairs = (0..fluids).flat_map(|a| (a + 1..fluids).map(move |b| [a, b]));
        let square = pairs.map(|pair| {
            let [a, b] = pair.map(|fluid| self.contents.density[fluid]);
            ((a - b).abs() * gravity * k + self.physics.tension_between(pair) * k.powi(3)) / (a + b)
        });
        square.fold(0.0, f64::max)
    }

    /// The shortest time in which the flow crosses an element, in free fall if it is at rest [s] (theory (H.8)).
    pub fn crossing_time(&self) -> f64 {
        parallel::min(self.mesh_data.size.len(), |e| {
            let (h, nodes) = (self.mesh_data.size[e], &self.mesh.elements()[e]);
            let largest = |values: &[Vector<D>]| nodes.iter().map(|&i| values[i as usize].norm()).fold(0.0, f64::max);
            let (v, g) = (largest(&self.velocity), largest(&self.force));
            // v t + ½ g t² = h
            2.0 * h / (v + (v * v + 2.0 * g * h).sqrt())
        })
    }
}
