//! Graded boxes: a lattice whose planes are close where a refined region is, along each axis by itself.

use super::size::{Refined, SizeField, too_many};
use crate::geometry::Region;

/// The planes of the lattice between two corners [m]; those of `fixed` are among them. A refined region asks for
/// its size along the whole slab that it spans, since planes go through.
///
/// # Errors
/// More elements than a mesh can have.
pub fn lines<const D: usize>(
    lower: [f64; D],
    upper: [f64; D],
    fixed: [Vec<f64>; D],
    size: &SizeField,
) -> Result<[Vec<f64>; D], String> {
    let per_cell = if D == 2 { 2.0 } else { 6.0 };
    let cells = |axis: usize| {
        let along = SizeField { coarse: size.coarse, refined: slabs(size, axis) };
        along.count(|s| [lower[axis] + s * (upper[axis] - lower[axis]), 0.0, 0.0]).max(1.0)
    };
    if let Some(why) = too_many(per_cell * (0..D).map(cells).product::<f64>()) {
        return Err(why);
    }
    Ok(std::array::from_fn(|axis| {
        let along = SizeField { coarse: size.coarse, refined: slabs(size, axis) };
        let ends = fixed[axis].iter().copied().chain([upper[axis]]);
        let mut line = vec![lower[axis]];
        for end in ends {
            let start = line[line.len() - 1];
            let at = |s: f64| [start + s * (end - start), 0.0, 0.0];
            let inside = along.spread(at, 1);
            line.extend(inside[1..inside.len() - 1].iter().map(|&s| at(s)[0]));
            line.push(end);
        }
        line
    }))
}

/// The extent of each refined region along one axis, turned onto the first.
fn slabs(size: &SizeField, axis: usize) -> Vec<Refined> {
    let slab = |refined: &Refined| {
        let bounds = refined.region.bounds();
        let mut lower = [f64::NEG_INFINITY; 3];
        let mut upper = [f64::INFINITY; 3];
        (lower[0], upper[0]) = (bounds.lower[axis], bounds.upper[axis]);
        Refined { region: Region::Box { lower, upper }, cell: refined.cell, growth: refined.growth }
    };
    size.refined.iter().map(slab).collect()
}
