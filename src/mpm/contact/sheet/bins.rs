//! Bins of space, in which elements are found.

use crate::math::Vector;

/// The bin of `x` [m].
#[inline]
pub fn bin<const D: usize>(x: Vector<D>, cell: f64) -> [i32; D] {
    std::array::from_fn(|a| (x[a] / cell).floor() as i32)
}

/// Calls `visit` with all bins between two corners.
pub fn for_each_bin<const D: usize>(lower: [i32; D], upper: [i32; D], mut visit: impl FnMut([i32; D])) {
    let mut at = lower;
    loop {
        visit(at);
        let Some(axis) = (0..D).find(|&a| at[a] < upper[a]) else { return };
        at[axis] += 1;
        at[..axis].copy_from_slice(&lower[..axis]);
    }
}
