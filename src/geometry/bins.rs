//! Boxes found by the places that they reach: a uniform grid of bins without bounds.

use crate::math::Vector;
use hashbrown::HashMap;

/// Numbers of things with axis-aligned boxes, listed in every bin that their boxes touch.
///
/// A bin is a cube [m³] (in 2D a square, [m²]); the list of a bin has the order in which things were added. A query
/// reads lists by their bins and never in the order of memory.
///
/// ```
/// use lateen::geometry::SpatialBins;
/// use lateen::math::Vector;
///
/// let mut bins = SpatialBins::<2>::new(0.5);
/// bins.add(7, Vector([0.1, 0.1]), Vector([0.6, 0.2]));
/// assert_eq!(bins.at(Vector([0.9, 0.4])), [7], "in the same bin as the box's right end");
/// assert!(bins.at(Vector([1.1, 0.4])).is_empty());
/// ```
#[derive(Debug, Clone, Default)]
pub struct SpatialBins<const D: usize> {
    size: f64,
    lists: HashMap<[i32; D], Vec<u32>>,
}

impl<const D: usize> SpatialBins<D> {
    /// Bins with edges of this length [m].
    pub fn new(size: f64) -> Self {
        Self { size, lists: HashMap::new() }
    }

    /// Removes everything, keeps the memory, and sets the length of edges [m].
    pub fn clear(&mut self, size: f64) {
        self.size = size;
        self.lists.clear();
    }

    /// Lists a thing in all bins that the box between two corners [m] touches.
    pub fn add(&mut self, thing: u32, lower: Vector<D>, upper: Vector<D>) {
        let (lower, upper) = (self.bin(lower), self.bin(upper));
        Self::for_each(lower, upper, |bin| self.lists.entry(bin).or_default().push(thing));
    }

    /// The bin of a place [m].
    pub fn bin(&self, x: Vector<D>) -> [i32; D] {
        std::array::from_fn(|a| (x[a] / self.size).floor() as i32)
    }

    /// Entries listed in the bin of a place [m].
    pub fn at(&self, x: Vector<D>) -> &[u32] {
        self.of(&self.bin(x))
    }

    /// Entries listed in a bin.
    pub fn of(&self, bin: &[i32; D]) -> &[u32] {
        self.lists.get(bin).map_or(&[], Vec::as_slice)
    }

    /// Visits the bins between two corners, both included, the first axis fastest.
    pub fn for_each(lower: [i32; D], upper: [i32; D], mut visit: impl FnMut([i32; D])) {
        let mut at = lower;
        loop {
            visit(at);
            let Some(axis) = (0..D).find(|&a| at[a] < upper[a]) else { return };
            at[axis] += 1;
            at[..axis].copy_from_slice(&lower[..axis]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_in_the_bins_that_it_touches_and_no_other() {
        let mut bins = SpatialBins::<3>::new(0.25);
        bins.add(1, Vector([-0.3, 0.0, 0.1]), Vector([0.1, 0.3, 0.2]));
        bins.add(2, Vector([0.0; 3]), Vector([0.0; 3]));
        let mut listed = Vec::new();
        SpatialBins::for_each([-3; 3], [3; 3], |bin| listed.extend(bins.of(&bin).iter().map(|&thing| (thing, bin))));
        let touched = [-2, -1, 0].into_iter().flat_map(|x| [0, 1].map(|y| (1, [x, y, 0])));
        let mut expected: Vec<_> = touched.chain([(2, [0; 3])]).collect();
        listed.sort_unstable();
        expected.sort_unstable();
        assert_eq!(listed, expected);
        assert_eq!(bins.at(Vector([0.01; 3])), [1, 2]);
        bins.clear(1.0);
        assert!(bins.at(Vector::ZERO).is_empty());
    }
}
