//! Size field: the wanted size of elements at each place.

use crate::geometry::Region;
use crate::memory;

/// Pieces into which a curve is cut to measure its elements.
const SAMPLES: usize = 4096;

/// Most elements of a mesh that is made here: about 10 GB for the mesh alone.
pub const MOST_ELEMENTS: f64 = 4e7;

/// Memory per element at least, with the particles and unknowns that a solver keeps of it.
const BYTES: f64 = 1000.0;

/// The message about a mesh with more elements, estimated as `count` before anything is stored.
pub fn too_many(count: f64) -> Option<String> {
    if count > MOST_ELEMENTS {
        return Some(format!("about {count:.1e} elements: more than the {MOST_ELEMENTS:.0e} that a mesh can have"));
    }
    memory::refusal(BYTES * count).map(|refusal| format!("about {count:.1e} elements take {refusal}"))
}

/// The element size h(x).
pub struct SizeField {
    /// Away from all refined regions [m].
    pub coarse: f64,
    /// Regions with smaller elements.
    pub refined: Vec<Refined>,
}

/// A region with smaller elements.
pub struct Refined {
    /// The region.
    pub region: Region,
    /// The size in and at it [m].
    pub cell: f64,
    /// Growth of the size with the distance from it.
    pub growth: f64,
}

impl SizeField {
    /// The size at `x` [m].
    pub fn at(&self, x: [f64; 3]) -> f64 {
        let near = |near: &Refined| near.cell + near.growth * near.region.signed_distance(x).max(0.0);
        self.refined.iter().map(near).fold(self.coarse, f64::min)
    }

    /// A bound that no size within a `radius` of `x` lies below [m]: no distance to a region changes by more than the
    /// way.
    pub fn least(&self, x: [f64; 3], radius: f64) -> f64 {
        /// Rounding of the distances.
        const ROUNDING: f64 = 1e-9;
        let near = |near: &Refined| near.cell + near.growth * (near.region.signed_distance(x) - radius).max(0.0);
        (1.0 - ROUNDING) * self.refined.iter().map(near).fold(self.coarse, f64::min)
    }

    /// The smallest size [m].
    pub fn finest(&self) -> f64 {
        self.refined.iter().map(|near| near.cell).fold(self.coarse, f64::min)
    }

    /// True for a curve that is one element however small elements are: an outline of 100,000 corners has many.
    fn is_short(&self, at: &impl Fn(f64) -> [f64; 3]) -> bool {
        const CHORDS: usize = 16;
        let place = |i: usize| at(i as f64 / CHORDS as f64);
        let chord = |i: usize| (0..3).map(|k| (place(i + 1)[k] - place(i)[k]).powi(2)).sum::<f64>().sqrt();
        (0..CHORDS).map(chord).sum::<f64>() < 0.25 * self.finest()
    }

    /// Elements along a curve of the given speed |dx/ds|, s from 0 to 1: ∫ ds/h.
    pub fn count(&self, at: impl Fn(f64) -> [f64; 3]) -> f64 {
        self.passed(&at)[SAMPLES]
    }

    /// ∫ ds/h from the start of a curve to each of its samples.
    fn passed(&self, at: &impl Fn(f64) -> [f64; 3]) -> Vec<f64> {
        let place = |i: usize| at(i as f64 / SAMPLES as f64);
        let mut passed = vec![0.0; SAMPLES + 1];
        for i in 0..SAMPLES {
            let (a, b) = (place(i), place(i + 1));
            let length = (0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt();
            passed[i + 1] = passed[i] + length / self.at(at((i as f64 + 0.5) / SAMPLES as f64));
        }
        passed
    }

    /// Points along a curve of the given speed |dx/ds|, s from 0 to 1, spaced by the size: the parameters of at
    /// least `least` pieces, with both ends. The count of elements ∫ ds/h is rounded to the nearest number.
    pub fn spread(&self, at: impl Fn(f64) -> [f64; 3], least: usize) -> Vec<f64> {
        if least == 1 && self.is_short(&at) {
            return vec![0.0, 1.0];
        }
        let passed = self.passed(&at);
        let total = passed[SAMPLES];
        let count = (total.round() as usize).max(least);
        let mut parameters = Vec::with_capacity(count + 1);
        let mut i = 0;
        for n in 0..count {
            let wanted = total * n as f64 / count as f64;
            while passed[i + 1] < wanted {
                i += 1;
            }
            parameters.push((i as f64 + (wanted - passed[i]) / (passed[i + 1] - passed[i])) / SAMPLES as f64);
        }
        parameters.push(1.0);
        parameters
    }
}
